//! `factotum run`: the main job.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::{Args, ValueEnum};
use factotum_agent::{AgentError, Executive, RunReport, Settings};
use factotum_descriptions::RobotDescription;
use factotum_geometry::Pose2;
use factotum_geometry::grid::{Cell, OccupancyGrid, map_overlap};
use factotum_protocol::{self as wire, ServerMessage};
use factotum_semantic_map::{Aosm, ChoreGoal, home_folder};
use factotum_studio::{Studio, StudioConfig, StudioHandle};
use factotum_worlds::{Fault, FaultSwitch, HomeScene, Noise, SimRobot, WorldConfig};
use serde_json::json;

use crate::assets;
use crate::console::{Answer, Console, usage};
use crate::plan::{PlannerName, planner};
use crate::watch::{FRAME_SECS, Pacer, Reporter, StopFlag, scene_of};

/// Arguments of `factotum run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Home to work in: a folder with `scene.toml`, or the name of a shipped one.
    #[arg(long, default_value = "household")]
    scene: PathBuf,
    /// Chore to do; every chore of the scene if absent.
    #[arg(long)]
    goal: Option<String>,
    /// Robot: a folder with `robot.toml`, or the name of a shipped one.
    #[arg(long, default_value = "movo")]
    robot: PathBuf,
    /// Draws object places, start pose and noise.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Do not open the page.
    #[arg(long)]
    headless: bool,
    /// Robot seconds per second: 1 is real time, 0 as fast as possible. Default: 0 headless, 2 with the page.
    #[arg(long)]
    speed: Option<f64>,
    /// Something that goes wrong.
    #[arg(long, value_enum)]
    fault: Option<FaultName>,
    /// Task planner.
    #[arg(long, value_enum, default_value_t)]
    planner: PlannerName,
    /// Run folder to write: the home as it was mapped, and the result.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// What may go wrong on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FaultName {
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

/// Edge of a cell of the map, metres.
const MAP_RESOLUTION_M: f64 = 0.05;

/// What came of one chore.
struct Done {
    goal: String,
    report: RunReport,
    achieved: bool,
    measured: String,
}

/// Runs `factotum run`.
pub(crate) fn run(args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    let started = Instant::now();
    let stop = StopFlag::default();
    let on_interrupt = stop.clone();
    ctrlc::set_handler(move || {
        if on_interrupt.is_raised() {
            std::process::exit(130);
        }
        on_interrupt.raise();
    })?;
    let speed = args.speed.unwrap_or(if args.headless { 0.0 } else { 2.0 });
    if !(speed >= 0.0 && speed.is_finite()) {
        return Err(usage(format!("--speed is {speed}, expected 0 or a positive number")));
    }

    console.progress("loading models");
    let scene = HomeScene::load(&assets::scene(&args.scene)?).map_err(usage)?;
    let robot = RobotDescription::load(&assets::robot(&args.robot)?).map_err(usage)?;
    let chores: Vec<(String, ChoreGoal)> = match &args.goal {
        Some(name) => vec![scene.chore(name).map_err(usage)?],
        None => scene.chores().iter().collect(),
    }
    .into_iter()
    .map(|chore| {
        let goal = scene.classes().get(&chore.class).map(|class| ChoreGoal::of_action(class, &chore.action));
        match goal {
            Some(Ok(goal)) => Ok((chore.name.clone(), goal)),
            Some(Err(error)) => Err(usage(format!("chore `{}`: {error}", chore.name))),
            None => Err(usage(format!("chore `{}`: no class `{}` in this scene", chore.name, chore.class))),
        }
    })
    .collect::<anyhow::Result<_>>()?;
    let planner = planner(args.planner)?;
    let classes: Vec<_> = scene.classes().values().cloned().collect();
    let mut sim = SimRobot::new(WorldConfig {
        robot,
        scene,
        seed: args.seed,
        noise: Noise::default(),
        fault: args.fault.map(Fault::from),
    })
    .map_err(usage)?;

    let studio = if args.headless { None } else { Some(Arc::new(Studio::start(StudioConfig::default())?)) };
    if let Some(studio) = &studio {
        console.say(format_args!("watch at {}", studio.url()));
        show_bodies(studio, &sim);
    }
    let mut pacer = Pacer::new(studio.clone(), stop.clone(), &sim, speed);
    sim.set_observer(FRAME_SECS, Box::new(move |view| pacer.frame(view)));

    // The map begins where the robot stands: nothing of the home is given.
    let world_from_map = sim.world_from_odom_start();
    let nothing = OccupancyGrid::filled(1, 1, MAP_RESOLUTION_M, Pose2::identity(), Cell::UNKNOWN)?;
    let aosm = Aosm::new(classes, nothing);
    let mut reporter =
        Reporter { studio: studio.clone(), stop: stop.clone(), console, world_from_map, n_plans: 0 };
    let faults = sim.fault_switch();
    let mut executive = Executive::new(
        &mut sim,
        aosm,
        Pose2::identity(),
        planner.as_ref(),
        &mut reporter,
        Settings::default(),
        args.seed,
    )?;
    let reports = do_chores(&mut executive, &chores, &faults, console)?;
    let n_edges = executive.graph().edges.len();
    let n_nodes = executive.graph().nodes.len();
    let aosm = executive.into_aosm();

    if let Some(out) = &args.out {
        home_folder::write(&out.join("home"), sim.scene().name(), &aosm).map_err(usage)?;
    }

    let mut done: Vec<Done> = Vec::new();
    for ((name, _), report) in chores.iter().zip(reports) {
        let verdict = sim.judge().achieved(name)?;
        done.push(Done { goal: name.clone(), report, achieved: verdict.achieved, measured: verdict.measured });
    }
    let truth = sim.true_grid(MAP_RESOLUTION_M)?;
    let map_iou = map_overlap(&aosm.grid, &truth, &world_from_map, 2.0 * MAP_RESOLUTION_M).free_iou;
    let known = json!({"classes": aosm.classes.len(), "objects": aosm.objects.len(), "nodes": n_nodes, "edges": n_edges});

    let is_achieved = done.len() == chores.len() && done.iter().all(|chore| chore.achieved);
    if let Some(studio) = &studio {
        let summary = done.iter().map(|chore| format!("{}: {}", chore.goal, chore.measured)).collect::<Vec<_>>().join("; ");
        studio.publish(ServerMessage::Done(wire::Done { achieved: is_achieved, summary }));
    }
    let wall_secs = started.elapsed().as_secs_f64();
    let documents: Vec<_> = done.iter().map(|chore| document(chore, &known, map_iou, wall_secs)).collect();
    let document = match documents.as_slice() {
        [one] => one.clone(),
        _ => json!({"achieved": is_achieved, "chores": documents, "wall_secs": wall_secs}),
    };
    console.answer(&document, || text(&done, wall_secs))?;
    Ok(Answer::from(is_achieved))
}

/// Explores, then does one chore after the other; what is learned in one serves the next.
fn do_chores(
    executive: &mut Executive<'_>,
    chores: &[(String, ChoreGoal)],
    faults: &FaultSwitch,
    console: &Console,
) -> anyhow::Result<Vec<RunReport>> {
    let stopped = || RunReport { reason: Some("stopped on request".to_owned()), ..RunReport::default() };
    match executive.explore(&mut |_| false) {
        Ok(()) => {}
        Err(AgentError::Stopped) => return Ok(vec![stopped(); chores.len()]),
        Err(error) => return Err(error.into()),
    }
    // What goes wrong on request goes wrong after mapping.
    faults.arm();
    let mut reports = Vec::new();
    for (name, goal) in chores {
        console.say(format_args!("chore: {name}"));
        match executive.do_chore(goal) {
            Ok(report) => reports.push(report),
            Err(AgentError::Stopped) => {
                reports.resize(chores.len(), stopped());
                break;
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(reports)
}

fn show_bodies(studio: &StudioHandle, sim: &SimRobot) {
    let bodies = sim.visual_bodies();
    let poses = sim.world_from_bodies();
    for source in [wire::SceneSource::Home, wire::SceneSource::Robot] {
        studio.publish(ServerMessage::Scene(scene_of(&bodies, &poses, source)));
    }
}

fn document(done: &Done, known: &serde_json::Value, map_iou: f64, wall_secs: f64) -> serde_json::Value {
    let report = &done.report;
    json!({
        "achieved": done.achieved,
        "goal": done.goal,
        "measured": done.measured,
        "reason": report.reason,
        "plan": report.plan.iter().map(|step| json!({"action": step.name, "args": step.args})).collect::<Vec<_>>(),
        "executed": report.executed.iter().map(|step| json!({
            "action": step.action, "args": step.args, "outcome": step.outcome,
            "attempts": step.attempts, "sim_secs": rounded(step.robot_secs),
        })).collect::<Vec<_>>(),
        "replans": report.n_replans,
        "aosm": known,
        "map_iou": rounded(map_iou),
        "wall_secs": rounded(wall_secs),
        "sim_secs": rounded(report.robot_secs),
        "peak_rss_mb": peak_rss_mb(),
    })
}

fn rounded(secs: f64) -> f64 {
    (secs * 100.0).round() / 100.0
}

fn text(done: &[Done], wall_secs: f64) -> String {
    let mut lines: Vec<String> = Vec::new();
    for chore in done {
        let mark = if chore.achieved { "achieved" } else { "NOT achieved" };
        lines.push(format!("{:<20} {mark}: {}", chore.goal, chore.measured));
        if let Some(reason) = &chore.report.reason {
            lines.push(format!("  {reason}"));
        }
        for step in &chore.report.executed {
            lines.push(format!("  {:<10} {:<28} {:6.1} s  {}", step.action, step.args.join(" "), step.robot_secs, step.outcome));
        }
    }
    lines.push(format!("{wall_secs:.1} s"));
    lines.join("\n")
}

/// The most memory the process has held, in MB, where the system tells.
fn peak_rss_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some((kib / 102.4).round() / 10.0)
}
