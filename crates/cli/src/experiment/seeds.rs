//! A command of this program over seeds 0 to N - 1, told run by run and summed up.

use std::path::PathBuf;

use factotum_experiments::sweep::{
    Progress, RESULTS_NAME, RunResult, SeedSweep, StopWish, Summary, SweepError, summarize,
};

use super::duration_words;
use crate::console::{Console, usage};

/// What is to be run.
#[derive(Debug)]
pub(super) struct Seeds {
    /// The command but for `--seed`.
    pub(super) arguments: Vec<String>,
    /// How many seeds.
    pub(super) n: u64,
    /// Runs at a time.
    pub(super) n_workers: usize,
    /// Folder of the results.
    pub(super) folder: PathBuf,
}

/// What came of it.
#[derive(Debug)]
pub(super) struct Swept {
    /// Nothing if no run came to its end.
    pub(super) summary: Option<Summary>,
    /// Whether every seed has a result.
    pub(super) is_complete: bool,
}

impl Swept {
    /// Whether every seed was run and succeeded.
    pub(super) fn is_success(&self) -> bool {
        self.is_complete
            && self
                .summary
                .as_ref()
                .is_some_and(|summary| summary.n_successes == summary.n_runs)
    }
}

impl Seeds {
    /// Runs what has no result yet.
    pub(super) fn run(&self, stop: &StopWish, console: &Console) -> anyhow::Result<Swept> {
        if self.n == 0 {
            return Err(usage("--seeds is 0, expected at least 1"));
        }
        let sweep = SeedSweep {
            program: std::env::current_exe()?,
            arguments: self.arguments.clone(),
            seeds: (0..self.n).collect(),
            n_workers: self.n_workers,
            folder: self.folder.clone(),
        };
        let tell = |result: &RunResult, progress: Progress| {
            let word = match (result.is_success(), result.is_answered()) {
                (true, _) => "achieved",
                (false, true) => "not achieved",
                (false, false) => "no answer",
            };
            console.say(format_args!(
                "seed {:>3}: {word} in {:.1} s; {} of {}, {} achieved; {} left",
                result.seed,
                result.wall_secs,
                progress.n_done,
                progress.n_runs,
                progress.n_successes,
                duration_words(progress.secs_left)
            ));
        };
        let results = sweep.run(stop, tell).map_err(|error| match error {
            SweepError::OtherCommand { .. } | SweepError::NoCommand { .. } => usage(error),
            error => error.into(),
        })?;
        Ok(Swept {
            is_complete: results.len() as u64 == self.n,
            summary: summarize(&results),
        })
    }

    /// What came of it, in words.
    pub(super) fn describe(&self, swept: &Swept) -> String {
        let Some(summary) = &swept.summary else {
            return "no runs".to_owned();
        };
        let interval = &summary.success;
        let mut lines = vec![format!(
            "{} of {} achieved; 95 % interval {:.0} to {:.0} % (Wilson); median {:.1} s, longest {:.1} s a run",
            summary.n_successes,
            summary.n_runs,
            100.0 * interval.lower,
            100.0 * interval.upper,
            summary.wall_secs_median,
            summary.wall_secs_max
        )];
        if !summary.seeds_failed.is_empty() {
            lines.push(format!("not achieved: seeds {:?}", summary.seeds_failed));
        }
        if !summary.seeds_unanswered.is_empty() {
            lines.push(format!("no answer: seeds {:?}", summary.seeds_unanswered));
        }
        if !swept.is_complete {
            lines.push(format!(
                "stopped with {} of {} seeds run; the same command goes on",
                summary.n_runs, self.n
            ));
        }
        lines.push(format!(
            "results: `{}`",
            self.folder.join(RESULTS_NAME).display()
        ));
        lines.join("\n")
    }
}
