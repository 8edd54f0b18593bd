//! The robot as planning sees it: its chain, limits and postures.

use std::sync::Arc;

use factotum_descriptions::RobotDescription;

use crate::chain::KinematicChain;
use crate::error::MotionError;
use crate::joint_space::{JointLimit, JointSpace};

/// A robot compiled for planning. Cheap to clone.
#[derive(Debug, Clone)]
pub struct RobotModel {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    description: RobotDescription,
    joints: Vec<String>,
    chain: KinematicChain,
    space: JointSpace,
}

impl RobotModel {
    /// Composes the robot's parts and reads its chain, limits and self-collision pairs.
    ///
    /// # Errors
    /// [`MotionError`] if a model does not load or a name of the description is not in it.
    pub fn load(description: &RobotDescription) -> Result<Self, MotionError> {
        Err(MotionError::Value {
            what: "robot",
            found: description.name.clone(),
            wanted: "a physics engine to load it with (not yet linked)",
        })
    }

    /// What the robot was loaded from.
    pub fn description(&self) -> &RobotDescription {
        &self.inner.description
    }

    /// Names of the chain's joints: the lift, if any, then the arm.
    pub fn chain_joints(&self) -> &[String] {
        &self.inner.joints
    }

    /// Number of chain joints.
    pub fn n(&self) -> usize {
        self.inner.joints.len()
    }

    /// What each chain joint may do.
    pub fn limits(&self) -> &[JointLimit] {
        self.inner.space.limits()
    }

    /// The space of configurations.
    pub fn space(&self) -> &JointSpace {
        &self.inner.space
    }

    /// Forward kinematics of the chain.
    pub fn chain(&self) -> &KinematicChain {
        &self.inner.chain
    }

    /// The tucked posture for driving.
    pub fn q_rest(&self) -> Vec<f64> {
        self.q_from_state(self.lift_rest_m(), &self.inner.description.arm.rest)
    }

    /// The posture from which manipulation starts, with the lift at its rest height.
    pub fn q_ready(&self) -> Vec<f64> {
        self.q_from_state(self.lift_rest_m(), &self.inner.description.arm.ready)
    }

    /// A configuration from a lift height (ignored without a lift) and arm positions.
    pub fn q_from_state(&self, lift_m: f64, arm: &[f64]) -> Vec<f64> {
        let lift = self.inner.description.lift.as_ref().map(|_| lift_m);
        lift.into_iter().chain(arm.iter().copied()).collect()
    }

    fn lift_rest_m(&self) -> f64 {
        self.inner
            .description
            .lift
            .as_ref()
            .map_or(0.0, |lift| lift.rest_m)
    }
}
