//! Faults happen once, where they should, when armed.

use factotum_control::{Command, Robot as _};
use factotum_geometry::Pose2;
use factotum_worlds::{Fault, SimRobot, WorldConfig};
use nalgebra::Point2;

use crate::fixture::{config, pose, starting_at};

fn with_fault(seed: u64, fault: Fault) -> SimRobot {
    starting_at(
        WorldConfig {
            fault: Some(fault),
            ..config(seed)
        },
        3.3,
        1.2,
        1.5,
    )
}

/// Sends the base along corners given in the world.
fn send_along(robot: &mut SimRobot, corners: &[Pose2]) {
    let state = robot.state().unwrap();
    let world_from_odom = robot.world_from_base() * state.odom_from_base.inverse();
    let odom_from_base = corners
        .iter()
        .map(|world| world_from_odom.inv_mul(world))
        .collect();
    let path = factotum_control::BasePath {
        odom_from_base,
        speed: 1.0,
    };
    robot.send(Command::BasePath(path)).unwrap();
}

#[test]
fn the_object_is_moved_when_the_robot_sets_off_to_it() {
    for seed in 0..4 {
        let mut robot = with_fault(seed, Fault::MovedObject);
        let before = robot.world_from_object("bottle_1").unwrap();
        let near = pose(before.translation.x, before.translation.y - 0.9, 1.57);
        send_along(&mut robot, &[near]);
        assert_eq!(robot.fault_happened(), None, "not armed yet");
        robot.fault_switch().arm();
        send_along(&mut robot, &[pose(3.3, 1.0, 0.0)]);
        assert_eq!(robot.fault_happened(), None, "not on the way to it");
        send_along(&mut robot, &[near]);
        assert!(
            robot
                .fault_happened()
                .is_some_and(|what| what.starts_with("bottle_1 was moved by"))
        );
        robot.stop().unwrap();
        robot.wait(0.5).unwrap();
        let after = robot.world_from_object("bottle_1").unwrap();
        let moved = (after.translation.vector - before.translation.vector).norm();
        assert!((0.1..0.32).contains(&moved), "moved by {moved} m");
        assert!((after.translation.z - 0.75).abs() < 3e-3, "{after}");
        assert!(
            (after.rotation * nalgebra::Vector3::z()).z > 0.999,
            "it fell over"
        );
    }
}

#[test]
fn a_packing_case_stands_on_the_path_and_the_lidar_sees_it() {
    let mut robot = with_fault(1, Fault::BlockedPath);
    robot.fault_switch().arm();
    send_along(&mut robot, &[pose(3.3, 1.6, 1.5)]);
    assert_eq!(robot.fault_happened(), None, "too short to be worth it");
    let before = robot.scan().unwrap();
    send_along(&mut robot, &[pose(3.3, 5.0, 1.5)]);
    assert!(
        robot
            .fault_happened()
            .is_some_and(|what| what.starts_with("a packing case"))
    );
    robot.stop().unwrap();
    robot.wait(0.2).unwrap();
    let after = robot.scan().unwrap();
    let nearer = before
        .data
        .ranges_m
        .iter()
        .zip(&after.data.ranges_m)
        .filter(|(before, after)| **after < **before - 0.2)
        .count();
    assert!(nearer >= 3, "{nearer} rays see it");
    // There is room to pass: some free floor beside it, still one map.
    let grid = robot.true_grid(0.05).unwrap();
    assert!(
        grid.cell_at(&Point2::new(3.3, 5.0)).is_free()
            || grid.cell_at(&Point2::new(3.0, 5.0)).is_free()
    );
}

#[test]
fn faults_have_names() {
    for fault in Fault::ALL {
        assert_eq!(fault.name().parse::<Fault>().unwrap(), fault);
    }
    assert_eq!(
        "earthquake".parse::<Fault>().unwrap_err().to_string(),
        "fault `earthquake` is not known; available: `moved-object`, `blocked-path`, `grasp-slip`"
    );
}
