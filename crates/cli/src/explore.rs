//! `factotum map explore`: a home folder from nothing but a robot's own senses, on its own or driven by hand.

use std::cell::RefCell;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use factotum_protocol as wire;
use factotum_semantic_map::Home;
use factotum_task_planning::planner::Ferroplan;
use serde_json::json;

use crate::console::{Answer, Console, now, usage};
use crate::keeper::Keeper;
use crate::session::{Session, Start, WorldArgs, empty_map};

/// Arguments of `factotum map explore`.
#[derive(Debug, Args)]
pub(crate) struct ExploreArgs {
    #[command(flatten)]
    world: WorldArgs,
    /// Drive the robot yourself, from the page: it maps what it passes. In real time, unless --speed says otherwise.
    #[arg(long)]
    drive: bool,
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
    if args.drive && args.world.headless {
        return Err(usage(
            "--drive is done by hand from the page, and with --headless there is none; leave one of them out",
        ));
    }
    console.progress("loading models");
    let models = args.world.load()?;
    let world = if args.drive {
        args.world.at_real_time()
    } else {
        args.world.clone()
    };
    let name = models.0.name().to_owned();
    let aosm = empty_map(&models.0)?;
    let mut session = Session::begin(&world, models, None, None, None, started, console)?;
    session.audience.set_goal("know the home");
    session.audience.set_activity(wire::Activity::Exploring);
    session.audience.set_takes_driving(args.drive);
    let mut hand = session.hand.clone();
    let home = Home::create(&args.out, &name, &aosm, started.unix_secs() as f64)?;
    let keeper = RefCell::new(Keeper::new(Some(home), None, None, Instant::now()));
    let planner = Ferroplan::default();
    let ended = session.execute(aosm, &Start::AtOrigin, &planner, &keeper, |executive| {
        if args.drive {
            executive.drive_by_hand(&mut hand)
        } else {
            executive.explore(&mut |_| false)
        }
    });
    let is_stopped = session.stop.is_raised();
    session.audience.set_takes_driving(false);
    session.audience.set_activity(wire::Activity::Finished);
    let grid = &ended.aosm.grid;
    let objects: Vec<&String> = ended.aosm.objects.keys().collect();
    let document = json!({
        "home": name, "complete": !is_stopped && ended.failed.is_none(), "objects": objects,
        "width": grid.width(), "height": grid.height(), "sim_secs": session.audience.time_secs(),
    });
    console.answer(&document, || {
        let how = match (is_stopped, args.drive) {
            (true, _) => "stopped early",
            (false, true) => "driven through",
            (false, false) => "explored",
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
    let trouble = session.audience.take_troubles().into_iter().next();
    match (ended.failed, trouble) {
        (Some(error), _) if !is_stopped => Err(error.into()),
        (_, Some(trouble)) => Err(trouble),
        _ => Ok(Answer::from(!is_stopped)),
    }
}
