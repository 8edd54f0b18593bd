//! External wrench on the tool, from joint torques and motion, without a force sensor.
//!
//! From `M q̈ + b = τ + Jᵀ f`: `τ_ext = M q̈ + b - τ`, smoothed by a first-order low pass, then
//! `f = (J Jᵀ + λ² I)⁻¹ J τ_ext` (damped least squares, λ for singular postures).
//!
//! This is the direct form of the residual of De Luca et al., "Collision detection and safe reaction with the DLR-III
//! lightweight manipulator arm", IROS 2006, doi:10.1109/IROS.2006.282053. Theirs avoids q̈ by integrating the momentum;
//! a simulated encoder has no noise, so differencing the velocity loses nothing, and the filter is the same.
//! Joint friction and the weight of an object in the hand appear in the estimate, as they do on a real arm.

use nalgebra::{DVector, Matrix6, Vector6};

use crate::error::{check_finite, check_size};
use crate::{ArmState, ControlError};

/// Time constant of the low pass, seconds: fast enough to stop within a centimetre at 0.2 m/s.
const FILTER_SECS: f64 = 0.02;

/// λ of the damped least squares, in the unit of J (m, with angular rows weighed by 1 m).
const DAMPING: f64 = 0.02;

/// Estimates the wrench from one control step to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct WrenchEstimate {
    velocities_before: Option<DVector<f64>>,
    torques_external: DVector<f64>,
}

impl WrenchEstimate {
    /// An estimate of zero for an arm of `n_joints`.
    pub fn new(n_joints: usize) -> Self {
        Self {
            velocities_before: None,
            torques_external: DVector::zeros(n_joints),
        }
    }

    /// The smoothed external joint torques, N m, and the joint velocities they were last differenced from.
    pub fn memory(&self) -> (&DVector<f64>, Option<&DVector<f64>>) {
        (&self.torques_external, self.velocities_before.as_ref())
    }

    /// An estimate that goes on from a [`memory`](Self::memory).
    pub fn from_memory(
        torques_external: DVector<f64>,
        velocities_before: Option<DVector<f64>>,
    ) -> Self {
        Self {
            velocities_before,
            torques_external,
        }
    }

    /// Takes one step into account: the arm now, and the torques applied during the `dt_secs` that led here.
    ///
    /// # Errors
    /// Sizes that disagree, or torques that are not finite.
    pub fn update(
        &mut self,
        arm: &ArmState,
        torques_applied: &DVector<f64>,
        dt_secs: f64,
    ) -> Result<(), ControlError> {
        check_size(
            "wrench estimate",
            self.torques_external.len(),
            arm.n_joints(),
        )?;
        check_size("applied torques", torques_applied.len(), arm.n_joints())?;
        check_finite("applied torques", torques_applied.iter())?;
        if let Some(before) = &self.velocities_before {
            let acceleration = (&arm.velocities - before) / dt_secs;
            let external = &arm.mass * acceleration + &arm.bias - torques_applied;
            let share = dt_secs / (FILTER_SECS + dt_secs);
            self.torques_external += (external - &self.torques_external) * share;
        }
        self.velocities_before = Some(arm.velocities.clone());
        Ok(())
    }

    /// The wrench that the surroundings exert on the tool, in the base frame: force (N), then torque (N m).
    pub fn wrench(&self, arm: &ArmState) -> Vector6<f64> {
        let gram: Matrix6<f64> =
            &arm.jacobian * arm.jacobian.transpose() + Matrix6::identity() * (DAMPING * DAMPING);
        let moment: Vector6<f64> = &arm.jacobian * &self.torques_external;
        // Positive definite by the damping; zero is the honest answer if numbers have gone bad.
        gram.cholesky()
            .map_or_else(Vector6::zeros, |cholesky| cholesky.solve(&moment))
    }
}
