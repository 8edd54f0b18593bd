//! Commands reach their goals.

use factotum_control::{Command, MotionStatus, Robot as _};

use crate::fixture::{household, move_to, run};

#[test]
fn the_world_stands_still_when_nobody_commands() {
    let mut robot = household(1);
    let before = robot.state().unwrap();
    let start = std::time::Instant::now();
    robot.wait(5.0).unwrap();
    eprintln!("real-time factor {}", 5.0 / start.elapsed().as_secs_f64());
    let after = robot.state().unwrap();
    eprintln!("{before:?}\n{after:?}");
    for (a, b) in before.arm_positions.iter().zip(&after.arm_positions) {
        assert!((a - b).abs() < 2e-3, "{a} {b}");
    }
}

#[test]
fn the_arm_goes_to_its_ready_posture() {
    let mut robot = household(1);
    let ready = robot.description().arm.ready.clone();
    let trajectory = move_to(&mut robot, 0.2, &ready, 8.0);
    let status = run(&mut robot, Command::Joints(trajectory), 12.0);
    let after = robot.state().unwrap();
    eprintln!("{status:?} {after:?}");
    assert_eq!(status, MotionStatus::Done);
}
