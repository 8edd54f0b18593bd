//! The gripper controller on an ideal finger, free and with something between the pads.

use factotum_control::GripperGoal;
use factotum_control::gripper::{GripState, GripperController};

const STEP_SECS: f64 = 0.002;

/// A finger that follows its target with a lag, and an object that stops it at `object` with a spring.
fn close_on(object: Option<f64>, force_n: f64) -> (GripState, f64, f64) {
    let mut opening = 1.0;
    let mut controller = GripperController::holding(opening, force_n);
    controller
        .set_goal(GripperGoal {
            opening: 0.0,
            force_n,
        })
        .unwrap();
    let mut force = 0.0;
    let mut state = GripState::Moving;
    for _ in 0..3000 {
        let target = controller.step(opening, force, STEP_SECS);
        opening += (target - opening) * STEP_SECS / 0.02;
        if let Some(object) = object {
            opening = opening.max(object);
            force = if opening <= object {
                200.0 * (object - target).max(0.0)
            } else {
                0.0
            };
        }
        state = controller.state(opening, &[force, force]);
        if state != GripState::Moving {
            break;
        }
    }
    (state, opening, force)
}

#[test]
fn it_closes_on_nothing() {
    let (state, opening, force) = close_on(None, 40.0);
    assert_eq!(state, GripState::Reached);
    assert!(opening < 0.03 && force == 0.0);
}

#[test]
fn it_holds_an_object_at_the_wanted_force() {
    let (state, opening, force) = close_on(Some(0.4), 10.0);
    assert_eq!(state, GripState::Holding);
    assert!((opening - 0.4).abs() < 1e-9);
    assert!((8.0..12.0).contains(&force), "{force} N");
}

#[test]
fn it_says_when_it_is_stuck() {
    let mut controller = GripperController::holding(1.0, 40.0);
    controller
        .set_goal(GripperGoal {
            opening: 0.0,
            force_n: 40.0,
        })
        .unwrap();
    for _ in 0..3000 {
        controller.step(0.7, 0.0, STEP_SECS);
    }
    assert_eq!(controller.state(0.7, &[0.0, 0.0]), GripState::Stuck);
}

#[test]
fn nonsense_is_refused() {
    let mut controller = GripperController::holding(1.0, 40.0);
    let error = controller
        .set_goal(GripperGoal {
            opening: 1.5,
            force_n: 10.0,
        })
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "gripper opening is 1.5, expected 0 (closed) to 1 (open)"
    );
    assert!(
        controller
            .set_goal(GripperGoal {
                opening: 0.5,
                force_n: 0.0
            })
            .is_err()
    );
}
