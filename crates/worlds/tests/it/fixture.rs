//! The worlds that the tests run in.

use std::path::{Path, PathBuf};

use factotum_control::{ArmDynamics, BasePath, Command, MotionStatus, Robot, send_and_wait};
use factotum_descriptions::{JointTrajectory, RobotDescription, TrajectoryPoint};
use factotum_geometry::{Pose, Pose2};
use factotum_worlds::{HomeScene, Noise, SimRobot, WorldConfig};
use nalgebra::Vector2;

pub(crate) fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets")
}

/// Movo in the household with perfect senses.
pub(crate) fn config(seed: u64) -> WorldConfig {
    WorldConfig {
        robot: RobotDescription::load(&assets().join("robots/movo")).unwrap(),
        scene: HomeScene::load(&assets().join("scenes/household")).unwrap(),
        seed,
        noise: Noise::none(),
        fault: None,
    }
}

pub(crate) fn household(seed: u64) -> SimRobot {
    SimRobot::new(config(seed)).unwrap()
}

/// The household with the robot starting at a pose.
pub(crate) fn starting_at(config: WorldConfig, x: f64, y: f64, yaw: f64) -> SimRobot {
    let scene = config.scene.clone().with_start(pose(x, y, yaw));
    SimRobot::new(WorldConfig { scene, ..config }).unwrap()
}

pub(crate) fn pose(x: f64, y: f64, yaw: f64) -> Pose2 {
    Pose2::new(Vector2::new(x, y), yaw)
}

/// Runs a command to its end.
pub(crate) fn run(robot: &mut dyn Robot, command: Command, timeout_secs: f64) -> MotionStatus {
    send_and_wait(robot, command, timeout_secs, &mut |_| Ok(true)).unwrap()
}

/// Runs a command that must be done.
pub(crate) fn must(robot: &mut dyn Robot, command: Command) {
    let what = format!("{command:?}");
    let what: String = what.chars().take(60).collect();
    assert_eq!(run(robot, command, 30.0), MotionStatus::Done, "{what}");
}

/// A smooth trajectory of arm and lift from where they are: cubic, at rest at both ends.
pub(crate) fn move_to(
    robot: &mut dyn Robot,
    lift_m: f64,
    arm: &[f64],
    secs: f64,
) -> JointTrajectory {
    let state = robot.state().unwrap();
    let description = robot.description().clone();
    let mut joints = vec![description.lift.unwrap().joint];
    joints.extend(description.arm.joints);
    let chain = |lift_m: f64, arm: &[f64]| {
        let mut positions = vec![lift_m];
        positions.extend_from_slice(arm);
        positions
    };
    let n = joints.len();
    let point = |time_secs: f64, positions: Vec<f64>| TrajectoryPoint {
        time_secs,
        positions,
        velocities: vec![0.0; n],
    };
    let points = vec![
        point(0.0, chain(state.lift_m, &state.arm_positions)),
        point(secs, chain(lift_m, arm)),
    ];
    JointTrajectory::new(joints, points).unwrap()
}

/// Tool pose in the base frame, by the robot's own model.
pub(crate) fn base_from_tcp(robot: &mut dyn Robot) -> Pose {
    let state = robot.state().unwrap();
    let mut dynamics = ArmDynamics::new(robot.description()).unwrap();
    dynamics
        .base_from_tcp(state.lift_m, &state.arm_positions)
        .unwrap()
}

/// A straight path to a pose in the odometry frame.
pub(crate) fn path_to(x: f64, y: f64, yaw: f64) -> Command {
    Command::BasePath(BasePath {
        odom_from_base: vec![pose(x, y, yaw)],
        speed: 1.0,
    })
}
