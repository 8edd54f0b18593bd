//! `factotum run`: the main job.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use factotum_agent::{AgentError, Executive, RunReport};
use factotum_experiments::run_folder::{Manifest, REPORT_NAME, RunFolder, RunFolderError};
use factotum_experiments::utc::UtcTime;
use factotum_geometry::grid::map_overlap;
use factotum_protocol::{self as wire, ServerMessage};
use factotum_semantic_map::{Aosm, ChoreGoal, home_folder};
use factotum_worlds::{Fault, FaultSwitch, HomeScene};

use crate::audience::Audience;
use crate::console::{Answer, Console, now, usage};
use crate::plan::{PlannerName, planner};
use crate::result::{ChoreResult, Known, RunResult, peak_rss_mb};
use crate::session::{Ended, MAP_RESOLUTION_M, Session, WorldArgs};
use crate::watch::StopFlag;

/// Where run folders go if no other place is given.
const RUNS_DIR: &str = "runs";
/// Name of the result in a run folder: the document that `--json` prints.
const RESULT_NAME: &str = "result.json";
/// Name of the home folder in a run folder.
const HOME_NAME: &str = "home";

/// Arguments of `factotum run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    world: WorldArgs,
    /// Chore to do; every chore of the scene if absent.
    #[arg(long)]
    goal: Option<String>,
    /// Something that goes wrong.
    #[arg(long, value_enum)]
    fault: Option<FaultName>,
    /// Task planner.
    #[arg(long, value_enum, default_value_t)]
    planner: PlannerName,
    /// Run folder to make: the home as it was mapped, a report, a recording, the result. Default:
    /// `runs/<UTC date>-<scene>-<seed>`.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Keep nothing but the answer.
    #[arg(long, conflicts_with = "out")]
    no_folder: bool,
}

/// What may go wrong on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FaultName {
    /// The object is moved after it was mapped.
    MovedObject,
    /// A new obstacle stands in the way.
    BlockedPath,
    /// The grasp slips once.
    GraspSlip,
}

impl From<FaultName> for Fault {
    fn from(name: FaultName) -> Self {
        match name {
            FaultName::MovedObject => Self::MovedObject,
            FaultName::BlockedPath => Self::BlockedPath,
            FaultName::GraspSlip => Self::GraspSlip,
        }
    }
}

/// What the executive did, and what ended it before its time.
struct Work {
    reports: Vec<RunReport>,
    explore_secs: f64,
    failed: Option<AgentError>,
}

/// Runs `factotum run`.
pub(crate) fn run(args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    let clock = Instant::now();
    let started = now();
    console.progress("loading models");
    let models = args.world.load()?;
    let chores = chores_of(&models.0, args.goal.as_deref())?;
    let planner = planner(args.planner)?;
    let mut folder = if args.no_folder {
        None
    } else {
        Some(make_folder(args, models.0.name(), started)?)
    };
    let fault = args.fault.map(Fault::from);
    let mut session = Session::begin(
        &args.world,
        models,
        fault,
        folder.as_ref().map(RunFolder::path),
        started,
        console,
    )?;

    let faults = session.sim.fault_switch();
    let aosm = session.empty_map()?;
    let mut work = Work {
        reports: Vec::new(),
        explore_secs: 0.0,
        failed: None,
    };
    let home = HomeKeeper {
        dir: folder.as_ref().map(|folder| folder.file(HOME_NAME)),
        name: session.sim.scene().name().to_owned(),
        audience: session.audience.clone(),
    };
    let ended = session.execute(aosm, planner.as_ref(), |executive| {
        if let Err(error) = do_chores(executive, &chores, &faults, &home, &mut work) {
            work.failed = Some(error);
        }
        home.keep(executive.aosm());
    })?;
    let is_stopped = session.stop.is_raised();
    let result = judge(&session, args, &chores, &mut work, clock, &ended)?;

    let activity = if is_stopped {
        wire::Activity::Stopped
    } else {
        wire::Activity::Finished
    };
    session.audience.set_activity(activity);
    session.audience.tell(ServerMessage::Done(wire::Done {
        achieved: result.is_achieved(),
        summary: result.summary(),
    }));
    session.audience.finish_recording();
    let fault_of_ours = work.failed.filter(|_| !is_stopped);
    let exit_code = match (&fault_of_ours, result.is_achieved()) {
        (Some(_), _) => 3,
        (None, true) => 0,
        (None, false) => 1,
    };
    if let Some(folder) = &mut folder {
        keep_result(folder, &result, &session.audience, args, exit_code);
    }

    console.answer(&result.document(), || result.text())?;
    if let Some(folder) = &folder {
        console.say(format_args!("run folder: {}", folder.path().display()));
    }
    let troubles = session.audience.take_troubles();
    for trouble in &troubles {
        console.error(trouble);
    }
    if fault_of_ours.is_none() {
        session.linger();
    }
    match (fault_of_ours, troubles.is_empty()) {
        (Some(error), _) => Err(error.into()),
        (None, false) => Err(anyhow::anyhow!("the run folder is not whole")),
        (None, true) => Ok(Answer::from(result.is_achieved())),
    }
}

/// The chore of that name, or all.
fn chores_of(scene: &HomeScene, goal: Option<&str>) -> anyhow::Result<Vec<(String, ChoreGoal)>> {
    let chores = match goal {
        Some(name) => vec![scene.chore(name).map_err(usage)?],
        None => scene.chores().iter().collect(),
    };
    chores
        .into_iter()
        .map(|chore| {
            let goal = scene
                .classes()
                .get(&chore.class)
                .map(|class| ChoreGoal::of_action(class, &chore.action));
            match goal {
                Some(Ok(goal)) => Ok((chore.name.clone(), goal)),
                Some(Err(error)) => Err(usage(format!("chore `{}`: {error}", chore.name))),
                None => Err(usage(format!(
                    "chore `{}`: no class `{}` in this scene",
                    chore.name, chore.class
                ))),
            }
        })
        .collect()
}

fn make_folder(args: &RunArgs, scene: &str, started: UtcTime) -> anyhow::Result<RunFolder> {
    let program = concat!("factotum ", env!("CARGO_PKG_VERSION"));
    let command = std::env::args().collect();
    let manifest = Manifest::begin(program, command, scene, args.world.seed, started);
    let made: Result<RunFolder, RunFolderError> = match &args.out {
        Some(path) => RunFolder::create_at(path, manifest),
        None => RunFolder::create_in(Path::new(RUNS_DIR), started, manifest),
    };
    made.map_err(|error| usage(format!("{:#}", anyhow::Error::from(error))))
}

/// Writes the home folder whenever much has been learned, so that a crash leaves what was known.
struct HomeKeeper {
    dir: Option<PathBuf>,
    name: String,
    audience: Audience,
}

impl HomeKeeper {
    fn keep(&self, aosm: &Aosm) {
        if let Some(dir) = &self.dir
            && let Err(error) = home_folder::write(dir, &self.name, aosm)
        {
            self.audience.add_trouble(error.into());
        }
    }
}

/// Explores, then does one chore after the other; what is learned in one serves the next.
fn do_chores(
    executive: &mut Executive<'_>,
    chores: &[(String, ChoreGoal)],
    faults: &FaultSwitch,
    home: &HomeKeeper,
    work: &mut Work,
) -> Result<(), AgentError> {
    let audience = &home.audience;
    audience.set_goal("know the home");
    audience.set_activity(wire::Activity::Exploring);
    let explored = executive.explore(&mut |_| false);
    work.explore_secs = audience.time_secs();
    explored?;
    home.keep(executive.aosm());
    // What goes wrong on request goes wrong after mapping.
    faults.arm();
    for (name, goal) in chores {
        audience.set_goal(&name.replace('-', " "));
        audience.set_activity(wire::Activity::Planning);
        work.reports.push(executive.do_chore(goal)?);
    }
    Ok(())
}

/// What physics says came of it. Chores that were not begun are not achieved by the robot, and say why.
fn judge(
    session: &Session<'_>,
    args: &RunArgs,
    chores: &[(String, ChoreGoal)],
    work: &mut Work,
    clock: Instant,
    ended: &Ended,
) -> anyhow::Result<RunResult> {
    let why = |stop: &StopFlag| match &work.failed {
        _ if stop.is_raised() => "stopped on request".to_owned(),
        Some(error) => error.to_string(),
        None => "not begun".to_owned(),
    };
    let unfinished = RunReport {
        reason: Some(why(&session.stop)),
        ..RunReport::default()
    };
    work.reports.resize(chores.len(), unfinished);
    let judge = session.sim.judge();
    let results = chores
        .iter()
        .zip(work.reports.drain(..))
        .map(|((name, _), report)| {
            let verdict = judge.achieved(name)?;
            Ok(ChoreResult {
                goal: name.clone(),
                report,
                achieved: verdict.achieved,
                measured: verdict.measured,
            })
        })
        .collect::<anyhow::Result<Vec<_>>>()?;
    let truth = session.sim.true_grid(MAP_RESOLUTION_M)?;
    let overlap = map_overlap(
        &ended.aosm.grid,
        &truth,
        &session.world_from_map(),
        2.0 * MAP_RESOLUTION_M,
    );
    Ok(RunResult {
        is_single: args.goal.is_some(),
        chores: results,
        known: Known {
            classes: ended.aosm.classes.len(),
            objects: ended.aosm.objects.len(),
            nodes: ended.n_nodes,
            edges: ended.n_edges,
        },
        map_iou: overlap.free_iou,
        explore_secs: work.explore_secs,
        sim_secs: session.audience.time_secs(),
        wall_secs: clock.elapsed().as_secs_f64(),
        peak_rss_mb: peak_rss_mb(),
        fault: session.sim.fault_happened().map(str::to_owned),
    })
}

/// Writes the report, the result and the end of the manifest; what cannot be written is a trouble of the audience.
fn keep_result(
    folder: &mut RunFolder,
    result: &RunResult,
    audience: &Audience,
    args: &RunArgs,
    exit_code: u8,
) {
    let report = result.report(
        audience.told(),
        folder.manifest(),
        args.world.robot.as_path(),
    );
    let written = [
        folder
            .write_json(RESULT_NAME, &result.document())
            .map_err(anyhow::Error::from),
        report
            .to_html()
            .map_err(anyhow::Error::from)
            .and_then(|html| Ok(folder.write(REPORT_NAME, html.as_bytes())?)),
        folder.finish(now(), exit_code).map_err(anyhow::Error::from),
    ];
    for error in written.into_iter().filter_map(Result::err) {
        audience.add_trouble(error);
    }
}
