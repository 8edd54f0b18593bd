//! `factotum experiment`: how often something succeeds, over many seeds.

mod bootstrap;
mod cells;
mod chores;
mod cip_ablation;
mod cip_compose;
mod cip_robustness;
mod nav_symbols;
mod seeds;

use std::sync::Arc;

use clap::Subcommand;
use factotum_experiments::sweep::StopWish;
use serde_json::json;

use crate::console::{Answer, Console, tell};
use bootstrap::Question;

/// Arguments of `factotum experiment`.
#[derive(Debug, Subcommand)]
pub(crate) enum ExperimentCommand {
    /// Name the experiments there are.
    List,
    /// Run an experiment; what has a result under `--out` is not run again.
    #[command(subcommand)]
    Run(ExperimentRun),
    /// Draw the figures and tables of an experiment from its results.
    #[command(subcommand)]
    Report(ExperimentReport),
}

/// The experiments that can be run.
#[derive(Debug, Subcommand)]
pub(crate) enum ExperimentRun {
    /// `factotum skill train` from the robot's own plan and from random weights: what a plan to begin with is worth.
    BootstrapSim(bootstrap::SimArgs),
    /// `factotum skill train` from plans by ever worse models of the object.
    BootstrapNoise(bootstrap::RunArgs),
    /// `factotum skill train` with and without a plan, by other forms of policy and other searches.
    BootstrapMatrix(bootstrap::RunArgs),
    /// `factotum run --headless` a seed at a time: how often physics says that the chores are achieved.
    Chores(chores::ChoresArgs),
    /// `factotum skill train` and `eval` for each task, setting and seed: what each part of a contact skill is worth.
    CipAblation(cip_ablation::RunArgs),
    /// `factotum skill run` in either order, a seed at a time: how often skills learned apart succeed one after the other.
    CipCompose(cip_compose::ComposeArgs),
    /// `factotum skill eval` of the skills of `cip-ablation` with other resistance, and errors of object and grasp.
    CipRobustness(cip_robustness::RunArgs),
    /// Coffee again and again, in one kitchen and in ever others: how many tries it takes to learn where the base must be.
    NavSymbols(nav_symbols::RunArgs),
}

/// The experiments that have a report.
#[derive(Debug, Subcommand)]
pub(crate) enum ExperimentReport {
    /// Returns over rollouts, and a table with intervals.
    BootstrapSim(bootstrap::ReportArgs),
    /// Returns over rollouts, and a table with intervals.
    BootstrapNoise(bootstrap::ReportArgs),
    /// Returns over rollouts, and a table with intervals.
    BootstrapMatrix(bootstrap::ReportArgs),
    /// Success and joint-limit violation over training episodes, and a table with intervals.
    CipAblation(cip_ablation::ReportArgs),
    /// A table with intervals.
    CipRobustness(cip_robustness::ReportArgs),
    /// Tries over coffees made, and a table with intervals.
    NavSymbols(nav_symbols::ReportArgs),
}

/// Runs `factotum experiment`.
pub(crate) fn experiment(command: &ExperimentCommand, console: &Console) -> anyhow::Result<Answer> {
    match command {
        ExperimentCommand::List => list(console),
        ExperimentCommand::Run(run) => match run {
            ExperimentRun::BootstrapSim(args) => bootstrap::run_sim(args, console),
            ExperimentRun::BootstrapNoise(args) => bootstrap::run(Question::Noise, args, console),
            ExperimentRun::BootstrapMatrix(args) => bootstrap::run(Question::Matrix, args, console),
            ExperimentRun::Chores(args) => chores::chores(args, console),
            ExperimentRun::CipAblation(args) => cip_ablation::run(args, console),
            ExperimentRun::CipCompose(args) => cip_compose::compose(args, console),
            ExperimentRun::CipRobustness(args) => cip_robustness::run(args, console),
            ExperimentRun::NavSymbols(args) => nav_symbols::run(args, console),
        },
        ExperimentCommand::Report(report) => match report {
            ExperimentReport::BootstrapSim(args) => bootstrap::report(Question::Sim, args, console),
            ExperimentReport::BootstrapNoise(args) => {
                bootstrap::report(Question::Noise, args, console)
            }
            ExperimentReport::BootstrapMatrix(args) => {
                bootstrap::report(Question::Matrix, args, console)
            }
            ExperimentReport::CipAblation(args) => cip_ablation::report(args, console),
            ExperimentReport::CipRobustness(args) => cip_robustness::report(args, console),
            ExperimentReport::NavSymbols(args) => nav_symbols::report(args, console),
        },
    }
}

fn list(console: &Console) -> anyhow::Result<Answer> {
    const EXPERIMENTS: [(&str, &str); 8] = [
        (
            "bootstrap-matrix",
            "whether a plan helps motor skills whatever policy and search are; has a report",
        ),
        (
            "bootstrap-noise",
            "what a wrong model of the object costs a motor skill that begins with a plan; has a report",
        ),
        (
            "bootstrap-sim",
            "what a plan to begin with is worth to a motor skill, beside random weights; has a report",
        ),
        (
            "chores",
            "how often the chores are achieved, over seeds; --goal and --fault choose",
        ),
        (
            "cip-ablation",
            "how contact skills are learned with and without each of their parts; has a report",
        ),
        (
            "cip-compose",
            "how often two contact skills learned apart succeed one after the other, in either order",
        ),
        (
            "cip-robustness",
            "what the skills of cip-ablation stand: other resistance, errors of object and grasp; has a report",
        ),
        (
            "nav-symbols",
            "how many tries it takes to learn where the base must be, over kitchens; has a report",
        ),
    ];
    let document: Vec<_> = EXPERIMENTS
        .iter()
        .map(|(name, what)| json!({"name": name, "what": what}))
        .collect();
    console.answer(&document, || {
        let lines = EXPERIMENTS.map(|(name, what)| format!("{name:<18}{what}"));
        lines.join("\n")
    })?;
    Ok(Answer::Yes)
}

/// The first Ctrl-C lets the runs under way end; the second ends them too.
fn stop_on_interrupt() -> anyhow::Result<Arc<StopWish>> {
    let stop = Arc::new(StopWish::default());
    let raised = stop.clone();
    ctrlc::set_handler(move || {
        if !raised.is_raised() {
            tell(&"stopping when the runs under way have ended; Ctrl-C again ends them now");
        }
        raised.raise();
    })?;
    Ok(stop)
}

/// `2 h 05 min`, `3 min`, `40 s`.
fn duration_words(secs: f64) -> String {
    let minutes = (secs / 60.0).round() as u64;
    match minutes {
        0 | 1 => format!("{secs:.0} s"),
        2..60 => format!("{minutes} min"),
        _ => format!("{} h {:02} min", minutes / 60, minutes % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::duration_words;

    #[test]
    fn durations_are_as_long_as_people_ask_for() {
        assert_eq!(duration_words(40.2), "40 s");
        assert_eq!(duration_words(89.0), "89 s");
        assert_eq!(duration_words(181.0), "3 min");
        assert_eq!(duration_words(7_500.0), "2 h 05 min");
    }
}
