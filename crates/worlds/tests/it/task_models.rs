//! The objects of the contact tasks: what they weigh, how they move, and whether the robot reaches them.

use std::f64::consts::PI;

use factotum_control::composition::attach_robot;
use factotum_descriptions::{RobotDescription, TaskSpec};
use factotum_motion::{
    IkOptions, IkPreference, Obstacle, ObstacleShape, PlanningScene, RobotModel, solve_ik_many,
};
use factotum_physics::{AttachPoint, GeomId, JointId, Part, Pose, SceneBuilder, State};
use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::fixture::assets;

fn load(name: &str) -> TaskSpec {
    TaskSpec::load(&assets().join(format!("tasks/{name}.toml"))).unwrap()
}

const TASKS: [&str; 5] = ["door", "drawer", "slide", "lever", "faucet"];

/// Where in the range of x, y, z and yaw an object is put.
const PLACEMENTS: [[f64; 4]; 5] = [
    [0.5, 0.5, 0.5, 0.5],
    [0.0, 0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0, 1.0],
    [0.0, 1.0, 1.0, 0.0],
    [1.0, 1.0, 1.0, 1.0],
];

/// The robot in its ready posture, before the object.
struct Scene {
    state: State,
    /// The joint to move.
    joint: JointId,
    /// What is grasped.
    handle: GeomId,
    robot: RobotDescription,
}

impl Scene {
    fn new(task: &TaskSpec, base_from_object: Pose) -> Self {
        let robot = RobotDescription::load(&task.robot).unwrap();
        let mut scene = SceneBuilder::new();
        scene.impratio(20.0);
        attach_robot(&mut scene, &robot, &AttachPoint::World(Pose::identity())).unwrap();
        let object = Part {
            file: task.model.clone(),
            prefix: "object/".to_owned(),
        };
        scene
            .attach(&object, &AttachPoint::World(base_from_object), false)
            .unwrap();
        let model = scene.compile().unwrap();
        let named = |name: &str| format!("object/{name}");
        let mut scene = Self {
            state: State::new(&model).unwrap(),
            joint: model.joint(&named(&task.joint)).unwrap(),
            handle: model.geom(&named(&task.grasp_region[0])).unwrap(),
            robot,
        };
        scene.set_arm(&scene.robot.arm.ready.clone());
        scene.set_joint(task.start);
        scene
    }

    fn set_arm(&mut self, q: &[f64]) {
        for (name, q) in self.robot.arm.joints.iter().zip(q) {
            let joint = self.state.model().joint(name).unwrap();
            self.state.set_joint_position(joint, *q);
        }
    }

    fn set_joint(&mut self, position: f64) {
        self.state.set_joint_position(self.joint, position);
        self.state.forward().unwrap();
    }

    fn handle_point(&self) -> Vector3<f64> {
        self.state.world_from_geom(self.handle).translation.vector
    }

    /// Acceleration of the joint from rest under a force or torque on it.
    fn acceleration(&mut self, force: f64) -> f64 {
        let dof = self.state.model().dof_adr(self.joint);
        self.state.qfrc_applied_mut()[dof] = force;
        self.state.forward().unwrap();
        self.state.qacc()[dof]
    }
}

#[test]
fn objects_weigh_what_their_sources_say() {
    for (name, mass_kg) in [
        ("door", 2.5346),
        ("drawer", 11.78),
        // A little less than published, for the clearance: 0.1480.
        ("slide", 0.1465),
        ("lever", 0.2410),
        ("faucet", 0.27),
    ] {
        let task = load(name);
        let scene = Scene::new(&task, task.placement.at(PLACEMENTS[0]));
        let model = scene.state.model();
        let moving = model.bodies_of_subtree(model.joint_body(scene.joint));
        let found: f64 = moving.iter().map(|&body| model.body_mass(body)).sum();
        assert!((found - mass_kg).abs() < 1e-4, "{name}: {found} kg");
        let [low, high] = model.joint_range(scene.joint).unwrap();
        assert!(low <= task.start && task.goal < high, "{name}");
    }
}

#[test]
fn nothing_touches_before_the_robot_moves() {
    for name in TASKS {
        let task = load(name);
        for shares in PLACEMENTS {
            let mut scene = Scene::new(&task, task.placement.at(shares));
            for step in 0..=10 {
                let share = f64::from(step) / 10.0;
                scene.set_joint(task.start + share * (task.goal - task.start));
                assert_eq!(scene.state.n_contacts(), 0, "{name} {shares:?} at {share}");
            }
        }
    }
}

/// Whither the handle moves in the base frame, in the middle of the placements.
#[test]
fn joints_move_the_handle_where_they_should() {
    for (name, towards) in [
        ("door", Vector3::y()),
        ("drawer", Vector3::y()),
        ("slide", -Vector3::x()),
        ("lever", Vector3::z()),
        ("faucet", -Vector3::x()),
    ] {
        let task = load(name);
        let mut scene = Scene::new(&task, task.placement.at(PLACEMENTS[0]));
        let before = scene.handle_point();
        scene.set_joint(task.start + 0.1 * (task.goal - task.start));
        let moved = (scene.handle_point() - before).normalize();
        assert!(moved.dot(&towards) > 0.9, "{name}: {moved}");
    }
}

/// From rest, by the published masses, frictions and inertias.
#[test]
fn joints_resist_as_their_sources_say() {
    let at_start = |name: &str| {
        let task = load(name);
        Scene::new(&task, task.placement.at(PLACEMENTS[0]))
    };
    let close = |found: f64, wanted: f64| (found - wanted).abs() < 0.02 * wanted.abs();
    // 11.78 kg against 1 N of friction.
    let drawer = at_start("drawer").acceleration(11.0);
    assert!(close(drawer, 10.0 / 11.78), "{drawer} m/s²");
    let slide = at_start("slide").acceleration(0.5);
    assert!(close(slide, 0.5 / 0.1465), "{slide} m/s²");
    // The leaf about the hinge, by the parallel axes, and the handle.
    let inertia = 0.0437 + 2.43455 * 0.2253_f64.powi(2) + 0.0166;
    let door = at_start("door").acceleration(0.5);
    assert!(close(door, 0.5 / inertia), "{door} rad/s²");
    // Raised a little, off its stop, the lever falls by its weight alone.
    let mut lever = at_start("lever");
    lever.set_joint(0.1);
    let rod = 0.10603 * 0.15_f64.powi(2) / 3.0;
    let bar = 0.135 * (0.225_f64.powi(2) + 0.15_f64.powi(2) / 12.0);
    let weight = (0.10603 * 0.075 + 0.135 * 0.225) * 9.81 * 0.1_f64.cos();
    let lever = lever.acceleration(0.0);
    assert!(close(lever, -weight / (rod + bar)), "{lever} rad/s²");
    // The tap's friction takes 0.3 N m from what moves it. Of what is less it holds nine tenths at first, as MuJoCo's
    // friction does.
    let mut faucet = at_start("faucet");
    faucet.set_joint(0.4);
    let [held, once, twice] = [0.25, 0.8, 1.3].map(|torque| faucet.acceleration(torque));
    assert!(close(once, twice - once), "{once} and {twice} rad/s²");
    let without_friction = 0.25 * once / 0.5;
    assert!(close(held, 0.1 * without_friction), "{held} rad/s²");
}

/// A way to hold the handle, by the axes of its geom: the hand across a bar, or over the knob of the slide.
fn handle_from_tcp(name: &str) -> UnitQuaternion<f64> {
    let (bar, turn_rad) = match name {
        "door" => (Vector3::y(), 5.0 * PI / 3.0),
        "drawer" => (Vector3::z(), 11.0 * PI / 6.0),
        "slide" => return UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI),
        "lever" => (Vector3::y(), 7.0 * PI / 6.0),
        "faucet" => (Vector3::y(), 5.0 * PI / 6.0),
        other => panic!("no task {other}"),
    };
    let across = UnitQuaternion::rotation_between(&Vector3::y(), &bar).unwrap();
    across * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), turn_rad)
}

/// Least distance of a joint to its limits.
fn limit_margin_rad(robot: &RobotModel, q: &[f64]) -> f64 {
    let to_limits = robot.limits().iter().zip(q);
    to_limits
        .map(|(limit, q)| (q - limit.lower).min(limit.upper - q))
        .fold(f64::INFINITY, f64::min)
}

/// Arm postures along the joint's way, start and goal included.
type Way = Vec<Vec<f64>>;

/// Ways to hold the handle from start to goal, with either finger on either side: postures free of collision, each near
/// the one before, at least 0.3 rad from all limits.
fn ways(task: &TaskSpec, grasp: UnitQuaternion<f64>, base_from_object: Pose) -> Vec<Way> {
    let half_turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), PI);
    let sides = [grasp, grasp * half_turn];
    sides
        .iter()
        .flat_map(|grasp| ways_of_one_side(task, *grasp, base_from_object))
        .collect()
}

fn ways_of_one_side(
    task: &TaskSpec,
    grasp: UnitQuaternion<f64>,
    base_from_object: Pose,
) -> Vec<Way> {
    const N_STEPS: usize = 6;
    const MARGIN_RAD: f64 = 0.3;
    const STEP_RAD: f64 = 0.6;
    let robot = RobotModel::load(&RobotDescription::load(&task.robot).unwrap()).unwrap();
    let mut scene = Scene::new(task, base_from_object);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut ways: Vec<Way> = Vec::new();
    for step in 0..=N_STEPS {
        let position = task.start + step as f64 / N_STEPS as f64 * (task.goal - task.start);
        scene.set_joint(position);
        let tcp = scene.state.world_from_geom(scene.handle) * grasp;
        let obstacle = Obstacle {
            name: "object".to_owned(),
            shape: ObstacleShape::Model {
                file: task.model.clone(),
                joint_positions: vec![(task.joint.clone(), position)],
            },
            base_from_obstacle: base_from_object,
        };
        let mut planning = PlanningScene::new(&robot, &[obstacle], None).unwrap();
        let mut solve = |seed: &[f64], restarts: usize, n_wanted: usize| {
            let options = IkOptions {
                restarts,
                prefer: IkPreference::First,
                ..IkOptions::default()
            };
            let seeds = [seed.to_vec()];
            let mut found =
                solve_ik_many(&mut planning, &tcp, &seeds, &options, n_wanted, &mut rng);
            found.retain(|q| limit_margin_rad(&robot, q) > MARGIN_RAD);
            found
        };
        if step == 0 {
            let found = solve(&robot.q_ready(), 40, 12);
            ways = found.into_iter().map(|q| vec![q]).collect();
            continue;
        }
        ways.retain_mut(|way| {
            let last = &way[step - 1];
            let next = solve(last, 0, 1)
                .pop()
                .filter(|next| last.iter().zip(next).all(|(a, b)| (a - b).abs() < STEP_RAD));
            way.extend(next);
            way.len() == step + 1
        });
    }
    ways
}

#[test]
fn the_arm_can_hold_each_handle_from_start_to_goal() {
    for name in TASKS {
        let task = load(name);
        for shares in PLACEMENTS {
            let n = ways(&task, handle_from_tcp(name), task.placement.at(shares)).len();
            assert!(n >= 2, "{name} {shares:?}: {n} ways");
        }
    }
}

/// The fingers close about the handle and the arm, a stiff servo in its joints, follows the way: the joint comes along.
#[test]
fn a_closed_hand_takes_each_handle_to_its_goal() {
    const SECS: f64 = 3.0;
    for name in TASKS {
        let task = load(name);
        let base_from_object = task.placement.at(PLACEMENTS[0]);
        let way = ways(&task, handle_from_tcp(name), base_from_object)
            .into_iter()
            .next()
            .unwrap();
        let mut scene = Scene::new(&task, base_from_object);
        scene.set_arm(&way[0]);
        let gripper = scene.robot.gripper.clone().unwrap();
        let model = scene.state.model().clone();
        for joint in &gripper.joints {
            let joint = model.joint(joint).unwrap();
            scene.state.set_joint_position(joint, gripper.open[0]);
        }
        scene.set_joint(task.start);
        let grip = model.actuator(&gripper.actuators[0]).unwrap();
        scene.state.set_ctrl(grip, gripper.closed[0]);
        let arm = scene.robot.arm.clone();
        let dt = model.timestep_secs();
        let n_steps = (SECS / dt) as usize;
        for step in 0..n_steps {
            // Half a second to close, two to move, and half a second at the end.
            let share = ((step as f64 * dt - 0.5) / (SECS - 1.0)).clamp(0.0, 1.0);
            let along = share * (way.len() - 1) as f64;
            let first = (along as usize).min(way.len() - 2);
            let part = along - first as f64;
            for (k, (joint, actuator)) in arm.joints.iter().zip(&arm.actuators).enumerate() {
                let joint = model.joint(joint).unwrap();
                let actuator = model.actuator(actuator).unwrap();
                let wanted = way[first][k] * (1.0 - part) + way[first + 1][k] * part;
                let error = wanted - scene.state.joint_position(joint);
                let bias = scene.state.bias_forces()[model.dof_adr(joint)];
                let torque = bias + 800.0 * error - 50.0 * scene.state.joint_velocity(joint);
                let most = arm.torque_max_nm[k];
                scene.state.set_ctrl(actuator, torque.clamp(-most, most));
            }
            scene.state.step().unwrap();
        }
        let share =
            (scene.state.joint_position(scene.joint) - task.start) / (task.goal - task.start);
        assert!(share > 0.9, "{name}: {share} of the way");
    }
}
