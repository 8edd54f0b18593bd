//! `factotum plan`: task planning alone.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use clap::{Args, ValueEnum};
use factotum_task_planning::pddl::{parse_domain, parse_problem};
use factotum_task_planning::planner::{FastDownward, Ferroplan, Limits, PlanOutcome, Planner};
use serde_json::json;

use crate::console::{Answer, Console, usage};

/// Arguments of `factotum plan`.
#[derive(Debug, Args)]
pub(crate) struct PlanArgs {
    /// PDDL domain.
    domain: PathBuf,
    /// PDDL problem.
    problem: PathBuf,
    /// Planner.
    #[arg(long, value_enum, default_value_t)]
    planner: PlannerName,
    /// Time limit, seconds.
    #[arg(long, default_value_t = 30.0)]
    time_limit: f64,
}

/// The planners there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum PlannerName {
    /// Built in.
    #[default]
    Ferroplan,
    /// An external process, found on PATH or in the wheel `up-fast-downward`.
    FastDownward,
}

/// The planner of that name.
pub(crate) fn planner(name: PlannerName) -> anyhow::Result<Box<dyn Planner>> {
    Ok(match name {
        PlannerName::Ferroplan => Box::new(Ferroplan::default()),
        PlannerName::FastDownward => {
            Box::new(FastDownward::discover(&fast_downward_places()).map_err(usage)?)
        }
    })
}

/// Where Fast Downward may be: where the user says and nowhere else, or on PATH, and where `cargo x setup` puts it.
pub(crate) fn fast_downward_places() -> Vec<PathBuf> {
    if let Some(place) = std::env::var_os("FAST_DOWNWARD") {
        return vec![PathBuf::from(place)];
    }
    let mut places: Vec<PathBuf> = Vec::new();
    if let Some(path) = std::env::var_os("PATH") {
        places.extend(std::env::split_paths(&path));
    }
    if let Ok(program) = std::env::current_exe() {
        places.extend(
            program
                .ancestors()
                .skip(1)
                .take(4)
                .map(|dir| dir.join(".deps/fast-downward")),
        );
    }
    places
}

/// Runs `factotum plan`.
pub(crate) fn plan(args: &PlanArgs, console: &Console) -> anyhow::Result<Answer> {
    if !(args.time_limit > 0.0 && args.time_limit.is_finite()) {
        return Err(usage(format!(
            "--time-limit is {}, expected a positive number of seconds",
            args.time_limit
        )));
    }
    let domain = parse_domain(&read(&args.domain)?)
        .map_err(|error| usage(format!("{}:{error}", args.domain.display())))?;
    let problem = parse_problem(&read(&args.problem)?, &domain)
        .map_err(|error| usage(format!("{}:{error}", args.problem.display())))?;
    let planner = planner(args.planner)?;
    console.progress(format!("planning with {}", planner.name()));
    let limits = Limits {
        time: Duration::from_secs_f64(args.time_limit),
        ..Limits::default()
    };
    let started = Instant::now();
    let outcome = planner
        .solve(&domain, &problem, &limits)
        .context("planning failed")?;
    let wall_secs = started.elapsed().as_secs_f64();
    let (word, reason) = match &outcome {
        PlanOutcome::Solved { .. } => ("solved", String::new()),
        PlanOutcome::Unsolvable { reason } => ("unsolvable", reason.clone()),
        PlanOutcome::Exhausted { reason } => ("exhausted", reason.clone()),
        PlanOutcome::LimitReached { limit } => {
            ("limit_reached", format!("{limit:?}").to_lowercase())
        }
    };
    let steps = outcome.plan().map(|plan| {
        plan.steps
            .iter()
            .map(|step| json!({"action": step.name, "args": step.args}))
            .collect::<Vec<_>>()
    });
    let document = json!({
        "outcome": word, "planner": planner.name(), "plan": steps, "cost": outcome.plan().map(|plan| plan.cost),
        "reason": reason, "wall_secs": wall_secs,
    });
    console.answer(&document, || match outcome.plan() {
        Some(plan) => {
            let steps: Vec<String> = plan.steps.iter().map(ToString::to_string).collect();
            format!(
                "{}\n; cost {} ({} in {wall_secs:.3} s)",
                steps.join("\n"),
                plan.cost,
                planner.name()
            )
        }
        None => format!("no plan: {} {reason}", word.replace('_', " ")),
    })?;
    Ok(Answer::from(outcome.plan().is_some()))
}

fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path)
        .map_err(|error| usage(format!("cannot read `{}`: {error}", path.display())))
}
