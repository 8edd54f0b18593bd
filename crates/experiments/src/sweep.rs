//! Runs in number, in child processes, whose results are kept as they come.
//!
//! Each run is one line of `results.jsonl`, synced to the disk when the run ends, so a sweep that was stopped or killed
//! goes on where it was; `sweep.json` says of which command the results are. No run that came to its own end is dropped.
//! Results are sorted by key, so that the number of workers cannot change what is reported.
//!
//! [`SeedSweep`] runs one command over seeds; [`crate::grid`] trains a skill for each cell of a table.

mod child;
mod folder;
mod seeds;
mod stop;
mod wilson;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::io;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::storage::StorageError;

pub use child::{ChildEnd, Launcher};
pub use folder::{RESULTS_NAME, read_results};
pub use seeds::{RunResult, SeedSweep, Summary, summarize};
pub use stop::StopWish;
pub use wilson::{Interval, wilson_interval};

/// A sweep that cannot go on.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The results could not be written or read.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// A line of earlier results is not one of ours.
    #[error("`{}` line {line}: not the result of a run", file.display())]
    Result {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong in it.
        source: serde_json::Error,
    },
    /// The folder holds results of another command.
    #[error(
        "`{}` holds results of another command: there `{}`, here `{}`; choose another folder",
        folder.display(),
        there.join(" "),
        here.join(" ")
    )]
    OtherCommand {
        /// The folder.
        folder: PathBuf,
        /// What the command of its results has that this one lacks.
        there: Vec<String>,
        /// What this command has that theirs lacks.
        here: Vec<String>,
    },
    /// The folder holds results that nobody can say the command of.
    #[error(
        "`{}` holds results but no `{}`, which says of what command; choose another folder",
        folder.display(),
        folder::COMMAND_NAME
    )]
    NoCommand {
        /// The folder.
        folder: PathBuf,
    },
    /// The command in a folder cannot be understood.
    #[error("`{}`: not the command of a sweep", file.display())]
    Command {
        /// The file.
        file: PathBuf,
        /// What is wrong in it.
        source: serde_json::Error,
    },
    /// The command cannot be started at all.
    #[error("cannot start `{}`", program.display())]
    Start {
        /// The program.
        program: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A child process cannot be followed.
    #[error("cannot follow `{command}`")]
    Follow {
        /// Its command.
        command: String,
        /// Why.
        source: io::Error,
    },
    /// A worker thread could not be started.
    #[error("cannot start a worker")]
    Worker(#[source] io::Error),
}

/// What is kept of one run, as a line of the results.
pub trait Outcome: Serialize + DeserializeOwned + Send {
    /// What names a run within its sweep.
    type Key: Ord + Clone + Send + Sync + Display;

    /// Which run it is of.
    fn key(&self) -> Self::Key;

    /// Whether the run did what it was to do.
    fn is_success(&self) -> bool;

    /// How long it took, seconds.
    fn wall_secs(&self) -> f64;
}

/// Runs to be carried out, each by its key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sweep<K> {
    /// Where the results are kept.
    pub folder: PathBuf,
    /// What all runs have in common. A folder keeps results of one command only.
    pub command: Vec<String>,
    /// The runs.
    pub keys: Vec<K>,
    /// How many run at a time, at least one.
    pub n_workers: usize,
}

/// How far a sweep is, results of earlier times included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Runs that have a result.
    pub n_done: usize,
    /// Runs of the sweep.
    pub n_runs: usize,
    /// Runs that succeeded.
    pub n_successes: usize,
    /// What the rest will take if it is like the runs before, seconds.
    pub secs_left: f64,
}

impl Progress {
    fn of<O: Outcome>(results: &BTreeMap<O::Key, O>, n_runs: usize, n_workers: usize) -> Self {
        let n_done = results.len();
        let wall_secs: f64 = results.values().map(O::wall_secs).sum();
        let n_open = n_runs.saturating_sub(n_done);
        Self {
            n_done,
            n_runs,
            n_successes: results
                .values()
                .filter(|result| result.is_success())
                .count(),
            secs_left: wall_secs / n_done.max(1) as f64 * n_open as f64 / n_workers as f64,
        }
    }
}

impl<K: Ord + Clone + Send + Sync + Display> Sweep<K> {
    /// The results that its folder holds already, of these runs and of others; makes the folder if there is none.
    ///
    /// # Errors
    /// [`SweepError`] when the folder holds results of another command, or what is none.
    pub fn open<O: Outcome<Key = K>>(&self) -> Result<Vec<O>, SweepError> {
        folder::open(&self.folder, &self.command)
    }

    /// Carries out the runs that have no result yet by `run_one`, and returns all results, sorted by key.
    ///
    /// `stop` ends the sweep early. `run_one` returns nothing for a run that did not come to its own end: it is carried
    /// out another time. `on_result` hears of each new result once it is kept, and how far the sweep is with it.
    ///
    /// # Errors
    /// [`SweepError`] when the folder holds results of another command or results cannot be kept; what `run_one` says.
    pub fn run<O, E>(
        &self,
        stop: &StopWish,
        run_one: impl Fn(&K) -> Result<Option<O>, E> + Sync,
        mut on_result: impl FnMut(&O, Progress) -> Result<(), E>,
    ) -> Result<Vec<O>, E>
    where
        O: Outcome<Key = K>,
        E: From<SweepError> + Send,
    {
        let keys: BTreeSet<K> = self.keys.iter().cloned().collect();
        // Results of runs that are not asked for now stay in the file and out of the answer.
        let mut results: BTreeMap<K, O> = self
            .open()?
            .into_iter()
            .map(|result: O| (result.key(), result))
            .filter(|(key, _)| keys.contains(key))
            .collect();
        let open: BTreeSet<K> = keys
            .iter()
            .filter(|key| !results.contains_key(key))
            .cloned()
            .collect();
        let open = Mutex::new(open);
        // A worker that cannot go on stops the others through this.
        let halt = AtomicBool::new(false);
        let next_key = || {
            let is_over = stop.is_raised() || halt.load(Ordering::Relaxed);
            open.lock()
                .ok()
                .filter(|_| !is_over)
                .and_then(|mut keys| keys.pop_first())
        };
        let n_workers = self.n_workers.max(1);
        thread::scope(|scope| {
            let (send, receive) = std::sync::mpsc::sync_channel::<Result<O, E>>(n_workers);
            for number in 0..n_workers {
                let (send, next_key, run_one) = (send.clone(), &next_key, &run_one);
                let work = move || {
                    while let Some(key) = next_key() {
                        let result = run_one(&key).transpose();
                        if result.is_some_and(|result| send.send(result).is_err()) {
                            break;
                        }
                    }
                };
                let worker = thread::Builder::new().name(format!("sweep {number}"));
                if let Err(error) = worker.spawn_scoped(scope, work) {
                    halt.store(true, Ordering::Relaxed);
                    return Err(SweepError::Worker(error).into());
                }
            }
            drop(send);
            for received in receive {
                let mut keep = |result: O| {
                    folder::keep(&self.folder, &result).map_err(SweepError::from)?;
                    let key = result.key();
                    results.insert(key.clone(), result);
                    on_result(
                        &results[&key],
                        Progress::of(&results, keys.len(), n_workers),
                    )
                };
                if let Err(error) = received.and_then(&mut keep) {
                    halt.store(true, Ordering::Relaxed);
                    return Err(error);
                }
            }
            Ok(())
        })?;
        Ok(results.into_values().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_that_of_the_runs_before() {
        let result = |seed, wall_secs| RunResult {
            seed,
            exit_code: Some(i32::from(seed == 1)),
            wall_secs,
            output: None,
            messages: String::new(),
        };
        let results = [(0, result(0, 10.0)), (1, result(1, 20.0))].into();
        // 15 s a run, six to go, two at a time.
        let progress = Progress::of(&results, 8, 2);
        assert_eq!((progress.n_done, progress.n_successes), (2, 1));
        assert!((progress.secs_left - 45.0).abs() < 1e-9, "{progress:?}");
        let none = Progress::of::<RunResult>(&BTreeMap::new(), 8, 2);
        assert!(none.secs_left.abs() < 1e-9);
    }
}
