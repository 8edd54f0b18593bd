//! Learned forces over the phase, one per dimension.

use super::canonical::phase_at;
use super::error::{check_finite, check_size};
use super::{DmpError, DmpParams};
use nalgebra::DMatrix;

/// Narrowness of the kernels: half way to the next centre each has fallen to 1/e. Chosen by measurement: 1 and 2 smooth
/// a minimum-jerk motion three and two times as much.
const OVERLAP: f64 = 4.0;

/// Forces over the phase: kernels shared by all dimensions, and one weight per dimension and kernel.
#[derive(Debug, Clone, PartialEq)]
pub struct ForcingTerms {
    /// Phases at which the kernels peak, falling; evenly spread in time.
    centers: Vec<f64>,
    /// `h_i`, [`OVERLAP`] over the squared distance to the next centre.
    widths: Vec<f64>,
    /// `(n_dims, n_kernels)`.
    weights: DMatrix<f64>,
}

impl ForcingTerms {
    /// Fits weights by locally weighted regression to `(n_dims, n_samples)` forces at equal steps over the duration.
    ///
    /// Each kernel's weight is the least-squares slope of force over phase, samples weighted by the kernel.
    pub(super) fn fit(params: &DmpParams, forces: &DMatrix<f64>) -> Self {
        let (centers, widths) = kernels(params);
        let n_steps = (forces.ncols() - 1) as f64;
        let phases: Vec<f64> = (0..forces.ncols())
            .map(|k| phase_at(k as f64 / n_steps, params.phase_decay))
            .collect();
        let weights = DMatrix::from_fn(forces.nrows(), params.n_kernels, |dim, i| {
            let (mut along, mut square) = (0.0, 0.0);
            for (k, &x) in phases.iter().enumerate() {
                let psi = (-widths[i] * (x - centers[i]).powi(2)).exp();
                along += psi * x * forces[(dim, k)];
                square += psi * x * x;
            }
            // No sample under the kernel: nothing is known, no force.
            if square > 0.0 { along / square } else { 0.0 }
        });
        Self {
            centers,
            widths,
            weights,
        }
    }

    /// The weights, `(n_dims, n_kernels)`: what policy search changes.
    #[must_use]
    pub fn weights(&self) -> &DMatrix<f64> {
        &self.weights
    }

    /// Replaces the weights.
    ///
    /// # Errors
    /// [`DmpError`] when their shape is another or one is not finite.
    pub fn set_weights(&mut self, weights: DMatrix<f64>) -> Result<(), DmpError> {
        check_size("weights, dimensions", weights.nrows(), self.weights.nrows())?;
        check_size("weights, kernels", weights.ncols(), self.weights.ncols())?;
        check_finite("weights", weights.iter())?;
        self.weights = weights;
        Ok(())
    }

    /// Shares of the kernels at a phase, times the phase, into `activations` (length `n_kernels`).
    pub(super) fn activate_into(&self, phase: f64, activations: &mut [f64]) {
        let mut highest = f64::NEG_INFINITY;
        for ((out, center), width) in activations.iter_mut().zip(&self.centers).zip(&self.widths) {
            *out = -width * (phase - center).powi(2);
            highest = highest.max(*out);
        }
        // Relative to the strongest kernel, so that the sum cannot vanish far beyond the last centre.
        let mut sum = 0.0;
        for out in activations.iter_mut() {
            *out = (*out - highest).exp();
            sum += *out;
        }
        for out in activations.iter_mut() {
            *out *= phase / sum;
        }
    }

    /// Force of one dimension under activations.
    pub(super) fn force(&self, dim: usize, activations: &[f64]) -> f64 {
        activations
            .iter()
            .enumerate()
            .map(|(i, activation)| activation * self.weights[(dim, i)])
            .sum()
    }

    pub(super) fn n_kernels(&self) -> usize {
        self.centers.len()
    }
}

/// Centres evenly spread in time, and widths that let neighbours overlap alike.
fn kernels(params: &DmpParams) -> (Vec<f64>, Vec<f64>) {
    let n_gaps = params.n_kernels - 1;
    let centers: Vec<f64> = (0..=n_gaps)
        .map(|i| phase_at(i as f64 / n_gaps as f64, params.phase_decay))
        .collect();
    let widths = (0..=n_gaps)
        .map(|i| {
            let gap = i.min(n_gaps - 1);
            OVERLAP * (centers[gap] - centers[gap + 1]).powi(-2)
        })
        .collect();
    (centers, widths)
}
