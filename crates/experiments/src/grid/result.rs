//! What is kept of a cell: its evaluations, its training violations, and the judgement of its policies.

use factotum_skills::cip::setting::Ablation;
use factotum_skills::cip::training::EvaluationRecord;
use serde::{Deserialize, Serialize};

use super::Cell;
use crate::sweep::Outcome;

/// The result of a cell, as a line of `results.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellResult {
    /// The task, by name.
    pub task: String,
    /// Setting.
    pub ablation: Ablation,
    /// Seed.
    pub seed: u64,
    /// Digest of the numbers that it was learned with.
    pub setting: String,
    /// How long it took since it was last begun or resumed, seconds.
    pub wall_secs: f64,
    /// Training episodes lived through.
    pub n_episodes: u64,
    /// Steps in them.
    pub n_env_steps: u64,
    /// The training episodes with a joint near its limit, by number from 1.
    pub training_violations: Vec<u64>,
    /// Largest contact force on a finger in all of training, N.
    pub training_peak_force_n: f64,
    /// The evaluations while it was trained.
    pub evaluations: Vec<EvaluationRecord>,
    /// The policy after the last episode, judged.
    pub last: Option<Judgement>,
    /// The policy of the best evaluation, judged.
    pub best: Option<Judgement>,
    /// What ended it early.
    pub failure: Option<CellFailure>,
}

/// What `skill eval` says of a policy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judgement {
    /// Rollouts.
    pub rollouts: u32,
    /// Share of them that succeeded.
    pub success_rate: f64,
    /// Share of them in which a joint came near its limit.
    pub violation_rate: f64,
    /// Median over the rollouts of the largest contact force on a finger, N.
    pub peak_force_n: f64,
    /// Median time of the rollouts that succeeded, seconds.
    pub time_to_success_secs: Option<f64>,
}

/// How a cell ended early.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellFailure {
    /// The command that failed.
    pub command: String,
    /// Its exit code; nothing when a signal ended it.
    pub exit_code: Option<i32>,
    /// The end of its messages.
    pub messages: String,
}

impl CellResult {
    /// Which cell it is of.
    #[must_use]
    pub fn cell(&self) -> Cell {
        Cell {
            seed: self.seed,
            task: self.task.clone(),
            ablation: self.ablation,
        }
    }
}

impl Outcome for CellResult {
    type Key = Cell;

    fn key(&self) -> Cell {
        self.cell()
    }

    fn is_success(&self) -> bool {
        self.failure.is_none()
    }

    fn wall_secs(&self) -> f64 {
        self.wall_secs
    }
}
