//! `factotum map explore`: a home folder from nothing but a robot's own senses.

use std::path::PathBuf;

use clap::Args;
use factotum_agent::AgentError;
use factotum_protocol as wire;
use factotum_semantic_map::home_folder;
use factotum_task_planning::planner::Ferroplan;
use serde_json::json;

use crate::console::{Answer, Console, now, usage};
use crate::session::{Session, WorldArgs};

/// Arguments of `factotum map explore`.
#[derive(Debug, Args)]
pub(crate) struct ExploreArgs {
    #[command(flatten)]
    world: WorldArgs,
    /// Home folder to make.
    #[arg(long)]
    out: PathBuf,
}

/// Runs `factotum map explore`. Stopped early, it keeps what it has found and says so.
pub(crate) fn explore(args: &ExploreArgs, console: &Console) -> anyhow::Result<Answer> {
    let started = now();
    if args.out.join("home.toml").exists() {
        return Err(usage(format!(
            "`{}` is a home folder already; nothing was written",
            args.out.display()
        )));
    }
    console.progress("loading models");
    let models = args.world.load()?;
    let mut session = Session::begin(&args.world, models, None, None, started, console)?;
    session.audience.set_goal("know the home");
    session.audience.set_activity(wire::Activity::Exploring);
    let mut explored: Result<(), AgentError> = Ok(());
    let aosm = session.empty_map()?;
    let planner = Ferroplan::default();
    let ended = session.execute(aosm, &planner, |executive| {
        explored = executive.explore(&mut |_| false);
    })?;
    let is_stopped = session.stop.is_raised();
    let name = session.sim.scene().name().to_owned();
    home_folder::write(&args.out, &name, &ended.aosm)?;
    session.audience.set_activity(wire::Activity::Finished);
    let grid = &ended.aosm.grid;
    let objects: Vec<&String> = ended.aosm.objects.keys().collect();
    let document = json!({
        "home": name, "complete": !is_stopped && explored.is_ok(), "objects": objects,
        "width": grid.width(), "height": grid.height(), "sim_secs": session.audience.time_secs(),
    });
    console.answer(&document, || {
        let how = if is_stopped {
            "stopped early"
        } else {
            "explored"
        };
        format!(
            "{name}: {how}; {} x {} cells and {} objects in `{}`",
            grid.width(),
            grid.height(),
            objects.len(),
            args.out.display()
        )
    })?;
    session.linger();
    match explored {
        Err(error) if !is_stopped => Err(error.into()),
        _ => Ok(Answer::from(!is_stopped)),
    }
}
