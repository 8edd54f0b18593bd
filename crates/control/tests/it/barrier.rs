//! The barrier before the joint limits, and the tool servo that it guards.

use factotum_control::Impedance;
use factotum_control::barrier::JointBarrier;
use factotum_control::impedance::ToolTarget;
use factotum_control::safety::SafetyEnvelope;
use factotum_control::tool_servo::{JointGuard, ToolServo};
use nalgebra::{DVector, Vector3};
use proptest::prelude::*;

use crate::snake::{LIMIT_RAD, STEP_SECS, Snake, TORQUE_MAX_NM, bent};

const MARGIN_RAD: f64 = 0.15;
const SPEED_MAX: f64 = 2.0;

fn limits() -> Vec<Option<[f64; 2]>> {
    vec![Some([-LIMIT_RAD, LIMIT_RAD]); 7]
}

fn barrier() -> JointGuard {
    JointGuard::Barrier(JointBarrier::new(limits(), vec![SPEED_MAX; 7], MARGIN_RAD).unwrap())
}

/// Smallest distance of a joint to its limit while a policy for ever wants the tool to go on along `wish` (m), and the
/// world pushes it with `force` (N).
fn nearest(guard: JointGuard, wish: Vector3<f64>, force: Vector3<f64>) -> f64 {
    let mut snake = Snake::new(7, &bent(7));
    let start = snake.arm_state();
    let mut servo = ToolServo::new(&[TORQUE_MAX_NM; 7], guard, start.positions.clone());
    servo.restart(&start).unwrap();
    let mut nearest = f64::INFINITY;
    for _ in 0..1500 {
        snake.push_tool(force);
        let arm = snake.arm_state();
        let mut goal = arm.base_from_tcp;
        goal.translation.vector += wish;
        let target = ToolTarget::at_rest(goal);
        let gains = Impedance::uniform(300.0, 300.0);
        let torques = servo.torques(&arm, &target, &gains, STEP_SECS).unwrap();
        snake.step(torques);
        let distances = arm.positions.iter().map(|q| LIMIT_RAD - q.abs());
        nearest = distances.fold(nearest, f64::min);
    }
    nearest
}

#[test]
fn no_wish_and_no_push_gets_past_the_barrier() {
    let wishes = [
        Vector3::new(-0.04, 0.0, -0.03),
        Vector3::new(0.05, 0.05, 0.05),
        Vector3::new(0.0, -0.05, 0.05),
    ];
    for wish in wishes {
        for force in [Vector3::zeros(), Vector3::new(-8.0, 5.0, -6.0)] {
            let free = nearest(JointGuard::None, wish, force);
            let kept = nearest(barrier(), wish, force);
            assert!(
                free < 0.1,
                "{wish:?} is too gentle to show anything: {free}"
            );
            // What is left is the time step: at 2 ms a joint may overshoot by a few milliradians.
            assert!(kept > MARGIN_RAD - 0.02, "{wish:?} with {force:?}: {kept}");
        }
    }
}

#[test]
fn far_from_the_limits_every_guard_is_the_same() {
    let wish = Vector3::new(0.0, 0.01, 0.0);
    let run = |guard| {
        let mut snake = Snake::new(7, &bent(7));
        let start = snake.arm_state();
        let mut servo = ToolServo::new(&[TORQUE_MAX_NM; 7], guard, start.positions.clone());
        servo.restart(&start).unwrap();
        for _ in 0..50 {
            let arm = snake.arm_state();
            let mut goal = start.base_from_tcp;
            goal.translation.vector += wish;
            let target = ToolTarget::at_rest(goal);
            let torques = servo.torques(&arm, &target, &Impedance::default(), STEP_SECS);
            snake.step(torques.unwrap());
        }
        snake.arm_state().positions
    };
    let free = run(JointGuard::None);
    let envelope = SafetyEnvelope::new(limits(), vec![TORQUE_MAX_NM; 7]).unwrap();
    assert_eq!(run(JointGuard::Envelope(envelope)), free);
    assert_eq!(run(barrier()), free);
}

#[test]
fn a_margin_that_is_none_is_refused() {
    let error = JointBarrier::new(limits(), vec![SPEED_MAX; 7], 0.0)
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "margin of the joint barrier is 0 rad, expected a positive angle"
    );
}

proptest! {
    /// The law itself: a joint whose acceleration obeys the bounds from any state behind the barrier stays behind it.
    #[test]
    fn a_joint_that_obeys_stays_behind(position in -1.8..1.8, share in -1.0..1.0, wish in -500.0..500.0_f64) {
        let barrier = JointBarrier::new(vec![Some([-LIMIT_RAD, LIMIT_RAD])], vec![SPEED_MAX], MARGIN_RAD).unwrap();
        let wall = LIMIT_RAD - MARGIN_RAD;
        let (mut q, mut v): (f64, f64) = (position, share * 5.0 * (wall - position).min(wall + position).min(SPEED_MAX / 5.0));
        for _ in 0..2000 {
            let [low, high] = barrier.bounds(0, q, v);
            prop_assert!(low <= high);
            v += wish.clamp(low, high) * 1e-3;
            q += v * 1e-3;
            prop_assert!(q.abs() < wall + 1e-6 && v.abs() < SPEED_MAX + 1e-6, "{q} at {v}");
        }
    }

    #[test]
    fn a_joint_without_limits_is_held_to_its_speed_alone(position in -9.0..9.0, velocity in -9.0..9.0_f64) {
        let barrier = JointBarrier::new(vec![None], vec![SPEED_MAX], MARGIN_RAD).unwrap();
        let [low, high] = barrier.bounds(0, position, velocity);
        prop_assert_eq!(high > 0.0, velocity < SPEED_MAX);
        prop_assert_eq!(low < 0.0, velocity > -SPEED_MAX);
    }
}

#[test]
fn a_servo_refuses_another_arm() {
    let mut snake = Snake::new(7, &bent(7));
    let arm = snake.arm_state();
    let mut servo = ToolServo::new(&[TORQUE_MAX_NM; 6], JointGuard::None, DVector::zeros(6));
    assert!(servo.restart(&arm).is_err());
}
