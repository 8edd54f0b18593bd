//! Computed-torque tracking on a small arm.

use factotum_control::joint_tracking::{JointGains, JointTarget, JointTracker};
use factotum_control::torque_limit::TorqueLimiter;
use nalgebra::{DVector, Vector3};

use crate::snake::{STEP_SECS, Snake, TORQUE_MAX_NM, bent};

fn sine(start: &[f64], time_secs: f64) -> JointTarget {
    let (amplitude, rate) = (0.3, 2.0);
    let n = start.len();
    let of = |f: fn(f64) -> f64, scale: f64| DVector::from_element(n, scale * f(rate * time_secs));
    JointTarget {
        positions: DVector::from_row_slice(start) + of(|x| 1.0 - x.cos(), amplitude),
        velocities: of(f64::sin, amplitude * rate),
        accelerations: of(f64::cos, amplitude * rate * rate),
    }
}

#[test]
fn follows_a_sine_within_a_milliradian_and_the_torque_limits() {
    let start = bent(5);
    let mut snake = Snake::new(5, &start);
    let limits = [TORQUE_MAX_NM; 5];
    let mut tracker = JointTracker::new(JointGains::default(), &limits);
    let mut limiter = TorqueLimiter::new(&limits);
    let mut worst: f64 = 0.0;
    for i in 0..2000 {
        let time_secs = f64::from(i) * STEP_SECS;
        let arm = snake.arm_state();
        let target = sine(&start, time_secs);
        // The limiter starts from zero torque: the first moments do not count.
        if time_secs > 0.3 {
            worst = worst.max((&target.positions - &arm.positions).amax());
        }
        let wished = tracker.torques(&arm, &target, STEP_SECS).unwrap();
        snake.step(limiter.limit(&wished, STEP_SECS).unwrap());
    }
    assert!(worst < 2e-3, "{worst} rad");
}

#[test]
fn the_integral_carries_an_unknown_load() {
    let start = bent(7);
    let mut snake = Snake::new(7, &start);
    let limits = [TORQUE_MAX_NM; 7];
    let mut tracker = JointTracker::new(JointGains::default(), &limits);
    let target = JointTarget::at_rest(DVector::from_vec(start));
    for _ in 0..3000 {
        snake.push_tool(Vector3::new(0.0, 0.0, -15.0));
        let arm = snake.arm_state();
        let torques = tracker.torques(&arm, &target, STEP_SECS).unwrap();
        snake.step(&torques);
    }
    let error = (snake.arm_state().positions - &target.positions).amax();
    assert!(error < 1e-3, "{error} rad");
    assert!(tracker.integral().amax() > 1.0);
}

#[test]
fn a_target_of_the_wrong_size_is_an_error() {
    let mut snake = Snake::new(5, &bent(5));
    let arm = snake.arm_state();
    let mut tracker = JointTracker::new(JointGains::default(), &[TORQUE_MAX_NM; 5]);
    let target = JointTarget::at_rest(DVector::zeros(4));
    let error = tracker.torques(&arm, &target, STEP_SECS).unwrap_err();
    assert_eq!(
        error.to_string(),
        "target positions has 4 values, expected 5"
    );
}
