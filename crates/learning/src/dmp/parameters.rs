//! What policy search changes of a primitive, as one list of numbers.
//!
//! The list has the weights of each dimension, kernel after kernel; then the goal; then the logarithm of the speed,
//! `-ln(duration / s)`, so that no number is a duration below zero.

use super::error::{check_finite, check_size};
use super::position::{PositionDmp, PositionMotion};
use super::{DmpError, canonical::substeps};
use nalgebra::DMatrix;

impl PositionDmp {
    /// Weights, goal and speed of a run of this primitive.
    #[must_use]
    pub fn parameters(&self, motion: &PositionMotion) -> Vec<f64> {
        let weights = self.forcing().weights().transpose();
        weights
            .iter()
            .chain(&motion.goal)
            .copied()
            .chain([-motion.duration_s.ln()])
            .collect()
    }

    /// The primitive and the run that have these weights, goal and speed, and all else from this one.
    ///
    /// # Errors
    /// [`DmpError`] when there is another number of parameters or one is not finite.
    pub fn with_parameters(
        &self,
        motion: &PositionMotion,
        parameters: &[f64],
    ) -> Result<(Self, PositionMotion), DmpError> {
        let (n_dims, n_kernels) = self.forcing().weights().shape();
        let n_weights = n_dims * n_kernels;
        check_size("parameters", parameters.len(), n_weights + n_dims + 1)?;
        check_finite("parameters", parameters)?;
        let (weights, rest) = parameters.split_at(n_weights);
        let (goal, speed) = rest.split_at(n_dims);
        let mut changed = self.clone();
        let weights = DMatrix::from_row_slice(n_dims, n_kernels, weights);
        changed.forcing_mut().set_weights(weights)?;
        let mut motion = motion.clone();
        motion.goal.copy_from_slice(goal);
        for speed in speed {
            motion.duration_s = (-speed).exp();
        }
        Ok((changed, motion))
    }

    /// Sizes of the runs of parameters that belong together: the weights of each dimension, the goal, the speed.
    #[must_use]
    pub fn parameter_blocks(&self) -> Vec<usize> {
        let (n_dims, n_kernels) = self.forcing().weights().shape();
        let mut sizes = vec![n_kernels; n_dims];
        sizes.extend([n_dims, 1]);
        sizes
    }

    /// How much each parameter has to say in each of `n_steps` steps of a run, `(n_parameters, n_steps)`: the share of
    /// its kernel, and 1 for goal and speed.
    ///
    /// # Errors
    /// [`DmpError::OutOfRange`] when the step is not positive or longer than a thousand durations.
    pub fn parameter_activity(
        &self,
        motion: &PositionMotion,
        step_s: f64,
        n_steps: usize,
    ) -> Result<DMatrix<f64>, DmpError> {
        substeps(step_s, motion.duration_s, 1.0)?;
        let (n_dims, n_kernels) = self.forcing().weights().shape();
        let n_weights = n_dims * n_kernels;
        let mut activity = DMatrix::from_element(n_weights + n_dims + 1, n_steps, 1.0);
        activity.rows_mut(0, n_weights).fill(0.0);
        for (step, mut column) in activity.column_iter_mut().enumerate() {
            let share = step as f64 * step_s / motion.duration_s;
            for (kernel, share) in self.kernel_shares(share) {
                for dim in 0..n_dims {
                    column[dim * n_kernels + kernel] = share;
                }
            }
        }
        Ok(activity)
    }
}
