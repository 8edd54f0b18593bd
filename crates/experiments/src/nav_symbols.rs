//! Where the base must be: navigation symbols learned while a robot makes coffee again and again, in one kitchen and in
//! ever others (dissertation 5.4, Fig. 5.3).
//!
//! For each step of the plan the robot chooses a place, goes there and tries the skill, until it succeeds; each try is told to
//! its symbols. What is measured is the number of tries. A try is judged by an action map
//! ([`factotum_worlds::action_map`]), of which the robot knows where it can stand and where the objects are.
//!
//! A trial is one method, setting and seed, and one line of `results.jsonl`.

mod kitchen;
mod method;
mod report;
#[cfg(test)]
mod tests;
mod trial;

use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

use factotum_symbols::gaussian_process::GpError;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::storage::StorageError;
use crate::sweep::{Outcome, Progress, StopWish, Sweep, SweepError};

pub use kitchen::{COFFEE, Kitchen, Step};
pub use method::{Method, Setting};
pub use report::{Figures, Row, Table, report, table};
pub use trial::Completion;

/// Why a study cannot go on, or cannot be reported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NavStudyError {
    /// The runs.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A file.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// A symbol cannot be learned.
    #[error("{trial}: {source}")]
    Symbol {
        /// Whose.
        trial: Trial,
        /// Why.
        source: GpError,
    },
    /// There is nothing to report.
    #[error("`{}` holds no results", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
    },
    /// The table cannot be written as JSON.
    #[error("the table cannot be written as JSON")]
    Table(#[source] serde_json::Error),
}

impl NavStudyError {
    /// Whether it is the user's to mend: a folder, a file of results.
    pub fn is_of_input(&self) -> bool {
        match self {
            Self::Sweep(error) => matches!(
                error,
                SweepError::OtherCommand { .. }
                    | SweepError::NoCommand { .. }
                    | SweepError::Command { .. }
                    | SweepError::Result { .. }
                    | SweepError::Storage(StorageError::Read { .. })
            ),
            Self::Empty { .. } => true,
            Self::Storage(error) => matches!(error, StorageError::Read { .. }),
            Self::Symbol { .. } | Self::Table(_) => false,
        }
    }
}

/// One robot that learns. Ordered by seed first: a study that is stopped early has compared all methods.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Trial {
    /// Seed of all that is random.
    pub seed: u64,
    /// Which kitchens.
    pub setting: Setting,
    /// How it finds places.
    pub method: Method,
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} seed {}", self.method, self.setting, self.seed)
    }
}

/// What came of a trial, as a line of `results.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialResult {
    /// Which kitchens.
    pub setting: Setting,
    /// How it found places.
    pub method: Method,
    /// Seed.
    pub seed: u64,
    /// How long it took, seconds.
    pub wall_secs: f64,
    /// Coffee after coffee.
    pub completions: Vec<Completion>,
}

impl TrialResult {
    /// Whether it was stopped in a step that did not succeed.
    #[must_use]
    pub fn is_stuck(&self) -> bool {
        self.completions.iter().any(|done| done.is_stuck)
    }
}

impl Outcome for TrialResult {
    type Key = Trial;

    fn key(&self) -> Trial {
        Trial {
            seed: self.seed,
            setting: self.setting,
            method: self.method,
        }
    }

    fn is_success(&self) -> bool {
        !self.is_stuck()
    }

    fn wall_secs(&self) -> f64 {
        self.wall_secs
    }
}

/// A study to be run.
#[derive(Debug, Clone)]
pub struct NavStudy {
    /// Where coffee is made, at least one.
    pub kitchens: Vec<Kitchen>,
    /// Seeds, the same for all methods.
    pub seeds: Vec<u64>,
    /// How often coffee is made in a trial.
    pub n_completions: usize,
    /// Trials at a time, at least one.
    pub n_workers: usize,
    /// Where the results are kept.
    pub folder: PathBuf,
}

impl NavStudy {
    /// All trials.
    #[must_use]
    pub fn trials(&self) -> Vec<Trial> {
        let mut trials = Vec::new();
        for &seed in &self.seeds {
            for setting in Setting::ALL {
                trials.extend(Method::ALL.map(|method| Trial {
                    seed,
                    setting,
                    method,
                }));
            }
        }
        trials
    }

    /// Runs the trials that have no result yet and returns all results, sorted by seed, setting and method.
    ///
    /// # Errors
    /// [`NavStudyError`] when the folder holds what does not belong to this study, or results cannot be kept.
    pub fn run(
        &self,
        stop: &StopWish,
        mut on_result: impl FnMut(&TrialResult, Progress),
    ) -> Result<Vec<TrialResult>, NavStudyError> {
        let sweep = Sweep {
            folder: self.folder.clone(),
            command: self.command(),
            keys: self.trials(),
            n_workers: self.n_workers,
        };
        sweep.run(
            stop,
            |trial| self.carry_out(trial).map(Some),
            |result, progress| {
                on_result(result, progress);
                Ok(())
            },
        )
    }

    fn carry_out(&self, trial: &Trial) -> Result<TrialResult, NavStudyError> {
        let begin = Instant::now();
        let completions = trial::trial(
            &self.kitchens,
            trial.method,
            trial.setting,
            trial.seed,
            self.n_completions,
        );
        Ok(TrialResult {
            setting: trial.setting,
            method: trial.method,
            seed: trial.seed,
            wall_secs: begin.elapsed().as_secs_f64(),
            completions: completions.map_err(|source| NavStudyError::Symbol {
                trial: trial.clone(),
                source,
            })?,
        })
    }

    /// What all trials have in common: a folder keeps results of the same kitchens only.
    fn command(&self) -> Vec<String> {
        let kitchen = |kitchen: &Kitchen| {
            let digest = Sha256::digest(format!("{kitchen:?}"));
            let digest: String = digest[..4].iter().map(|x| format!("{x:02x}")).collect();
            format!("{}:{digest}", kitchen.map().scene())
        };
        let mut command = vec!["--completions".to_owned(), self.n_completions.to_string()];
        command.extend(self.kitchens.iter().map(kitchen));
        command
    }
}
