//! Runs of one command over many seeds, in child processes, and how often it succeeded.
//!
//! Each run is one line of `results.jsonl`, synced to the disk when the run ends, so a sweep that was stopped or killed
//! goes on where it was; `sweep.json` says of which command the results are. A run that crashed counts as a failure; no
//! run that came to its own end is dropped. Results are sorted by seed, so that the number of workers cannot change what
//! is reported.

mod folder;
mod run;
mod stop;
mod wilson;

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use thiserror::Error;

use crate::storage::StorageError;

pub use folder::RESULTS_NAME;
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
    /// A run under way cannot be followed.
    #[error("cannot follow the run of seed {seed}")]
    Follow {
        /// Its seed.
        seed: u64,
        /// Why.
        source: io::Error,
    },
    /// A worker thread could not be started.
    #[error("cannot start a worker")]
    Worker(#[source] io::Error),
}

/// A command to run over seeds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sweep {
    /// The program.
    pub program: PathBuf,
    /// Its arguments; `--seed SEED` is added to them. It prints one JSON document on its standard output and ends with
    /// exit code 0 for success and 1 for a negative answer.
    pub arguments: Vec<String>,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// How many run at a time, at least one.
    pub n_workers: usize,
    /// Where the results are kept.
    pub folder: PathBuf,
}

/// What came of one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunResult {
    /// Its seed.
    pub seed: u64,
    /// Its exit code; nothing when a signal ended it.
    pub exit_code: Option<i32>,
    /// How long it took, seconds.
    pub wall_secs: f64,
    /// The JSON document it printed; nothing when it printed none.
    pub output: Option<Value>,
    /// The end of its messages, kept when it did not succeed.
    pub messages: String,
}

impl RunResult {
    /// Whether the run said that it succeeded.
    #[must_use]
    pub fn is_success(&self) -> bool {
        self.exit_code == Some(0)
    }

    /// Whether the run came to an answer, be it negative.
    #[must_use]
    pub fn is_answered(&self) -> bool {
        matches!(self.exit_code, Some(0 | 1))
    }
}

/// What a sweep shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Runs that ended.
    pub n_runs: usize,
    /// Those that succeeded.
    pub n_successes: usize,
    /// Seeds that ended with a negative answer.
    pub seeds_failed: Vec<u64>,
    /// Seeds that ended without an answer: crashes, bad input. They count as failures.
    pub seeds_unanswered: Vec<u64>,
    /// Where the probability of success lies, with 95 % confidence.
    pub success: Interval,
    /// Median time of a run, seconds.
    pub wall_secs_median: f64,
    /// Longest time of a run, seconds.
    pub wall_secs_max: f64,
}

/// How far a sweep is, results of earlier times included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Seeds that have a result.
    pub n_done: usize,
    /// Seeds of the sweep.
    pub n_seeds: usize,
    /// Seeds that succeeded.
    pub n_successes: usize,
}

impl Sweep {
    /// Runs the seeds that have no result yet and returns all results, sorted by seed.
    ///
    /// `stop` ends the sweep early; `on_result` hears of each new result, and how far the sweep is with it.
    ///
    /// # Errors
    /// [`SweepError`] when the folder holds results of another command, the command cannot be started, or results cannot
    /// be kept.
    pub fn run(
        &self,
        stop: &StopWish,
        mut on_result: impl FnMut(&RunResult, Progress),
    ) -> Result<Vec<RunResult>, SweepError> {
        let seeds: BTreeSet<u64> = self.seeds.iter().copied().collect();
        // Results of seeds that are not asked for now stay in the file and out of the answer.
        let mut results: BTreeMap<u64, RunResult> = folder::open(&self.folder, &self.arguments)?
            .into_iter()
            .filter(|result| seeds.contains(&result.seed))
            .map(|result| (result.seed, result))
            .collect();
        let open: BTreeSet<u64> = seeds
            .iter()
            .copied()
            .filter(|seed| !results.contains_key(seed))
            .collect();
        let open = Mutex::new(open);
        // A worker that cannot go on stops the others through this.
        let halt = AtomicBool::new(false);
        let next_seed = || {
            let is_over = stop.is_raised() || halt.load(Ordering::Relaxed);
            open.lock()
                .ok()
                .filter(|_| !is_over)
                .and_then(|mut seeds| seeds.pop_first())
        };
        thread::scope(|scope| {
            let n_workers = self.n_workers.max(1);
            let (send, receive) =
                std::sync::mpsc::sync_channel::<Result<RunResult, SweepError>>(n_workers);
            for number in 0..n_workers {
                let (send, next_seed) = (send.clone(), &next_seed);
                let work = move || {
                    while let Some(seed) = next_seed() {
                        let result = run::run_one(self, seed, stop).transpose();
                        if result.is_some_and(|result| send.send(result).is_err()) {
                            break;
                        }
                    }
                };
                let worker = thread::Builder::new().name(format!("sweep {number}"));
                if let Err(error) = worker.spawn_scoped(scope, work) {
                    halt.store(true, Ordering::Relaxed);
                    return Err(SweepError::Worker(error));
                }
            }
            drop(send);
            let mut n_successes = results
                .values()
                .filter(|result| result.is_success())
                .count();
            for received in receive {
                let kept = received.and_then(|result| {
                    folder::keep(&self.folder, &result)?;
                    Ok(result)
                });
                match kept {
                    Ok(result) => {
                        n_successes += usize::from(result.is_success());
                        let progress = Progress {
                            n_done: results.len() + 1,
                            n_seeds: seeds.len(),
                            n_successes,
                        };
                        on_result(&result, progress);
                        results.insert(result.seed, result);
                    }
                    Err(error) => {
                        halt.store(true, Ordering::Relaxed);
                        return Err(error);
                    }
                }
            }
            Ok(())
        })?;
        Ok(results.into_values().collect())
    }
}

/// What the results show together; nothing for no results.
#[must_use]
pub fn summarize(results: &[RunResult]) -> Option<Summary> {
    let mut wall_secs: Vec<f64> = results.iter().map(|result| result.wall_secs).collect();
    wall_secs.sort_by(f64::total_cmp);
    let seeds = |is_chosen: &dyn Fn(&RunResult) -> bool| -> Vec<u64> {
        results
            .iter()
            .filter(|result| is_chosen(result))
            .map(|result| result.seed)
            .collect()
    };
    let n_successes = results.iter().filter(|result| result.is_success()).count();
    Some(Summary {
        n_runs: results.len(),
        n_successes,
        seeds_failed: seeds(&|result| result.is_answered() && !result.is_success()),
        seeds_unanswered: seeds(&|result| !result.is_answered()),
        success: wilson_interval(n_successes, results.len())?,
        wall_secs_median: median(&wall_secs)?,
        wall_secs_max: *wall_secs.last()?,
    })
}

fn median(sorted: &[f64]) -> Option<f64> {
    let upper = *sorted.get(sorted.len() / 2)?;
    let lower = *sorted.get((sorted.len() - 1) / 2)?;
    Some(f64::midpoint(lower, upper))
}

#[cfg(test)]
mod tests;
