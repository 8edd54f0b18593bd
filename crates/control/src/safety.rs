//! The safety envelope σ of the thesis, section 3.2.1: specific to the robot's joints, not to the task.
//!
//! Three measures, as the thesis lists them:
//! 1. The stiffness that a policy may ask for is capped ([`SafetyEnvelope::cap`]), so that the arm stays compliant.
//! 2. Torques are clipped to their range ([`crate::torque_limit`]).
//! 3. Two thresholds guard the joint limits ([`SafetyEnvelope::guard`]). With d the distance of a joint to its nearer limit:
//!    - `d < σ_1`: the task is dropped for a null-space controller that moves the joint away from its limit without
//!      changing the tool's pose;
//!    - `d < σ_2 < σ_1`: the joint is driven away from its limit with all its torque, whatever becomes of the tool.
//!
//! And the failure classifier B: a joint nearer than [`SafetyEnvelope::failure_rad`] to its limit
//! ([`SafetyEnvelope::violation`]).
//!
//! Where we differ from the experiments' released code: while the null-space controller has the arm, the tool is braked
//! with the damping of Eq. 3.1 (else it would coast on with the speed it had), and the posture torque follows a
//! spring towards the middle of the range instead of always saturating one joint, so that the guard does not kick.
//! The second threshold pushes until the joint is on its way back and no longer, for the same reason.
//! Joints without limits (the continuous joints of the Jaco) are never guarded.

use nalgebra::DVector;

use crate::error::check_size;
use crate::impedance::{OperationalSpace, damping};
use crate::robot::Impedance;
use crate::{ArmState, ControlError};

/// Stiffness with which the null-space controller pulls a joint to the middle of its range, 1/s².
const RETREAT_KP: f64 = 100.0;

/// Speed away from the limit at which the second threshold stops pushing, rad/s.
const RETREAT_SPEED: f64 = 0.3;

/// Limits and thresholds of σ.
#[derive(Debug, Clone, PartialEq)]
pub struct SafetyEnvelope {
    limits_rad: Vec<Option<[f64; 2]>>,
    torque_max_nm: Vec<f64>,
    /// σ_1: nearer than this to a limit, the null-space controller takes over, rad.
    pub null_space_rad: f64,
    /// σ_2: nearer than this, the joint is pushed back, rad.
    pub push_back_rad: f64,
    /// B: nearer than this, the motion has failed, rad.
    pub failure_rad: f64,
    /// Largest stiffness, 1/s².
    pub kp_max: f64,
}

/// What the joint-limit guard did.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Zone {
    /// All joints are far from their limits: the task's torques pass.
    Free,
    /// These joints are nearer than σ_1: the null-space controller acts.
    NullSpace(Vec<usize>),
    /// These joints are nearer than σ_2: they are pushed back.
    PushBack(Vec<usize>),
}

impl SafetyEnvelope {
    /// An envelope with the thresholds of the thesis' experiments: σ_1 = 0.3 rad, σ_2 = 0.2 rad, B at 5 degrees, and
    /// stiffness up to 300 1/s².
    ///
    /// `limits_rad` has `None` for a joint without limits.
    ///
    /// # Errors
    /// [`ControlError::Size`] unless there is one limit per torque limit.
    pub fn new(
        limits_rad: Vec<Option<[f64; 2]>>,
        torque_max_nm: Vec<f64>,
    ) -> Result<Self, ControlError> {
        check_size("joint limits", limits_rad.len(), torque_max_nm.len())?;
        Ok(Self {
            limits_rad,
            torque_max_nm,
            null_space_rad: 0.3,
            push_back_rad: 0.2,
            failure_rad: 5.0_f64.to_radians(),
            kp_max: 300.0,
        })
    }

    /// The same envelope with other thresholds.
    ///
    /// # Errors
    /// [`ControlError::Value`] unless σ_1 > σ_2 > B > 0.
    pub fn with_thresholds(
        mut self,
        null_space_rad: f64,
        push_back_rad: f64,
        failure_rad: f64,
    ) -> Result<Self, ControlError> {
        let ordered = null_space_rad > push_back_rad
            && push_back_rad > failure_rad
            && failure_rad > 0.0
            && null_space_rad.is_finite();
        if !ordered {
            return Err(ControlError::Value {
                what: "safety thresholds",
                found: format!("{null_space_rad}, {push_back_rad}, {failure_rad} rad"),
                expected: "null space > push back > failure > 0",
            });
        }
        (self.null_space_rad, self.push_back_rad, self.failure_rad) =
            (null_space_rad, push_back_rad, failure_rad);
        Ok(self)
    }

    /// Gains with the stiffness capped to `[0, kp_max]`.
    pub fn cap(&self, wished: Impedance) -> Impedance {
        Impedance {
            kp_position: wished.kp_position.map(|kp| kp.clamp(0.0, self.kp_max)),
            kp_rotation: wished.kp_rotation.map(|kp| kp.clamp(0.0, self.kp_max)),
            damping_ratio: wished.damping_ratio,
        }
    }

    /// Distance of a joint to its nearer limit, rad, negative beyond it; infinite for a joint without limits.
    pub fn distance(&self, joint: usize, position: f64) -> f64 {
        match self.limits_rad.get(joint) {
            Some(Some([lower, upper])) => (position - lower).min(upper - position),
            _ => f64::INFINITY,
        }
    }

    /// The first joint that B refuses, with its distance to the limit.
    pub fn violation(&self, positions: &DVector<f64>) -> Option<(usize, f64)> {
        positions
            .iter()
            .enumerate()
            .map(|(joint, &position)| (joint, self.distance(joint, position)))
            .find(|(_, distance)| *distance < self.failure_rad)
    }

    /// Passes the task's torques, or replaces them where joints are near their limits.
    ///
    /// # Errors
    /// [`ControlError::Size`] if the envelope is for another arm.
    pub fn guard(
        &self,
        arm: &ArmState,
        space: &OperationalSpace,
        task: DVector<f64>,
    ) -> Result<(DVector<f64>, Zone), ControlError> {
        check_size("safety envelope", self.limits_rad.len(), arm.n_joints())?;
        let nearer_than = |threshold: f64| -> Vec<usize> {
            (0..arm.n_joints())
                .filter(|&joint| self.distance(joint, arm.positions[joint]) < threshold)
                .collect()
        };
        let pushed = nearer_than(self.push_back_rad);
        if !pushed.is_empty() {
            let torques = self.push_back(arm, &pushed);
            return Ok((torques, Zone::PushBack(pushed)));
        }
        let near = nearer_than(self.null_space_rad);
        if !near.is_empty() {
            let torques = self.retreat(arm, space, &near);
            return Ok((torques, Zone::NullSpace(near)));
        }
        Ok((task, Zone::Free))
    }

    /// Direction away from the nearer limit, +1 or -1.
    fn inwards(&self, joint: usize, position: f64) -> f64 {
        match self.limits_rad[joint] {
            Some([lower, upper]) if position - lower > upper - position => -1.0,
            _ => 1.0,
        }
    }

    /// Below σ_2: full torque inwards on the joints concerned, gravity compensation and braking on the others.
    fn push_back(&self, arm: &ArmState, joints: &[usize]) -> DVector<f64> {
        let brake = &arm.mass * &arm.velocities * damping(RETREAT_KP, 1.0);
        let mut torques = &arm.bias - brake;
        for &joint in joints {
            let inwards = self.inwards(joint, arm.positions[joint]);
            let speed = arm.velocities[joint] * inwards;
            let share = (1.0 - speed / RETREAT_SPEED).clamp(0.0, 1.0);
            torques[joint] =
                arm.bias[joint] * (1.0 - share) + inwards * self.torque_max_nm[joint] * share;
        }
        torques
    }

    /// Below σ_1: joints concerned to mid-range in the null space, the tool braked.
    fn retreat(&self, arm: &ArmState, space: &OperationalSpace, joints: &[usize]) -> DVector<f64> {
        let mut pull = -&arm.velocities * damping(RETREAT_KP, 1.0);
        for &joint in joints {
            if let Some([lower, upper]) = self.limits_rad[joint] {
                pull[joint] += RETREAT_KP * ((lower + upper) / 2.0 - arm.positions[joint]);
            }
        }
        let brake = space.inertia * arm.tool_velocity() * damping(RETREAT_KP, 1.0);
        &arm.bias + &space.null_space * (&arm.mass * pull) - arm.jacobian.transpose() * brake
    }
}
