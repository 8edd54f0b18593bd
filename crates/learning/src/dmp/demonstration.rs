//! Samples taken at equal steps: what they must be, and their velocities and accelerations.

use super::error::check_positive;
use super::{DmpError, DmpParams};
use nalgebra::DMatrix;

/// Checks the parameters, the step and the number of samples, and returns the first and the last of them.
pub(super) fn ends_of<'a, T>(
    demonstration: &'a [T],
    step_s: f64,
    params: &DmpParams,
) -> Result<(&'a T, &'a T), DmpError> {
    params.check()?;
    check_positive("step", step_s)?;
    let (found, wanted) = (demonstration.len(), params.n_kernels.max(3));
    match demonstration {
        [start, .., goal] if found >= wanted => Ok((start, goal)),
        _ => Err(DmpError::TooFewSamples { found, wanted }),
    }
}

/// Time derivative of each row of `(n_dims, n_samples)` by second-order differences, one-sided at both ends.
///
/// Needs at least three samples.
pub(super) fn derivative(samples: &DMatrix<f64>, step_s: f64) -> DMatrix<f64> {
    let last = samples.ncols() - 1;
    DMatrix::from_fn(samples.nrows(), samples.ncols(), |dim, k| {
        let at = |k: usize| samples[(dim, k)];
        let twice = if k == 0 {
            4.0 * at(1) - 3.0 * at(0) - at(2)
        } else if k == last {
            3.0 * at(last) - 4.0 * at(last - 1) + at(last - 2)
        } else {
            at(k + 1) - at(k - 1)
        };
        twice / (2.0 * step_s)
    })
}
