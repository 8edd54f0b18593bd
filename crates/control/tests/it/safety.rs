//! The safety envelope σ.

use factotum_control::Impedance;
use factotum_control::impedance::{OperationalSpace, ToolTarget, impedance_torques_in};
use factotum_control::safety::{SafetyEnvelope, Zone};
use factotum_control::torque_limit::TorqueLimiter;
use nalgebra::{DVector, Vector3};

use crate::snake::{LIMIT_RAD, STEP_SECS, Snake, TORQUE_MAX_NM, bent};

fn envelope(n: usize) -> SafetyEnvelope {
    SafetyEnvelope::new(
        vec![Some([-LIMIT_RAD, LIMIT_RAD]); n],
        vec![TORQUE_MAX_NM; n],
    )
    .unwrap()
}

fn zone_at(joint: usize, position: f64) -> (DVector<f64>, DVector<f64>, Zone) {
    let mut q = bent(7);
    q[joint] = position;
    let mut snake = Snake::new(7, &q);
    let arm = snake.arm_state();
    let space = OperationalSpace::of(&arm).unwrap();
    let task = DVector::from_element(7, 1.0);
    let (torques, zone) = envelope(7).guard(&arm, &space, task).unwrap();
    (torques, arm.bias, zone)
}

#[test]
fn the_task_passes_far_from_the_limits() {
    let (torques, _, zone) = zone_at(3, 1.2);
    assert_eq!(zone, Zone::Free);
    assert_eq!(torques, DVector::from_element(7, 1.0));
}

#[test]
fn below_the_first_threshold_the_null_space_controller_acts() {
    let (_, _, zone) = zone_at(3, LIMIT_RAD - 0.25);
    assert_eq!(zone, Zone::NullSpace(vec![3]));
}

#[test]
fn below_the_second_threshold_the_joint_is_pushed_back_with_all_its_torque() {
    let (torques, _, zone) = zone_at(3, LIMIT_RAD - 0.15);
    assert_eq!(zone, Zone::PushBack(vec![3]));
    assert_eq!(torques[3], -TORQUE_MAX_NM);
    let (torques, bias, _) = zone_at(3, -LIMIT_RAD + 0.15);
    assert_eq!(torques[3], TORQUE_MAX_NM);
    // The other joints are held against gravity only, the arm being at rest.
    assert!((torques[1] - bias[1]).abs() < 1e-9);
}

#[test]
fn the_null_space_controller_moves_the_joint_and_not_the_tool() {
    let mut q = bent(8);
    q[4] = LIMIT_RAD - 0.25;
    let mut snake = Snake::new(8, &q);
    let sigma = envelope(8);
    let start = snake.arm_state();
    for _ in 0..150 {
        let arm = snake.arm_state();
        let space = OperationalSpace::of(&arm).unwrap();
        let (torques, zone) = sigma.guard(&arm, &space, DVector::zeros(8)).unwrap();
        if zone == Zone::Free {
            break;
        }
        snake.step(&torques);
    }
    let arm = snake.arm_state();
    let tool =
        (arm.base_from_tcp.translation.vector - start.base_from_tcp.translation.vector).norm();
    assert!(
        arm.positions[4] < start.positions[4] - 0.03,
        "joint at {}",
        arm.positions[4]
    );
    assert!(tool < 5e-3, "the tool moved by {tool} m");
}

/// A task that pulls the tool away for ever drives joints into their limits, unless σ has the last word.
#[test]
fn a_task_cannot_drive_the_arm_into_its_limits() {
    let nearest = |guarded: bool| {
        let mut snake = Snake::new(7, &bent(7));
        let sigma = envelope(7);
        let mut limiter = TorqueLimiter::new(&[TORQUE_MAX_NM; 7]);
        let mut nearest = f64::INFINITY;
        for _ in 0..2000 {
            let arm = snake.arm_state();
            let space = OperationalSpace::of(&arm).unwrap();
            // A policy that always wants to go 5 cm further.
            let mut goal = arm.base_from_tcp;
            goal.translation.vector += Vector3::new(-0.04, 0.0, -0.03);
            let target = ToolTarget::at_rest(goal);
            let gains = sigma.cap(Impedance {
                kp_position: Vector3::repeat(1e4),
                ..Impedance::default()
            });
            assert!(gains.kp_position.max() <= 300.0);
            let task = impedance_torques_in(&space, &arm, &target, &gains, None).unwrap();
            let wished = if guarded {
                sigma.guard(&arm, &space, task).unwrap().0
            } else {
                task
            };
            snake.step(limiter.limit(&wished, STEP_SECS).unwrap());
            let distances = (0..7).map(|joint| sigma.distance(joint, arm.positions[joint]));
            nearest = distances.fold(nearest, f64::min);
        }
        nearest
    };
    let (guarded, unguarded) = (nearest(true), nearest(false));
    assert!(
        unguarded < 0.05,
        "the task is too gentle to show anything: {unguarded} rad"
    );
    assert!(guarded > 0.1, "{guarded} rad");
}

#[test]
fn the_failure_classifier_names_the_joint() {
    let sigma = envelope(3);
    let q = DVector::from_vec(vec![0.0, LIMIT_RAD - 0.05, 0.0]);
    let (joint, distance) = sigma.violation(&q).unwrap();
    assert_eq!(joint, 1);
    assert!((distance - 0.05).abs() < 1e-12);
    assert_eq!(sigma.violation(&DVector::zeros(3)), None);
}

#[test]
fn a_joint_without_limits_is_never_guarded() {
    let sigma = SafetyEnvelope::new(vec![None], vec![10.0]).unwrap();
    assert_eq!(sigma.distance(0, 100.0), f64::INFINITY);
    assert_eq!(sigma.violation(&DVector::from_element(1, 100.0)), None);
}

#[test]
fn thresholds_in_the_wrong_order_are_refused() {
    let error = envelope(2).with_thresholds(0.1, 0.2, 0.05).unwrap_err();
    assert_eq!(
        error.to_string(),
        "safety thresholds is 0.1, 0.2, 0.05 rad, expected null space > push back > failure > 0"
    );
}
