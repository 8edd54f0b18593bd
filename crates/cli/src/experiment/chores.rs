//! `factotum experiment run chores`: how often physics says that the chores are achieved.

use std::path::PathBuf;

use clap::{Args, ValueEnum as _};
use factotum_experiments::sweep::{
    Progress, RESULTS_NAME, RunResult, SeedSweep, SweepError, summarize,
};
use serde_json::json;

use super::{duration_words, stop_on_interrupt};
use crate::console::{Answer, Console, usage};
use crate::run::FaultName;

/// Arguments of `factotum experiment run chores`.
#[derive(Debug, Args)]
pub(crate) struct ChoresArgs {
    /// Runs seeds 0 to N - 1.
    #[arg(long, value_name = "N", default_value_t = 20)]
    seeds: u64,
    /// Chore; every chore of the scene if absent.
    #[arg(long)]
    goal: Option<String>,
    /// Something that goes wrong.
    #[arg(long, value_enum)]
    fault: Option<FaultName>,
    /// Robot: a folder with `robot.toml`, or the name of a shipped one.
    #[arg(long)]
    robot: Option<PathBuf>,
    /// Home: a folder with `scene.toml`, or the name of a shipped one.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Runs at a time.
    #[arg(long, default_value_t = 1)]
    workers: usize,
    /// Folder of the results. Default: `runs/chores-<goal>-<fault>`.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Runs `factotum experiment run chores`.
pub(super) fn chores(args: &ChoresArgs, console: &Console) -> anyhow::Result<Answer> {
    if args.seeds == 0 {
        return Err(usage("--seeds is 0, expected at least 1"));
    }
    let stop = stop_on_interrupt()?;
    let fault = args.fault.and_then(|fault| fault.to_possible_value());
    let fault = fault.as_ref().map(|fault| fault.get_name().to_owned());
    let folder = args.out.clone().unwrap_or_else(|| {
        let words = [Some("chores"), args.goal.as_deref(), fault.as_deref()];
        PathBuf::from("runs").join(words.into_iter().flatten().collect::<Vec<_>>().join("-"))
    });
    let sweep = SeedSweep {
        program: std::env::current_exe()?,
        arguments: run_arguments(args, fault),
        seeds: (0..args.seeds).collect(),
        n_workers: args.workers,
        folder: folder.clone(),
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
    let results = sweep.run(&stop, tell).map_err(|error| match error {
        SweepError::OtherCommand { .. } | SweepError::NoCommand { .. } => usage(error),
        error => error.into(),
    })?;
    let is_complete = results.len() as u64 == args.seeds;
    let Some(summary) = summarize(&results) else {
        console.answer(&json!({"complete": false, "n_runs": 0}), || {
            "no runs".to_owned()
        })?;
        return Ok(Answer::No);
    };
    console.answer(&json!({"complete": is_complete, "summary": summary}), || {
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
        if !is_complete {
            lines.push(format!(
                "stopped with {} of {} seeds run; the same command goes on",
                summary.n_runs, args.seeds
            ));
        }
        lines.push(format!("results: `{}`", folder.join(RESULTS_NAME).display()));
        lines.join("\n")
    })?;
    Ok(Answer::from(
        is_complete && summary.n_successes == summary.n_runs,
    ))
}

/// The run of one seed, but for `--seed`. It keeps no run folder: its document is in the results.
fn run_arguments(args: &ChoresArgs, fault: Option<String>) -> Vec<String> {
    let path = |path: &PathBuf| path.display().to_string();
    let options = [
        ("--goal", args.goal.clone()),
        ("--fault", fault),
        ("--robot", args.robot.as_ref().map(path)),
        ("--scene", args.scene.as_ref().map(path)),
    ];
    let given = options
        .into_iter()
        .filter_map(|(name, value)| Some([name.to_owned(), value?]));
    ["run", "--headless", "--json", "--no-folder"]
        .map(str::to_owned)
        .into_iter()
        .chain(given.flatten())
        .collect()
}
