//! A learned skill as a folder.
//!
//! | file | holds |
//! |---|---|
//! | `skill.toml` | task, ablation, seed, and every number it was learned with |
//! | `policy.safetensors` | π_c of the best evaluation so far, the later of equals |
//! | `grasps.json` | I_c that belongs to it |
//! | `metrics.jsonl` | a line for each episode and each evaluation |
//! | `checkpoint.safetensors` | all that is needed to go on: learner, replay, grasps |
//!
//! Each file is written whole or not at all, the metrics by whole lines. A run that was stopped goes on from its last
//! checkpoint; lines of the metrics beyond it are dropped, since those episodes are lived through again.

use std::path::{Path, PathBuf};

use factotum_descriptions::{DescriptionError, read_toml};
use factotum_skills::cip::initiation::KnownGrasp;
use factotum_skills::cip::setting::{Ablation, CipSetting};
use factotum_skills::cip::training::{EpisodeRecord, EvaluationRecord};
use serde::{Deserialize, Serialize};

use crate::storage::{StorageError, append_line, keep_whole_lines, write_atomically};

/// Version of the folder's format.
const FORMAT: u32 = 1;

/// What a skill was learned with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkillRecord {
    /// Version of the format.
    pub format: u32,
    /// The task: a task file, or the name of a shipped task.
    pub task: PathBuf,
    /// Setting by name.
    pub ablation: Ablation,
    /// Seed of all that is random.
    pub seed: u64,
    /// Episodes at the beginning that are the robot's own plan.
    #[serde(default)]
    pub shown: u64,
    /// The setting.
    pub setting: CipSetting,
}

impl SkillRecord {
    /// The record of a run with the setting of an ablation.
    pub fn new(task: PathBuf, ablation: Ablation, seed: u64) -> Self {
        Self {
            format: FORMAT,
            task,
            ablation,
            seed,
            shown: 0,
            setting: CipSetting::of(ablation),
        }
    }
}

/// A line of `metrics.jsonl`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum MetricsLine {
    /// Of an evaluation.
    Evaluation(EvaluationRecord),
    /// Of a training episode.
    Episode(EpisodeRecord),
}

/// What is wrong with a skill folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SkillFolderError {
    /// A file cannot be written or read.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// `skill.toml` cannot be read.
    #[error(transparent)]
    Record(#[from] DescriptionError),
    /// The folder holds another run.
    #[error(
        "`{}` holds a run of task `{found_task}`, `{found_ablation}`, seed {found_seed}; go on with that by --resume, or \
         choose another folder", folder.display()
    )]
    Taken {
        /// The folder.
        folder: PathBuf,
        /// Its task.
        found_task: String,
        /// Its setting.
        found_ablation: &'static str,
        /// Its seed.
        found_seed: u64,
    },
    /// A later program wrote it.
    #[error("`{}` has format {found}, expected {FORMAT}", folder.display())]
    Format {
        /// The folder.
        folder: PathBuf,
        /// Its format.
        found: u32,
    },
    /// A record that cannot be written as text.
    #[error("the record of the run cannot be written as TOML: {0}")]
    Text(String),
}

/// The folder of a skill.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SkillFolder {
    dir: PathBuf,
}

impl SkillFolder {
    /// The folder at a path, whether it is there or not.
    pub fn at(dir: &Path) -> Self {
        Self {
            dir: dir.to_owned(),
        }
    }

    /// Where it is.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The policy.
    pub fn policy(&self) -> PathBuf {
        self.dir.join("policy.safetensors")
    }

    /// I_c.
    pub fn grasps(&self) -> PathBuf {
        self.dir.join("grasps.json")
    }

    /// Metrics.
    pub fn metrics(&self) -> PathBuf {
        self.dir.join("metrics.jsonl")
    }

    /// The state to go on from.
    pub fn checkpoint(&self) -> PathBuf {
        self.dir.join("checkpoint.safetensors")
    }

    /// Whether a run was begun in it.
    pub fn has_record(&self) -> bool {
        self.record_file().exists()
    }

    pub(crate) fn record_file(&self) -> PathBuf {
        self.dir.join("skill.toml")
    }

    /// Begins a folder for a run.
    ///
    /// # Errors
    /// [`SkillFolderError::Taken`] if it holds a run already.
    pub fn begin(&self, record: &SkillRecord) -> Result<(), SkillFolderError> {
        if self.has_record() {
            let found = self.record()?;
            return Err(SkillFolderError::Taken {
                folder: self.dir.clone(),
                found_task: found.task.display().to_string(),
                found_ablation: found.ablation.name(),
                found_seed: found.seed,
            });
        }
        std::fs::create_dir_all(&self.dir)
            .map_err(|error| StorageError::writing(&self.dir, error))?;
        let text =
            toml::to_string(record).map_err(|error| SkillFolderError::Text(error.to_string()))?;
        Ok(write_atomically(&self.record_file(), text.as_bytes())?)
    }

    /// What its run was made with.
    ///
    /// # Errors
    /// [`SkillFolderError`] if `skill.toml` is not there or not of this program.
    pub fn record(&self) -> Result<SkillRecord, SkillFolderError> {
        let record: SkillRecord = read_toml(&self.record_file())?;
        if record.format != FORMAT {
            return Err(SkillFolderError::Format {
                folder: self.dir.clone(),
                found: record.format,
            });
        }
        Ok(record)
    }

    /// Writes I_c.
    ///
    /// # Errors
    /// [`SkillFolderError::Storage`].
    pub fn write_grasps(&self, grasps: &[KnownGrasp]) -> Result<(), SkillFolderError> {
        let text = serde_json::to_string_pretty(grasps)
            .map_err(|error| SkillFolderError::Text(error.to_string()))?;
        Ok(write_atomically(&self.grasps(), text.as_bytes())?)
    }

    /// Appends a line to the metrics.
    ///
    /// # Errors
    /// [`SkillFolderError::Storage`].
    pub fn append(&self, line: &impl Serialize) -> Result<(), SkillFolderError> {
        let text = serde_json::to_string(line)
            .map_err(|error| SkillFolderError::Text(error.to_string()))?;
        Ok(append_line(&self.metrics(), &text)?)
    }

    /// Keeps the metrics of the first `n_episodes` episodes, for a run that goes on from there; returns the best success
    /// rate among the evaluations that stay.
    ///
    /// # Errors
    /// [`SkillFolderError::Storage`].
    pub fn keep_metrics(&self, n_episodes: u64) -> Result<Option<f64>, SkillFolderError> {
        let file = self.metrics();
        keep_whole_lines(&file)?;
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(StorageError::reading(&file, error).into()),
        };
        let mut kept = String::new();
        let mut best: Option<f64> = None;
        for line in text.lines() {
            let Ok(value) = serde_json::from_str::<serde_json::Value>(line) else {
                continue;
            };
            if value["episode"]
                .as_u64()
                .is_none_or(|episode| episode > n_episodes)
            {
                continue;
            }
            best = match (best, value["success_rate"].as_f64()) {
                (Some(best), Some(rate)) => Some(best.max(rate)),
                (best, rate) => best.or(rate),
            };
            kept.push_str(line);
            kept.push('\n');
        }
        write_atomically(&file, kept.as_bytes())?;
        Ok(best)
    }
}
