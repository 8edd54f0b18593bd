//! `factotum experiment run|report cip-robustness`: what learned contact skills stand.

use std::path::PathBuf;

use clap::Args;
use factotum_experiments::grid::Cell;
use factotum_experiments::grid::robustness::{self, Robustness, TrialResult};
use factotum_experiments::sweep::{Outcome as _, Progress, RESULTS_NAME};
use factotum_skills::cip::setting::Ablation;
use serde_json::json;

use super::cells::{CellArgs, ablations, of_input};
use super::{duration_words, stop_on_interrupt};
use crate::console::{Answer, Console};
use crate::skill::{AblationName, PolicyName};

/// Arguments of `factotum experiment run cip-robustness`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Folder of `factotum experiment run cip-ablation`, with the skills in `cells/`.
    #[arg(long, value_name = "DIR", default_value = "runs/cip-ablation")]
    skills: PathBuf,
    #[command(flatten)]
    cells: CellArgs,
    /// Settings. Default: `cip` and `fast`.
    #[arg(long, value_name = "SETTING,...", value_enum, value_delimiter = ',')]
    settings: Vec<AblationName>,
    /// Which policy of a skill: that of the best evaluation while training, or that of the last.
    #[arg(long, value_enum, default_value_t = PolicyName::Best)]
    policy: PolicyName,
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "runs/cip-robustness")]
    out: PathBuf,
}

/// Arguments of `factotum experiment report cip-robustness`.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "experiments/cip-robustness")]
    from: PathBuf,
    /// Folder of the tables. Default: that of the results.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs `factotum experiment run cip-robustness`.
pub(super) fn run(args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    let seeds = args.cells.checked_seeds()?;
    let settings = ablations(&args.settings, &[Ablation::Cip, Ablation::Fast]);
    let robustness = Robustness {
        program: std::env::current_exe()?,
        leading: Vec::new(),
        skills: args.skills.clone(),
        cells: Cell::all(&args.cells.tasks, &settings, &seeds),
        policy: args.policy.into(),
        rollouts: args.cells.rollouts,
        n_workers: args.cells.n_workers(),
        folder: args.out.clone(),
    };
    let stop = stop_on_interrupt()?;
    let tell = |result: &TrialResult, progress: Progress| {
        let word = match result.judgement {
            Some(judged) => format!("success {:.0} %", 100.0 * judged.success_rate),
            None => "failed".to_owned(),
        };
        console.say(format_args!(
            "{}: {word}; {} of {}; {} left",
            result.key(),
            progress.n_done,
            progress.n_runs,
            duration_words(progress.secs_left)
        ));
    };
    let results = robustness.run(&stop, tell).map_err(of_input)?;
    let n_failed = results.iter().filter(|result| !result.is_success()).count();
    let n_trials = robustness.n_trials();
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
            format!("their table: factotum experiment report cip-robustness --from {out}")
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

/// Runs `factotum experiment report cip-robustness`.
pub(super) fn report(args: &ReportArgs, console: &Console) -> anyhow::Result<Answer> {
    let out = args.out.as_ref().unwrap_or(&args.from);
    let (table, files) = robustness::report(&args.from, out).map_err(of_input)?;
    console.answer(&json!({"files": files, "table": table}), || {
        table.to_markdown()
    })?;
    Ok(Answer::Yes)
}
