//! The object's own motion as an action: the tool goes along with the joint, as the object's model says it moves.
//!
//! A policy that corrects this needs to learn what the model does not know (dynamics, friction, compliance), instead of
//! where a door goes. The correction is capped, so that it can do no harm beyond the cap.

use factotum_learning::action::{ActionError, CappedCorrection};
use serde::{Deserialize, Serialize};

use super::action::{ActionRanges, GRIPPER, N_ACTION};
use super::hand_motion::HandMotion;
use super::rig::Reading;

/// How the motion is followed, and how far a policy may correct it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuideParams {
    /// How far ahead of the tool its target is, as a share of what an action can displace it.
    pub reach: f64,
    /// Stiffness, as a share of the largest.
    pub stiffness: f64,
    /// Cap of the correction of stiffness, displacement and rotation; the gripper stays closed.
    pub cap: f32,
}

impl Default for GuideParams {
    fn default() -> Self {
        Self {
            reach: 0.8,
            stiffness: 0.6,
            cap: 0.1,
        }
    }
}

/// The motion of the object, as actions.
#[derive(Debug, Clone, PartialEq)]
pub struct Guide {
    params: GuideParams,
    correction: CappedCorrection,
    motion: HandMotion,
    forward: f64,
}

impl Guide {
    /// A guide for a hand, from the joint's start to its goal.
    ///
    /// # Errors
    /// [`ActionError`] for a cap that is not within 0 to 1.
    pub fn new(
        params: GuideParams,
        motion: HandMotion,
        start: f64,
        goal: f64,
    ) -> Result<Self, ActionError> {
        let mut caps = vec![params.cap; N_ACTION];
        caps[GRIPPER] = 0.0;
        Ok(Self {
            params,
            correction: CappedCorrection::new(caps)?,
            motion,
            forward: (goal - start).signum(),
        })
    }

    /// The action that goes along with the joint from here.
    pub fn action(&self, reading: &Reading, ranges: &ActionRanges) -> [f32; N_ACTION] {
        // The tool's path for a small motion of the joint, lengthened to the reach.
        const SMALL: f64 = 1e-3;
        let object = &reading.base_from_object;
        let here = reading.object_joint;
        let along = |step: f64| {
            let way = [here, here + self.forward * step];
            self.motion.tool(way, |moved| {
                object * moved * object.inverse() * reading.base_from_tcp
            })
        };
        let small = along(SMALL);
        let moved = (small.translation.vector - reading.base_from_tcp.translation.vector).norm()
            / ranges.displacement_max_m;
        let turned =
            small.rotation.angle_to(&reading.base_from_tcp.rotation) / ranges.rotation_max_rad;
        let step = SMALL * self.params.reach / moved.max(turned).max(1e-9);
        ranges.towards(&reading.base_from_tcp, &along(step), self.params.stiffness)
    }

    /// The guide's action with a policy's correction.
    ///
    /// # Errors
    /// [`ActionError`] for a correction of another size.
    pub fn corrected(
        &self,
        reading: &Reading,
        ranges: &ActionRanges,
        correction: &[f32],
    ) -> Result<[f32; N_ACTION], ActionError> {
        let base = self.action(reading, ranges);
        let mut corrected = [0.0; N_ACTION];
        let n = correction.len().min(N_ACTION);
        corrected[..n].copy_from_slice(&correction[..n]);
        self.correction.apply(&base, &mut corrected)?;
        Ok(corrected)
    }
}
