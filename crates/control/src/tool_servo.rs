//! From where a policy wants the tool to motor torques, once per control step: thesis Eq. 3.1, the guard of the joint
//! limits, and the limits of the motors.
//!
//! The apparent inertia Λ and the null space change slowly; they are computed anew every [`SPACE_STEPS`] steps, tool
//! pose, velocities and bias forces at every step.

use nalgebra::DVector;

use crate::barrier::JointBarrier;
use crate::impedance::{OperationalSpace, Posture, ToolTarget, impedance_torques_in};
use crate::robot::{GuardSpec, Impedance};
use crate::safety::SafetyEnvelope;
use crate::torque_limit::TorqueLimiter;
use crate::{ArmState, ControlError};

/// Steps for which Λ is kept: 10 ms at 2 ms a step, in which a joint at 2 rad/s turns by 0.02 rad.
pub const SPACE_STEPS: u32 = 5;

/// What keeps the joints from their limits.
#[derive(Debug, Clone, PartialEq)]
pub enum JointGuard {
    /// Nothing.
    None,
    /// The two thresholds of σ.
    Envelope(SafetyEnvelope),
    /// The barrier, which cannot be passed.
    Barrier(JointBarrier),
}

impl JointGuard {
    /// The guard for an arm with these limits of its joints (rad, `None` for one that turns without end), joint speeds
    /// (rad/s) and motors (N m).
    ///
    /// # Errors
    /// [`ControlError`] if sizes disagree or a distance makes no sense.
    pub fn new(
        spec: GuardSpec,
        limits_rad: &[Option<[f64; 2]>],
        speed_max_rad_per_s: &[f64],
        torque_max_nm: &[f64],
    ) -> Result<Self, ControlError> {
        Ok(match spec {
            GuardSpec::None => Self::None,
            GuardSpec::Envelope {
                null_space_rad,
                push_back_rad,
            } => {
                let envelope = SafetyEnvelope::new(limits_rad.to_vec(), torque_max_nm.to_vec())?;
                let failure_rad = envelope.failure_rad;
                Self::Envelope(envelope.with_thresholds(
                    null_space_rad,
                    push_back_rad,
                    failure_rad,
                )?)
            }
            GuardSpec::Barrier { margin_rad } => Self::Barrier(JointBarrier::new(
                limits_rad.to_vec(),
                speed_max_rad_per_s.to_vec(),
                margin_rad,
            )?),
        })
    }
}

/// Drives the tool to a target that may change at every step.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolServo {
    guard: JointGuard,
    limiter: TorqueLimiter,
    posture: Posture,
    space: Option<OperationalSpace>,
    space_age: u32,
}

impl ToolServo {
    /// A servo for motors of these limits (N m), with the arm at rest in the posture that it keeps.
    pub fn new(torque_max_nm: &[f64], guard: JointGuard, positions: DVector<f64>) -> Self {
        Self {
            guard,
            limiter: TorqueLimiter::new(torque_max_nm),
            posture: Posture::soft(positions),
            space: None,
            space_age: 0,
        }
    }

    /// Begins anew from an arm at rest, whose posture is kept from now on.
    ///
    /// # Errors
    /// [`ControlError::Size`] if the arm has another number of joints.
    pub fn restart(&mut self, arm: &ArmState) -> Result<(), ControlError> {
        self.posture.positions.clone_from(&arm.positions);
        self.limiter.set_last(&arm.bias)?;
        self.space = None;
        if let JointGuard::Barrier(barrier) = &mut self.guard {
            barrier.restart();
        }
        Ok(())
    }

    /// Motor torques for the next `dt_secs`, N m.
    ///
    /// # Errors
    /// [`ControlError`] if sizes disagree or a number is not finite.
    pub fn torques(
        &mut self,
        arm: &ArmState,
        target: &ToolTarget,
        gains: &Impedance,
        dt_secs: f64,
    ) -> Result<&DVector<f64>, ControlError> {
        let space = match &mut self.space {
            Some(space) if self.space_age < SPACE_STEPS => space,
            stale => {
                self.space_age = 0;
                stale.insert(OperationalSpace::of(arm)?)
            }
        };
        self.space_age += 1;
        let gains = match &self.guard {
            JointGuard::Envelope(envelope) => envelope.cap(*gains),
            JointGuard::None | JointGuard::Barrier(_) => *gains,
        };
        let task = impedance_torques_in(space, arm, target, &gains, Some(&self.posture))?;
        match &mut self.guard {
            JointGuard::None => self.limiter.limit(&task, dt_secs),
            JointGuard::Envelope(envelope) => {
                let (guarded, _) = envelope.guard(arm, space, task)?;
                self.limiter.limit(&guarded, dt_secs)
            }
            JointGuard::Barrier(barrier) => {
                // The gears are spared first; nothing comes after the barrier but the motors' own limit.
                let before = self.limiter.last().clone();
                let spared = self.limiter.limit(&task, dt_secs)?.clone();
                let kept = barrier.filter(arm, &spared, &before, self.limiter.max(), dt_secs)?;
                self.limiter.set_last(&kept)?;
                Ok(self.limiter.last())
            }
        }
    }
}
