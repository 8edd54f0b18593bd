//! Grasps hold in physics: every shipped robot and another maker's, every movable class, every grasp of it that fits the
//! hand.
//!
//! The object stands on a support, the fingers close by their own drives, the support goes. Then the object is held for
//! 10 s, shaken 5 cm at 1 Hz along each axis of the tool, and pulled with 20 N both ways along each. The robot stands on
//! a carriage that does the shaking; it is weightless, so that any posture will do, and only the object is heavy.
//!
//! Slip is what the object moves in the tool frame. Where the pull is all that the fingers' drives can give, the fingers
//! yield to it along the closing axis, and slip is what the object moves beside them.

use std::path::{Path, PathBuf};

use factotum_control::GripperGoal;
use factotum_control::composition::attach_robot;
use factotum_descriptions::{Grasp, ObjectClass, RobotDescription};
use factotum_geometry::Pose;
use factotum_motion::grasps::fit_grasp;
use factotum_motion::{ObstacleShape, RobotModel};
use factotum_physics::{
    ActuatorId, AttachOptions, AttachPoint, BodyId, GeomId, JointId, Motion, Part, Primitive,
    SceneBuilder, SceneOptions, Shape, SiteId, State,
};
use nalgebra::{DMatrix, DVector, Point3, Vector3};

use super::{GripControl, GripperScale};
use crate::assembly::STEP_SECS;

const SLIP_MAX_M: f64 = 0.003;
const HOLD_SECS: f64 = 10.0;
const SHAKE_M: f64 = 0.05;
const SHAKE_HZ: f64 = 1.0;
const PULL_N: f64 = 20.0;
const GRAVITY: f64 = 9.81;
/// Phases of pulling along the closing axis.
const PULLED_TO_CLOSE: [&str; 2] = ["pulled +x", "pulled -x"];
/// Where things are that are not in use yet.
const FAR_BELOW_M: f64 = -50.0;

/// A heavy slab on three stiff slides.
const CARRIAGE: &str = r#"<mujoco><worldbody><body name="carriage">
    <inertial pos="0 0 0" mass="2000" diaginertia="100 100 100"/>
    <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
    <joint name="z" type="slide" axis="0 0 1"/><site name="mount"/>
  </body></worldbody><actuator>
    <position name="x" joint="x" kp="2e7" kv="4e5"/><position name="y" joint="y" kp="2e7" kv="4e5"/>
    <position name="z" joint="z" kp="2e7" kv="4e5"/>
  </actuator></mujoco>"#;

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets")
}

/// The most that what was held at first moved.
#[derive(Debug, Clone, Copy, Default)]
struct Moved {
    /// In the tool frame, metres.
    in_hand_m: f64,
    /// From the middle between the pads, metres.
    beside_fingers_m: f64,
    turn_rad: f64,
}

/// A robot, an object, and the laboratory around them.
struct Bench {
    state: State,
    carriage: [ActuatorId; 3],
    arm: Vec<(JointId, ActuatorId, f64)>,
    fingers: Vec<JointId>,
    drives: Vec<(ActuatorId, f64, f64)>,
    pads: Vec<GeomId>,
    scale: GripperScale,
    grip: GripControl,
    tcp: SiteId,
    object: BodyId,
    mass_kg: f64,
    /// Force on the object beside its weight, N.
    pull_n: Vector3<f64>,
    down: Vector3<f64>,
    support: BodyId,
}

impl Bench {
    /// The object on its support, where the tool is, the fingers open.
    fn new(robot: &RobotDescription, class: &ObjectClass, grasp: &Grasp) -> Self {
        let gripper = robot.gripper.as_ref().unwrap();
        let mut scene = SceneBuilder::new();
        scene.options(SceneOptions {
            timestep_secs: STEP_SECS,
            gravity: [0.0; 3],
            visuals: false,
            ..SceneOptions::default()
        });
        let world = AttachPoint::World(Pose::identity());
        let plain = AttachOptions::default();
        scene
            .attach_text("carriage", CARRIAGE, "carriage/", &world, &plain)
            .unwrap();
        let mount = AttachPoint::Frame {
            name: "carriage/mount".to_owned(),
            offset: Pose::identity(),
        };
        attach_robot(&mut scene, robot, &mount).unwrap();
        let part = Part {
            file: class.model.clone(),
            prefix: "object/".to_owned(),
        };
        scene.attach(&part, &world, true).unwrap();
        scene.add_shape(Shape {
            name: "support".to_owned(),
            primitive: Primitive::Box {
                half: [0.03, 0.03, 0.01],
            },
            world_from_shape: Pose::translation(0.0, 0.0, FAR_BELOW_M),
            rgba: [0.5, 0.5, 0.5, 1.0],
            collides: true,
            motion: Motion::Mocap,
        });
        let model = scene.compile().unwrap();
        let names = ["carriage/x", "carriage/y", "carriage/z"];
        let arm = &robot.arm;
        let arm = arm.joints.iter().zip(&arm.actuators).zip(&arm.ready);
        let object = model
            .bodies()
            .find(|&body| model.body_name(body).starts_with("object/"))
            .unwrap();
        let scale = GripperScale::measure(robot, &model).unwrap().unwrap();
        let ends = gripper.closed.iter().zip(&gripper.open);
        let mut bench = Self {
            carriage: names.map(|name| model.actuator(name).unwrap()),
            arm: arm
                .map(|((joint, motor), &at)| {
                    (
                        model.joint(joint).unwrap(),
                        model.actuator(motor).unwrap(),
                        at,
                    )
                })
                .collect(),
            fingers: all(&gripper.joints, |name| model.joint(name).unwrap()),
            drives: gripper
                .actuators
                .iter()
                .zip(ends)
                .map(|(name, (&closed, &open))| (model.actuator(name).unwrap(), closed, open))
                .collect(),
            pads: all(&gripper.pads, |name| model.geom(name).unwrap()),
            grip: GripControl::new(1.0, gripper.force_max_n),
            scale,
            tcp: model.site(&robot.arm.tcp_site).unwrap(),
            object,
            mass_kg: model.body_mass(object),
            pull_n: Vector3::zeros(),
            down: Vector3::zeros(),
            support: model.body("support").unwrap(),
            state: State::new(&model).unwrap(),
        };
        let far = Pose::translation(1.0, 0.0, FAR_BELOW_M);
        bench.state.set_free_body_pose(object, &far).unwrap();
        for &(joint, _, at) in &bench.arm {
            bench.state.set_joint_position(joint, at);
        }
        bench.run(1.5, |_, _| {});
        // The object comes to the tool, as the grasp says.
        let world_from_object = bench.world_from_tcp() * grasp.object_from_tcp().inverse();
        let below = Pose::translation(0.0, 0.0, -0.0101);
        bench
            .state
            .set_free_body_pose(object, &world_from_object)
            .unwrap();
        bench
            .state
            .set_mocap(bench.support, &(world_from_object * below))
            .unwrap();
        bench.down = -(world_from_object.rotation * Vector3::z());
        bench
    }

    fn world_from_tcp(&self) -> Pose {
        self.state.world_from_site(self.tcp)
    }

    fn tcp_from_object(&self) -> Pose {
        self.world_from_tcp().inverse() * self.state.world_from_body(self.object)
    }

    /// The middle between the pads, in the tool frame.
    fn middle_of_pads(&self) -> Vector3<f64> {
        let tcp_from_world = self.world_from_tcp().inverse();
        let places = self.pads.iter().map(|&pad| {
            (tcp_from_world * self.state.world_from_geom(pad))
                .translation
                .vector
        });
        places.sum::<Vector3<f64>>() / self.pads.len() as f64
    }

    /// Steps for a time; `drive` may set the carriage and the pull, and learns the time since the beginning.
    fn run(&mut self, secs: f64, mut drive: impl FnMut(&mut Self, f64)) -> Moved {
        let before = self.tcp_from_object();
        let fingers_before = self.middle_of_pads();
        let held = before.inverse() * Point3::origin();
        let start_secs = self.state.time_secs();
        let mut moved = Moved::default();
        while self.state.time_secs() - start_secs < secs {
            let since = self.state.time_secs() - start_secs;
            drive(self, since);
            self.step();
            let now = self.tcp_from_object();
            let way = (now * held).coords;
            let fingers = self.middle_of_pads() - fingers_before;
            moved.in_hand_m = moved.in_hand_m.max(way.norm());
            moved.beside_fingers_m = moved.beside_fingers_m.max((way - fingers).norm());
            let turn_rad = now.rotation.angle_to(&before.rotation);
            moved.turn_rad = moved.turn_rad.max(turn_rad);
        }
        moved
    }

    fn step(&mut self) {
        // 1. The object's weight and what pulls at it.
        let force = self.down * (self.mass_kg * GRAVITY) + self.pull_n;
        self.state.xfrc_applied_mut(self.object)[..3].copy_from_slice(force.as_slice());
        // 2. The arm's motors hold its posture.
        self.hold_posture();
        // 3. The fingers, as the simulated robot drives them.
        let positions: Vec<f64> = self
            .fingers
            .iter()
            .map(|&joint| self.state.joint_position(joint))
            .collect();
        let opening = self.scale.opening(positions.into_iter());
        let pads: Vec<f64> = self
            .pads
            .iter()
            .map(|&pad| self.state.contact_force_on(&[pad]).norm())
            .collect();
        let now_secs = self.state.time_secs();
        let (target, _) = self.grip.step(now_secs, opening, &pads, STEP_SECS);
        for &(drive, closed, open) in &self.drives {
            self.state
                .set_ctrl(drive, closed + target * (open - closed));
        }
        self.state.step().unwrap();
    }

    /// Computed torque about the posture.
    fn hold_posture(&mut self) {
        const STIFFNESS_RAD_PER_S: f64 = 60.0;
        let model = self.state.model().clone();
        let dofs: Vec<usize> = self
            .arm
            .iter()
            .map(|&(joint, ..)| model.dof_adr(joint))
            .collect();
        let mut wanted = DVector::zeros(model.n_v());
        for (&(joint, _, at), &dof) in self.arm.iter().zip(&dofs) {
            let off = at - self.state.joint_position(joint);
            let speed = self.state.joint_velocity(joint);
            wanted[dof] = STIFFNESS_RAD_PER_S.powi(2) * off - 2.0 * STIFFNESS_RAD_PER_S * speed;
        }
        let mut mass = DMatrix::zeros(0, 0);
        self.state.mass_matrix_into(&mut mass);
        let torques = mass * wanted;
        for (&(_, motor, _), &dof) in self.arm.iter().zip(&dofs) {
            let bias = self.state.bias_forces()[dof];
            self.state.set_ctrl(motor, torques[dof] + bias);
        }
    }

    /// Closes the fingers and takes the support away.
    fn grasp(&mut self, force_n: f64) {
        let goal = GripperGoal {
            opening: 0.0,
            force_n,
        };
        self.grip.controller.set_goal(goal).unwrap();
        self.run(2.0, |_, _| {});
        let away = Pose::translation(0.0, 0.0, FAR_BELOW_M);
        self.state.set_mocap(self.support, &away).unwrap();
    }

    fn tool_axes(&self) -> [Vector3<f64>; 3] {
        let rotation = self.world_from_tcp().rotation;
        [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| rotation * axis)
    }

    fn shake(&mut self, axis: Vector3<f64>) -> Moved {
        let start = self.world_from_tcp().translation.vector;
        let mut way_m = 0.0_f64;
        let moved = self.run(3.0, |bench, secs| {
            let size = SHAKE_M * secs.min(1.0) * (std::f64::consts::TAU * SHAKE_HZ * secs).sin();
            for (drive, along) in bench.carriage.into_iter().zip(axis.iter()) {
                bench.state.set_ctrl(drive, size * along);
            }
            let way = bench.world_from_tcp().translation.vector - start;
            way_m = way_m.max(way.norm());
        });
        assert!(
            way_m > 0.9 * SHAKE_M,
            "the hand was shaken by {way_m} m only"
        );
        moved
    }

    fn pull(&mut self, axis: Vector3<f64>) -> Moved {
        let moved = self.run(1.0, |bench, secs| {
            bench.pull_n = axis * (PULL_N * (2.0 * secs).min(1.0));
        });
        self.pull_n = Vector3::zeros();
        self.run(0.3, |_, _| {});
        moved
    }
}

fn all<T>(names: &[String], find: impl Fn(&str) -> T) -> Vec<T> {
    names.iter().map(|name| find(name)).collect()
}

fn movable_classes() -> Vec<ObjectClass> {
    let mut folders: Vec<PathBuf> = std::fs::read_dir(assets().join("objects"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    folders.sort();
    folders
        .iter()
        .map(|folder| ObjectClass::load(folder).unwrap())
        .filter(|class| class.movable)
        .collect()
}

#[expect(
    clippy::print_stdout,
    reason = "the figures, for whoever asks with --nocapture"
)]
fn check(robot: &RobotDescription) {
    let force_max_n = robot.gripper.as_ref().unwrap().force_max_n;
    let classes = movable_classes();
    assert!(!classes.is_empty());
    let mut bad = Vec::new();
    let model = RobotModel::load(robot).unwrap();
    for class in &classes {
        let shape = ObstacleShape::Model {
            file: class.model.clone(),
            joint_positions: Vec::new(),
        };
        let fitting: Vec<Grasp> = class
            .grasps
            .iter()
            .filter_map(|grasp| fit_grasp(&model, &shape, grasp).unwrap())
            .collect();
        assert!(fitting.len() >= 2, "{}: {fitting:?}", class.name);
        for grasp in &fitting {
            let mut bench = Bench::new(robot, class, grasp);
            bench.grasp(force_max_n);
            let mut phases = vec![("held", bench.run(HOLD_SECS, |_, _| {}))];
            for (name, axis) in ["shaken x", "shaken y", "shaken z"]
                .into_iter()
                .zip(bench.tool_axes())
            {
                phases.push((name, bench.shake(axis)));
            }
            for (names, axis) in [
                PULLED_TO_CLOSE,
                ["pulled +y", "pulled -y"],
                ["pulled +z", "pulled -z"],
            ]
            .into_iter()
            .zip(bench.tool_axes())
            {
                for (name, sign) in names.into_iter().zip([1.0, -1.0]) {
                    phases.push((name, bench.pull(axis * sign)));
                }
            }
            for (phase, moved) in phases {
                let fingers_yield = force_max_n <= PULL_N && PULLED_TO_CLOSE.contains(&phase);
                let slip_m = if fingers_yield {
                    moved.beside_fingers_m
                } else {
                    moved.in_hand_m
                };
                let line = format!(
                    "{} {} {}, {phase}: {:.2} mm in the hand, {:.2} mm beside the fingers, {:.2} deg",
                    robot.name,
                    class.name,
                    grasp.name,
                    moved.in_hand_m * 1e3,
                    moved.beside_fingers_m * 1e3,
                    moved.turn_rad.to_degrees()
                );
                println!("{line}");
                if slip_m >= SLIP_MAX_M {
                    bad.push(line);
                }
            }
        }
    }
    assert!(
        bad.is_empty(),
        "slipped by {SLIP_MAX_M} m or more: {bad:#?}"
    );
}

fn shipped(name: &str) -> RobotDescription {
    RobotDescription::load(&assets().join("robots").join(name)).unwrap()
}

#[test]
fn movo_holds() {
    check(&shipped("movo"));
}

#[test]
fn jaco_holds() {
    check(&shipped("jaco"));
}

#[test]
fn panda_holds() {
    check(&shipped("panda"));
}

#[test]
fn iiwa7_holds() {
    check(&shipped("iiwa7"));
}

#[test]
fn movo_panda_holds() {
    check(&shipped("movo_panda"));
}

/// The robot of the tutorial, with robosuite's own models where they are: FACTOTUM_ROBOSUITE_DIR names the folder
/// `robosuite` of a wheel that is not in `.deps`.
#[test]
#[expect(clippy::print_stdout, reason = "a skipped test says why")]
fn robosuite_panda_holds() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let variable = "FACTOTUM_ROBOSUITE_DIR";
    let robosuite = std::env::var_os(variable)
        .map_or_else(|| root.join(".deps/robosuite/robosuite"), PathBuf::from);
    if !robosuite.is_dir() {
        println!("skipped: `.deps/robosuite` is absent (cargo x models) and {variable} is not set");
        return;
    }
    let tutorial = root.join("docs/tutorials/robosuite_panda/robot.toml");
    let text = std::fs::read_to_string(tutorial)
        .unwrap()
        .replace(
            "../../../.deps/robosuite/robosuite",
            &robosuite.display().to_string(),
        )
        .replace("../../../assets", &assets().display().to_string());
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("robot.toml"), text).unwrap();
    check(&RobotDescription::load(dir.path()).unwrap());
}
