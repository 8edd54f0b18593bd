//! Learned forces over the phase, one per dimension.

use super::canonical::phase_at;
use super::error::{check_finite, check_size};
use super::{DmpError, DmpParams};
use crate::lwr::{Activation, LocalModel, LocallyWeightedRegression, LwrError, ReceptiveFields};
use nalgebra::DMatrix;

/// Narrowness of the kernels: half way to the next centre each has fallen to 1/e. Chosen by measurement: 1 and 2 smooth
/// a minimum-jerk motion three and two times as much.
const OVERLAP: f64 = 4.0;

/// Forces over the phase: kernels shared by all dimensions, and one weight per dimension and kernel.
///
/// A locally weighted regression whose models are lines through the origin: a weight is the slope of a force over the
/// phase.
#[derive(Debug, Clone, PartialEq)]
pub struct ForcingTerms {
    force: LocallyWeightedRegression,
}

impl ForcingTerms {
    /// Fits weights by locally weighted regression to `(n_dims, n_samples)` forces at equal steps over the duration.
    pub(super) fn fit(params: &DmpParams, forces: &DMatrix<f64>) -> Result<Self, DmpError> {
        let n_steps = (forces.ncols() - 1) as f64;
        let phases = DMatrix::from_fn(1, forces.ncols(), |_, k| {
            phase_at(k as f64 / n_steps, params.phase_decay)
        });
        let form = LocalModel::ThroughOrigin;
        let force = kernels(params)
            .and_then(|kernels| LocallyWeightedRegression::fit(kernels, form, &phases, forces))
            .map_err(|source| DmpError::Forces { source })?;
        Ok(Self { force })
    }

    /// The weights, `(n_dims, n_kernels)`: what policy search changes.
    #[must_use]
    pub fn weights(&self) -> &DMatrix<f64> {
        self.force.models()
    }

    /// Replaces the weights.
    ///
    /// # Errors
    /// [`DmpError`] when their shape is another or one is not finite.
    pub fn set_weights(&mut self, weights: DMatrix<f64>) -> Result<(), DmpError> {
        let (n_dims, n_kernels) = self.weights().shape();
        check_size("weights, dimensions", weights.nrows(), n_dims)?;
        check_size("weights, kernels", weights.ncols(), n_kernels)?;
        check_finite("weights", weights.iter())?;
        self.force
            .set_models(weights)
            .map_err(|source| DmpError::Forces { source })
    }

    /// Memory for [`Self::force_into`].
    pub(super) fn activation(&self) -> Activation {
        self.force.fields().activation()
    }

    /// Kernels that count at a phase, each with its share.
    pub(super) fn kernel_shares(&self, phase: f64) -> Vec<(usize, f64)> {
        let fields = self.force.fields();
        let mut activation = fields.activation();
        fields.activate_into(&[phase], &mut activation);
        activation.shares().collect()
    }

    /// Forces of all dimensions at a phase.
    pub(super) fn force_into(&self, phase: f64, activation: &mut Activation, out: &mut [f64]) {
        self.force.evaluate_into(&[phase], activation, out);
    }
}

/// Kernels whose centres are evenly spread in time, of widths that let neighbours overlap alike.
fn kernels(params: &DmpParams) -> Result<ReceptiveFields, LwrError> {
    let n_gaps = params.n_kernels - 1;
    let centers = DMatrix::from_fn(1, params.n_kernels, |_, i| {
        phase_at(i as f64 / n_gaps as f64, params.phase_decay)
    });
    let widths = DMatrix::from_fn(1, params.n_kernels, |_, i| {
        let gap = i.min(n_gaps - 1);
        OVERLAP * (centers[gap] - centers[gap + 1]).powi(-2)
    });
    ReceptiveFields::new(&centers, &widths)
}
