//! The transformation system of one dimension: a critically damped spring to the goal, and a force.

/// The spring's constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spring {
    /// `alpha_z`; `beta_z` is a quarter of it, which makes the damping critical.
    pub(super) damping: f64,
}

impl Spring {
    /// Acceleration from the way left to the goal, the velocity and the force.
    pub(super) fn acceleration(
        self,
        to_goal: f64,
        velocity: f64,
        force: f64,
        duration_s: f64,
    ) -> f64 {
        (self.pull(to_goal, velocity, duration_s) + force) / (duration_s * duration_s)
    }

    /// The force under which the spring moves with this acceleration: the inverse of [`Spring::acceleration`].
    pub(super) fn force(
        self,
        to_goal: f64,
        velocity: f64,
        acceleration: f64,
        duration_s: f64,
    ) -> f64 {
        duration_s * duration_s * acceleration - self.pull(to_goal, velocity, duration_s)
    }

    fn pull(self, to_goal: f64, velocity: f64, duration_s: f64) -> f64 {
        self.damping * (0.25 * self.damping * to_goal - duration_s * velocity)
    }
}
