//! Carrying out a cell: training, from the beginning or from its checkpoint, and two judgements.

use std::fs::{File, TryLockError};
use std::path::Path;

use factotum_skills::cip::setting::CipSetting;
use factotum_skills::cip::training::EvaluationRecord;

use super::{Cell, CellFailure, CellResult, Grid, GridError, Judgement, setting_digest};
use crate::skill_folder::{MetricsLine, SkillFolder};
use crate::storage::StorageError;
use crate::sweep::{ChildEnd, Launcher, StopWish};

/// Carries out a cell; nothing when it was stopped, by us or from outside, before its own end.
pub(super) fn carry_out(
    grid: &Grid,
    cell: &Cell,
    stop: &StopWish,
) -> Result<Option<CellResult>, GridError> {
    let folder = grid.skill_folder(cell);
    let lock = lock(&folder, cell)?;
    let launcher = Launcher {
        program: &grid.program,
        folder: folder.dir(),
        stop,
        lock: Some(&lock),
    };
    let dir = folder.dir().display().to_string();
    let begun = has_begun(grid, cell, &folder)?;
    let mut wall_secs = 0.0;
    let mut run = |words: &[&str]| -> Result<Option<ChildEnd>, GridError> {
        let words = words.iter().map(|&word| word.to_owned());
        let arguments: Vec<String> = grid.leading.iter().cloned().chain(words).collect();
        let end = launcher.run(&arguments)?.filter(|end| !end.is_from_outside);
        wall_secs += end.as_ref().map_or(0.0, |end| end.wall_secs);
        Ok(end)
    };
    let (seed, episodes, rollouts) = (
        cell.seed.to_string(),
        grid.episodes.to_string(),
        grid.rollouts.to_string(),
    );
    let ablation = cell.ablation.name();
    let length = ["--episodes", &episodes, "--json"];
    let train: Vec<&str> = if begun {
        [&["skill", "train", "--resume", &dir], &length[..]].concat()
    } else {
        let what = ["skill", "train", &cell.task, "--ablation", ablation];
        [&what[..], &["--seed", &seed, "--out", &dir], &length[..]].concat()
    };
    let Some(end) = run(&train)? else {
        return Ok(None);
    };
    // Its own word for being interrupted.
    if end.exit_code == Some(1) {
        return Ok(None);
    }
    let mut failure = failure_of("skill train", &end);
    let mut judge = |policy: &str| -> Result<Option<Option<Judgement>>, GridError> {
        if failure.is_some() {
            return Ok(Some(None));
        }
        let eval = ["skill", "eval", &dir, "--policy", policy];
        let how = ["--rollouts", &rollouts, "--seed", &seed, "--json"];
        let Some(end) = run(&[&eval[..], &how[..]].concat())? else {
            return Ok(None);
        };
        Ok(Some(match judgement_of(end) {
            Ok(judgement) => Some(judgement),
            Err(why) => {
                failure = Some(why);
                None
            }
        }))
    };
    let (Some(last), Some(best)) = (judge("last")?, judge("best")?) else {
        return Ok(None);
    };
    let history = History::read(&folder.metrics())?;
    Ok(Some(CellResult {
        task: cell.task.clone(),
        ablation: cell.ablation,
        seed: cell.seed,
        setting: setting_digest(&CipSetting::of(cell.ablation)),
        wall_secs,
        n_episodes: history.n_episodes,
        n_env_steps: history.n_env_steps,
        training_violations: history.violations,
        training_peak_force_n: history.peak_force_n,
        evaluations: history.evaluations,
        last,
        best,
        failure,
    }))
}

/// A lock that lasts as long as somebody is at work on the cell.
fn lock(folder: &SkillFolder, cell: &Cell) -> Result<File, GridError> {
    let dir = folder.dir();
    let file = dir.join(".lock");
    std::fs::create_dir_all(dir).map_err(|error| StorageError::writing(dir, error))?;
    let lock = File::options()
        .read(true)
        .append(true)
        .create(true)
        .open(&file)
        .map_err(|error| StorageError::writing(&file, error))?;
    match lock.try_lock() {
        Ok(()) => Ok(lock),
        Err(TryLockError::WouldBlock) => Err(GridError::InUse {
            cell: cell.clone(),
            folder: dir.to_path_buf(),
        }),
        Err(TryLockError::Error(error)) => Err(StorageError::writing(&file, error).into()),
    }
}

/// Whether there is a run to go on with, with the numbers that the setting has now.
fn has_begun(grid: &Grid, cell: &Cell, folder: &SkillFolder) -> Result<bool, GridError> {
    if !folder.has_record() {
        return Ok(false);
    }
    let record = folder.record()?;
    let is_same = record.ablation == cell.ablation
        && record.seed == cell.seed
        && record.setting == CipSetting::of(cell.ablation);
    if is_same {
        Ok(true)
    } else {
        Err(GridError::OtherSetting {
            cell: cell.clone(),
            folder: grid.folder.clone(),
        })
    }
}

/// What `skill eval` said, or how it failed.
pub(super) fn judgement_of(end: ChildEnd) -> Result<Judgement, CellFailure> {
    if let Some(failure) = failure_of("skill eval", &end) {
        return Err(failure);
    }
    let judgement = end.output.map(serde_json::from_value);
    judgement.and_then(Result::ok).ok_or_else(|| CellFailure {
        command: "skill eval".to_owned(),
        exit_code: end.exit_code,
        messages: "it printed no judgement".to_owned(),
    })
}

fn failure_of(command: &str, end: &ChildEnd) -> Option<CellFailure> {
    (end.exit_code != Some(0)).then(|| CellFailure {
        command: command.to_owned(),
        exit_code: end.exit_code,
        messages: end.messages.clone(),
    })
}

/// What is kept of a cell's metrics.
#[derive(Debug, Default)]
struct History {
    n_episodes: u64,
    n_env_steps: u64,
    violations: Vec<u64>,
    peak_force_n: f64,
    evaluations: Vec<EvaluationRecord>,
}

impl History {
    fn read(metrics: &Path) -> Result<Self, GridError> {
        let text = match std::fs::read_to_string(metrics) {
            Ok(text) => text,
            // A run that failed before its first episode has none.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(StorageError::reading(metrics, error).into()),
        };
        let mut history = Self::default();
        for (idx, line) in text.lines().enumerate() {
            let line = serde_json::from_str(line).map_err(|source| GridError::Metrics {
                file: metrics.to_path_buf(),
                line: idx + 1,
                source,
            })?;
            history.add(line);
        }
        Ok(history)
    }

    fn add(&mut self, line: MetricsLine) {
        match line {
            MetricsLine::Evaluation(evaluation) => self.evaluations.push(evaluation),
            MetricsLine::Episode(episode) => {
                self.n_episodes = episode.episode;
                self.n_env_steps = episode.env_steps;
                self.peak_force_n = self.peak_force_n.max(episode.peak_force_n);
                if episode.violation {
                    self.violations.push(episode.episode);
                }
            }
        }
    }
}
