//! The transformation system: in each dimension a critically damped spring to the goal, and a learned force.

use super::canonical::phase_at;
use super::demonstration::derivative;
use super::{DmpParams, ForcingTerms};
use nalgebra::DMatrix;

/// What primitives of positions and of rotations have in common: springs, and forces learned over the phase.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ForcedSprings {
    pub(super) forcing: ForcingTerms,
    /// `alpha_z`; `beta_z` is a quarter of it, which makes the damping critical.
    damping: f64,
    phase_decay: f64,
}

impl ForcedSprings {
    /// Learns the forces under which the springs move as shown: the way left to the goal and the velocity, both
    /// `(n_dims, n_samples)`, at equal steps.
    pub(super) fn learn(
        to_goal: &DMatrix<f64>,
        velocities: &DMatrix<f64>,
        step_s: f64,
        params: &DmpParams,
    ) -> Self {
        let accelerations = derivative(velocities, step_s);
        let duration_s = step_s * (velocities.ncols() - 1) as f64;
        let forces = DMatrix::from_fn(velocities.nrows(), velocities.ncols(), |dim, k| {
            let at = (dim, k);
            let pull = pull(params.damping, to_goal[at], velocities[at], duration_s);
            duration_s * duration_s * accelerations[at] - pull
        });
        Self {
            forcing: ForcingTerms::fit(params, &forces),
            damping: params.damping,
            phase_decay: params.phase_decay,
        }
    }

    /// Sets `activations` to those of the kernels after a share of the duration.
    pub(super) fn activate_into(&self, share: f64, activations: &mut [f64]) {
        self.forcing
            .activate_into(phase_at(share, self.phase_decay), activations);
    }

    /// Acceleration in one dimension from the way left to the goal, the velocity, and the learned force times `scale`.
    pub(super) fn acceleration(
        &self,
        dim: usize,
        (to_goal, velocity): (f64, f64),
        (scale, activations): (f64, &[f64]),
        duration_s: f64,
    ) -> f64 {
        let force = scale * self.forcing.force(dim, activations);
        (pull(self.damping, to_goal, velocity, duration_s) + force) / (duration_s * duration_s)
    }
}

fn pull(damping: f64, to_goal: f64, velocity: f64, duration_s: f64) -> f64 {
    damping * (0.25 * damping * to_goal - duration_s * velocity)
}
