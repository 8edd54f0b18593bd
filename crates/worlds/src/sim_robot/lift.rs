//! The lift: a position servo whose steady error (weight over stiffness) a slow integral takes away.

/// Integral gain, 1/s.
const INTEGRAL: f64 = 2.0;

/// Largest correction, metres.
const CORRECTION_MAX_M: f64 = 0.02;

/// Where the lift should be, and the correction learned so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LiftControl {
    pub(crate) target_m: f64,
    pub(crate) correction_m: f64,
}

impl LiftControl {
    pub(crate) fn new(target_m: f64) -> Self {
        Self {
            target_m,
            correction_m: 0.0,
        }
    }

    /// The servo's target for the next step.
    pub(crate) fn step(&mut self, lift_m: f64, dt_secs: f64) -> f64 {
        let step = INTEGRAL * (self.target_m - lift_m) * dt_secs;
        self.correction_m = (self.correction_m + step).clamp(-CORRECTION_MAX_M, CORRECTION_MAX_M);
        self.target_m + self.correction_m
    }
}
