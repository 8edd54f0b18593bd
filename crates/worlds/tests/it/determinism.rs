//! The same seed and the same commands give the same bytes.

use factotum_control::{Command, GripperGoal, Robot as _, RobotState};
use factotum_geometry::sensing::{DepthFrame, LaserScan};
use factotum_worlds::{Noise, SimRobot, WorldConfig};

use crate::fixture::{config, move_to, path_to};

fn noisy(seed: u64) -> SimRobot {
    SimRobot::new(WorldConfig {
        noise: Noise::default(),
        ..config(seed)
    })
    .unwrap()
}

fn begin(robot: &mut SimRobot) {
    let ready = robot.description().arm.ready.clone();
    let up = move_to(robot, 0.1, &ready, 8.0);
    robot.send(Command::Joints(up)).unwrap();
    robot.send(path_to(0.3, 0.1, 0.4)).unwrap();
    robot.wait(0.7).unwrap();
}

fn go_on(robot: &mut SimRobot) -> (RobotState, LaserScan, DepthFrame) {
    robot
        .send(Command::Gripper(GripperGoal {
            opening: 0.2,
            force_n: 10.0,
        }))
        .unwrap();
    robot.wait(0.8).unwrap();
    let state = robot.state().unwrap();
    (
        state,
        robot.scan().unwrap().data,
        robot.look().unwrap().data,
    )
}

#[test]
fn twice_the_same_world() {
    let run = || {
        let mut robot = noisy(11);
        begin(&mut robot);
        go_on(&mut robot)
    };
    assert_eq!(run(), run());
}

#[test]
fn another_seed_another_world() {
    assert_ne!(noisy(11).world_from_base(), noisy(12).world_from_base());
}

#[test]
fn a_restored_world_goes_on_exactly() {
    let mut robot = noisy(11);
    begin(&mut robot);
    let snapshot = robot.snapshot();
    let first = go_on(&mut robot);
    robot.restore(&snapshot).unwrap();
    assert_eq!(go_on(&mut robot), first);
    let mut fresh = noisy(11);
    fresh.restore(&snapshot).unwrap();
    assert_eq!(go_on(&mut fresh), first);
}

#[test]
fn how_time_is_cut_does_not_matter() {
    let run = |pieces: &[f64]| {
        let mut robot = noisy(11);
        begin(&mut robot);
        for piece in pieces {
            robot.wait(*piece).unwrap();
        }
        robot.state().unwrap()
    };
    assert_eq!(run(&[0.3]), run(&[0.1, 0.0005, 0.0995, 0.1]));
}

#[test]
fn a_stored_world_goes_on_exactly() {
    let mut robot = noisy(11);
    begin(&mut robot);
    let error = robot.snapshot().to_bytes().unwrap_err().to_string();
    assert_eq!(
        error,
        "snapshot: motion 1 is under way; wait for it or stop it"
    );
    robot.stop().unwrap();
    robot.scan().unwrap();
    robot.wait(0.05).unwrap();
    let bytes = robot.snapshot().to_bytes().unwrap();
    let first = go_on(&mut robot);
    let mut fresh = noisy(11);
    let snapshot = fresh.read_snapshot(&bytes).unwrap();
    fresh.restore(&snapshot).unwrap();
    assert_eq!(go_on(&mut fresh), first);
    assert_eq!(snapshot.to_bytes().unwrap(), bytes);
}

#[test]
fn broken_bytes_are_refused() {
    let robot = noisy(11);
    let bytes = robot.snapshot().to_bytes().unwrap();
    let reason = |bytes: &[u8]| robot.read_snapshot(bytes).unwrap_err().to_string();
    assert!(reason(&bytes[..bytes.len() / 2]).ends_with("the bytes end too early"));
    assert!(reason(b"not a world at all").contains("do not begin"));
    assert!(reason(&[&bytes[..], &[0; 8]].concat()).ends_with("8 bytes too many"));
}
