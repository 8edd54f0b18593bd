//! A simulated robot at work with somebody watching: what `run` and `map explore` have in common.

use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use factotum_agent::{AgentError, Checkpoint, Executive, RunReport, Settings, find_in_map};
use factotum_control::Robot as _;
use factotum_descriptions::RobotDescription;
use factotum_experiments::run_folder::RunFolder;
use factotum_experiments::utc::UtcTime;
use factotum_geometry::Pose2;
use factotum_geometry::grid::{Cell, OccupancyGrid};
use factotum_protocol::{self as wire, ServerMessage};
use factotum_semantic_map::Aosm;
use factotum_studio::{Studio, StudioConfig};
use factotum_task_planning::planner::Planner;
use factotum_worlds::{Fault, HomeScene, Noise, SimRobot, WorldConfig};

use crate::assets;
use crate::audience::Audience;
use crate::belief::BeliefScene;
use crate::console::{Console, usage};
use crate::hand::Hand;
use crate::keeper::Keeper;
use crate::robot;
use crate::snapshot::Snapshot;
use crate::watch::{FRAME_SECS, Overheard, Pacer, Reporter, StopFlag};
use crate::wire_view::scene_of;

/// Edge of a cell of the map, metres.
pub(crate) const MAP_RESOLUTION_M: f64 = 0.05;

/// Paces that can be asked for, robot seconds per second: slower, nobody could stop it in time.
const SPEEDS: RangeInclusive<f64> = 0.05..=1000.0;

/// Which robot works in which home, and how it is watched.
#[derive(Debug, Clone, Args)]
pub(crate) struct WorldArgs {
    /// Home to work in: a folder with `scene.toml`, or the name of a shipped one.
    #[arg(long, default_value = "household")]
    pub(crate) scene: PathBuf,
    /// Robot: a folder with `robot.toml`, or the name of a shipped one.
    #[arg(long, default_value = "movo")]
    pub(crate) robot: PathBuf,
    /// Draws object places, start pose and noise.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Do not open the page.
    #[arg(long)]
    pub(crate) headless: bool,
    /// Robot seconds per second: 1 is real time, 0 as fast as possible. Default: 0 headless, 2 with the page.
    #[arg(long)]
    speed: Option<f64>,
}

impl WorldArgs {
    /// Reads the models.
    pub(crate) fn load(&self) -> anyhow::Result<(HomeScene, RobotDescription)> {
        let scene = HomeScene::load(&assets::scene(&self.scene)?).map_err(usage)?;
        let robot = robot::load(&self.robot)?.description().clone();
        let parts = [
            ("mobile base", robot.base.is_none()),
            ("lidar", robot.sensors.lidar.is_none()),
            ("camera", robot.sensors.camera.is_none()),
        ];
        if let Some((part, _)) = parts.iter().find(|(_, is_missing)| *is_missing) {
            return Err(usage(format!(
                "robot `{}` has no {part}; in a home a robot needs a mobile base, a lidar and a camera",
                robot.name
            )));
        }
        Ok((scene, robot))
    }

    /// The same, at real time unless another speed was asked for.
    pub(crate) fn at_real_time(&self) -> Self {
        Self {
            speed: self.speed.or(Some(1.0)),
            ..self.clone()
        }
    }

    fn speed(&self) -> anyhow::Result<f64> {
        let speed = self.speed.unwrap_or(if self.headless { 0.0 } else { 2.0 });
        if speed == 0.0 || SPEEDS.contains(&speed) {
            Ok(speed)
        } else {
            let (least, most) = SPEEDS.into_inner();
            Err(usage(format!(
                "--speed is {speed}, expected 0 or {least} to {most}"
            )))
        }
    }
}

/// A robot in its home, and whoever follows it.
pub(crate) struct Session<'a> {
    /// Shared by the executive, which acts through it, and the keeper, which takes snapshots between motions.
    pub(crate) sim: RefCell<SimRobot>,
    pub(crate) audience: Audience,
    pub(crate) stop: StopFlag,
    /// Whoever drives from the page.
    pub(crate) hand: Hand,
    /// World in map. A map that begins in this session begins where the robot stands.
    pub(crate) world_from_map: Pose2,
    console: &'a Console,
    seed: u64,
}

/// Where an executive begins.
pub(crate) enum Start<'s> {
    /// At the origin of the map.
    AtOrigin,
    /// Somewhere in a stored map: it must find out.
    Somewhere,
    /// Where an earlier one was.
    From(&'s Checkpoint),
}

/// What is left when an executive has ended.
pub(crate) struct Ended {
    /// What it believed in the end.
    pub(crate) aosm: Aosm,
    /// Regions of the topological graph.
    pub(crate) n_nodes: usize,
    /// Ways between them.
    pub(crate) n_edges: usize,
    /// What ended it before its time.
    pub(crate) failed: Option<AgentError>,
    /// The chore that was under way then, as far as it got.
    pub(crate) under_way: Option<RunReport>,
}

/// A map of a home of which nothing is known yet but what classes of objects there are.
pub(crate) fn empty_map(scene: &HomeScene) -> anyhow::Result<Aosm> {
    let nothing = OccupancyGrid::filled(1, 1, MAP_RESOLUTION_M, Pose2::identity(), Cell::UNKNOWN)?;
    Ok(Aosm::new(scene.classes().values().cloned(), nothing))
}

impl<'a> Session<'a> {
    /// Makes the world, or makes it anew as it was in the snapshot `before`, and opens the page, unless headless. What
    /// happens goes into `run_folder`, if there is one.
    pub(crate) fn begin(
        args: &WorldArgs,
        (scene, robot): (HomeScene, RobotDescription),
        fault: Option<Fault>,
        run_folder: Option<&RunFolder>,
        before: Option<&Snapshot>,
        started: UtcTime,
        console: &'a Console,
    ) -> anyhow::Result<Self> {
        let speed = args.speed()?;
        let stop = StopFlag::on_interrupt()?;
        let noise = Noise::default();
        let mut sim = SimRobot::new(WorldConfig {
            robot,
            scene,
            seed: args.seed,
            noise,
            fault,
        })
        .map_err(usage)?;
        if let Some(before) = before {
            let changed = |error| {
                usage(format!(
                    "the scene or the robot is not as it was when the run was stopped: {error}"
                ))
            };
            let world = sim.read_snapshot(&before.world).map_err(changed)?;
            sim.restore(&world).map_err(changed)?;
        }
        let time_secs = sim.state()?.time_secs;
        let studio = if args.headless {
            None
        } else {
            Some(Arc::new(Studio::start(StudioConfig::default())?))
        };
        if let Some(studio) = &studio {
            console.say(format_args!("watch at {}", studio.url()));
        }
        let told = before.map(|before| before.told.clone()).unwrap_or_default();
        let audience = Audience::new(studio, run_folder, started, told, time_secs);
        let (bodies, poses) = (sim.visual_bodies(), sim.world_from_bodies());
        for source in [wire::SceneSource::Home, wire::SceneSource::Robot] {
            audience.tell(ServerMessage::Scene(scene_of(&bodies, &poses, source)));
        }
        let hand = Hand::default();
        let mut pacer = Pacer::new(audience.clone(), stop.clone(), hand.clone(), &sim, speed);
        sim.set_observer(FRAME_SECS, Box::new(move |view| pacer.frame(view)));
        Ok(Self {
            world_from_map: before.map_or_else(
                || sim.world_from_odom_start(),
                |before| before.world_from_map,
            ),
            sim: RefCell::new(sim),
            audience,
            stop,
            hand,
            console,
            seed: args.seed,
        })
    }

    /// Lets an executive with the belief `aosm` do something, and answers what is left of it.
    pub(crate) fn execute(
        &mut self,
        aosm: Aosm,
        start: &Start<'_>,
        planner: &dyn Planner,
        keeper: &RefCell<Keeper>,
        work: impl FnOnce(&mut Executive<'_>) -> Result<(), AgentError>,
    ) -> Ended {
        let mut ended = Ended {
            aosm,
            n_nodes: 0,
            n_edges: 0,
            failed: None,
            under_way: None,
        };
        let worked = self.work(&mut ended, start, planner, keeper, work);
        ended.failed = worked.err();
        ended
    }

    fn work(
        &mut self,
        ended: &mut Ended,
        start: &Start<'_>,
        planner: &dyn Planner,
        keeper: &RefCell<Keeper>,
        work: impl FnOnce(&mut Executive<'_>) -> Result<(), AgentError>,
    ) -> Result<(), AgentError> {
        let aosm = ended.aosm.clone();
        let description = self.sim.borrow().description().clone();
        let mut robot = Overheard {
            description,
            sim: &self.sim,
            audience: self.audience.clone(),
            stop: self.stop.clone(),
        };
        let mut reporter = Reporter {
            sim: &self.sim,
            keeper,
            audience: self.audience.clone(),
            stop: self.stop.clone(),
            console: self.console,
            world_from_map: self.world_from_map,
            belief: BeliefScene::new(aosm.classes.values()),
        };
        let map_from_odom = match start {
            Start::AtOrigin => Pose2::identity(),
            Start::From(checkpoint) => checkpoint.map_from_odom,
            Start::Somewhere => {
                let map_from_odom = find_in_map(&mut robot, &aosm.grid, &mut reporter)?;
                let odom_from_base = robot.state()?.odom_from_base;
                let world_from_odom =
                    self.sim.borrow().world_from_base() * odom_from_base.inverse();
                self.world_from_map = world_from_odom * map_from_odom.inverse();
                reporter.world_from_map = self.world_from_map;
                map_from_odom
            }
        };
        let mut executive = Executive::new(
            &mut robot,
            aosm,
            map_from_odom,
            planner,
            &mut reporter,
            Settings::default(),
            self.seed,
        )?;
        if let Start::From(checkpoint) = start {
            executive.restore(checkpoint);
        }
        let worked = work(&mut executive);
        (ended.n_nodes, ended.n_edges) =
            (executive.graph().nodes.len(), executive.graph().edges.len());
        ended.under_way = executive.under_way().cloned();
        ended.aosm = executive.into_aosm();
        keeper.borrow_mut().keep_map(&ended.aosm, &self.audience);
        worked
    }

    /// Keeps the page open until somebody closes it, unless the job was stopped, which meant the page as well.
    pub(crate) fn linger(&self) {
        let Some(studio) = self.audience.studio().filter(|_| !self.stop.is_raised()) else {
            return;
        };
        self.console.say(format_args!(
            "the page stays at {} until Ctrl-C or its Stop",
            studio.url()
        ));
        let commands = studio.commands();
        while !self.stop.is_raised() {
            if commands.next_within(Duration::from_millis(200)) == Some(wire::ClientMessage::Stop) {
                break;
            }
        }
    }
}
