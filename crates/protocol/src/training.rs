//! Contact skills that are being learned, or were.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

/// The trainings there are: those under way first, then the latest begun. A later message replaces it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Trainings {
    /// The trainings.
    pub trainings: Vec<Training>,
}

/// How far a skill is learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Training {
    /// Name of its folder, unique among the trainings.
    pub name: String,
    /// Name of the task.
    pub task: String,
    /// Name of the setting, such as `cip`.
    pub ablation: String,
    /// Seed of all that is random, in digits: a page's numbers are exact only up to 2^53.
    pub seed: String,
    /// Whether it went on within the last seconds.
    pub running: bool,
    /// Training episodes lived through.
    pub episodes: u32,
    /// Steps in them.
    pub env_steps: u32,
    /// Those of them in which a joint came near its limit.
    pub violations: u32,
    /// Share of successes in the last 20 of them, 0 to 1; nothing before the first.
    pub recent_success_rate: Option<f64>,
    /// Its evaluations by episode. Of very many, evenly chosen ones and the last.
    pub evaluations: Vec<Evaluation>,
}

/// What rollouts of the policy said that nothing was learned from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Evaluation {
    /// Training episodes before it.
    pub episode: u32,
    /// Share of rollouts that succeeded, 0 to 1.
    pub success_rate: f64,
    /// Share of rollouts in which a joint came near its limit, 0 to 1.
    pub violation_rate: f64,
    /// Median over the rollouts of the largest contact force on a finger, in newtons.
    pub peak_force_n: f64,
    /// Median time of the rollouts that succeeded, in seconds; nothing when none did.
    pub time_to_success_secs: Option<f64>,
}
