//! What is chosen before learning.

use super::DmpError;
use super::error::check_positive;

/// Form of a primitive; the defaults reproduce a minimum-jerk motion to within 0.3 % of its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DmpParams {
    /// Kernels per dimension, at least 2. The error of reproduction falls with its square; each needs a sample.
    pub n_kernels: usize,
    /// `alpha_z`: how fast the spring pulls, in units of 1 / duration. Ijspeert et al. use 25.
    pub damping: f64,
    /// `alpha_x`: the phase is `exp(-alpha_x)` when the duration is over. Default ln 100: one per cent is left.
    pub phase_decay: f64,
}

impl Default for DmpParams {
    fn default() -> Self {
        Self {
            n_kernels: 30,
            damping: 25.0,
            phase_decay: 100.0_f64.ln(),
        }
    }
}

impl DmpParams {
    pub(super) fn check(&self) -> Result<(), DmpError> {
        if self.n_kernels < 2 {
            return Err(DmpError::OutOfRange {
                name: "number of kernels",
                found: self.n_kernels as f64,
                wanted: "at least 2",
            });
        }
        check_positive("damping", self.damping)?;
        check_positive("phase decay", self.phase_decay)
    }
}
