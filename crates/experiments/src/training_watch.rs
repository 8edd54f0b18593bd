//! Trainings of other processes, seen from outside: what their skill folders say, look by look.
//!
//! A look asks the files of each folder for their times and lengths, and reads no more than what is new in them. It never
//! writes, so a training does not notice that it is watched.

mod metrics;

use std::collections::BTreeMap;
use std::fs::Metadata;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use factotum_protocol as wire;

use crate::skill_folder::{SkillFolder, SkillFolderError, SkillRecord};
use crate::storage::StorageError;
use crate::utc::UtcTime;

use metrics::Metrics;
pub use metrics::MetricsError;

/// Trainings that are shown at most.
pub const TRAININGS_MAX: usize = 50;

/// A training whose files changed within this many seconds is under way: longer than an episode and an evaluation take.
const RUNNING_SECS: u64 = 15;

/// Evaluations of a training that are shown at most.
const EVALUATIONS_MAX: usize = 200;

/// What cannot be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainingWatchError {
    /// The folder of the skill folders cannot be listed.
    #[error(transparent)]
    List(#[from] StorageError),
    /// What a skill is learned with.
    #[error(transparent)]
    Folder(#[from] SkillFolderError),
    /// How far it is learned.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
}

/// What a look found.
#[derive(Debug, Default)]
pub struct Look {
    /// All trainings, if something has changed since the last look.
    pub changed: Option<wire::Trainings>,
    /// What cannot be shown, told once.
    pub troubles: Vec<TrainingWatchError>,
}

/// A watch over the skill folders in a folder.
#[derive(Debug)]
pub struct TrainingWatch {
    dir: PathBuf,
    watched: BTreeMap<String, Watched>,
    listing: Trouble,
    shown: wire::Trainings,
}

impl TrainingWatch {
    /// A watch over the skill folders in `dir`, which need not be there.
    #[must_use]
    pub fn new(dir: &Path) -> Self {
        Self {
            dir: dir.to_path_buf(),
            watched: BTreeMap::new(),
            listing: Trouble::default(),
            shown: wire::Trainings::default(),
        }
    }

    /// Looks at all of them.
    pub fn look(&mut self, now: UtcTime) -> Look {
        let mut troubles = Vec::new();
        let found = self.found(now);
        let mut found = self.listing.heard(found, &mut troubles).unwrap_or_default();
        // Rows stay where they are as long as nothing begins or ends.
        found.sort_by(|one, other| {
            let by_time = |found: &Found| (found.is_running, found.stamp.begun.changed);
            by_time(other)
                .cmp(&by_time(one))
                .then_with(|| one.name.cmp(&other.name))
        });
        found.truncate(TRAININGS_MAX);
        let mut before = std::mem::take(&mut self.watched);
        let mut trainings = Vec::with_capacity(found.len());
        for found in found {
            let mut watched = before.remove(&found.name).unwrap_or_default();
            watched.look(&self.dir.join(&found.name), found.stamp, &mut troubles);
            trainings.extend(watched.training(&found));
            self.watched.insert(found.name, watched);
        }
        let trainings = wire::Trainings { trainings };
        let changed = (trainings != self.shown).then(|| {
            self.shown.clone_from(&trainings);
            trainings
        });
        Look { changed, troubles }
    }

    /// The skill folders that are there.
    fn found(&self, now: UtcTime) -> Result<Vec<Found>, TrainingWatchError> {
        let failed = |error| StorageError::reading(&self.dir, error);
        let entries = match std::fs::read_dir(&self.dir) {
            Ok(entries) => entries,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(failed(error).into()),
        };
        let mut found = Vec::new();
        for entry in entries {
            let entry = entry.map_err(failed)?;
            // A name that is no text could not be shown.
            let (Ok(name), Some(stamp)) =
                (entry.file_name().into_string(), Stamp::of(&entry.path()))
            else {
                continue;
            };
            let changed = UtcTime::from(stamp.changed());
            found.push(Found {
                name,
                stamp,
                is_running: now.unix_secs().saturating_sub(changed.unix_secs()) < RUNNING_SECS,
            });
        }
        Ok(found)
    }
}

/// A skill folder that is there.
#[derive(Debug)]
struct Found {
    name: String,
    stamp: Stamp,
    is_running: bool,
}

/// Times and lengths of a folder's files: what is read again only once they have changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    begun: FileStamp,
    metrics: Option<FileStamp>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FileStamp {
    changed: SystemTime,
    length: u64,
}

impl Stamp {
    /// Of a skill folder; nothing for what is none.
    fn of(dir: &Path) -> Option<Self> {
        let folder = SkillFolder::at(dir);
        Some(Self {
            begun: FileStamp::of(&folder.record_file())?,
            metrics: FileStamp::of(&folder.metrics()),
        })
    }

    fn changed(&self) -> SystemTime {
        let metrics = self.metrics.map(|metrics| metrics.changed);
        metrics.map_or(self.begun.changed, |changed| {
            changed.max(self.begun.changed)
        })
    }
}

impl FileStamp {
    fn of(file: &Path) -> Option<Self> {
        let metadata = std::fs::metadata(file).ok().filter(Metadata::is_file)?;
        Some(Self {
            changed: metadata.modified().ok()?,
            length: metadata.len(),
        })
    }
}

/// What is known of a skill folder.
#[derive(Debug, Default)]
struct Watched {
    stamp: Option<Stamp>,
    record: Option<SkillRecord>,
    metrics: Metrics,
    trouble: Trouble,
}

impl Watched {
    /// Reads what has changed since the last look.
    fn look(&mut self, dir: &Path, stamp: Stamp, troubles: &mut Vec<TrainingWatchError>) {
        if self.stamp == Some(stamp) {
            return;
        }
        if self.stamp.is_none_or(|before| before.begun != stamp.begun) {
            self.record = None;
            self.metrics = Metrics::default();
        }
        self.stamp = Some(stamp);
        let read = self.read(&SkillFolder::at(dir), stamp.metrics.is_some());
        self.trouble.heard(read, troubles);
    }

    fn read(&mut self, folder: &SkillFolder, has_metrics: bool) -> Result<(), TrainingWatchError> {
        if self.record.is_none() {
            self.record = Some(folder.record()?);
        }
        if has_metrics {
            self.metrics.follow(&folder.metrics())?;
        } else {
            self.metrics = Metrics::default();
        }
        Ok(())
    }

    /// What a page is shown of it; nothing while there is trouble with it.
    fn training(&self, found: &Found) -> Option<wire::Training> {
        let record = self
            .record
            .as_ref()
            .filter(|_| self.trouble.text.is_none())?;
        let metrics = &self.metrics;
        let task = record.task.file_stem().unwrap_or_default();
        Some(wire::Training {
            name: found.name.clone(),
            task: task.to_string_lossy().into_owned(),
            ablation: record.ablation.name().to_owned(),
            seed: record.seed.to_string(),
            running: found.is_running,
            episodes: count(metrics.n_episodes),
            env_steps: count(metrics.n_env_steps),
            violations: count(metrics.n_violations),
            recent_success_rate: metrics.recent_success_rate(),
            evaluations: evaluations(metrics),
        })
    }
}

/// Every k-th evaluation back from the last, so that there are not too many.
fn evaluations(metrics: &Metrics) -> Vec<wire::Evaluation> {
    let every = metrics.evaluations.len().div_ceil(EVALUATIONS_MAX).max(1);
    let latest_first = metrics.evaluations.iter().rev().step_by(every);
    let mut evaluations: Vec<_> = latest_first
        .map(|evaluation| wire::Evaluation {
            episode: count(evaluation.episode),
            success_rate: evaluation.success_rate,
            violation_rate: evaluation.violation_rate,
            peak_force_n: evaluation.peak_force_n,
            time_to_success_secs: evaluation.time_to_success_secs,
        })
        .collect();
    evaluations.reverse();
    evaluations
}

/// A count as the wire has it.
fn count(n: u64) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

/// Trouble that lasts, and is told once.
#[derive(Debug, Default)]
struct Trouble {
    text: Option<String>,
}

impl Trouble {
    /// What was read, if it was; trouble goes to `troubles`, unless it is the same as before.
    fn heard<T>(
        &mut self,
        read: Result<T, TrainingWatchError>,
        troubles: &mut Vec<TrainingWatchError>,
    ) -> Option<T> {
        match read {
            Ok(read) => {
                self.text = None;
                Some(read)
            }
            Err(error) => {
                let text = Some(error.to_string());
                if self.text != text {
                    self.text = text;
                    troubles.push(error);
                }
                None
            }
        }
    }
}

#[cfg(test)]
mod tests;
