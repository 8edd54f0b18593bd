//! The simulated robot in its home.

mod answers;
mod arm;
mod base;
mod commands;
pub(crate) mod grip;
mod lift;
mod making;
mod stored;

use std::collections::BTreeMap;

use factotum_control::{
    ArmDynamics, ArmState, MotionId, MotionStatus, RobotError, RobotState, Stamped,
};
use factotum_descriptions::RobotDescription;
use factotum_geometry::frames::planar_from_pose;
use factotum_geometry::grid::OccupancyGrid;
use factotum_geometry::sensing::LaserScan;
use factotum_geometry::{Pose, Pose2};
use factotum_physics::{BodyId, Snapshot, State};
use nalgebra::{Point2, Vector3, Vector6};
use rand_chacha::ChaCha8Rng;

use crate::assembly::{Assembly, ObjectIds, STEP_SECS};
use crate::faults::FaultState;
use crate::ground_truth;
use crate::judge::Judge;
use crate::noise::Noise;
use crate::odometry::Odometry;
use crate::random::{Purpose, stream};
use crate::scene::{HomeScene, Placed};
use crate::visual::{self, VisualBody, WorldView};
use crate::{Fault, FaultSwitch, WorldError, WorldSnapshot};

use arm::ArmControl;
use base::BaseControl;
use grip::{GripControl, GripperScale};
use lift::LiftControl;
use stored::Reader;

pub(crate) use stored::{Writer, visit};

/// Height at which the true map is taken when the robot has no lidar, metres.
const MAP_HEIGHT_M: f64 = 0.2;

/// What a world is made of.
#[derive(Debug, Clone)]
pub struct WorldConfig {
    /// The robot.
    pub robot: RobotDescription,
    /// Its home.
    pub scene: HomeScene,
    /// Names one of the worlds that robot and home allow.
    pub seed: u64,
    /// How far its senses are off.
    pub noise: Noise,
    /// What goes wrong, once armed.
    pub fault: Option<Fault>,
}

/// All that changes from step to step besides physics.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Live {
    next_id: u64,
    statuses: BTreeMap<MotionId, MotionStatus>,
    arm: ArmControl,
    lift: LiftControl,
    base: Option<BaseControl>,
    grip: Option<GripControl>,
    odometry: Odometry,
    lidar_rng: ChaCha8Rng,
    camera_rng: ChaCha8Rng,
    last_scan: Option<Stamped<LaserScan>>,
    fault: FaultState,
    /// Time asked for that is too short for a step, seconds.
    remainder_secs: f64,
    /// What the pads felt in the last step, N.
    pad_forces_n: Vec<f64>,
    /// Whether the gripper held an object that touched nothing else in the last step.
    carrying: bool,
    /// Whether any part of the robot touched a movable object in the last step.
    touching: bool,
    observed_secs: f64,
}

struct Observer {
    period_secs: f64,
    call: Box<dyn FnMut(&WorldView<'_>) + Send>,
}

impl std::fmt::Debug for Observer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Observer")
            .field("period_secs", &self.period_secs)
            .finish_non_exhaustive()
    }
}

/// A simulated robot in its home; see the crate's documentation.
#[derive(Debug)]
pub struct SimRobot {
    config: WorldConfig,
    placed: Placed,
    assembly: Assembly,
    state: State,
    dynamics: ArmDynamics,
    gripper_scale: Option<GripperScale>,
    visuals: Vec<(BodyId, VisualBody)>,
    live: Live,
    fault_switch: FaultSwitch,
    observer: Option<Observer>,
    /// Why the simulation ended, once it has.
    failed: Option<String>,
}

/// Joint readings of one instant.
struct Readings {
    lift_m: f64,
    arm_positions: Vec<f64>,
    arm_velocities: Vec<f64>,
    opening: f64,
}

impl SimRobot {
    /// Draws the home of the seed, puts the robot in it and lets everything come to rest. Time begins at zero.
    ///
    /// # Errors
    /// [`WorldError`] if a model is broken or lacks a name that the description uses, or if no draw is free of overlaps.
    pub fn new(config: WorldConfig) -> Result<Self, WorldError> {
        let (placed, assembly, state) = Self::draw(&config)?;
        let dynamics = ArmDynamics::new(&config.robot)?;
        let gripper_scale = GripperScale::measure(&config.robot, dynamics.model())
            .map_err(WorldError::physics("measuring the gripper"))?;
        let robot = &config.robot;
        let live = Live {
            next_id: 1,
            statuses: BTreeMap::new(),
            arm: ArmControl::new(&robot.arm, dynamics.joint_limits(), &robot.arm.rest)?,
            lift: LiftControl::new(robot.lift.as_ref().map_or(0.0, |lift| lift.rest_m)),
            base: robot.base.as_ref().map(BaseControl::new),
            grip: robot
                .gripper
                .as_ref()
                .map(|gripper| GripControl::new(1.0, gripper.force_max_n)),
            odometry: Odometry::new(config.seed, &config.noise, assembly.world_from_base(&state)),
            lidar_rng: stream(config.seed, Purpose::Lidar),
            camera_rng: stream(config.seed, Purpose::Camera),
            last_scan: None,
            fault: FaultState::new(config.fault, config.seed),
            remainder_secs: 0.0,
            pad_forces_n: vec![0.0; robot.gripper.as_ref().map_or(0, |g| g.pads.len())],
            carrying: false,
            touching: false,
            observed_secs: 0.0,
        };
        let mut sim = Self {
            visuals: visual::visual_bodies(&assembly.model, |body| {
                visual::group_of(&assembly, body)
            }),
            placed,
            assembly,
            state,
            dynamics,
            gripper_scale,
            live,
            fault_switch: FaultSwitch::default(),
            observer: None,
            failed: None,
            config,
        };
        sim.settle()?;
        Ok(sim)
    }

    /// Calls `observer` in [`Robot::wait`](factotum_control::Robot::wait) each `period_secs` of simulated time. It may block: the world waits for it.
    pub fn set_observer(
        &mut self,
        period_secs: f64,
        observer: Box<dyn FnMut(&WorldView<'_>) + Send>,
    ) {
        self.observer = Some(Observer {
            period_secs: period_secs.max(STEP_SECS),
            call: observer,
        });
    }

    /// The home's scene.
    pub fn scene(&self) -> &HomeScene {
        &self.config.scene
    }

    /// The judge of this world.
    pub fn judge(&self) -> Judge<'_> {
        Judge {
            scene: &self.config.scene,
            assembly: &self.assembly,
            state: &self.state,
        }
    }

    /// What there is to draw.
    pub fn visual_bodies(&self) -> Vec<VisualBody> {
        self.visuals.iter().map(|(_, body)| body.clone()).collect()
    }

    /// Where the drawn bodies are, in the order of [`visual_bodies`](Self::visual_bodies).
    pub fn world_from_bodies(&self) -> Vec<Pose> {
        let bodies: Vec<BodyId> = self.visuals.iter().map(|(body, _)| *body).collect();
        visual::poses(&self.state, &bodies)
    }

    /// Where the base really is. For those who measure; the robot cannot know.
    pub fn world_from_base(&self) -> Pose2 {
        self.assembly.world_from_base(&self.state)
    }

    /// Where the origin of the robot's odometry is in the world: where it started.
    pub fn world_from_odom_start(&self) -> Pose2 {
        self.placed.world_from_base
    }

    /// Force with which everything else pushes the robot at this moment, N: zero while it touches nothing. For those who
    /// measure; the robot cannot know.
    pub fn push_on_robot_n(&self) -> f64 {
        let force = self.state.contact_force_on(&self.assembly.robot.geoms);
        force.norm()
    }

    /// Where an object's Λ really is. For those who measure; the robot cannot know.
    ///
    /// # Errors
    /// [`WorldError::UnknownName`] for an object that the home does not have.
    pub fn world_from_object(&self, name: &str) -> Result<Pose, WorldError> {
        let object = self.known_object(name)?;
        Ok(self.state.world_from_body(object.root))
    }

    fn known_object(&self, name: &str) -> Result<&ObjectIds, WorldError> {
        let objects = self.assembly.objects.iter();
        self.assembly
            .object(name)
            .ok_or_else(|| WorldError::UnknownName {
                kind: "object",
                name: name.to_owned(),
                scene: self.config.scene.name().to_owned(),
                available: objects.map(|object| object.name.clone()).collect(),
            })
    }

    /// Where a joint of an object really is, rad or m. For those who measure; the robot cannot know.
    ///
    /// # Errors
    /// [`WorldError::UnknownName`] for an object that the home does not have, or a joint that the object does not have.
    pub fn object_joint(&self, name: &str, joint: &str) -> Result<f64, WorldError> {
        let object = self.known_object(name)?;
        let found = object.joints.get(joint);
        found
            .map(|&joint| self.state.joint_position(joint))
            .ok_or_else(|| WorldError::UnknownName {
                kind: "joint",
                name: format!("{name}/{joint}"),
                scene: self.config.scene.name().to_owned(),
                available: object.joints.keys().cloned().collect(),
            })
    }

    /// The true map at the height of the lidar: what the map that the robot makes is measured by.
    ///
    /// # Errors
    /// [`WorldError::Grid`] if the resolution is not positive or the home too large for it.
    pub fn true_grid(&self, resolution_m: f64) -> Result<OccupancyGrid, WorldError> {
        let height_m = self.assembly.robot.lidar.map_or(MAP_HEIGHT_M, |site| {
            self.state.world_from_site(site).translation.z
        });
        ground_truth::true_grid(
            &self.assembly,
            &self.state,
            self.config.scene.bounds(),
            Point2::from(self.placed.world_from_base.translation.vector),
            height_m,
            resolution_m,
        )
    }

    /// Arms this world's fault from elsewhere.
    pub fn fault_switch(&self) -> FaultSwitch {
        self.fault_switch.clone()
    }

    /// What the fault did, once it has happened.
    pub fn fault_happened(&self) -> Option<&str> {
        self.live.fault.happened.as_deref()
    }

    /// Keeps the world aside.
    pub fn snapshot(&self) -> WorldSnapshot {
        WorldSnapshot {
            physics: self.state.snapshot(),
            live: self.live.clone(),
        }
    }

    /// Goes on from a snapshot of a world made from the same configuration.
    ///
    /// # Errors
    /// [`WorldError::Physics`] if the snapshot is of another world.
    pub fn restore(&mut self, snapshot: &WorldSnapshot) -> Result<(), WorldError> {
        let what = "restoring a snapshot";
        self.state
            .restore(&snapshot.physics)
            .map_err(WorldError::physics(what))?;
        // Contacts and velocities for the judge; the solver's warm start, which this touches, is then put back.
        self.state.forward().map_err(WorldError::physics(what))?;
        self.state
            .restore(&snapshot.physics)
            .map_err(WorldError::physics(what))?;
        self.live = snapshot.live.clone();
        self.failed = None;
        Ok(())
    }

    /// Reads a snapshot that [`WorldSnapshot::to_bytes`] wrote, of a world made from the same configuration.
    ///
    /// # Errors
    /// [`WorldError::Snapshot`] if the bytes are cut short, of another version or of another world.
    pub fn read_snapshot(&self, bytes: &[u8]) -> Result<WorldSnapshot, WorldError> {
        let wrong = |reason| WorldError::Snapshot { reason };
        let mut reader = Reader(bytes);
        let mut live = self.live.clone();
        live.statuses.clear();
        let mut values = Vec::new();
        visit(&mut reader, &mut values, &mut live).map_err(wrong)?;
        if !reader.0.is_empty() {
            return Err(wrong(format!("{} bytes too many", reader.0.len())));
        }
        let physics = Snapshot::from_values(&self.assembly.model, values)
            .map_err(|error| wrong(error.to_string()))?;
        Ok(WorldSnapshot { physics, live })
    }

    /// The physics, for tests that must bring about what they judge.
    #[cfg(test)]
    pub(crate) fn physics_mut(&mut self) -> (&Assembly, &mut State) {
        (&self.assembly, &mut self.state)
    }

    fn readings(&self) -> Readings {
        let robot = &self.assembly.robot;
        let state = &self.state;
        Readings {
            lift_m: robot
                .lift
                .map_or(0.0, |lift| state.joint_position(lift.joint)),
            arm_positions: robot
                .arm_joints
                .iter()
                .map(|&j| state.joint_position(j))
                .collect(),
            arm_velocities: robot
                .arm_joints
                .iter()
                .map(|&j| state.joint_velocity(j))
                .collect(),
            opening: self.opening(),
        }
    }

    fn opening(&self) -> f64 {
        let (Some(scale), Some(gripper)) = (&self.gripper_scale, &self.assembly.robot.gripper)
        else {
            return 0.0;
        };
        let joints = gripper.joints.iter();
        scale.opening(joints.map(|&joint| self.state.joint_position(joint)))
    }

    /// One physics step with all controllers.
    fn step(&mut self) -> Result<(), WorldError> {
        let now_secs = self.state.time_secs();
        let readings = self.readings();
        self.drive_arm(now_secs, &readings)?;
        self.drive_base(now_secs);
        self.drive_gripper(now_secs, readings.opening);
        self.state
            .step()
            .map_err(WorldError::physics("stepping the world"))?;
        self.feel();
        Ok(())
    }

    fn drive_arm(&mut self, now_secs: f64, readings: &Readings) -> Result<(), WorldError> {
        let arm = self.dynamics.arm_state(
            readings.lift_m,
            &readings.arm_positions,
            &readings.arm_velocities,
        )?;
        let command = self
            .live
            .arm
            .step(now_secs, &arm, readings.lift_m, STEP_SECS)?;
        for (actuator, torque) in self
            .assembly
            .robot
            .arm_actuators
            .iter()
            .zip(command.torques.iter())
        {
            self.state.set_ctrl(*actuator, *torque);
        }
        if let Some(lift_m) = command.lift_m {
            self.live.lift.target_m = lift_m;
        }
        if let Some(lift) = self.assembly.robot.lift {
            let target = self.live.lift.step(readings.lift_m, STEP_SECS);
            self.state.set_ctrl(lift.actuator, target);
        }
        self.end(command.ended);
        Ok(())
    }

    fn drive_base(&mut self, now_secs: f64) {
        let (Some(ids), Some(base)) = (&self.assembly.robot.base, &mut self.live.base) else {
            return;
        };
        let (command, ended) = base.step(now_secs, &self.live.odometry.odom_from_base, STEP_SECS);
        // The slides are aligned with the world; the wheels turn with the base.
        let yaw = self.state.joint_position(ids.joints[2]);
        let linear = nalgebra::Rotation2::new(yaw) * command.xy();
        let actuators = ids.actuators;
        for (actuator, value) in actuators.into_iter().zip([linear.x, linear.y, command.z]) {
            self.state.set_ctrl(actuator, value);
        }
        self.end(ended);
    }

    fn drive_gripper(&mut self, now_secs: f64, opening: f64) {
        let (Some(ids), Some(description), Some(grip)) = (
            &self.assembly.robot.gripper,
            &self.config.robot.gripper,
            &mut self.live.grip,
        ) else {
            return;
        };
        let (target, ended) = grip.step(now_secs, opening, &self.live.pad_forces_n, STEP_SECS);
        let target = if self.fault_switch.is_armed() {
            let (carrying, touching) = (self.live.carrying, self.live.touching);
            self.live
                .fault
                .on_grip(now_secs, carrying, touching, target, STEP_SECS)
        } else {
            target
        };
        let ends = description.closed.iter().zip(&description.open);
        for (actuator, (closed, open)) in ids.actuators.iter().zip(ends) {
            self.state
                .set_ctrl(*actuator, closed + target * (open - closed));
        }
        self.end(ended);
    }

    /// Reads what the step did to the pads and the base.
    fn feel(&mut self) {
        if let Some(gripper) = &self.assembly.robot.gripper {
            let state = &self.state;
            let forces = gripper
                .pads
                .iter()
                .map(|&pad| state.contact_force_on(&[pad]).norm());
            self.live.pad_forces_n = forces.collect();
        }
        if self.live.fault.fault == Some(Fault::GraspSlip) {
            self.live.carrying = self.is_carrying();
            let mut movable = self.assembly.objects.iter().filter(|object| object.movable);
            let robot = &self.assembly.robot.geoms;
            self.live.touching =
                movable.any(|object| self.state.are_touching(robot, &object.geoms));
        }
        if self.assembly.robot.base.is_some() {
            let world_from_base = self.assembly.world_from_base(&self.state);
            self.live.odometry.update(world_from_base);
        }
    }

    fn is_carrying(&self) -> bool {
        let robot = &self.assembly.robot;
        let Some(gripper) = &robot.gripper else {
            return false;
        };
        self.assembly
            .objects
            .iter()
            .filter(|object| object.movable)
            .any(|object| {
                let n_pads = gripper
                    .pads
                    .iter()
                    .filter(|pad| self.state.are_touching(&[**pad], &object.geoms))
                    .count();
                n_pads >= 2
                    && self.state.contacts().all(|contact| {
                        let pair = [contact.geom_a, contact.geom_b];
                        let mine = pair.iter().any(|geom| object.geoms.contains(geom));
                        !mine || pair.iter().any(|geom| robot.geoms.contains(geom))
                    })
            })
    }

    fn end(&mut self, ended: Option<(MotionId, MotionStatus)>) {
        if let Some((id, status)) = ended {
            self.live.statuses.insert(id, status);
        }
    }

    fn observe(&mut self) -> Result<(), RobotError> {
        let Some(mut observer) = self.observer.take() else {
            return Ok(());
        };
        let now_secs = self.state.time_secs();
        // Half a step of slack: the period need not be a whole number of steps.
        if now_secs - self.live.observed_secs >= observer.period_secs - STEP_SECS / 2.0 {
            self.live.observed_secs = now_secs;
            let state = self.read_state()?;
            let world_from_body = self.world_from_bodies();
            (observer.call)(&WorldView {
                time_secs: now_secs,
                world_from_body: &world_from_body,
                state: &state,
            });
        }
        self.observer = Some(observer);
        Ok(())
    }

    fn read_state(&mut self) -> Result<RobotState, RobotError> {
        let readings = self.readings();
        let arm = self.arm_state(&readings)?;
        let tcp_from_world = self
            .state
            .world_from_site(self.assembly.robot.tcp)
            .inverse();
        let gripper = self.assembly.robot.gripper.as_ref();
        let fingers = gripper.map_or(&[][..], |gripper| &gripper.fingers[..]);
        let finger_joints = gripper.map_or(&[][..], |gripper| &gripper.joints[..]);
        let state = &self.state;
        Ok(RobotState {
            time_secs: self.state.time_secs(),
            odom_from_base: self.live.odometry.odom_from_base,
            base_velocity: self.base_velocity(),
            lift_m: readings.lift_m,
            arm_positions: readings.arm_positions,
            arm_velocities: readings.arm_velocities,
            gripper_opening: readings.opening,
            finger_positions: finger_joints
                .iter()
                .map(|&joint| state.joint_position(joint))
                .collect(),
            finger_velocities: finger_joints
                .iter()
                .map(|&joint| state.joint_velocity(joint))
                .collect(),
            pad_forces_in_tcp: fingers
                .iter()
                .map(|finger| tcp_from_world.rotation * state.contact_force_on(finger))
                .collect(),
            tool_wrench_in_base: Vector6::from_iterator(
                self.live.arm.wrench.wrench(&arm).iter().copied(),
            ),
        })
    }

    fn arm_state(&mut self, readings: &Readings) -> Result<ArmState, RobotError> {
        self.dynamics
            .arm_state(
                readings.lift_m,
                &readings.arm_positions,
                &readings.arm_velocities,
            )
            .map_err(|error| self.lost(&error))
    }

    fn base_velocity(&self) -> Vector3<f64> {
        let Some(base) = &self.assembly.robot.base else {
            return Vector3::zeros();
        };
        let [x, y, yaw_rate] = base.joints.map(|joint| self.state.joint_velocity(joint));
        let yaw = self.state.joint_position(base.joints[2]);
        let in_base = nalgebra::Rotation2::new(-yaw) * nalgebra::Vector2::new(x, y);
        self.live
            .odometry
            .felt_velocity(Vector3::new(in_base.x, in_base.y, yaw_rate))
    }

    fn alive(&self) -> Result<(), RobotError> {
        match &self.failed {
            None => Ok(()),
            Some(reason) => Err(RobotError::Lost {
                robot: self.config.robot.name.clone(),
                reason: reason.clone(),
            }),
        }
    }

    /// The simulation failed: everything under way is given up, and the robot answers no more.
    fn lost(&mut self, error: &dyn std::error::Error) -> RobotError {
        let mut reason = error.to_string();
        let mut source = error.source();
        while let Some(cause) = source {
            let cause_text = cause.to_string();
            if !reason.contains(&cause_text) {
                reason = format!("{reason}: {cause_text}");
            }
            source = cause.source();
        }
        for status in self
            .live
            .statuses
            .values_mut()
            .filter(|status| !status.is_over())
        {
            *status = MotionStatus::Aborted(reason.clone());
        }
        self.failed = Some(reason.clone());
        RobotError::Lost {
            robot: self.config.robot.name.clone(),
            reason,
        }
    }

    fn absent(&self, what: &'static str) -> RobotError {
        RobotError::Absent {
            robot: self.config.robot.name.clone(),
            what,
        }
    }

    fn stamped<T>(&self, data: T) -> Stamped<T> {
        Stamped {
            time_secs: self.state.time_secs(),
            odom_from_base: self.live.odometry.odom_from_base,
            data,
        }
    }
}

/// The planar pose of a body.
fn planar(state: &State, body: BodyId) -> Pose2 {
    planar_from_pose(&state.world_from_body(body))
}
