//! The ablation study of contact skills (thesis 3.3): a skill for each task, setting and seed, judged when it is learned.
//!
//! A cell of the grid is three child processes: `skill train`, then `skill eval` of the last and of the best policy. What
//! came of it is one line of `results.jsonl`, small enough to be committed; the skill folders lie under `cells/`. A cell
//! that was interrupted goes on from its last checkpoint, and one that is done is not run again.
//!
//! A cell that crashed is a result as well: its failure is kept, and its success rate counts as 0.

mod cell;
mod curves;
mod measure;
mod report;
mod result;
pub mod robustness;
mod student;
mod table;

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use factotum_skills::cip::setting::{Ablation, CipSetting};
use sha2::{Digest as _, Sha256};
use thiserror::Error;

use crate::skill_folder::{SkillFolder, SkillFolderError};
use crate::storage::StorageError;
use crate::sweep::{Outcome, Progress, RESULTS_NAME, StopWish, Sweep, SweepError, read_results};

pub use measure::Measure;
pub use report::{GridReport, report};
pub use result::{CellFailure, CellResult, Judgement};
pub use student::MeanInterval;
pub use table::{Difference, Entry, FailedCell, Table};

/// A grid that cannot go on, or cannot be reported.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GridError {
    /// The runs.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A file.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// The skill folder of a cell.
    #[error(transparent)]
    Folder(#[from] SkillFolderError),
    /// A cell was learned with other numbers than its setting has now.
    #[error(
        "{cell} in `{}` was learned with other numbers than `{}` has now; choose another folder, or remove the cell and \
         its line",
        folder.display(),
        cell.ablation.name()
    )]
    OtherSetting {
        /// The cell.
        cell: Cell,
        /// The folder of the grid.
        folder: PathBuf,
    },
    /// Another process is at work on a cell.
    #[error("`{}`: another process is still at work on {cell}; wait for its end, or end it", folder.display())]
    InUse {
        /// The cell.
        cell: Cell,
        /// Its folder.
        folder: PathBuf,
    },
    /// A line of metrics is neither an episode nor an evaluation.
    #[error("`{}` line {line}: neither an episode nor an evaluation", file.display())]
    Metrics {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong in it.
        source: serde_json::Error,
    },
    /// There is nothing to report.
    #[error("`{}` holds no results", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
    },
    /// A cell has two results.
    #[error("`{}` line {line}: a second result of {run}", file.display())]
    Twice {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The cell, or another run by its key.
        run: String,
    },
    /// There is no skill to judge.
    #[error(
        "there is no `{}`, the policy of {cell}; learn it with `factotum experiment run cip-ablation`, which drops the last \
         policy unless told --keep-checkpoints",
        policy.display()
    )]
    NoSkill {
        /// The cell.
        cell: Cell,
        /// The file that would hold it.
        policy: PathBuf,
    },
    /// The table cannot be written as JSON.
    #[error("the table cannot be written as JSON")]
    Table(#[source] serde_json::Error),
}

impl GridError {
    /// Whether it is the user's to mend: a folder, a file of results.
    #[must_use]
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
            Self::Folder(error) => !matches!(error, SkillFolderError::Storage(_)),
            Self::Storage(_) | Self::Table(_) => false,
            _ => true,
        }
    }
}

/// One training run of the grid. Ordered by seed first: a grid that is stopped early has compared all settings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    /// Seed of all that is random.
    pub seed: u64,
    /// A shipped task, by name.
    pub task: String,
    /// Setting.
    pub ablation: Ablation,
}

impl Cell {
    /// A cell for each task, setting and seed.
    #[must_use]
    pub fn all(tasks: &[String], ablations: &[Ablation], seeds: &[u64]) -> Vec<Self> {
        let mut cells = Vec::new();
        for &seed in seeds {
            for task in tasks {
                cells.extend(ablations.iter().map(|&ablation| Self {
                    seed,
                    task: task.clone(),
                    ablation,
                }));
            }
        }
        cells
    }

    /// Where its skill is, in the folder of a grid.
    fn skill_folder(&self, folder: &Path) -> SkillFolder {
        let name = format!("{}-{}-{}", self.task, self.ablation.name(), self.seed);
        SkillFolder::at(&folder.join("cells").join(name))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        let [here, there] =
            [self, other].map(|cell| (cell.seed, &*cell.task, cell.ablation as usize));
        here.cmp(&there)
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} {} seed {}",
            self.task,
            self.ablation.name(),
            self.seed
        )
    }
}

/// A grid to be run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grid {
    /// The program `factotum`.
    pub program: PathBuf,
    /// Arguments before `skill`; none but in tests.
    pub leading: Vec<String>,
    /// Names of shipped tasks.
    pub tasks: Vec<String>,
    /// Settings.
    pub ablations: Vec<Ablation>,
    /// Seeds; the rollouts that judge a skill have the seed that it was learned with, in another stream.
    pub seeds: Vec<u64>,
    /// Training episodes of a cell.
    pub episodes: u64,
    /// Rollouts that judge a policy.
    pub rollouts: u32,
    /// Cells at a time, at least one.
    pub n_workers: usize,
    /// Whether the checkpoint of a cell stays when it is done.
    pub keep_checkpoints: bool,
    /// Where everything is kept.
    pub folder: PathBuf,
}

impl Grid {
    /// Runs the cells that have no result yet and returns all results, sorted by seed, task and setting.
    ///
    /// `stop` ends the grid early: raised once, the cells under way are finished; raised again, they are left as they are
    /// and go on another time. `on_result` hears of each new result, and how far the grid is with it.
    ///
    /// # Errors
    /// [`GridError`] when the folder holds what does not belong to this grid, children cannot be started, or results
    /// cannot be kept.
    pub fn run(
        &self,
        stop: &StopWish,
        mut on_result: impl FnMut(&CellResult, Progress),
    ) -> Result<Vec<CellResult>, GridError> {
        let sweep = Sweep {
            folder: self.folder.clone(),
            command: vec![
                "--episodes".to_owned(),
                self.episodes.to_string(),
                "--rollouts".to_owned(),
                self.rollouts.to_string(),
            ],
            keys: self.cells(),
            n_workers: self.n_workers,
        };
        for result in sweep.open::<CellResult>()? {
            let is_asked_for = self.ablations.contains(&result.ablation);
            if is_asked_for && result.setting != setting_digest(&CipSetting::of(result.ablation)) {
                return Err(GridError::OtherSetting {
                    cell: result.cell(),
                    folder: self.folder.clone(),
                });
            }
        }
        sweep.run(
            stop,
            |cell| cell::carry_out(self, cell, stop),
            |result, progress| {
                if !self.keep_checkpoints {
                    remove_checkpoint(&self.skill_folder(&result.cell()))?;
                }
                on_result(result, progress);
                Ok(())
            },
        )
    }

    /// How many cells it has, each counted once.
    #[must_use]
    pub fn n_cells(&self) -> usize {
        self.cells().into_iter().collect::<BTreeSet<_>>().len()
    }

    /// All cells.
    fn cells(&self) -> Vec<Cell> {
        Cell::all(&self.tasks, &self.ablations, &self.seeds)
    }

    /// Where the skill of a cell is learned.
    fn skill_folder(&self, cell: &Cell) -> SkillFolder {
        cell.skill_folder(&self.folder)
    }
}

/// Tells apart numbers that skills were learned with.
fn setting_digest(setting: &CipSetting) -> String {
    let text = toml::to_string(setting).unwrap_or_default();
    let digest = Sha256::digest(text);
    digest[..8]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn remove_checkpoint(folder: &SkillFolder) -> Result<(), StorageError> {
    match std::fs::remove_file(folder.checkpoint()) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(StorageError::writing(&folder.checkpoint(), error))
        }
        _ => Ok(()),
    }
}

/// The results in a folder, at least one and none twice, sorted by key.
fn results_in<O: Outcome>(folder: &Path) -> Result<Vec<O>, GridError> {
    let file = folder.join(RESULTS_NAME);
    let mut results: Vec<O> = read_results(&file)?;
    let mut known = BTreeSet::new();
    for (idx, result) in results.iter().enumerate() {
        let run = result.key().to_string();
        if !known.insert(result.key()) {
            let line = idx + 1;
            return Err(GridError::Twice { file, line, run });
        }
    }
    if results.is_empty() {
        return Err(GridError::Empty { file });
    }
    results.sort_by_key(O::key);
    Ok(results)
}

#[cfg(test)]
mod tests;
