//! What learned contact skills stand: the skills of a grid, judged where the object resists otherwise than in training, or
//! where object or hand are not where the robot believes.
//!
//! A trial is one `skill eval` of one skill under one [`Condition`]; it changes nothing in the skill's folder. Its rollouts
//! have the seed that the skill was learned with, so that [`Condition::AsTrained`] is the grid's own judgement again.

mod table;

use std::fmt;
use std::path::{Path, PathBuf};

use factotum_skills::cip::setting::Ablation;
use serde::{Deserialize, Serialize};

use super::cell::judgement_of;
use super::{Cell, CellFailure, GridError, Judgement, results_in};
use crate::skill_folder::SkillFolder;
use crate::skill_training::WhichPolicy;
use crate::storage::{StorageError, write_atomically};
use crate::sweep::{Launcher, Outcome, Progress, StopWish, Sweep};

pub use table::{Row, Table};

/// What is otherwise than in training. Errors are drawn anew in each rollout, from normal distributions with these standard
/// deviations along and about each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// Nothing.
    AsTrained,
    /// Damping and dry friction of the object's joint are 0.3 of what they were.
    ResistanceTimes03,
    /// They are three times what they were.
    ResistanceTimes3,
    /// The object is 3 mm and 1 degree off.
    ObjectOff,
    /// The grasp is 3 mm and 3 degrees off.
    GraspOff,
}

impl Condition {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::AsTrained,
        Self::ResistanceTimes03,
        Self::ResistanceTimes3,
        Self::ObjectOff,
        Self::GraspOff,
    ];

    /// Its name in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::AsTrained => "as trained",
            Self::ResistanceTimes03 => "resistance × 0.3",
            Self::ResistanceTimes3 => "resistance × 3",
            Self::ObjectOff => "object 3 mm, 1° off",
            Self::GraspOff => "grasp 3 mm, 3° off",
        }
    }

    /// What `skill eval` is told of it.
    fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::AsTrained => &[],
            Self::ResistanceTimes03 => &["--damping", "0.3", "--friction", "0.3"],
            Self::ResistanceTimes3 => &["--damping", "3", "--friction", "3"],
            Self::ObjectOff => &["--pose-error-mm", "3", "--pose-error-deg", "1"],
            Self::GraspOff => &["--grasp-error-mm", "3", "--grasp-error-deg", "3"],
        }
    }
}

/// A skill under a condition.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Trial {
    /// The skill.
    pub cell: Cell,
    /// The condition.
    pub condition: Condition,
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.cell, self.condition.name())
    }
}

/// The result of a trial, as a line of `results.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialResult {
    /// The task, by name.
    pub task: String,
    /// Setting.
    pub ablation: Ablation,
    /// Seed that the skill was learned with, and of its rollouts here.
    pub seed: u64,
    /// The condition.
    pub condition: Condition,
    /// How long it took, seconds.
    pub wall_secs: f64,
    /// What the rollouts say.
    pub judgement: Option<Judgement>,
    /// What ended it early.
    pub failure: Option<CellFailure>,
}

impl Outcome for TrialResult {
    type Key = Trial;

    fn key(&self) -> Trial {
        Trial {
            cell: Cell {
                seed: self.seed,
                task: self.task.clone(),
                ablation: self.ablation,
            },
            condition: self.condition,
        }
    }

    fn is_success(&self) -> bool {
        self.failure.is_none()
    }

    fn wall_secs(&self) -> f64 {
        self.wall_secs
    }
}

/// Skills of a grid, to be judged under every condition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Robustness {
    /// The program `factotum`.
    pub program: PathBuf,
    /// Arguments before `skill`; none but in tests.
    pub leading: Vec<String>,
    /// Folder of the grid.
    pub skills: PathBuf,
    /// Its cells.
    pub cells: Vec<Cell>,
    /// Which policy of a skill; the last needs the checkpoints of the grid.
    pub policy: WhichPolicy,
    /// Rollouts of a trial.
    pub rollouts: u32,
    /// Trials at a time, at least one.
    pub n_workers: usize,
    /// Where the results are kept.
    pub folder: PathBuf,
}

impl Robustness {
    /// Carries out the trials that have no result yet and returns all results, sorted by seed, task, setting and
    /// condition. `stop` and `on_result` are as for [`super::Grid::run`].
    ///
    /// # Errors
    /// [`GridError`] when a skill is missing, the folder holds what does not belong here, children cannot be started, or
    /// results cannot be kept.
    pub fn run(
        &self,
        stop: &StopWish,
        mut on_result: impl FnMut(&TrialResult, Progress),
    ) -> Result<Vec<TrialResult>, GridError> {
        for cell in &self.cells {
            let skill = self.skill(cell);
            let policy = match self.policy {
                WhichPolicy::Best => skill.policy(),
                WhichPolicy::Last => skill.checkpoint(),
            };
            if !(skill.has_record() && policy.is_file()) {
                return Err(GridError::NoSkill {
                    cell: cell.clone(),
                    policy,
                });
            }
        }
        let sweep = Sweep {
            folder: self.folder.clone(),
            command: vec![
                "--policy".to_owned(),
                self.policy.name().to_owned(),
                "--rollouts".to_owned(),
                self.rollouts.to_string(),
            ],
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

    /// How many trials there are.
    #[must_use]
    pub fn n_trials(&self) -> usize {
        self.trials().len()
    }

    fn trials(&self) -> Vec<Trial> {
        let of = |cell: &Cell| {
            let cell = cell.clone();
            Condition::ALL.map(|condition| Trial {
                cell: cell.clone(),
                condition,
            })
        };
        self.cells.iter().flat_map(of).collect()
    }

    fn skill(&self, cell: &Cell) -> SkillFolder {
        cell.skill_folder(&self.skills)
    }

    fn carry_out(&self, trial: &Trial, stop: &StopWish) -> Result<Option<TrialResult>, GridError> {
        let Trial { cell, condition } = trial;
        let dir = self.skill(cell).dir().display().to_string();
        let (seed, rollouts) = (cell.seed.to_string(), self.rollouts.to_string());
        let what = ["skill", "eval", &dir, "--policy", self.policy.name()];
        let how = ["--rollouts", &rollouts, "--seed", &seed, "--json"];
        let words = [&what[..], &how[..], condition.arguments()].concat();
        let words = words.into_iter().map(str::to_owned);
        let arguments: Vec<String> = self.leading.iter().cloned().chain(words).collect();
        let launcher = Launcher {
            program: &self.program,
            folder: &self.folder,
            stop,
            lock: None,
        };
        let end = launcher.run(&arguments)?;
        let Some(end) = end.filter(|end| !end.is_from_outside) else {
            return Ok(None);
        };
        let wall_secs = end.wall_secs;
        let judged = judgement_of(end);
        Ok(Some(TrialResult {
            task: cell.task.clone(),
            ablation: cell.ablation,
            seed: cell.seed,
            condition: *condition,
            wall_secs,
            judgement: judged.as_ref().ok().copied(),
            failure: judged.err(),
        }))
    }
}

/// Writes the table of the results in a folder, as Markdown and as JSON, into `out`, and returns it with the files.
///
/// # Errors
/// [`GridError`] if there are no results, one is not of this program or there twice, or a file cannot be written.
pub fn report(from: &Path, out: &Path) -> Result<(Table, Vec<PathBuf>), GridError> {
    let table = Table::of(&results_in::<TrialResult>(from)?);
    let json = serde_json::to_string_pretty(&table).map_err(GridError::Table)?;
    std::fs::create_dir_all(out).map_err(|error| StorageError::writing(out, error))?;
    let mut files = Vec::new();
    for (name, text) in [
        ("table.md", table.to_markdown()),
        ("table.json", json + "\n"),
    ] {
        let file = out.join(name);
        write_atomically(&file, text.as_bytes())?;
        files.push(file);
    }
    Ok((table, files))
}

#[cfg(test)]
mod tests;
