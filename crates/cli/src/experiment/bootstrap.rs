//! `factotum experiment run|report bootstrap-sim|bootstrap-noise|bootstrap-matrix`: motor skills learned in several ways
//! (thesis Chapter 4).

use std::path::PathBuf;

use clap::Args;
use factotum_experiments::motor::{
    Comparison, Study, StudyError, TrialResult, Variant, study_report,
};
use factotum_experiments::sweep::{Outcome as _, Progress, RESULTS_NAME};
use serde_json::json;

use super::cells::at_least_one;
use super::{duration_words, stop_on_interrupt};
use crate::assets;
use crate::console::{Answer, Console, usage};

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Question {
    /// What a plan to begin with is worth (thesis Fig. 4.5).
    Sim,
    /// What a wrong model of the object costs.
    Noise,
    /// Whether it hangs on the form of the policy and on the search.
    Matrix,
}

impl Question {
    /// Name of the experiment.
    fn name(self) -> &'static str {
        match self {
            Self::Sim => "bootstrap-sim",
            Self::Noise => "bootstrap-noise",
            Self::Matrix => "bootstrap-matrix",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Sim => "Motor skills: what a plan to begin with is worth",
            Self::Noise => "Motor skills: what a wrong model of the object costs a plan",
            Self::Matrix => "Motor skills: forms of policy and searches, with and without a plan",
        }
    }

    /// What is compared: name, words for the legend, arguments. The others are compared with the first.
    fn rows(self) -> &'static [(&'static str, &'static str, &'static str)] {
        match self {
            Self::Sim => &[
                ("random", "random weights", "--init random"),
                ("plan", "from a plan", "--init plan"),
            ],
            Self::Noise => &[
                ("exact", "true model", "--init plan"),
                (
                    "10mm-2.5deg",
                    "10 mm and 2.5° off",
                    "--init plan --model-error-mm 10 --model-error-deg 2.5",
                ),
                (
                    "20mm-5deg",
                    "20 mm and 5° off",
                    "--init plan --model-error-mm 20 --model-error-deg 5",
                ),
                (
                    "40mm-10deg",
                    "40 mm and 10° off",
                    "--init plan --model-error-mm 40 --model-error-deg 10",
                ),
                (
                    "80mm-20deg",
                    "80 mm and 20° off",
                    "--init plan --model-error-mm 80 --model-error-deg 20",
                ),
            ],
            Self::Matrix => &[
                (
                    "random-dmp-pi2cma",
                    "random primitive, PI²-CMA",
                    "--init random --policy dmp --search pi2cma",
                ),
                (
                    "plan-dmp-pi2cma",
                    "planned primitive, PI²-CMA",
                    "--init plan --policy dmp --search pi2cma",
                ),
                (
                    "random-mlp-npg",
                    "random network, NPG",
                    "--init random --policy mlp --search npg",
                ),
                (
                    "plan-mlp-npg",
                    "cloned network, NPG",
                    "--init plan --policy mlp --search npg",
                ),
                (
                    "plan-mlp-dapg",
                    "cloned network, DAPG",
                    "--init plan --policy mlp --search dapg",
                ),
            ],
        }
    }

    fn variants(self) -> Vec<Variant> {
        /// So that a network of `bootstrap-matrix`, with 20 rollouts an epoch, has as many as a primitive.
        const NETWORK_EPOCHS: u64 = 20;
        let rows = self.rows().iter();
        rows.map(|(name, _, arguments)| Variant {
            name: (*name).to_owned(),
            arguments: arguments.split(' ').map(str::to_owned).collect(),
            epochs: arguments.contains("mlp").then_some(NETWORK_EPOCHS),
        })
        .collect()
    }

    fn comparison(self) -> Comparison {
        let rows = self.rows();
        let words = rows
            .iter()
            .map(|(name, words, _)| ((*name).to_owned(), (*words).to_owned()));
        Comparison {
            title: self.title().to_owned(),
            variants: words.collect(),
            baseline: rows[0].0.to_owned(),
        }
    }
}

/// Arguments of `factotum experiment run bootstrap-sim`.
#[derive(Debug, Args)]
pub(crate) struct SimArgs {
    #[command(flatten)]
    run: RunArgs,
    /// Standard deviation of the error of the object's position and of its joint's origin, for the plan.
    #[arg(long, value_name = "MM", default_value_t = 0.0)]
    model_error_mm: f64,
    /// Standard deviation of the error of its joint's axis, for the plan.
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    model_error_deg: f64,
}

/// Arguments of `factotum experiment run bootstrap-noise` and `bootstrap-matrix`.
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
    /// Seeds of each task and way of learning.
    #[arg(long, value_name = "N", default_value_t = 20)]
    seeds: u64,
    /// The first of them.
    #[arg(long, value_name = "BASE", default_value_t = 200)]
    seed: u64,
    /// Updates of the policy. Default: 40 for primitives, 20 for the networks of bootstrap-matrix.
    #[arg(long, value_name = "N")]
    epochs: Option<u64>,
    /// Runs at a time.
    #[arg(long, default_value_t = 1)]
    workers: usize,
    /// Folder of the results. Default: that of the experiment in `runs`.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Arguments of `factotum experiment report bootstrap-sim`, `bootstrap-noise` and `bootstrap-matrix`.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Folder of the results. Default: that of the experiment in `experiments`.
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// Folder of figure and tables. Default: that of the results.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs `factotum experiment run bootstrap-sim`.
pub(super) fn run_sim(args: &SimArgs, console: &Console) -> anyhow::Result<Answer> {
    let error = [
        ("--model-error-mm", args.model_error_mm),
        ("--model-error-deg", args.model_error_deg),
    ]
    .map(|(name, value)| [name.to_owned(), value.to_string()]);
    run_with(Question::Sim, &args.run, error.concat(), console)
}

/// Runs `factotum experiment run` for a question.
pub(super) fn run(question: Question, args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    run_with(question, args, Vec::new(), console)
}

fn run_with(
    question: Question,
    args: &RunArgs,
    arguments: Vec<String>,
    console: &Console,
) -> anyhow::Result<Answer> {
    at_least_one("--seeds", args.seeds)?;
    for task in &args.tasks {
        assets::task(task.as_ref())?;
    }
    let name = question.name();
    let usual = || PathBuf::from("runs").join(name);
    let out = args.out.clone().unwrap_or_else(usual);
    let study = Study {
        name: name.to_owned(),
        program: std::env::current_exe()?,
        tasks: args.tasks.clone(),
        variants: question.variants(),
        seeds: (0..args.seeds)
            .map(|i| args.seed.saturating_add(i))
            .collect(),
        epochs: args.epochs,
        arguments,
        n_workers: args.workers,
        folder: out.clone(),
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
    let file = out.join(RESULTS_NAME);
    let document = json!({
        "complete": is_complete,
        "n_trials": n_trials,
        "n_done": results.len(),
        "n_failed": n_failed,
        "results": file,
    });
    console.answer(&document, || {
        let hint = if is_complete {
            let out = out.display();
            format!("figure and table: factotum experiment report {name} --from {out}")
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

/// Runs `factotum experiment report` for a question.
pub(super) fn report(
    question: Question,
    args: &ReportArgs,
    console: &Console,
) -> anyhow::Result<Answer> {
    let committed = || PathBuf::from("experiments").join(question.name());
    let from = args.from.clone().unwrap_or_else(committed);
    let out = args.out.as_ref().unwrap_or(&from);
    let (table, files) = study_report(&from, out, &question.comparison()).map_err(of_input)?;
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
