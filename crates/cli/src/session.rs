//! A simulated robot at work with somebody watching: what `run` and `map explore` have in common.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use factotum_agent::{AgentError, Executive, Settings};
use factotum_descriptions::RobotDescription;
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
use crate::robot;
use crate::watch::{FRAME_SECS, Overheard, Pacer, Reporter, StopFlag};
use crate::wire_view::scene_of;

/// Edge of a cell of the map, metres.
pub(crate) const MAP_RESOLUTION_M: f64 = 0.05;

/// Which robot works in which home, and how it is watched.
#[derive(Debug, Args)]
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
        let robot = robot::load(&self.robot)?;
        Ok((scene, robot.description().clone()))
    }

    fn speed(&self) -> anyhow::Result<f64> {
        let speed = self.speed.unwrap_or(if self.headless { 0.0 } else { 2.0 });
        if speed >= 0.0 && speed.is_finite() {
            Ok(speed)
        } else {
            Err(usage(format!(
                "--speed is {speed}, expected 0 or a positive number"
            )))
        }
    }
}

/// A robot in its home, and whoever follows it.
pub(crate) struct Session<'a> {
    pub(crate) sim: SimRobot,
    pub(crate) audience: Audience,
    pub(crate) stop: StopFlag,
    console: &'a Console,
    seed: u64,
}

/// What is left when an executive has ended.
pub(crate) struct Ended {
    /// What it believed in the end.
    pub(crate) aosm: Aosm,
    /// Regions of the topological graph.
    pub(crate) n_nodes: usize,
    /// Ways between them.
    pub(crate) n_edges: usize,
}

impl<'a> Session<'a> {
    /// Makes the world and, unless headless, opens the page. What happens goes into `run_folder`, if there is one.
    pub(crate) fn begin(
        args: &WorldArgs,
        (scene, robot): (HomeScene, RobotDescription),
        fault: Option<Fault>,
        run_folder: Option<&Path>,
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
        let studio = if args.headless {
            None
        } else {
            Some(Arc::new(Studio::start(StudioConfig::default())?))
        };
        if let Some(studio) = &studio {
            console.say(format_args!("watch at {}", studio.url()));
        }
        let audience = Audience::new(studio, run_folder, started);
        let (bodies, poses) = (sim.visual_bodies(), sim.world_from_bodies());
        for source in [wire::SceneSource::Home, wire::SceneSource::Robot] {
            audience.tell(ServerMessage::Scene(scene_of(&bodies, &poses, source)));
        }
        let mut pacer = Pacer::new(audience.clone(), stop.clone(), &sim, speed);
        sim.set_observer(FRAME_SECS, Box::new(move |view| pacer.frame(view)));
        Ok(Self {
            sim,
            audience,
            stop,
            console,
            seed: args.seed,
        })
    }

    /// A map of which nothing is known yet but what classes of objects there are.
    pub(crate) fn empty_map(&self) -> anyhow::Result<Aosm> {
        let nothing =
            OccupancyGrid::filled(1, 1, MAP_RESOLUTION_M, Pose2::identity(), Cell::UNKNOWN)?;
        Ok(Aosm::new(
            self.sim.scene().classes().values().cloned(),
            nothing,
        ))
    }

    /// World in map: the map begins where the robot stood.
    pub(crate) fn world_from_map(&self) -> Pose2 {
        self.sim.world_from_odom_start()
    }

    /// Lets an executive with the belief `aosm` do something.
    pub(crate) fn execute(
        &mut self,
        aosm: Aosm,
        planner: &dyn Planner,
        work: impl FnOnce(&mut Executive<'_>),
    ) -> Result<Ended, AgentError> {
        let mut reporter = Reporter {
            audience: self.audience.clone(),
            stop: self.stop.clone(),
            console: self.console,
            world_from_map: self.world_from_map(),
            belief: BeliefScene::new(aosm.classes.values()),
        };
        let mut robot = Overheard {
            sim: &mut self.sim,
            audience: self.audience.clone(),
            stop: self.stop.clone(),
        };
        let settings = Settings::default();
        let mut executive = Executive::new(
            &mut robot,
            aosm,
            Pose2::identity(),
            planner,
            &mut reporter,
            settings,
            self.seed,
        )?;
        work(&mut executive);
        let (n_nodes, n_edges) = (executive.graph().nodes.len(), executive.graph().edges.len());
        Ok(Ended {
            aosm: executive.into_aosm(),
            n_nodes,
            n_edges,
        })
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
