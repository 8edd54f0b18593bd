//! The knobs of the executive, with what they default to and why.

/// How hard the executive tries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Tries of one plan step, each from another base pose, before the plan is made anew.
    pub n_attempts_max: usize,
    /// Plans made anew before the chore is given up.
    pub n_replans_max: usize,
    /// Base poses drawn from a navigation symbol for one step.
    pub n_base_samples: usize,
    /// Of those, the nearest reachable ones that are asked whether the skill could start there.
    pub n_base_checks: usize,
    /// Clearance kept from obstacles beyond the footprint, metres.
    pub clearance_m: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            n_attempts_max: 3,
            n_replans_max: 4,
            n_base_samples: 200,
            n_base_checks: 16,
            clearance_m: 0.08,
        }
    }
}
