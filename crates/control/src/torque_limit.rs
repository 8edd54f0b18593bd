//! Torque and torque rate limits.
//!
//! A command is clipped to `|τ_i| ≤ max_i` and may change by at most `rate_i · dt` per step. The rate limit spares the
//! gears a step when the impedance or the target changes suddenly.

use nalgebra::DVector;

use crate::ControlError;
use crate::error::{check_finite, check_size};

/// Time in which a joint may go from no torque to full torque, seconds.
///
/// The thesis' experiments change 80 N m by at most 10 N m per 2 ms step: 16 ms.
pub const FULL_TORQUE_SECS: f64 = 0.016;

/// Limits torques and their rates; remembers the last command.
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueLimiter {
    max: DVector<f64>,
    rate_max: DVector<f64>,
    last: DVector<f64>,
}

impl TorqueLimiter {
    /// Limits of `torque_max_nm` (N m), reached from zero in [`FULL_TORQUE_SECS`]; the last command counts as zero.
    pub fn new(torque_max_nm: &[f64]) -> Self {
        let max = DVector::from_row_slice(torque_max_nm);
        Self {
            rate_max: &max / FULL_TORQUE_SECS,
            last: DVector::zeros(max.len()),
            max,
        }
    }

    /// Torque limits, N m.
    pub fn max(&self) -> &DVector<f64> {
        &self.max
    }

    /// The last command, N m.
    pub fn last(&self) -> &DVector<f64> {
        &self.last
    }

    /// Takes `torques` (clipped) as the last command, so that the next may start from there.
    ///
    /// # Errors
    /// [`ControlError::Size`] unless there is one per joint, [`ControlError::NotFinite`] for a number that is not.
    pub fn set_last(&mut self, torques: &DVector<f64>) -> Result<(), ControlError> {
        self.check(torques)?;
        self.last = torques.zip_map(&self.max, |value, limit| value.clamp(-limit, limit));
        Ok(())
    }

    /// The torques nearest to `wished` that keep both limits for a step of `dt_secs`; they become the last command.
    ///
    /// # Errors
    /// [`ControlError::Size`] unless there is one per joint, [`ControlError::NotFinite`] for a number that is not.
    pub fn limit(
        &mut self,
        wished: &DVector<f64>,
        dt_secs: f64,
    ) -> Result<&DVector<f64>, ControlError> {
        self.check(wished)?;
        for i in 0..self.max.len() {
            let step = self.rate_max[i] * dt_secs;
            let near = wished[i].clamp(self.last[i] - step, self.last[i] + step);
            self.last[i] = near.clamp(-self.max[i], self.max[i]);
        }
        Ok(&self.last)
    }

    fn check(&self, torques: &DVector<f64>) -> Result<(), ControlError> {
        check_size("torques", torques.len(), self.max.len())?;
        check_finite("torques", torques.iter())
    }
}
