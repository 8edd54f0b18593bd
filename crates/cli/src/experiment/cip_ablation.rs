//! `factotum experiment run|report cip-ablation`: what each part of a contact skill is worth (thesis Fig. 3.2).

use std::path::PathBuf;

use clap::Args;
use factotum_experiments::grid::{self, CellResult, Grid};
use factotum_experiments::sweep::{Progress, RESULTS_NAME};
use factotum_skills::cip::setting::Ablation;
use serde_json::json;

use super::cells::{CellArgs, ablations, at_least_one, of_input};
use super::{duration_words, stop_on_interrupt};
use crate::console::{Answer, Console};
use crate::skill::AblationName;

/// Where the results of the project are.
const COMMITTED: &str = "experiments/cip-ablation";

/// Arguments of `factotum experiment run cip-ablation`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    cells: CellArgs,
    /// Settings. Default: all.
    #[arg(long, value_name = "SETTING,...", value_enum, value_delimiter = ',')]
    settings: Vec<AblationName>,
    /// Training episodes.
    #[arg(long, value_name = "N", default_value_t = 100)]
    episodes: u64,
    /// Keep the checkpoint of a run that is done, to train it for longer.
    #[arg(long)]
    keep_checkpoints: bool,
    /// Folder of the results, and of the skills in `cells/`.
    #[arg(long, value_name = "DIR", default_value = "runs/cip-ablation")]
    out: PathBuf,
}

/// Arguments of `factotum experiment report cip-ablation`.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = COMMITTED)]
    from: PathBuf,
    /// Folder of the figures and tables. Default: that of the results.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs `factotum experiment run cip-ablation`.
pub(super) fn run(args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    let grid = grid_of(args)?;
    let stop = stop_on_interrupt()?;
    let n_cells = grid.n_cells();
    let tell = |result: &CellResult, progress: Progress| {
        console.say(format_args!(
            "{}: {} in {}; {} of {}, {} failed; {} left",
            result.cell(),
            success_words(result),
            duration_words(result.wall_secs),
            progress.n_done,
            progress.n_runs,
            progress.n_done - progress.n_successes,
            duration_words(progress.secs_left)
        ));
    };
    let results = grid.run(&stop, tell).map_err(of_input)?;
    let n_failed = results
        .iter()
        .filter(|result| result.failure.is_some())
        .count();
    let is_complete = results.len() == n_cells;
    let file = args.out.join(RESULTS_NAME);
    let document = json!({
        "complete": is_complete,
        "n_cells": n_cells,
        "n_done": results.len(),
        "n_failed": n_failed,
        "results": file,
    });
    console.answer(&document, || {
        let out = args.out.display();
        let mut lines = vec![format!(
            "{} of {n_cells} cells done, {n_failed} of them failed; results: `{}`",
            results.len(),
            file.display()
        )];
        if !is_complete {
            lines.push("stopped; the same command goes on".to_owned());
        }
        let hint = (!results.is_empty())
            .then(|| format!("draw them: factotum experiment report cip-ablation --from {out}"));
        lines.extend(hint);
        lines.join("\n")
    })?;
    Ok(Answer::from(is_complete && n_failed == 0))
}

/// Runs `factotum experiment report cip-ablation`.
pub(super) fn report(args: &ReportArgs, console: &Console) -> anyhow::Result<Answer> {
    let out = args.out.as_ref().unwrap_or(&args.from);
    let report = grid::report(&args.from, out).map_err(of_input)?;
    let document = json!({"files": report.files, "table": report.table});
    console.answer(&document, || {
        let files: Vec<String> = report
            .files
            .iter()
            .map(|file| format!("`{}`", file.display()))
            .collect();
        format!(
            "{}\nwritten: {}",
            report.table.to_markdown(),
            files.join(", ")
        )
    })?;
    Ok(Answer::Yes)
}

fn grid_of(args: &RunArgs) -> anyhow::Result<Grid> {
    at_least_one("--episodes", args.episodes)?;
    let seeds = args.cells.checked_seeds()?;
    Ok(Grid {
        program: std::env::current_exe()?,
        leading: Vec::new(),
        tasks: args.cells.tasks.clone(),
        ablations: ablations(&args.settings, &Ablation::ALL),
        seeds,
        episodes: args.episodes,
        rollouts: args.cells.rollouts,
        n_workers: args.cells.n_workers(),
        keep_checkpoints: args.keep_checkpoints,
        folder: args.out.clone(),
    })
}

fn success_words(result: &CellResult) -> String {
    match (&result.failure, &result.last) {
        (Some(failure), _) => format!("`{}` failed", failure.command),
        (None, Some(last)) => format!("success {:.0} %", 100.0 * last.success_rate),
        (None, None) => "no judgement".to_owned(),
    }
}
