//! The gripper holds the bottle in physics, until the fault lets it slip.

use factotum_control::{Command, GripperGoal, MotionStatus, Robot};
use factotum_worlds::{Fault, SimRobot, WorldConfig};

use crate::fixture::{base_from_tcp, config, move_to, must, path_to, starting_at};

/// How far in front of the bottle the robot unfolds its arm, metres.
const CLEARANCE_M: f64 = 1.3;

/// A seed whose bottle is on the near side of the table, and where the bottle is.
fn near_bottle() -> (u64, f64, f64) {
    (0..20)
        .find_map(|seed| {
            let home = SimRobot::new(config(seed)).unwrap();
            let bottle = home.world_from_object("bottle_1").unwrap().translation;
            (bottle.y < 4.4).then_some((seed, bottle.x, bottle.y))
        })
        .unwrap()
}

/// Unfolds the arm clear of the table and drives up, until the bottle is between the open fingers, hand level.
fn reach_for_the_bottle(robot: &mut dyn Robot) {
    let ready = robot.description().arm.ready.clone();
    // Lift so that the hand is 0.105 m above the table's top.
    let unfold = move_to(robot, 0.105, &ready, 8.0);
    must(robot, Command::Joints(unfold));
    let tool = base_from_tcp(robot).translation.vector;
    assert!((tool.z - 0.855).abs() < 0.02, "tool at {tool}");
    must(robot, path_to(CLEARANCE_M - tool.x, -tool.y, 0.0));
}

/// Closes the fingers on the bottle and raises it by 0.2 m.
fn grasp_and_raise(robot: &mut dyn Robot) {
    let grip = GripperGoal {
        opening: 0.0,
        force_n: 30.0,
    };
    must(robot, Command::Gripper(grip));
    let state = robot.state().unwrap();
    assert!(
        state.gripper_opening > 0.2,
        "closed on nothing: {}",
        state.gripper_opening
    );
    let n_pads = state
        .pad_forces_in_tcp
        .iter()
        .filter(|force| force.norm() > 3.0)
        .count();
    assert!(n_pads >= 2, "{state:?}");
    let raise = move_to(robot, state.lift_m + 0.2, &state.arm_positions, 4.0);
    must(robot, Command::Joints(raise));
}

fn at_the_bottle(fault: Option<Fault>) -> SimRobot {
    let (seed, x, y) = near_bottle();
    let config = WorldConfig {
        fault,
        ..config(seed)
    };
    let mut robot = starting_at(config, x, y - CLEARANCE_M, std::f64::consts::FRAC_PI_2);
    reach_for_the_bottle(&mut robot);
    robot
}

#[test]
fn a_grasped_bottle_comes_along_and_stays() {
    let mut robot = at_the_bottle(None);
    let before = robot.world_from_object("bottle_1").unwrap();
    grasp_and_raise(&mut robot);
    let raised = robot.world_from_object("bottle_1").unwrap();
    let height = raised.translation.z - before.translation.z;
    assert!((height - 0.2).abs() < 0.02, "raised by {height} m");
    robot.wait(5.0).unwrap();
    let later = robot.world_from_object("bottle_1").unwrap();
    let slip = (later.translation.vector - raised.translation.vector).norm();
    assert!(slip < 0.003, "slipped by {slip} m in 5 s");
    let verdict = robot.judge().achieved("throw-away-bottle").unwrap();
    assert!(
        !verdict.achieved && verdict.measured.ends_with("touched by the robot"),
        "{verdict:?}"
    );
}

#[test]
fn grasp_slip_drops_the_bottle_once() {
    let mut robot = at_the_bottle(Some(Fault::GraspSlip));
    robot.fault_switch().arm();
    grasp_and_raise(&mut robot);
    robot.wait(8.0).unwrap();
    assert!(
        robot
            .fault_happened()
            .is_some_and(|what| what.starts_with("the gripper gave way"))
    );
    let forces = robot.state().unwrap().pad_forces_in_tcp;
    let bottle = robot.world_from_object("bottle_1").unwrap();
    assert!(
        bottle.translation.z < 0.85,
        "the bottle is at {bottle}, pads feel {forces:?}"
    );
}

#[test]
fn an_unarmed_fault_does_not_happen() {
    let mut robot = at_the_bottle(Some(Fault::GraspSlip));
    grasp_and_raise(&mut robot);
    robot.wait(2.0).unwrap();
    assert_eq!(robot.fault_happened(), None);
    let status = robot.progress(factotum_control::MotionId(1)).unwrap();
    assert_eq!(status, MotionStatus::Done);
}
