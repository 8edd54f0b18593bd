//! The worlds that the tests run in.

use std::path::{Path, PathBuf};

use factotum_control::{Command, MotionStatus, Robot, send_and_wait};
use factotum_descriptions::{JointTrajectory, RobotDescription, TrajectoryPoint};
use factotum_worlds::{Fault, HomeScene, Noise, SimRobot, WorldConfig};

pub(crate) fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets")
}

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

pub(crate) fn with_fault(seed: u64, fault: Fault) -> SimRobot {
    SimRobot::new(WorldConfig {
        fault: Some(fault),
        ..config(seed)
    })
    .unwrap()
}

/// Runs a command to its end.
pub(crate) fn run(robot: &mut SimRobot, command: Command, timeout_secs: f64) -> MotionStatus {
    send_and_wait(robot, command, timeout_secs, &mut |_| Ok(true)).unwrap()
}

/// A smooth trajectory of arm and lift from where they are: cubic, at rest at both ends.
pub(crate) fn move_to(
    robot: &mut SimRobot,
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
