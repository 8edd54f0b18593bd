//! Commands reach their goals.

use std::sync::{Arc, Mutex};

use factotum_control::{
    BasePath, BaseTwist, Command, GripperGoal, GuardSpec, Impedance, MotionStatus, Robot as _,
    ToolGoal, ToolPath,
};
use factotum_geometry::Pose2;
use factotum_geometry::frames::wrap_angle;
use factotum_worlds::SimRobot;
use nalgebra::{Translation3, Vector2, Vector3};

use crate::fixture::{
    base_from_tcp, config, household, move_to, must, path_to, pose, run, starting_at,
};

#[test]
fn the_robot_stands_still_when_nobody_commands() {
    let mut robot = household(1);
    let before = robot.state().unwrap();
    let base_before = robot.world_from_base();
    robot.wait(3.0).unwrap();
    let after = robot.state().unwrap();
    assert!((after.time_secs - before.time_secs - 3.0).abs() < 1e-9);
    for (a, b) in before.arm_positions.iter().zip(&after.arm_positions) {
        assert!((a - b).abs() < 1e-3, "an arm joint moved from {a} to {b}");
    }
    let moved = base_before.inv_mul(&robot.world_from_base());
    assert!(moved.translation.vector.norm() < 1e-4 && moved.rotation.angle().abs() < 1e-4);
    assert!((before.lift_m - after.lift_m).abs() < 1e-3);
}

#[test]
fn the_arm_follows_a_trajectory_within_a_degree() {
    let mut robot = household(1);
    let ready = robot.description().arm.ready.clone();
    let trajectory = move_to(&mut robot, 0.2, &ready, 8.0);
    let id = robot.send(Command::Joints(trajectory.clone())).unwrap();
    let mut worst: f64 = 0.0;
    let mut worst_lift: f64 = 0.0;
    for i in 1..=160 {
        robot.wait(0.05).unwrap();
        let wanted = trajectory.sample(f64::from(i) * 0.05).positions;
        let state = robot.state().unwrap();
        worst_lift = worst_lift.max((wanted[0] - state.lift_m).abs());
        for (wanted, found) in wanted[1..].iter().zip(&state.arm_positions) {
            worst = worst.max((wanted - found).abs());
        }
    }
    robot.wait(0.5).unwrap();
    assert_eq!(robot.progress(id).unwrap(), MotionStatus::Done);
    assert!(worst < 0.0175, "{worst} rad");
    assert!(worst_lift < 0.01, "{worst_lift} m");
    let state = robot.state().unwrap();
    for (wanted, found) in ready.iter().zip(&state.arm_positions) {
        assert!(
            (wanted - found).abs() < 5e-3,
            "{found} rad, expected {wanted}"
        );
    }
    assert!(
        (state.lift_m - 0.2).abs() < 2e-3,
        "lift at {} m",
        state.lift_m
    );
}

#[test]
fn the_base_follows_a_path_within_two_centimetres_and_two_degrees() {
    let mut robot = starting_at(config(1), 3.2, 1.2, 0.5);
    let truth = Arc::new(Mutex::new(Vec::new()));
    let bodies = robot.visual_bodies();
    let base = bodies
        .iter()
        .position(|body| body.name == "base_link")
        .unwrap();
    let seen = Arc::clone(&truth);
    robot.set_observer(
        0.02,
        Box::new(move |view| seen.lock().unwrap().push(view.world_from_body[base])),
    );
    let world_from_odom = robot.world_from_base();
    let corners = [
        pose(3.2, 1.2, 0.5),
        pose(3.6, 1.6, 1.0),
        pose(3.3, 3.6, 2.2),
        pose(1.6, 3.65, 3.0),
    ];
    let path: Vec<Pose2> = corners
        .iter()
        .map(|world| world_from_odom.inv_mul(world))
        .collect();
    must(
        &mut robot,
        Command::BasePath(BasePath {
            odom_from_base: path,
            speed: 1.0,
        }),
    );
    let off = truth
        .lock()
        .unwrap()
        .iter()
        .map(|seen| off_path(&corners, seen.translation.vector.xy()))
        .fold(0.0, f64::max);
    assert!(off < 0.02, "{off} m off the path");
    let end = corners[3].inv_mul(&robot.world_from_base());
    assert!(end.translation.vector.norm() < 0.02, "{end:?}");
    assert!(
        wrap_angle(end.rotation.angle()).abs() < 2.0_f64.to_radians(),
        "{end:?}"
    );
    assert!(truth.lock().unwrap().len() > 200);
}

fn off_path(corners: &[Pose2], p: Vector2<f64>) -> f64 {
    corners
        .windows(2)
        .map(|pair| {
            let (a, b) = (pair[0].translation.vector, pair[1].translation.vector);
            let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (a + (b - a) * t - p).norm()
        })
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_base_in_front_of_a_wall_says_that_it_is_stuck() {
    // The southern wall is 0.9 m behind the start.
    let mut robot = starting_at(config(1), 3.7, 0.9, -std::f64::consts::FRAC_PI_2);
    let status = run(&mut robot, path_to(1.5, 0.0, 0.0), 20.0);
    let MotionStatus::Aborted(reason) = status else {
        panic!("{status:?}")
    };
    assert!(reason.starts_with("the base is stuck"), "{reason}");
}

#[test]
fn tool_goals_pull_the_tool_along_until_nobody_sends_any_more() {
    let mut robot = household(1);
    let ready = robot.description().arm.ready.clone();
    let trajectory = move_to(&mut robot, 0.2, &ready, 8.0);
    must(&mut robot, Command::Joints(trajectory));
    let start = base_from_tcp(&mut robot);
    let guard = GuardSpec::Barrier { margin_rad: 0.1 };
    let mut last = None;
    // 8 cm in 2 s, 20 goals a second.
    for i in 1..=40 {
        let goal = ToolGoal {
            base_from_tcp: Translation3::new(0.0, 0.002 * f64::from(i), 0.0) * start,
            impedance: Impedance::uniform(300.0, 300.0),
            guard,
            valid_secs: 0.125,
        };
        let id = robot.send(Command::ToolGoal(goal)).unwrap();
        if let Some(last) = last.replace(id) {
            assert_eq!(robot.progress(last).unwrap(), MotionStatus::Preempted);
        }
        robot.wait(0.05).unwrap();
    }
    let last = last.unwrap();
    assert_eq!(robot.progress(last).unwrap(), MotionStatus::Active);
    robot.wait(0.1).unwrap();
    assert_eq!(robot.progress(last).unwrap(), MotionStatus::Done);
    let moved = |robot: &mut SimRobot| {
        let tool = base_from_tcp(robot).translation.vector;
        tool - start.translation.vector
    };
    let way = moved(&mut robot);
    assert!((0.06..0.085).contains(&way.y), "{way}");
    assert!(way.xz().norm() < 0.01, "{way}");
    robot.wait(1.0).unwrap();
    let drift = moved(&mut robot) - way;
    assert!(drift.norm() < 0.005, "it moved on by {drift}");
}

#[test]
fn a_velocity_command_expires() {
    let mut robot = household(2);
    let twist = BaseTwist {
        velocity: Vector3::new(0.2, 0.0, 0.3),
        valid_secs: 0.5,
    };
    let id = robot.send(Command::BaseTwist(twist)).unwrap();
    robot.wait(0.45).unwrap();
    assert!(robot.state().unwrap().base_velocity.norm() > 0.2);
    assert_eq!(robot.progress(id).unwrap(), MotionStatus::Active);
    robot.wait(1.0).unwrap();
    assert!(robot.state().unwrap().base_velocity.norm() < 0.005);
    assert_eq!(robot.progress(id).unwrap(), MotionStatus::Done);
}

#[test]
fn the_gripper_closes_and_opens() {
    let mut robot = household(1);
    must(
        &mut robot,
        Command::Gripper(GripperGoal {
            opening: 0.0,
            force_n: 20.0,
        }),
    );
    let closed = robot.state().unwrap().gripper_opening;
    assert!(closed < 0.06, "{closed}");
    must(
        &mut robot,
        Command::Gripper(GripperGoal {
            opening: 0.6,
            force_n: 20.0,
        }),
    );
    let open = robot.state().unwrap().gripper_opening;
    assert!((open - 0.6).abs() < 0.05, "{open}");
}

#[test]
fn the_tool_follows_a_path_under_impedance() {
    let mut robot = household(1);
    let ready = robot.description().arm.ready.clone();
    let up = move_to(&mut robot, 0.2, &ready, 8.0);
    must(&mut robot, Command::Joints(up));
    let start = base_from_tcp(&mut robot);
    let mut end = start;
    end.translation.vector += Vector3::new(-0.10, 0.08, 0.05);
    let path = ToolPath {
        base_from_tcp: vec![(0.0, start), (2.5, end)],
        impedance: Impedance::default(),
        stop_force_n: Some(15.0),
        tolerance_m: 0.01,
    };
    must(&mut robot, Command::Tool(path));
    let reached = base_from_tcp(&mut robot);
    let off = (reached.translation.vector - end.translation.vector).norm();
    assert!(off < 0.01, "{off} m");
    assert!(reached.rotation.angle_to(&end.rotation) < 0.05);
    // It holds there.
    robot.wait(1.0).unwrap();
    let later = base_from_tcp(&mut robot);
    assert!((later.translation.vector - reached.translation.vector).norm() < 0.003);
}

#[test]
fn a_tool_that_meets_something_is_guarded() {
    // Beside the table: the tool goes down onto its top.
    let mut robot = starting_at(config(1), 2.2, 3.2, std::f64::consts::FRAC_PI_2);
    let ready = robot.description().arm.ready.clone();
    let up = move_to(&mut robot, 0.2, &ready, 8.0);
    must(&mut robot, Command::Joints(up));
    must(&mut robot, path_to(0.32, 0.35, 0.0));
    let start = base_from_tcp(&mut robot);
    let mut below = start;
    below.translation.vector.z -= 0.25;
    let path = ToolPath {
        base_from_tcp: vec![(0.0, start), (4.0, below)],
        impedance: Impedance::default(),
        stop_force_n: Some(6.0),
        tolerance_m: 0.01,
    };
    let status = run(&mut robot, Command::Tool(path), 8.0);
    assert_eq!(status, MotionStatus::Guarded);
    let height = base_from_tcp(&mut robot).translation.z;
    assert!(
        (0.74..0.90).contains(&height),
        "stopped at {height} m, the table is 0.75 m high"
    );
}

#[test]
fn a_new_goal_preempts_and_stop_holds() {
    let mut robot = household(1);
    let ready = robot.description().arm.ready.clone();
    let first = move_to(&mut robot, 0.2, &ready, 8.0);
    let first = robot.send(Command::Joints(first)).unwrap();
    robot.wait(2.0).unwrap();
    let here = robot.state().unwrap();
    let second = move_to(&mut robot, here.lift_m, &here.arm_positions, 1.0);
    let second = robot.send(Command::Joints(second)).unwrap();
    assert_eq!(robot.progress(first).unwrap(), MotionStatus::Preempted);
    robot.stop().unwrap();
    assert_eq!(robot.progress(second).unwrap(), MotionStatus::Preempted);
    robot.wait(1.0).unwrap();
    let settled = robot.state().unwrap();
    robot.wait(1.0).unwrap();
    let later = robot.state().unwrap();
    for (a, b) in settled.arm_positions.iter().zip(&later.arm_positions) {
        assert!((a - b).abs() < 2e-3);
    }
}
