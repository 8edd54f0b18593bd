//! One command over many seeds, and how often it succeeded. A run that crashed counts as a failure.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{
    ChildEnd, Interval, Launcher, Outcome, Progress, StopWish, Sweep, SweepError, wilson_interval,
};

/// A command to run over seeds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SeedSweep {
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
    fn new(seed: u64, end: ChildEnd) -> Self {
        Self {
            seed,
            exit_code: end.exit_code,
            wall_secs: end.wall_secs,
            output: end.output,
            messages: end.messages,
        }
    }

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

impl Outcome for RunResult {
    type Key = u64;

    fn key(&self) -> u64 {
        self.seed
    }

    fn is_success(&self) -> bool {
        Self::is_success(self)
    }

    fn wall_secs(&self) -> f64 {
        self.wall_secs
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

impl SeedSweep {
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
        let sweep = Sweep {
            folder: self.folder.clone(),
            command: self.arguments.clone(),
            keys: self.seeds.clone(),
            n_workers: self.n_workers,
        };
        let launcher = Launcher {
            program: &self.program,
            folder: &self.folder,
            stop,
            lock: None,
        };
        let run_one = |seed: &u64| {
            let seed_words = ["--seed".to_owned(), seed.to_string()];
            let end = launcher.run(&[&self.arguments[..], &seed_words].concat())?;
            Ok(end.map(|end| RunResult::new(*seed, end)))
        };
        sweep.run(stop, run_one, |result, progress| {
            on_result(result, progress);
            Ok::<(), SweepError>(())
        })
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
