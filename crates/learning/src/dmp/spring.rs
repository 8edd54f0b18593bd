//! The transformation system: in each dimension a critically damped spring to the goal, and a learned force.

use super::canonical::phase_at;
use super::demonstration::derivative;
use super::{DmpError, DmpParams, ForcingTerms};
use crate::lwr::Activation;
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
    ) -> Result<Self, DmpError> {
        let accelerations = derivative(velocities, step_s);
        let duration_s = step_s * (velocities.ncols() - 1) as f64;
        let forces = DMatrix::from_fn(velocities.nrows(), velocities.ncols(), |dim, k| {
            let at = (dim, k);
            let pull = pull(params.damping, to_goal[at], velocities[at], duration_s);
            duration_s * duration_s * accelerations[at] - pull
        });
        Ok(Self {
            forcing: ForcingTerms::fit(params, &forces)?,
            damping: params.damping,
            phase_decay: params.phase_decay,
        })
    }

    /// Learned forces of all dimensions after a share of the duration.
    pub(super) fn force_into(&self, share: f64, activation: &mut Activation, out: &mut [f64]) {
        let phase = phase_at(share, self.phase_decay);
        self.forcing.force_into(phase, activation, out);
    }

    /// Kernels that count after a share of the duration, each with its share of the force.
    pub(super) fn kernel_shares(&self, share: f64) -> Vec<(usize, f64)> {
        self.forcing
            .kernel_shares(phase_at(share, self.phase_decay))
    }

    /// Acceleration in one dimension from the way left to the goal, the velocity, and the force.
    pub(super) fn acceleration(
        &self,
        (to_goal, velocity): (f64, f64),
        force: f64,
        duration_s: f64,
    ) -> f64 {
        (pull(self.damping, to_goal, velocity, duration_s) + force) / (duration_s * duration_s)
    }

    /// How a free spring moves in a step.
    pub(super) fn response(&self, step_s: f64, duration_s: f64) -> Response {
        Response::new(0.5 * self.damping / duration_s, step_s, duration_s)
    }
}

fn pull(damping: f64, to_goal: f64, velocity: f64, duration_s: f64) -> f64 {
    damping * (0.25 * damping * to_goal - duration_s * velocity)
}

/// The exact motion of a critically damped spring in a step, and its response to the force at two moments in it.
///
/// With `l = alpha_z / (2 tau)` the spring is `y'' = l^2 (g - y) - 2 l y' + f / tau^2`. Without a force, `e = y - g`
/// becomes `((1 + l h) e + h v) exp(-l h)` and `v` becomes `((1 - l h) v - l^2 h e) exp(-l h)`; an impulse moves it by
/// `r exp(-l r)` after a time `r`. The force is integrated by Gauss and Legendre's rule with two nodes, so the error
/// of a step is of fifth order in the force alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Response {
    /// New way to the goal and velocity from the old, row by row.
    free: [[f64; 2]; 2],
    /// Change of position and velocity by the force at each node.
    forced: [[f64; 2]; 2],
}

impl Response {
    /// Where in a step the force is asked for, as shares of it: `1/2 -+ sqrt(3)/6`.
    pub(super) const NODES: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

    fn new(rate: f64, step_s: f64, duration_s: f64) -> Self {
        let (lh, decay) = (rate * step_s, (-rate * step_s).exp());
        let impulse = |left: f64| {
            let r = left * step_s;
            let weight = 0.5 * step_s / (duration_s * duration_s) * (-rate * r).exp();
            [weight * r, weight * (1.0 - rate * r)]
        };
        // The nodes lie alike from both ends: what is left after the first is the second.
        Self {
            free: [
                [(1.0 + lh) * decay, step_s * decay],
                [-rate * lh * decay, (1.0 - lh) * decay],
            ],
            forced: [impulse(Self::NODES[1]), impulse(Self::NODES[0])],
        }
    }

    /// Position less goal and velocity after the step.
    pub(super) fn after(&self, from_goal: f64, velocity: f64, forces: [f64; 2]) -> (f64, f64) {
        let part = |i: usize| {
            self.free[i][0] * from_goal
                + self.free[i][1] * velocity
                + self.forced[0][i] * forces[0]
                + self.forced[1][i] * forces[1]
        };
        (part(0), part(1))
    }
}
