//! `factotum run`: the main job.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use factotum_agent::{AgentError, Executive, RunReport};
use factotum_experiments::run_folder::{Manifest, REPORT_NAME, RunFolder, RunFolderError};
use factotum_experiments::utc::UtcTime;
use factotum_geometry::grid::map_overlap;
use factotum_protocol::{self as wire, ServerMessage};
use factotum_semantic_map::{Aosm, ChoreGoal, Home};
use factotum_worlds::{Fault, FaultSwitch, HomeScene};

use crate::audience::Audience;
use crate::console::{Answer, Console, now, usage};
use crate::keeper::Keeper;
use crate::plan::{PlannerName, planner};
use crate::result::{ChoreResult, Known, RunResult, peak_rss_mb};
use crate::resume::{self, Earlier, Resumed};
use crate::session::{Ended, MAP_RESOLUTION_M, Session, Start, WorldArgs, empty_map};
use crate::skill::learned_with;
use crate::snapshot::Snapshot;

/// Where run folders go if no other place is given.
const RUNS_DIR: &str = "runs";
/// Name of the result in a run folder: the document that `--json` prints.
pub(crate) const RESULT_NAME: &str = "result.json";
/// Name of the home folder in a run folder.
const HOME_NAME: &str = "home";

/// Arguments of `factotum run`.
#[derive(Debug, Clone, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) world: WorldArgs,
    /// Chore to do; if absent, every chore of the scene but those on request.
    #[arg(long)]
    pub(crate) goal: Option<String>,
    /// Something that goes wrong.
    #[arg(long, value_enum)]
    pub(crate) fault: Option<FaultName>,
    /// Task planner.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) planner: PlannerName,
    /// Home folder to start from, mapped on an earlier day: the robot finds where it is instead of exploring, and what
    /// it learns is kept there.
    #[arg(long, value_name = "DIR")]
    pub(crate) home: Option<PathBuf>,
    /// Learned skills to use: a folder of skill folders. Default: the shipped ones.
    #[arg(long, value_name = "DIR")]
    pub(crate) skills: Option<PathBuf>,
    /// Go on with the run of this folder, which crashed or was stopped, as it was asked for then.
    #[arg(long, value_name = "RUNDIR", conflicts_with_all = resume::GIVEN_BY_MANIFEST)]
    pub(crate) resume: Option<PathBuf>,
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

/// Runs `factotum run`.
pub(crate) fn run(args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    match &args.resume {
        None => work(args, None, console),
        Some(dir) => match resume::open(dir, args, console)? {
            Resumed::Finished(answer) => Ok(answer),
            Resumed::GoesOn(earlier) => {
                let Earlier {
                    args,
                    folder,
                    before,
                } = *earlier;
                work(&args, Some((folder, before)), console)
            }
        },
    }
}

/// Begins the run, or goes on with that of a folder from a snapshot, if there is one.
fn work(
    args: &RunArgs,
    earlier: Option<(RunFolder, Option<Snapshot>)>,
    console: &Console,
) -> anyhow::Result<Answer> {
    let clock = Instant::now();
    let started = now();
    console.progress("loading models");
    let models = args.world.load()?;
    let chores = chores_of(&models.0, args.goal.as_deref())?;
    let planner = planner(args.planner)?;
    let learned = learned_with(&models.1, args.skills.as_deref())?;
    let stored = args.home.as_deref().map(open_home).transpose()?;
    let (mut folder, before) = match earlier {
        Some((folder, before)) => (Some(folder), before),
        None if args.no_folder => (None, None),
        None => (Some(make_folder(args, models.0.name(), started)?), None),
    };
    // The home is locked before anything is written: another process may be at work on the same run.
    let (home, aosm) = take_home(stored, folder.as_ref(), before.as_ref(), &models.0, started)?;
    if let Some(folder) = folder.as_mut().filter(|_| args.resume.is_some()) {
        folder.resume()?;
    }
    let mut session = Session::begin(
        &args.world,
        models,
        args.fault.map(Fault::from),
        folder.as_ref(),
        before.as_ref(),
        started,
        console,
    )?;
    let start = match &before {
        Some(before) => Start::From(&before.checkpoint),
        None if args.home.is_some() => Start::Somewhere,
        None => Start::AtOrigin,
    };
    let snapshots = folder.as_ref().map(RunFolder::snapshots);
    let keeper = RefCell::new(Keeper::new(home, snapshots, before.as_ref(), clock));
    let faults = session.sim.borrow().fault_switch();
    let audience = session.audience.clone();
    if before.is_some() {
        let text = format!("resumed from the snapshot at {:.1} s", audience.time_secs());
        console.say(&text);
        audience.note(text);
    }
    let is_known = args.home.is_some();
    let ended = session.execute(aosm, &start, planner.as_ref(), &keeper, |executive| {
        executive.teach(learned);
        do_chores(executive, &chores, is_known, &faults, &keeper, &audience)
    });
    let is_stopped = session.stop.is_raised();
    let n_resumed = folder
        .as_ref()
        .map_or(0, |folder| folder.manifest().resumed);
    let result = judge(&session, args, &chores, &keeper.borrow(), &ended, n_resumed)?;

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
    // That the robot cannot tell where it is, is its answer.
    let fault_of_ours = ended
        .failed
        .filter(|error| !is_stopped && !matches!(error, AgentError::NotInMap { .. }));
    let exit_code = match (&fault_of_ours, result.is_achieved()) {
        (Some(_), _) => 3,
        (None, true) => 0,
        (None, false) => 1,
    };
    if let Some(folder) = &mut folder {
        keep_result(folder, &result, &session, args, exit_code);
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

/// Opens the home that an earlier day left.
fn open_home(dir: &Path) -> anyhow::Result<Home> {
    Home::open(dir, now().unix_secs() as f64).map_err(|error| {
        usage(format!(
            "{error}; `factotum map explore --out DIR` makes a home folder"
        ))
    })
}

/// The home that is kept, if any, and what is believed at the start.
fn take_home(
    stored: Option<Home>,
    folder: Option<&RunFolder>,
    before: Option<&Snapshot>,
    scene: &HomeScene,
    started: UtcTime,
) -> anyhow::Result<(Option<Home>, Aosm)> {
    let when_secs = started.unix_secs() as f64;
    let is_known = stored.is_some();
    let empty = empty_map(scene)?;
    let home = match (stored, folder) {
        (Some(home), _) => Some(home),
        (None, Some(folder)) => {
            let dir = folder.file(HOME_NAME);
            let home = resume::open_or_create_home(&dir, scene.name(), &empty, when_secs);
            Some(home.map_err(usage)?)
        }
        (None, None) => None,
    };
    let Some(mut home) = home else {
        return Ok((None, empty));
    };
    let aosm = match before {
        Some(before) => {
            home.return_to(before.home_entry, "resume", when_secs)?;
            home.aosm().clone()
        }
        None if is_known => {
            let mut aosm = home.aosm().clone();
            // What can be there is known from the scene, what is there from the home.
            for (name, class) in empty.classes {
                aosm.classes.entry(name).or_insert(class);
            }
            aosm.begin_day();
            aosm
        }
        None => empty,
    };
    Ok((Some(home), aosm))
}

/// The chore of that name, or all that are not on request.
fn chores_of(scene: &HomeScene, goal: Option<&str>) -> anyhow::Result<Vec<(String, ChoreGoal)>> {
    let chores = match goal {
        Some(name) => vec![scene.chore(name).map_err(usage)?],
        None => {
            let all = scene.chores().iter();
            all.filter(|chore| !chore.on_request).collect()
        }
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
    let manifest = Manifest {
        options: resume::options_of(args)?,
        ..Manifest::begin(program, command, scene, args.world.seed, started)
    };
    let made: Result<RunFolder, RunFolderError> = match &args.out {
        Some(path) => RunFolder::create_at(path, manifest),
        None => RunFolder::create_in(Path::new(RUNS_DIR), started, manifest),
    };
    made.map_err(|error| usage(format!("{:#}", anyhow::Error::from(error))))
}

/// Explores, unless the home is known or was explored before, then does one chore after the other; what is learned in
/// one serves the next.
fn do_chores(
    executive: &mut Executive<'_>,
    chores: &[(String, ChoreGoal)],
    is_known: bool,
    faults: &FaultSwitch,
    keeper: &RefCell<Keeper>,
    audience: &Audience,
) -> Result<(), AgentError> {
    let is_explored = keeper.borrow().progress.explore_secs.is_some();
    if !is_explored {
        if !is_known {
            audience.set_goal("know the home");
            audience.set_activity(wire::Activity::Exploring);
            executive.explore(&mut |_| false)?;
        }
        keeper.borrow_mut().progress.explore_secs = Some(audience.time_secs());
        executive.checkpoint()?;
    }
    // What goes wrong on request goes wrong after mapping.
    faults.arm();
    let n_done = keeper.borrow().progress.reports.len();
    for (name, goal) in chores.iter().skip(n_done) {
        audience.set_goal(&name.replace('-', " "));
        audience.set_activity(wire::Activity::Planning);
        let report = executive.do_chore(goal)?;
        keeper.borrow_mut().end_chore(report);
        executive.checkpoint()?;
    }
    if n_done == chores.len() {
        executive.ground_graph()?;
    }
    Ok(())
}

/// What physics says came of it. Chores that were not begun are not achieved by the robot, and say why.
fn judge(
    session: &Session<'_>,
    args: &RunArgs,
    chores: &[(String, ChoreGoal)],
    keeper: &Keeper,
    ended: &Ended,
    n_resumed: u32,
) -> anyhow::Result<RunResult> {
    let why = match &ended.failed {
        _ if session.stop.is_raised() => "stopped on request".to_owned(),
        Some(error) => error.to_string(),
        None => "not begun".to_owned(),
    };
    let unfinished = RunReport {
        reason: Some(why.clone()),
        ..RunReport::default()
    };
    let under_way = ended.under_way.clone().map(|report| RunReport {
        reason: Some(why),
        ..report
    });
    let sim = session.sim.borrow();
    let judge = sim.judge();
    let reports = keeper.progress.reports.iter();
    let results = chores
        .iter()
        .zip(
            reports
                .chain(&under_way)
                .chain(std::iter::repeat(&unfinished)),
        )
        .map(|((name, _), report)| {
            let verdict = judge.achieved(name)?;
            Ok(ChoreResult {
                goal: name.clone(),
                report: report.clone(),
                achieved: verdict.achieved,
                measured: verdict.measured,
            })
        })
        .collect::<anyhow::Result<Vec<_>>>()?;
    let truth = sim.true_grid(MAP_RESOLUTION_M)?;
    let sim_secs = session.audience.time_secs();
    let overlap = map_overlap(
        &ended.aosm.grid,
        &truth,
        &session.world_from_map,
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
        explore_secs: keeper.progress.explore_secs.unwrap_or(sim_secs),
        sim_secs,
        wall_secs: keeper.wall_secs(),
        peak_rss_mb: peak_rss_mb(),
        fault: sim.fault_happened().map(str::to_owned),
        n_resumed,
    })
}

/// Writes the report, the result and the end of the manifest; what cannot be written is a trouble of the audience.
fn keep_result(
    folder: &mut RunFolder,
    result: &RunResult,
    session: &Session<'_>,
    args: &RunArgs,
    exit_code: u8,
) {
    let audience = &session.audience;
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
        folder
            .finish(now(), exit_code, session.stop.is_raised())
            .map_err(anyhow::Error::from),
    ];
    for error in written.into_iter().filter_map(Result::err) {
        audience.add_trouble(error);
    }
}
