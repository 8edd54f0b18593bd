//! Computed-torque tracking of joint targets.
//!
//! ```text
//! τ = M(q) [q̈_d + kd (q̇_d - q̇) + kp (q_d - q)] + b(q, q̇) + i,   i̇ = ki M (q_d - q),  |i| ≤ i_max
//! ```
//!
//! Source: Siciliano et al., "Robotics: Modelling, Planning and Control", Springer 2009, section 8.5.2 (inverse dynamics
//! control). We differ by the integral term: what the model does not know (friction, the object in the hand) would
//! otherwise leave a steady error. It is limited, so that a blocked arm does not wind up.

use nalgebra::DVector;

use crate::error::{check_finite, check_size};
use crate::{ArmState, ControlError};

/// Gains of joint tracking. The error of a well known arm decays like a second-order system with `kp`, `kd`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointGains {
    /// Stiffness, 1/s².
    pub kp: f64,
    /// Damping, 1/s; critical is `2 sqrt(kp)`.
    pub kd: f64,
    /// Integral gain, 1/s³; stable below `kp kd`.
    pub ki: f64,
    /// Largest integral torque, as a fraction of the torque limit.
    pub integral_fraction_max: f64,
}

impl Default for JointGains {
    /// 30 rad/s, critically damped, and an integral that settles within about a second: a fifth of the bandwidth that a
    /// 500 Hz loop allows.
    fn default() -> Self {
        Self {
            kp: 900.0,
            kd: 60.0,
            ki: 4500.0,
            integral_fraction_max: 0.3,
        }
    }
}

/// Where the joints should be at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct JointTarget {
    /// Positions, rad.
    pub positions: DVector<f64>,
    /// Velocities, rad/s.
    pub velocities: DVector<f64>,
    /// Accelerations, rad/s².
    pub accelerations: DVector<f64>,
}

impl JointTarget {
    /// A target at rest.
    pub fn at_rest(positions: DVector<f64>) -> Self {
        let n = positions.len();
        Self {
            positions,
            velocities: DVector::zeros(n),
            accelerations: DVector::zeros(n),
        }
    }
}

/// Tracks joint targets; holds the integral.
#[derive(Debug, Clone, PartialEq)]
pub struct JointTracker {
    gains: JointGains,
    integral_max: DVector<f64>,
    integral: DVector<f64>,
}

impl JointTracker {
    /// A tracker for joints with these torque limits (N m), with its integral at zero.
    pub fn new(gains: JointGains, torque_max_nm: &[f64]) -> Self {
        let integral_max =
            DVector::from_row_slice(torque_max_nm) * gains.integral_fraction_max.abs();
        Self {
            gains,
            integral: DVector::zeros(integral_max.len()),
            integral_max,
        }
    }

    /// The integral torques, N m.
    pub fn integral(&self) -> &DVector<f64> {
        &self.integral
    }

    /// Sets the integral torques, e.g. from a snapshot; clipped to their limit.
    ///
    /// # Errors
    /// [`ControlError::Size`] unless there is one per joint.
    pub fn set_integral(&mut self, integral: &[f64]) -> Result<(), ControlError> {
        check_size("integral torques", integral.len(), self.integral.len())?;
        self.integral = DVector::from_row_slice(integral).zip_map(&self.integral_max, clip);
        Ok(())
    }

    /// Forgets the integral.
    pub fn reset(&mut self) {
        self.integral.fill(0.0);
    }

    /// Joint torques towards the target, n values in N m, before any limit; advances the integral by `dt_secs`.
    ///
    /// # Errors
    /// Sizes that disagree, or numbers that are not finite.
    pub fn torques(
        &mut self,
        arm: &ArmState,
        target: &JointTarget,
        dt_secs: f64,
    ) -> Result<DVector<f64>, ControlError> {
        arm.check()?;
        let n = arm.n_joints();
        check_size("joint tracker", self.integral.len(), n)?;
        check_size("target positions", target.positions.len(), n)?;
        check_size("target velocities", target.velocities.len(), n)?;
        check_size("target accelerations", target.accelerations.len(), n)?;
        check_finite("target positions", target.positions.iter())?;
        check_finite("target velocities", target.velocities.iter())?;
        check_finite("target accelerations", target.accelerations.iter())?;
        let error = &target.positions - &arm.positions;
        let step = &arm.mass * &error * (self.gains.ki * dt_secs);
        self.integral = (&self.integral + step).zip_map(&self.integral_max, clip);
        let acceleration = &target.accelerations
            + (&target.velocities - &arm.velocities) * self.gains.kd
            + error * self.gains.kp;
        Ok(&arm.mass * acceleration + &arm.bias + &self.integral)
    }
}

fn clip(value: f64, limit: f64) -> f64 {
    value.clamp(-limit, limit)
}
