//! Between the run and whoever follows it: poses, map and plan go out; pause and stop, and Ctrl-C, come back.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use factotum_agent::{Event, LogLevel, Observer, StepState, StepView, Wish};
use factotum_control::{Command, MotionId, MotionStatus, Robot, RobotError, RobotState, Stamped};
use factotum_descriptions::RobotDescription;
use factotum_geometry::frames::{planar_from_pose, pose_from_planar};
use factotum_geometry::sensing::{DepthFrame, LaserScan};
use factotum_geometry::{Pose, Pose2};
use factotum_protocol as wire;
use factotum_protocol::ServerMessage;
use factotum_worlds::{BodyGroup, SimRobot, WorldView};

use crate::audience::Audience;
use crate::belief::BeliefScene;
use crate::console::Console;
use crate::hand::Hand;
use crate::keeper::Keeper;
use crate::wire_view::{aosm_of, map_of, plan_of, planar, pose_of};

/// A wish to stop, from the page or from Ctrl-C.
#[derive(Debug, Clone, Default)]
pub(crate) struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Raised by the first Ctrl-C; the second ends the program at once, with exit code 130.
    pub(crate) fn on_interrupt() -> anyhow::Result<Self> {
        let flag = Self::default();
        let raised = flag.clone();
        ctrlc::set_handler(move || {
            if raised.0.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
        })?;
        Ok(flag)
    }

    pub(crate) fn raise(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    pub(crate) fn is_raised(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

/// How often the page gets new poses, in robot seconds.
pub(crate) const FRAME_SECS: f64 = 1.0 / 30.0;

/// Tells where everything is and keeps pace with the clock.
pub(crate) struct Pacer {
    audience: Audience,
    stop: StopFlag,
    hand: Hand,
    names: Vec<String>,
    joints: Vec<String>,
    /// The robot's first body, which its base carries, and the base in it.
    base_body: Option<(usize, Pose)>,
    /// Robot seconds per second; 0 for as fast as possible.
    speed: f64,
    before: Option<(Instant, f64)>,
}

impl Pacer {
    pub(crate) fn new(
        audience: Audience,
        stop: StopFlag,
        hand: Hand,
        robot: &SimRobot,
        speed: f64,
    ) -> Self {
        let bodies = robot.visual_bodies();
        let base_body = bodies
            .iter()
            .position(|body| body.group == BodyGroup::Robot)
            .and_then(|index| {
                let world_from_body = *robot.world_from_bodies().get(index)?;
                Some((
                    index,
                    world_from_body.inverse() * pose_from_planar(&robot.world_from_base(), 0.0),
                ))
            });
        Self {
            audience,
            stop,
            hand,
            names: bodies.iter().map(|body| body.name.clone()).collect(),
            joints: robot.description().arm.joints.clone(),
            base_body,
            speed,
            before: None,
        }
    }

    /// Called by the simulation between steps; returning late slows it down, which is how a pause works.
    pub(crate) fn frame(&mut self, view: &WorldView<'_>) {
        self.keep_pace(view.time_secs);
        let sim_speed = self.measured_speed(view.time_secs);
        self.audience
            .tell(ServerMessage::State(self.state_of(view, sim_speed)));
        let Some(commands) = self.audience.studio().map(|studio| studio.commands()) else {
            return;
        };
        while let Some(command) = commands.try_next() {
            match command {
                wire::ClientMessage::Stop => self.stop.raise(),
                wire::ClientMessage::Resume => {}
                wire::ClientMessage::Drive(drive) => self.hand.hear(drive, Instant::now()),
                wire::ClientMessage::DriveDone => self.hand.finish(),
                wire::ClientMessage::Edit(_) => {}
                wire::ClientMessage::Pause => {
                    self.audience.set_paused(true);
                    self.audience
                        .tell(ServerMessage::State(self.state_of(view, 0.0)));
                    while !self.stop.is_raised() {
                        match commands.next_within(Duration::from_millis(200)) {
                            Some(wire::ClientMessage::Resume) => break,
                            Some(wire::ClientMessage::Stop) => self.stop.raise(),
                            Some(wire::ClientMessage::DriveDone) => self.hand.finish(),
                            Some(
                                wire::ClientMessage::Pause
                                | wire::ClientMessage::Drive(_)
                                | wire::ClientMessage::Edit(_),
                            )
                            | None => {}
                        }
                    }
                    self.audience.set_paused(false);
                    self.before = None;
                }
            }
        }
    }

    fn keep_pace(&self, time_secs: f64) {
        if let Some((instant, before_secs)) = self.before
            && self.speed > 0.0
        {
            let due = Duration::from_secs_f64(((time_secs - before_secs) / self.speed).max(0.0));
            std::thread::sleep(due.saturating_sub(instant.elapsed()));
        }
    }

    fn measured_speed(&mut self, time_secs: f64) -> f64 {
        let now = Instant::now();
        let speed = self.before.map_or(0.0, |(instant, before_secs)| {
            (time_secs - before_secs) / now.duration_since(instant).as_secs_f64().max(1e-6)
        });
        self.before = Some((now, time_secs));
        speed
    }

    /// Where the base really is: odometry drifts.
    fn world_from_base(&self, view: &WorldView<'_>) -> Pose2 {
        let base = self.base_body.as_ref().and_then(|(index, body_from_base)| {
            Some(planar_from_pose(
                &(view.world_from_body.get(*index)? * body_from_base),
            ))
        });
        base.unwrap_or(view.state.odom_from_base)
    }

    fn state_of(&self, view: &WorldView<'_>, sim_speed: f64) -> wire::State {
        let body = |(name, pose): (&String, _)| wire::BodyPose {
            name: name.clone(),
            pose: pose_of(pose),
        };
        let joint = |(name, position): (&String, &f64)| wire::JointPosition {
            name: name.clone(),
            position: *position,
        };
        wire::State {
            time_secs: view.time_secs,
            sim_speed,
            base: planar(&self.world_from_base(view)),
            body_poses: self
                .names
                .iter()
                .zip(view.world_from_body)
                .map(body)
                .collect(),
            joints: self
                .joints
                .iter()
                .zip(&view.state.arm_positions)
                .map(joint)
                .collect(),
        }
    }
}

/// The simulated robot, overheard: base paths and scans are told on their way. When a stop is wished it halts, and
/// answers no more, so that a stop need not wait for the end of a motion.
pub(crate) struct Overheard<'a> {
    pub(crate) description: RobotDescription,
    pub(crate) sim: &'a RefCell<SimRobot>,
    pub(crate) audience: Audience,
    pub(crate) stop: StopFlag,
}

impl Robot for Overheard<'_> {
    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn state(&mut self) -> Result<RobotState, RobotError> {
        self.sim.borrow_mut().state()
    }

    fn send(&mut self, command: Command) -> Result<MotionId, RobotError> {
        let mut sim = self.sim.borrow_mut();
        let points = match &command {
            Command::BasePath(path) => {
                // Odometry drifts; the path is drawn where the robot will really drive.
                let world_from_odom = sim.world_from_base() * sim.state()?.odom_from_base.inverse();
                let point = |pose: &Pose2| (world_from_odom * pose).translation.vector.into();
                Some(path.odom_from_base.iter().map(point).collect())
            }
            _ => None,
        };
        let id = sim.send(command)?;
        if let Some(points) = points {
            self.audience
                .tell(ServerMessage::BasePath(wire::BasePath { points }));
        }
        Ok(id)
    }

    fn progress(&mut self, id: MotionId) -> Result<MotionStatus, RobotError> {
        self.sim.borrow_mut().progress(id)
    }

    fn scan(&mut self) -> Result<Stamped<LaserScan>, RobotError> {
        let scan = self.sim.borrow_mut().scan()?;
        self.audience.tell_scan(scan.time_secs, &scan.data);
        Ok(scan)
    }

    fn look(&mut self) -> Result<Stamped<DepthFrame>, RobotError> {
        self.sim.borrow_mut().look()
    }

    fn wait(&mut self, secs: f64) -> Result<(), RobotError> {
        self.sim.borrow_mut().wait(secs)?;
        if self.stop.is_raised() {
            self.stop()?;
            let robot = self.description.name.clone();
            return Err(RobotError::Lost {
                robot,
                reason: "stopped on request".to_owned(),
            });
        }
        Ok(())
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.sim.borrow_mut().stop()
    }
}

/// Tells the followers and the terminal what the executive does, and has the keeper keep it.
pub(crate) struct Reporter<'a> {
    pub(crate) sim: &'a RefCell<SimRobot>,
    pub(crate) keeper: &'a RefCell<Keeper>,
    pub(crate) audience: Audience,
    pub(crate) stop: StopFlag,
    pub(crate) console: &'a Console,
    /// World in map: where what is believed must be drawn.
    pub(crate) world_from_map: Pose2,
    pub(crate) belief: BeliefScene,
}

impl Observer for Reporter<'_> {
    fn observe(&mut self, event: &Event<'_>) -> Wish {
        match event {
            Event::Log {
                time_secs,
                level,
                text,
            } => {
                self.console.progress(text.clone());
                self.console.say(format_args!("[{time_secs:7.1} s] {text}"));
                let level = match level {
                    LogLevel::Info => wire::EventLevel::Info,
                    LogLevel::Warning => wire::EventLevel::Warning,
                    LogLevel::Error => wire::EventLevel::Error,
                };
                let event = wire::Event {
                    level,
                    text: text.clone(),
                    time_secs: *time_secs,
                };
                self.audience.tell(ServerMessage::Event(event));
            }
            Event::Map { aosm, graph, .. } => {
                self.audience.tell(ServerMessage::Aosm(aosm_of(
                    aosm,
                    graph,
                    &self.world_from_map,
                )));
                self.audience.tell(ServerMessage::Scene(
                    self.belief.scene(aosm, &self.world_from_map),
                ));
                match map_of(aosm, &self.world_from_map) {
                    Ok(map) => self.audience.tell(ServerMessage::Map(map)),
                    Err(error) => tracing::warn!(%error, "map not shown"),
                }
            }
            Event::Plan { steps } => self.hear_plan(steps),
            Event::Checkpoint { aosm, checkpoint } => self.keeper.borrow_mut().keep(
                aosm,
                checkpoint,
                &self.sim.borrow(),
                self.world_from_map,
                &self.audience,
            ),
        }
        if self.stop.is_raised() {
            Wish::Stop
        } else {
            Wish::GoOn
        }
    }
}

impl Reporter<'_> {
    /// A plan none of whose steps was tried is a new one; one that failed and has nothing left to do will be replaced.
    fn hear_plan(&self, steps: &[StepView]) {
        let has = |state| steps.iter().any(|step| step.state == state);
        if steps.iter().all(|step| step.state == StepState::Pending) {
            self.audience.count_plan();
        }
        let is_given_up =
            has(StepState::Failed) && !has(StepState::Running) && !has(StepState::Pending);
        self.audience.set_activity(if is_given_up {
            wire::Activity::Planning
        } else {
            wire::Activity::Acting
        });
        self.audience.tell(ServerMessage::Plan(plan_of(
            steps,
            self.audience.n_replans(),
        )));
    }
}
