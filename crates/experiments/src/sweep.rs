//! Runs of one command over many seeds, in child processes, and how often it succeeded.
//!
//! Each run is one line of `results.jsonl`, synced to the disk when the run ends, so a sweep that was stopped or killed
//! goes on where it was. A run that crashed counts as a failure; nothing is dropped. Results are sorted by seed, so
//! that the number of workers cannot change what is reported.

mod wilson;

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use thiserror::Error;

use crate::storage::{self, StorageError};

pub use wilson::{Interval, wilson_interval};

/// Name of the file of results in a sweep's folder.
pub const RESULTS_NAME: &str = "results.jsonl";

/// As much of a child's messages as is kept, from the end.
const MESSAGES_BYTES_MAX: usize = 2_000;

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
    /// The command cannot be started at all.
    #[error("cannot start `{}`", program.display())]
    Start {
        /// The program.
        program: PathBuf,
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

impl Sweep {
    /// Runs the seeds that have no result yet and returns all results, sorted by seed.
    ///
    /// `stop` ends the sweep once the runs under way have ended; `on_result` hears of each new result.
    ///
    /// # Errors
    /// [`SweepError`] when the command cannot be started, or results cannot be kept.
    pub fn run(
        &self,
        stop: &AtomicBool,
        mut on_result: impl FnMut(&RunResult),
    ) -> Result<Vec<RunResult>, SweepError> {
        std::fs::create_dir_all(&self.folder)
            .map_err(|error| StorageError::writing(&self.folder, error))?;
        let file = self.folder.join(RESULTS_NAME);
        storage::keep_whole_lines(&file)?;
        let mut results: BTreeMap<u64, RunResult> = read_results(&file)?
            .into_iter()
            .map(|result| (result.seed, result))
            .collect();
        let open: BTreeSet<u64> = self
            .seeds
            .iter()
            .copied()
            .filter(|seed| !results.contains_key(seed))
            .collect();
        let open = Mutex::new(open);
        // A worker that cannot go on stops the others through this.
        let halt = AtomicBool::new(false);
        let next_seed = || {
            let is_over = stop.load(Ordering::Relaxed) || halt.load(Ordering::Relaxed);
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
                        if send.send(self.run_one(seed)).is_err() {
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
            for received in receive {
                let kept = received.and_then(|result| {
                    append_result(&file, &result)?;
                    Ok(result)
                });
                match kept {
                    Ok(result) => {
                        on_result(&result);
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
        // Results of seeds that are not asked for now stay in the file and out of the answer.
        Ok(self
            .seeds
            .iter()
            .collect::<BTreeSet<_>>()
            .into_iter()
            .filter_map(|seed| results.remove(seed))
            .collect())
    }

    fn run_one(&self, seed: u64) -> Result<RunResult, SweepError> {
        let begun = Instant::now();
        let output = Command::new(&self.program)
            .args(&self.arguments)
            .args(["--seed", &seed.to_string()])
            .stdin(Stdio::null())
            .output()
            .map_err(|source| SweepError::Start {
                program: self.program.clone(),
                source,
            })?;
        Ok(result_of(seed, &output, begun.elapsed().as_secs_f64()))
    }
}

/// The results in a file, none if there is no file.
///
/// # Errors
/// [`SweepError`] when the file cannot be read or holds something else.
pub fn read_results(file: &Path) -> Result<Vec<RunResult>, SweepError> {
    let text = match std::fs::read_to_string(file) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(StorageError::reading(file, error).into()),
    };
    let parse = |(idx, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|source| SweepError::Result {
            file: file.to_path_buf(),
            line: idx + 1,
            source,
        })
    };
    text.lines().enumerate().map(parse).collect()
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

fn append_result(file: &Path, result: &RunResult) -> Result<(), StorageError> {
    let line =
        serde_json::to_string(result).map_err(|error| StorageError::writing(file, error.into()))?;
    storage::append_line(file, &line)
}

fn result_of(seed: u64, output: &Output, wall_secs: f64) -> RunResult {
    let is_success = output.status.success();
    let messages = &output.stderr[output.stderr.len().saturating_sub(MESSAGES_BYTES_MAX)..];
    RunResult {
        seed,
        exit_code: output.status.code(),
        wall_secs,
        output: serde_json::from_slice(&output.stdout).ok(),
        messages: if is_success {
            String::new()
        } else {
            String::from_utf8_lossy(messages).into_owned()
        },
    }
}

#[cfg(test)]
mod tests;
