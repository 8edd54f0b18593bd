//! `factotum experiment run|report bootstrap-sim`: what a plan to begin with is worth to a motor skill (thesis Fig. 4.5).

use std::path::PathBuf;

use clap::Args;
use factotum_experiments::motor::{Study, StudyError, TrialResult, study_report};
use factotum_experiments::sweep::{Outcome as _, Progress, RESULTS_NAME};
use serde_json::json;

use super::{duration_words, stop_on_interrupt};
use crate::assets;
use crate::console::{Answer, Console, usage};

/// Arguments of `factotum experiment run bootstrap-sim`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Shipped tasks.
    #[arg(
        long,
        value_name = "TASK,...",
        value_delimiter = ',',
        default_value = "microwave,drawer-heavy,t-ball"
    )]
    tasks: Vec<String>,
    /// Seeds of each task and beginning.
    #[arg(long, value_name = "N", default_value_t = 20)]
    seeds: u64,
    /// The first of them.
    #[arg(long, value_name = "BASE", default_value_t = 200)]
    seed: u64,
    /// Updates of the policy [default: 40 for primitives, 10 for networks].
    #[arg(long, value_name = "N")]
    epochs: Option<u64>,
    /// Standard deviation of the error of the object's position and of its joint's origin, for the plan.
    #[arg(long, value_name = "MM", default_value_t = 0.0)]
    model_error_mm: f64,
    /// Standard deviation of the error of its joint's axis, for the plan.
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    model_error_deg: f64,
    /// Runs at a time.
    #[arg(long, default_value_t = 1)]
    workers: usize,
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "runs/bootstrap-sim")]
    out: PathBuf,
}

/// Arguments of `factotum experiment report bootstrap-sim`.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "experiments/bootstrap-sim")]
    from: PathBuf,
    /// Folder of figure and tables. Default: that of the results.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs `factotum experiment run bootstrap-sim`.
pub(super) fn run(args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    if args.seeds == 0 {
        return Err(usage("--seeds is 0, expected at least 1"));
    }
    for task in &args.tasks {
        assets::task(task.as_ref())?;
    }
    let study = Study {
        program: std::env::current_exe()?,
        tasks: args.tasks.clone(),
        seeds: (0..args.seeds)
            .map(|i| args.seed.saturating_add(i))
            .collect(),
        epochs: args.epochs,
        arguments: [
            "--model-error-mm".to_owned(),
            args.model_error_mm.to_string(),
            "--model-error-deg".to_owned(),
            args.model_error_deg.to_string(),
        ]
        .into(),
        n_workers: args.workers,
        folder: args.out.clone(),
    };
    let stop = stop_on_interrupt()?;
    let tell = |result: &TrialResult, progress: Progress| {
        let word = match (&result.failure, result.epochs.first(), result.epochs.last()) {
            (None, Some(first), Some(last)) => format!(
                "return {:.0} to {:.0}, object {:.3} to {:.3}",
                first.total_reward, last.total_reward, first.object_state, last.object_state
            ),
            _ => "failed".to_owned(),
        };
        console.say(format_args!(
            "{}: {word}; {} of {}; {} left",
            result.key(),
            progress.n_done,
            progress.n_runs,
            duration_words(progress.secs_left)
        ));
    };
    let results = study.run(&stop, tell).map_err(of_input)?;
    let n_failed = results.iter().filter(|result| !result.is_success()).count();
    let n_trials = study.trials().len();
    let is_complete = results.len() == n_trials;
    let file = args.out.join(RESULTS_NAME);
    let document = json!({
        "complete": is_complete,
        "n_trials": n_trials,
        "n_done": results.len(),
        "n_failed": n_failed,
        "results": file,
    });
    console.answer(&document, || {
        let hint = if is_complete {
            let out = args.out.display();
            format!("figure and table: factotum experiment report bootstrap-sim --from {out}")
        } else {
            "stopped; the same command goes on".to_owned()
        };
        format!(
            "{} of {n_trials} trials done, {n_failed} of them failed; results: `{}`\n{hint}",
            results.len(),
            file.display()
        )
    })?;
    Ok(Answer::from(is_complete && n_failed == 0))
}

/// Runs `factotum experiment report bootstrap-sim`.
pub(super) fn report(args: &ReportArgs, console: &Console) -> anyhow::Result<Answer> {
    let out = args.out.as_ref().unwrap_or(&args.from);
    let (table, files) = study_report(&args.from, out).map_err(of_input)?;
    console.answer(&json!({"files": files, "table": table}), || {
        table.to_markdown()
    })?;
    Ok(Answer::Yes)
}

/// Bad input ends with another exit code than a fault of ours.
fn of_input(error: StudyError) -> anyhow::Error {
    if error.is_of_input() {
        usage(error)
    } else {
        error.into()
    }
}
