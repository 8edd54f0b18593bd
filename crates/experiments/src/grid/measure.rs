//! What is measured of a cell when it is done.

use serde::Serialize;

use super::{CellResult, Judgement};

/// Something measured of a cell. "Last" is of the policy after the last episode, "best" of the policy of the best evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Share of rollouts that succeeded; 0 for a cell that failed.
    SuccessRateLast,
    /// The same of the best policy.
    SuccessRateBest,
    /// Share of rollouts in which a joint came within 5 degrees of its limit.
    ViolationRateLast,
    /// The same of the best policy.
    ViolationRateBest,
    /// Training episodes in which a joint came within 5 degrees of its limit.
    TrainingViolations,
    /// Median over the rollouts of the largest contact force on a finger, N.
    PeakForceNLast,
    /// The same of the best policy.
    PeakForceNBest,
    /// Median time of the rollouts that succeeded, seconds.
    TimeToSuccessSecsLast,
    /// The same of the best policy.
    TimeToSuccessSecsBest,
    /// Largest contact force on a finger in all of training, N.
    TrainingPeakForceN,
}

impl Measure {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::SuccessRateLast,
        Self::SuccessRateBest,
        Self::ViolationRateLast,
        Self::ViolationRateBest,
        Self::TrainingViolations,
        Self::PeakForceNLast,
        Self::PeakForceNBest,
        Self::TimeToSuccessSecsLast,
        Self::TimeToSuccessSecsBest,
        Self::TrainingPeakForceN,
    ];

    /// Its value for a cell, if there is one: a policy without a success has no time to it, and of a cell that failed
    /// nothing but its success rate is taken.
    #[must_use]
    pub fn of(self, cell: &CellResult) -> Option<f64> {
        if cell.failure.is_some() {
            let is_success = matches!(self, Self::SuccessRateLast | Self::SuccessRateBest);
            return is_success.then_some(0.0);
        }
        let of = |judgement: &Option<Judgement>, value: fn(&Judgement) -> f64| {
            judgement.as_ref().map(value)
        };
        let time = |judgement: &Option<Judgement>| judgement.as_ref()?.time_to_success_secs;
        match self {
            Self::SuccessRateLast => of(&cell.last, |judgement| judgement.success_rate),
            Self::SuccessRateBest => of(&cell.best, |judgement| judgement.success_rate),
            Self::ViolationRateLast => of(&cell.last, |judgement| judgement.violation_rate),
            Self::ViolationRateBest => of(&cell.best, |judgement| judgement.violation_rate),
            Self::TrainingViolations => Some(cell.training_violations.len() as f64),
            Self::PeakForceNLast => of(&cell.last, |judgement| judgement.peak_force_n),
            Self::PeakForceNBest => of(&cell.best, |judgement| judgement.peak_force_n),
            Self::TimeToSuccessSecsLast => time(&cell.last),
            Self::TimeToSuccessSecsBest => time(&cell.best),
            Self::TrainingPeakForceN => Some(cell.training_peak_force_n),
        }
    }
}
