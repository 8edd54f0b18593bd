//! A motor skill as a folder.
//!
//! | file | holds |
//! |---|---|
//! | `motor.toml` | task, seed, and what it was begun with |
//! | `demonstrations` | the recorded motions that it was begun with, if it was |
//! | `search.json` | the search after its last epoch: policy, exploration, epochs |
//! | `metrics.jsonl` | a line for each epoch, from 0, the policy that it began with |
//!
//! Each file is written whole or not at all, the metrics by whole lines.

use std::path::{Path, PathBuf};

use factotum_descriptions::{MotorPolicy, RecordedMotion, read_toml};
use serde::{Deserialize, Serialize};

use super::{EpochRecord, Init, MotorError, SearchName, SearchState};
use crate::storage::{StorageError, append_line, write_atomically};

/// Version of the folder's format.
const FORMAT: u32 = 2;

/// What a motor skill was learned with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorRecord {
    /// Version of the format.
    pub format: u32,
    /// The task: a task file, or the name of a shipped task.
    pub task: PathBuf,
    /// Where the first policy is from.
    pub init: Init,
    /// Form of the policy.
    pub policy: MotorPolicy,
    /// How it is improved.
    pub search: SearchName,
    /// Seed of all that is random.
    pub seed: u64,
    /// Rollouts of each epoch.
    pub rollouts: u32,
    /// Error of the planned object's position, metres.
    pub model_error_m: f64,
    /// Error of its joint's axis, rad.
    pub model_error_rad: f64,
}

impl MotorRecord {
    /// The record of a run with what the dissertation takes for such a policy, and a true model.
    pub fn new(task: PathBuf, init: Init, policy: MotorPolicy, seed: u64) -> Self {
        Self {
            format: FORMAT,
            task,
            init,
            policy,
            search: SearchName::usual(policy, init),
            seed,
            rollouts: match policy {
                MotorPolicy::Dmp => 10,
                MotorPolicy::Mlp => 20,
            },
            model_error_m: 0.0,
            model_error_rad: 0.0,
        }
    }

    /// Epochs, if nobody asks for another number: the dissertation's budget.
    pub fn usual_epochs(&self) -> u64 {
        match self.policy {
            MotorPolicy::Dmp => 40,
            MotorPolicy::Mlp => 10,
        }
    }
}

/// The folder of a motor skill.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MotorFolder {
    dir: PathBuf,
}

impl MotorFolder {
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

    /// Whether a run was begun in it.
    pub fn has_record(&self) -> bool {
        self.record_file().exists()
    }

    fn record_file(&self) -> PathBuf {
        self.dir.join("motor.toml")
    }

    fn search_file(&self) -> PathBuf {
        self.dir.join("search.json")
    }

    /// Its metrics.
    pub fn metrics(&self) -> PathBuf {
        self.dir.join("metrics.jsonl")
    }

    /// Begins a run, with recorded motions if it is to begin with them.
    ///
    /// # Errors
    /// [`MotorError::Taken`] if it holds a run, [`MotorError::Storage`] if it cannot be written.
    pub fn begin(
        &self,
        record: &MotorRecord,
        recorded: &[RecordedMotion],
    ) -> Result<(), MotorError> {
        if self.has_record() {
            let found = self.record()?;
            return Err(MotorError::Taken {
                folder: self.dir.display().to_string(),
                found_task: found.task.display().to_string(),
                found_init: found.init.name(),
                found_seed: found.seed,
            });
        }
        std::fs::create_dir_all(&self.dir)
            .map_err(|error| StorageError::writing(&self.dir, error))?;
        let shelf = self.demonstrations_dir();
        if !recorded.is_empty() {
            std::fs::create_dir_all(&shelf)
                .map_err(|error| StorageError::writing(&shelf, error))?;
        }
        for (i, motion) in recorded.iter().enumerate() {
            let file = shelf.join(format!("{i:03}.jsonl"));
            write_atomically(&file, motion.to_text().as_bytes())?;
        }
        let text = toml::to_string(record).map_err(|error| MotorError::Text(error.to_string()))?;
        Ok(write_atomically(&self.record_file(), text.as_bytes())?)
    }

    /// What its run was made with.
    ///
    /// # Errors
    /// [`MotorError`] if `motor.toml` is not there or not of this program.
    pub fn record(&self) -> Result<MotorRecord, MotorError> {
        let record: MotorRecord = read_toml(&self.record_file())?;
        if record.format != FORMAT {
            return Err(MotorError::Format {
                folder: self.dir.display().to_string(),
                found: record.format,
                wanted: FORMAT,
            });
        }
        Ok(record)
    }

    fn demonstrations_dir(&self) -> PathBuf {
        self.dir.join("demonstrations")
    }

    /// The recorded motions that its run was begun with.
    ///
    /// # Errors
    /// [`MotorError`] if one cannot be read.
    pub fn demonstrations(&self) -> Result<Vec<RecordedMotion>, MotorError> {
        let mut motions = Vec::new();
        loop {
            let name = format!("{:03}.jsonl", motions.len());
            let file = self.demonstrations_dir().join(name);
            if !file.exists() {
                return Ok(motions);
            }
            motions.push(RecordedMotion::load(&file)?);
        }
    }

    /// Stores the search after an epoch.
    ///
    /// # Errors
    /// [`MotorError::Storage`] if it cannot be written; the one before stays then.
    pub fn write_search(&self, state: &SearchState) -> Result<(), MotorError> {
        let text =
            serde_json::to_string(state).map_err(|error| MotorError::Text(error.to_string()))?;
        Ok(write_atomically(&self.search_file(), text.as_bytes())?)
    }

    /// The search after its last epoch, if there is one.
    ///
    /// # Errors
    /// [`MotorError::Stored`] if it is no search.
    pub fn search(&self) -> Result<Option<SearchState>, MotorError> {
        let file = self.search_file();
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(StorageError::reading(&file, error).into()),
        };
        let state =
            serde_json::from_str(&text).map_err(|error| self.not_this(error.to_string()))?;
        Ok(Some(state))
    }

    /// What is stored is of something else.
    pub(super) fn not_this(&self, reason: String) -> MotorError {
        MotorError::Stored {
            file: self.search_file().display().to_string(),
            reason,
        }
    }

    /// Appends an epoch to the metrics.
    ///
    /// # Errors
    /// [`MotorError::Storage`].
    pub fn append(&self, epoch: &EpochRecord) -> Result<(), MotorError> {
        Ok(append_line(&self.metrics(), &line_of(epoch)?)?)
    }

    /// The epochs of its metrics.
    ///
    /// # Errors
    /// [`MotorError::Storage`].
    pub fn epochs(&self) -> Result<Vec<EpochRecord>, MotorError> {
        let file = self.metrics();
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(StorageError::reading(&file, error).into()),
        };
        let epochs = text
            .lines()
            .map_while(|line| serde_json::from_str(line).ok());
        Ok(epochs.collect())
    }

    /// Keeps the epochs before `n` in the metrics, for a run that goes on from there.
    ///
    /// # Errors
    /// [`MotorError::Storage`].
    pub fn keep_epochs(&self, n: u64) -> Result<Vec<EpochRecord>, MotorError> {
        let mut kept = self.epochs()?;
        kept.retain(|epoch| epoch.epoch < n);
        let mut text = String::new();
        for epoch in &kept {
            text.push_str(&line_of(epoch)?);
            text.push('\n');
        }
        write_atomically(&self.metrics(), text.as_bytes())?;
        Ok(kept)
    }
}

fn line_of(epoch: &EpochRecord) -> Result<String, MotorError> {
    serde_json::to_string(epoch).map_err(|error| MotorError::Text(error.to_string()))
}
