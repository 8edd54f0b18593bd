//! `factotum experiment run chores`: how often physics says that the chores are achieved.

use std::path::PathBuf;

use clap::{Args, ValueEnum as _};
use serde_json::json;

use super::seeds::Seeds;
use super::stop_on_interrupt;
use crate::console::{Answer, Console};
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
    let fault = args.fault.and_then(|fault| fault.to_possible_value());
    let fault = fault.as_ref().map(|fault| fault.get_name().to_owned());
    let folder = args.out.clone().unwrap_or_else(|| {
        let words = [Some("chores"), args.goal.as_deref(), fault.as_deref()];
        PathBuf::from("runs").join(words.into_iter().flatten().collect::<Vec<_>>().join("-"))
    });
    let seeds = Seeds {
        arguments: run_arguments(args, fault),
        n: args.seeds,
        n_workers: args.workers,
        folder,
    };
    let swept = seeds.run(&*stop_on_interrupt()?, console)?;
    let document = match &swept.summary {
        Some(summary) => json!({"complete": swept.is_complete, "summary": summary}),
        None => json!({"complete": false, "n_runs": 0}),
    };
    console.answer(&document, || seeds.describe(&swept))?;
    Ok(Answer::from(swept.is_success()))
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
