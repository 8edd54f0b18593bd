//! Velocities and accelerations of samples taken at equal steps.

use nalgebra::DMatrix;

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
