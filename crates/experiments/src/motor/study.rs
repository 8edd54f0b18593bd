//! Ways of learning motor skills compared, over tasks and seeds: what a plan to begin with is worth (thesis Fig. 4.5), what a
//! wrong model costs it, and what policy and search make of it.
//!
//! A trial is one `skill train` in a child process; what came of it is one line of `results.jsonl`. A trial that was
//! interrupted goes on from its last epoch, and one that is done is not run again.

mod report;

use std::fmt;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{EpochRecord, MotorError, MotorFolder};
use crate::sweep::{ChildEnd, Launcher, Outcome, Progress, StopWish, Sweep, SweepError};

pub use report::{Comparison, Row, Table, report};

/// Why a study cannot go on, or cannot be reported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The runs.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// The folder of a trial.
    #[error(transparent)]
    Folder(#[from] MotorError),
    /// There is nothing to report.
    #[error("`{}` holds no results", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
    },
    /// The results are of another experiment.
    #[error("`{}` holds a trial of `{found}`, expected {}", file.display(), wanted.join(", "))]
    OtherVariant {
        /// The file.
        file: PathBuf,
        /// Its variant.
        found: String,
        /// Those of this experiment.
        wanted: Vec<String>,
    },
    /// The table cannot be written as JSON.
    #[error("the table cannot be written as JSON")]
    Table(#[source] serde_json::Error),
}

impl StudyError {
    /// Whether it is the user's to mend: a folder, a file of results.
    pub fn is_of_input(&self) -> bool {
        match self {
            Self::Sweep(error) => matches!(
                error,
                SweepError::OtherCommand { .. }
                    | SweepError::NoCommand { .. }
                    | SweepError::Command { .. }
                    | SweepError::Result { .. }
            ),
            Self::Folder(error) => error.is_of_input(),
            Self::Empty { .. } | Self::OtherVariant { .. } => true,
            Self::Table(_) => false,
        }
    }
}

/// A way of learning that is compared with others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variant {
    /// Its name, in results and in names of folders.
    pub name: String,
    /// The arguments of `skill train` that make it.
    pub arguments: Vec<String>,
    /// Epochs of a trial; what its policy takes if absent.
    pub epochs: Option<u64>,
}

/// One run of the study. Ordered by seed first: a study that is stopped early has compared all tasks.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Trial {
    /// Seed of all that is random.
    pub seed: u64,
    /// A shipped task, by name.
    pub task: String,
    /// How it is learned: the name of a [`Variant`].
    pub variant: String,
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} seed {}", self.task, self.variant, self.seed)
    }
}

/// What came of a trial, as a line of `results.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialResult {
    /// The task, by name.
    pub task: String,
    /// How it was learned.
    pub variant: String,
    /// Seed.
    pub seed: u64,
    /// How long it took since it was last begun or resumed, seconds.
    pub wall_secs: f64,
    /// Return of an arm that never moves: what returns are measured by.
    pub still_return: f64,
    /// Where the object's joint starts and should end, rad or m.
    pub way: [f64; 2],
    /// Epochs, from 0.
    pub epochs: Vec<EpochRecord>,
    /// What ended it early.
    pub failure: Option<String>,
}

impl Outcome for TrialResult {
    type Key = Trial;

    fn key(&self) -> Trial {
        Trial {
            seed: self.seed,
            task: self.task.clone(),
            variant: self.variant.clone(),
        }
    }

    fn is_success(&self) -> bool {
        self.failure.is_none()
    }

    fn wall_secs(&self) -> f64 {
        self.wall_secs
    }
}

/// A study to be run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Study {
    /// Name of the experiment.
    pub name: String,
    /// The program `factotum`.
    pub program: PathBuf,
    /// Names of shipped tasks.
    pub tasks: Vec<String>,
    /// What is compared.
    pub variants: Vec<Variant>,
    /// Seeds, the same for all variants.
    pub seeds: Vec<u64>,
    /// Epochs of a trial, whatever the variant says.
    pub epochs: Option<u64>,
    /// Arguments of `skill train` that all have in common, such as the error of the model.
    pub arguments: Vec<String>,
    /// Trials at a time, at least one.
    pub n_workers: usize,
    /// Where everything is kept.
    pub folder: PathBuf,
}

impl Study {
    /// Runs the trials that have no result yet and returns all results, sorted by seed, task and variant.
    ///
    /// # Errors
    /// [`StudyError`] when the folder holds what does not belong to this study, children cannot be started, or results
    /// cannot be kept.
    pub fn run(
        &self,
        stop: &StopWish,
        mut on_result: impl FnMut(&TrialResult, Progress),
    ) -> Result<Vec<TrialResult>, StudyError> {
        let mut command = vec![self.name.clone()];
        command.extend(epochs_argument(self.epochs));
        command.extend(self.arguments.iter().cloned());
        let sweep = Sweep {
            folder: self.folder.clone(),
            command,
            keys: self.trials(),
            n_workers: self.n_workers,
        };
        sweep.run(
            stop,
            |trial| self.carry_out(trial, stop),
            |result, progress| {
                on_result(result, progress);
                Ok(())
            },
        )
    }

    /// All trials.
    pub fn trials(&self) -> Vec<Trial> {
        let mut trials = Vec::new();
        for &seed in &self.seeds {
            for task in &self.tasks {
                trials.extend(self.variants.iter().map(|variant| Trial {
                    seed,
                    task: task.clone(),
                    variant: variant.name.clone(),
                }));
            }
        }
        trials
    }

    fn carry_out(&self, trial: &Trial, stop: &StopWish) -> Result<Option<TrialResult>, StudyError> {
        let mut variants = self.variants.iter();
        let Some(variant) = variants.find(|variant| variant.name == trial.variant) else {
            return Ok(None);
        };
        let name = format!("{}-{}-{}", trial.task, trial.variant, trial.seed);
        let folder = MotorFolder::at(&self.folder.join("trials").join(name));
        let dir = folder.dir().display().to_string();
        let seed = trial.seed.to_string();
        let mut arguments: Vec<String> = ["skill", "train"].map(str::to_owned).into();
        if folder.has_record() {
            arguments.extend(["--resume", &dir].map(str::to_owned));
        } else {
            arguments.push(trial.task.clone());
            arguments.extend(["--seed", &seed, "--out", &dir].map(str::to_owned));
            arguments.extend(variant.arguments.iter().chain(&self.arguments).cloned());
        }
        arguments.extend(epochs_argument(self.epochs.or(variant.epochs)));
        arguments.push("--json".to_owned());
        let launcher = Launcher {
            program: &self.program,
            folder: &self.folder,
            stop,
            lock: None,
        };
        let end = launcher.run(&arguments)?;
        let Some(end) = end.filter(|end| !end.is_from_outside && end.exit_code != Some(1)) else {
            return Ok(None);
        };
        let epochs = folder.epochs()?;
        let said = |key: &str| end.output.as_ref().and_then(|output| output[key].as_f64());
        Ok(Some(TrialResult {
            task: trial.task.clone(),
            variant: trial.variant.clone(),
            seed: trial.seed,
            wall_secs: end.wall_secs,
            still_return: said("still_return").unwrap_or(0.0),
            way: [said("start").unwrap_or(0.0), said("goal").unwrap_or(0.0)],
            epochs,
            failure: failure_of(&end),
        }))
    }
}

fn epochs_argument(epochs: Option<u64>) -> Vec<String> {
    let given = epochs.map(|n| ["--epochs".to_owned(), n.to_string()]);
    given.into_iter().flatten().collect()
}

fn failure_of(end: &ChildEnd) -> Option<String> {
    (end.exit_code != Some(0)).then(|| {
        let code = end
            .exit_code
            .map_or("none".to_owned(), |code| code.to_string());
        format!("exit code {code}: {}", end.messages)
    })
}
