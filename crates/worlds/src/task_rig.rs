//! A simulated robot at an object, to learn a contact skill on.
//!
//! The object hangs on a body that is moved by hand, so that it stands elsewhere in each episode without anything being
//! compiled anew. Commands become motor torques at every physics step, through the same laws as everywhere
//! (`control`); the arm's mass matrix and Jacobian are those of the simulated arm.
//!
//! The frame of the robot's base is the world here.

mod cloud;
mod joint_drive;

use factotum_control::composition::attach_robot;
use factotum_control::gripper::GripperController;
use factotum_control::impedance::ToolTarget;
use factotum_control::tool_servo::{JointGuard, ToolServo};
use factotum_control::{ArmDynamics, ArmState, ControlError, GripperGoal, GuardSpec, ModelArm};
use factotum_descriptions::{DescriptionError, JointKind, ObjectJoint, RobotDescription, TaskSpec};
use factotum_geometry::Pose;
use factotum_geometry::cloud::PointCloud;
use factotum_motion::{MotionError, RobotModel};
use factotum_physics::{
    ActuatorId, AttachPoint, BodyId, GeomId, JointId, Model, Motion, Part, PhysicsError, Primitive,
    SceneBuilder, SceneOptions, Shape, State,
};
use factotum_skills::cip::perturbation::Perturbation;
use factotum_skills::cip::rig::{Anatomy, Placing, Reading, Rig, RigCommand};
use nalgebra::{DVector, Point3, Vector3};

use crate::assembly::STEP_SECS;
use crate::sim_robot::grip::GripperScale;
use crate::visual::{BodyGroup, VisualBody, visual_bodies};

/// Prefix of the object's names.
const OBJECT: &str = "object/";

/// Prefix of the names of what stands about it.
const SURROUNDINGS: &str = "surroundings/";

/// The body that carries the object.
const STAND: &str = "stand";

/// Why there is no rig, or it broke down.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// The robot's description.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The engine.
    #[error("task `{task}`: {source}")]
    Physics {
        /// The task.
        task: String,
        /// The engine's word.
        source: PhysicsError,
    },
    /// The control laws.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The robot's kinematics.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// What the task file says does not fit its object or robot.
    #[error("`{file}`: `{field}` is {found}, expected {wanted}")]
    Task {
        /// The task file.
        file: String,
        /// The field.
        field: &'static str,
        /// What it says.
        found: String,
        /// What would fit.
        wanted: String,
    },
    /// A placing for another arm.
    #[error("a placing has {found} joint positions, expected {wanted}")]
    Size {
        /// Those given.
        found: usize,
        /// Those of the chain.
        wanted: usize,
    },
}

impl RigError {
    /// Whether it is the user's to mend: a task, or a model that it names.
    pub fn is_of_input(&self) -> bool {
        matches!(
            self,
            Self::Task { .. } | Self::Size { .. } | Self::Description(_) | Self::Physics { .. }
        )
    }
}

/// Everything that is looked up once.
#[derive(Debug)]
struct Ids {
    stand: BodyId,
    robot_bodies: Vec<BodyId>,
    robot_geoms: Vec<GeomId>,
    arm: ModelArm,
    arm_actuators: Vec<ActuatorId>,
    lift: Option<(JointId, ActuatorId)>,
    finger_joints: Vec<JointId>,
    finger_actuators: Vec<ActuatorId>,
    /// Geoms of each body that carries a pad.
    fingers: Vec<Vec<GeomId>>,
    object_joint: JointId,
    link: BodyId,
    region: Vec<GeomId>,
}

/// A simulated robot at an object.
#[derive(Debug)]
pub struct TaskRig {
    task: TaskSpec,
    robot: RobotDescription,
    anatomy: Anatomy,
    state: State,
    ids: Ids,
    scale: GripperScale,
    grip: GripperController,
    servo: ToolServo,
    arm: ArmState,
    n_substeps: u32,
    link_from_region: Point3<f64>,
    reading: Reading,
    /// What was done to each finger by contact in the last step, N in the world.
    finger_forces: Vec<Vector3<f64>>,
    world_from_object: Pose,
}

impl TaskRig {
    /// Puts a task's robot and object together.
    ///
    /// # Errors
    /// [`RigError`] if a model does not load, or the task names what its models do not have.
    pub fn new(task: &TaskSpec) -> Result<Self, RigError> {
        Self::perturbed(task, &Perturbation::default())
    }

    /// As [`TaskRig::new`], with another resistance of the object's joint.
    ///
    /// # Errors
    /// As [`TaskRig::new`].
    pub fn perturbed(task: &TaskSpec, perturbation: &Perturbation) -> Result<Self, RigError> {
        let robot = RobotDescription::load(&task.robot)?;
        if robot.gripper.is_none() {
            return Err(misfit(
                task,
                "robot",
                format!("`{}`, which has no gripper", robot.name),
                "a robot that can grasp",
            ));
        }
        let physics = |source| RigError::Physics {
            task: task.name.clone(),
            source,
        };
        let model = compose(task, &robot).map_err(physics)?;
        let ids = look_up(task, &robot, &model)?;
        let model = model
            .edited(|edit| {
                let Perturbation {
                    damping, friction, ..
                } = *perturbation;
                edit.scale_joint_resistance(ids.object_joint, damping, friction)
            })
            .map_err(physics)?;
        let range = model.joint_range(ids.object_joint);
        if let Some([low, high]) = range {
            for (field, value) in [("start", task.start), ("goal", task.goal)] {
                if !(low - 1e-9..=high + 1e-9).contains(&value) {
                    return Err(misfit(
                        task,
                        field,
                        value.to_string(),
                        &format!("within the range {low} to {high} of joint `{}`", task.joint),
                    ));
                }
            }
        }
        let mut state = State::new(&model).map_err(physics)?;
        state.forward_kinematics().map_err(physics)?;
        let object_joint = object_joint(task, &model, &state, &ids, range);
        let link_from_region = {
            let sum: Vector3<f64> = ids
                .region
                .iter()
                .map(|&geom| state.world_from_geom(geom).translation.vector)
                .sum();
            let middle = Point3::from(sum / ids.region.len() as f64);
            state.world_from_body(ids.link).inverse() * middle
        };
        let dynamics = ArmDynamics::new(&robot)?;
        let scale = GripperScale::measure(&robot, dynamics.model())
            .map_err(physics)?
            .ok_or_else(|| misfit(task, "robot", format!("`{}`", robot.name), "a gripper"))?;
        let n = ids.arm.joints().len();
        let aperture_max_m = robot
            .gripper
            .as_ref()
            .map_or(0.0, |gripper| gripper.aperture_max_m);
        let anatomy = Anatomy {
            robot: RobotModel::load(&robot)?,
            arm_limits: ids
                .arm
                .joints()
                .iter()
                .map(|&joint| model.joint_range(joint))
                .collect(),
            n_finger_joints: ids.finger_joints.len(),
            n_pads: ids.fingers.len(),
            aperture_max_m,
            object_joint,
            episode: task.episode,
        };
        let ready = DVector::from_row_slice(&robot.arm.ready);
        let n_substeps = (1.0 / (task.episode.control_hz * STEP_SECS))
            .round()
            .max(1.0);
        let mut rig = Self {
            task: task.clone(),
            anatomy,
            servo: ToolServo::new(&robot.arm.torque_max_nm, JointGuard::None, ready),
            robot,
            scale,
            grip: GripperController::holding(1.0, task.episode.grip_force_n),
            arm: ids.arm.read(&state),
            n_substeps: n_substeps as u32,
            link_from_region,
            reading: Reading {
                arm_positions: vec![0.0; n],
                arm_velocities: vec![0.0; n],
                base_from_tcp: Pose::identity(),
                finger_positions: vec![0.0; ids.finger_joints.len()],
                finger_velocities: vec![0.0; ids.finger_joints.len()],
                pad_forces_in_tcp: vec![Vector3::zeros(); ids.fingers.len()],
                base_from_object: Pose::identity(),
                region: Point3::origin(),
                object_joint: task.start,
                touching: false,
                peak_force_n: 0.0,
                limit_distance_rad: f64::INFINITY,
            },
            finger_forces: vec![Vector3::zeros(); ids.fingers.len()],
            world_from_object: Pose::identity(),
            ids,
            state,
        };
        let placing = Placing {
            base_from_object: task.placement.at([0.5; 4]),
            object_joint: task.start,
            q: rig.anatomy.robot.q_ready(),
            opening: 1.0,
        };
        rig.place(&placing)?;
        Ok(rig)
    }

    /// The task.
    pub fn task(&self) -> &TaskSpec {
        &self.task
    }

    /// The simulation, to look at.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What there is to draw, with the identifiers of the bodies.
    pub fn visual_bodies(&self) -> Vec<(BodyId, VisualBody)> {
        visual_bodies(self.state.model(), |body| {
            if self.ids.robot_bodies.contains(&body) {
                BodyGroup::Robot
            } else {
                BodyGroup::Object
            }
        })
    }

    fn physics(&self, source: PhysicsError) -> RigError {
        RigError::Physics {
            task: self.task.name.clone(),
            source,
        }
    }

    /// Targets of the gripper's drives for an opening.
    fn set_fingers(&mut self, opening: f64) {
        let Some(gripper) = &self.robot.gripper else {
            return;
        };
        for ((&actuator, &open), &closed) in self
            .ids
            .finger_actuators
            .iter()
            .zip(&gripper.open)
            .zip(&gripper.closed)
        {
            self.state
                .set_ctrl(actuator, closed + (open - closed) * opening);
        }
    }

    /// Opening of the gripper, 0 closed to 1 open.
    fn opening(&self) -> f64 {
        let fingers = self.ids.finger_joints.iter();
        self.scale
            .opening(fingers.map(|&joint| self.state.joint_position(joint)))
    }

    /// Sums up what contacts did to each finger in the last step.
    fn feel(&mut self) {
        let fingers = &self.ids.fingers;
        self.finger_forces.fill(Vector3::zeros());
        for contact in self.state.contacts() {
            let [a, b] = [contact.geom_a, contact.geom_b]
                .map(|geom| fingers.iter().position(|finger| finger.contains(&geom)));
            if a == b {
                continue;
            }
            let Some(wrench) = self.state.contact_wrench(contact.idx) else {
                continue;
            };
            // The wrench is what the first geom does to the second.
            if let Some(finger) = a {
                self.finger_forces[finger] -= wrench.force;
            }
            if let Some(finger) = b {
                self.finger_forces[finger] += wrench.force;
            }
        }
    }

    /// Smallest distance of an arm joint to its limit, rad.
    fn limit_distance(&self) -> f64 {
        let limits = self.ids.arm.joints().iter().zip(&self.anatomy.arm_limits);
        limits
            .filter_map(|(&joint, limit)| {
                let [lower, upper] = (*limit)?;
                let q = self.state.joint_position(joint);
                Some((q - lower).min(upper - q))
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// Fills in what is felt, from a state whose poses are up to date.
    fn read(&mut self) {
        let tcp_from_world = self.state.world_from_site(self.ids.arm.tcp()).inverse();
        let Self {
            state,
            ids,
            reading,
            ..
        } = self;
        for (place, &joint) in reading.arm_positions.iter_mut().zip(ids.arm.joints()) {
            *place = state.joint_position(joint);
        }
        for (place, &joint) in reading.arm_velocities.iter_mut().zip(ids.arm.joints()) {
            *place = state.joint_velocity(joint);
        }
        for (place, &joint) in reading.finger_positions.iter_mut().zip(&ids.finger_joints) {
            *place = state.joint_position(joint);
        }
        for (place, &joint) in reading.finger_velocities.iter_mut().zip(&ids.finger_joints) {
            *place = state.joint_velocity(joint);
        }
        for (place, force) in reading
            .pad_forces_in_tcp
            .iter_mut()
            .zip(&self.finger_forces)
        {
            *place = tcp_from_world.rotation * force;
        }
        reading.base_from_tcp = state.world_from_site(ids.arm.tcp());
        reading.base_from_object = self.world_from_object;
        reading.region = state.world_from_body(ids.link) * self.link_from_region;
        reading.object_joint = state.joint_position(ids.object_joint);
        reading.touching = ids
            .fingers
            .iter()
            .any(|finger| state.are_touching(finger, &ids.region));
    }

    fn substep(&mut self, target: &ToolTarget, command: &RigCommand) -> Result<(), RigError> {
        self.begin_substep()?;
        let torques = self
            .servo
            .torques(&self.arm, target, &command.impedance, STEP_SECS)?;
        for (&actuator, &torque) in self.ids.arm_actuators.iter().zip(torques) {
            self.state.set_ctrl(actuator, torque);
        }
        self.end_substep()
    }

    /// Up to where the arm's torques are needed.
    fn begin_substep(&mut self) -> Result<(), RigError> {
        self.state.step1().map_err(|error| self.physics(error))?;
        self.ids.arm.read_into(&self.state, &mut self.arm);
        Ok(())
    }

    /// From there on: the fingers, the motion, and what it feels like.
    fn end_substep(&mut self) -> Result<(), RigError> {
        let force = self.largest_finger_force();
        let fingers = self.grip.step(self.opening(), force, STEP_SECS);
        self.set_fingers(fingers);
        self.state.step2().map_err(|error| self.physics(error))?;
        self.feel();
        let peak = self.largest_finger_force();
        self.reading.peak_force_n = self.reading.peak_force_n.max(peak);
        self.reading.limit_distance_rad =
            self.reading.limit_distance_rad.min(self.limit_distance());
        Ok(())
    }

    fn largest_finger_force(&self) -> f64 {
        let forces = self.finger_forces.iter().map(Vector3::norm);
        forces.fold(0.0, f64::max)
    }
}

impl Rig for TaskRig {
    type Error = RigError;

    fn anatomy(&self) -> &Anatomy {
        &self.anatomy
    }

    fn set_guard(&mut self, guard: GuardSpec) -> Result<(), RigError> {
        let arm = &self.robot.arm;
        let torque_max_nm = &arm.torque_max_nm;
        let speed_max = &arm.velocity_max_rad_per_s;
        let guard = JointGuard::new(guard, &self.anatomy.arm_limits, speed_max, torque_max_nm)?;
        self.servo = ToolServo::new(torque_max_nm, guard, self.arm.positions.clone());
        Ok(())
    }

    fn place(&mut self, placing: &Placing) -> Result<bool, RigError> {
        let wanted = self.anatomy.robot.n();
        if placing.q.len() != wanted {
            return Err(RigError::Size {
                found: placing.q.len(),
                wanted,
            });
        }
        self.state.reset().map_err(|error| self.physics(error))?;
        self.world_from_object = placing.base_from_object;
        self.state
            .set_mocap(self.ids.stand, &placing.base_from_object)
            .map_err(|error| self.physics(error))?;
        self.state
            .set_joint_position(self.ids.object_joint, placing.object_joint);
        let (lift, arm) = placing.q.split_at(wanted - self.ids.arm.joints().len());
        if let (Some((joint, actuator)), [height]) = (self.ids.lift, lift) {
            self.state.set_joint_position(joint, *height);
            self.state.set_ctrl(actuator, *height);
        }
        for (&joint, &q) in self.ids.arm.joints().iter().zip(arm) {
            self.state.set_joint_position(joint, q);
        }
        for (&joint, q) in self
            .ids
            .finger_joints
            .iter()
            .zip(self.scale.positions(placing.opening))
        {
            self.state.set_joint_position(joint, q);
        }
        self.set_fingers(placing.opening);
        self.state.forward().map_err(|error| self.physics(error))?;
        self.ids.arm.read_into(&self.state, &mut self.arm);
        self.servo.restart(&self.arm)?;
        for (&actuator, &torque) in self.ids.arm_actuators.iter().zip(&self.arm.bias) {
            self.state.set_ctrl(actuator, torque);
        }
        self.grip = GripperController::holding(placing.opening, self.task.episode.grip_force_n);
        self.feel();
        self.read();
        self.reading.peak_force_n = 0.0;
        self.reading.limit_distance_rad = self.limit_distance();
        let robot = &self.ids.robot_geoms;
        let touches = |contact: factotum_physics::Contact| {
            contact.distance_m <= 0.0
                && robot.contains(&contact.geom_a) != robot.contains(&contact.geom_b)
        };
        Ok(!self.state.contacts().any(touches))
    }

    fn step(&mut self, command: &RigCommand) -> Result<(), RigError> {
        let target = ToolTarget::at_rest(command.base_from_tcp);
        self.grip.set_goal(GripperGoal {
            opening: command.opening,
            force_n: self.task.episode.grip_force_n,
        })?;
        self.reading.peak_force_n = 0.0;
        self.reading.limit_distance_rad = f64::INFINITY;
        for _ in 0..self.n_substeps {
            self.substep(&target, command)?;
        }
        self.state
            .forward_kinematics()
            .map_err(|error| self.physics(error))?;
        self.read();
        Ok(())
    }

    fn reading(&self) -> &Reading {
        &self.reading
    }

    fn region_cloud(&mut self) -> Result<PointCloud, RigError> {
        let middle = self.reading.region;
        let to_robot = -Vector3::new(middle.x, middle.y, 0.0);
        cloud::region_cloud(
            &self.state,
            &self.ids.region,
            &self.ids.robot_bodies,
            middle,
            to_robot,
        )
        .map_err(|error| self.physics(error))
    }
}

fn misfit(task: &TaskSpec, field: &'static str, found: String, wanted: &str) -> RigError {
    RigError::Task {
        file: task.file.display().to_string(),
        field,
        found,
        wanted: wanted.to_owned(),
    }
}

fn compose(task: &TaskSpec, robot: &RobotDescription) -> Result<Model, PhysicsError> {
    let mut builder = SceneBuilder::new();
    builder.name(&format!("{} at {}", robot.name, task.name));
    builder.options(SceneOptions {
        timestep_secs: STEP_SECS,
        impratio: 20.0,
        visuals: false,
        ..SceneOptions::default()
    });
    attach_robot(&mut builder, robot, &AttachPoint::World(Pose::identity()))?;
    builder.add_shape(Shape {
        name: STAND.to_owned(),
        primitive: Primitive::Sphere { r: 0.001 },
        world_from_shape: Pose::identity(),
        rgba: [0.0; 4],
        collides: false,
        motion: Motion::Mocap,
    });
    let object = Some((&task.model, OBJECT));
    let surroundings = task.surroundings.as_ref().map(|file| (file, SURROUNDINGS));
    for (file, prefix) in object.into_iter().chain(surroundings) {
        let part = Part {
            file: file.clone(),
            prefix: prefix.to_owned(),
        };
        let at = AttachPoint::Frame {
            name: STAND.to_owned(),
            offset: Pose::identity(),
        };
        builder.attach(&part, &at, false)?;
    }
    builder.compile()
}

fn look_up(task: &TaskSpec, robot: &RobotDescription, model: &Model) -> Result<Ids, RigError> {
    let physics = |source| RigError::Physics {
        task: task.name.clone(),
        source,
    };
    let own = |names: Vec<String>| -> String {
        let names: Vec<String> = names
            .iter()
            .filter_map(|name| name.strip_prefix(OBJECT))
            .map(|name| format!("`{name}`"))
            .collect();
        names.join(", ")
    };
    let Ok(object_joint) = model.joint(&format!("{OBJECT}{}", task.joint)) else {
        let wanted = format!("a joint of its model: {}", own(model.joint_names()));
        return Err(misfit(task, "joint", format!("`{}`", task.joint), &wanted));
    };
    let link = model.joint_body(object_joint);
    let mut region = Vec::new();
    for name in &task.grasp_region {
        match model.geom(&format!("{OBJECT}{name}")) {
            Ok(geom) => region.push(geom),
            Err(_unknown) => {
                let wanted = format!("geoms of its model: {}", own(model.geom_names()));
                return Err(misfit(task, "grasp_region", format!("`{name}`"), &wanted));
            }
        }
    }
    if region.is_empty() {
        region = model.geoms_of_subtree(link);
    }
    let all = |names: &[String]| -> Result<Vec<JointId>, PhysicsError> {
        names.iter().map(|name| model.joint(name)).collect()
    };
    let drives = |names: &[String]| -> Result<Vec<ActuatorId>, PhysicsError> {
        names.iter().map(|name| model.actuator(name)).collect()
    };
    let arm_joints = all(&robot.arm.joints).map_err(physics)?;
    let tcp = model.site(&robot.arm.tcp_site).map_err(physics)?;
    let gripper = robot.gripper.as_ref();
    let (joints, actuators, pads) = gripper.map_or((&[][..], &[][..], &[][..]), |gripper| {
        (
            &gripper.joints[..],
            &gripper.actuators[..],
            &gripper.pads[..],
        )
    });
    let fingers = pads
        .iter()
        .map(|name| Ok(model.geoms_of_body(model.geom_body(model.geom(name)?))))
        .collect::<Result<Vec<_>, _>>()
        .map_err(physics)?;
    let lift = robot
        .lift
        .as_ref()
        .map(|lift| Ok((model.joint(&lift.joint)?, model.actuator(&lift.actuator)?)))
        .transpose()
        .map_err(physics)?;
    let stand = model.body(STAND).map_err(physics)?;
    let object_bodies = model.bodies_of_subtree(stand);
    let robot_bodies: Vec<BodyId> = model
        .bodies()
        .filter(|body| *body != BodyId::WORLD && !object_bodies.contains(body))
        .collect();
    let robot_geoms = robot_bodies
        .iter()
        .flat_map(|&body| model.geoms_of_body(body))
        .collect();
    Ok(Ids {
        stand,
        robot_geoms,
        robot_bodies,
        arm: ModelArm::new(model, arm_joints, tcp),
        arm_actuators: drives(&robot.arm.actuators).map_err(physics)?,
        lift,
        finger_joints: all(joints).map_err(physics)?,
        finger_actuators: drives(actuators).map_err(physics)?,
        fingers,
        object_joint,
        link,
        region,
    })
}

/// How the object's joint moves its link, in Λ; the object stands at the origin.
fn object_joint(
    task: &TaskSpec,
    model: &Model,
    state: &State,
    ids: &Ids,
    range: Option<[f64; 2]>,
) -> ObjectJoint {
    let joint = ids.object_joint;
    let stand = state.world_from_body(ids.stand).inverse();
    ObjectJoint {
        name: task.joint.clone(),
        kind: match model.joint_kind(joint) {
            factotum_physics::JointKind::Slide => JointKind::Prismatic,
            _ => JointKind::Revolute,
        },
        axis: (stand.rotation * state.joint_axis_in_world(joint)).into(),
        origin: (stand * state.joint_anchor_in_world(joint)).into(),
        range: range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]),
        link: model.body_name(ids.link).to_owned(),
    }
}
