//! Eq. 3.1 against theory, with 7 and 8 joints.

use factotum_control::Impedance;
use factotum_control::impedance::{
    OperationalSpace, Posture, ToolTarget, guarded_inverse, impedance_torques,
};
use nalgebra::{DVector, Matrix3, Vector3, Vector6};
use proptest::prelude::*;

use crate::snake::{Snake, bent};

/// Holds a posture's tool pose while a force pushes the tool; returns force and displacement at rest.
fn displacement_under(n: usize, force: Vector3<f64>, gains: Impedance) -> (Vector3<f64>, f64) {
    let mut snake = Snake::new(n, &bent(n));
    let start = snake.arm_state();
    let target = ToolTarget::at_rest(start.base_from_tcp);
    let posture = Posture::soft(start.positions.clone());
    for _ in 0..3000 {
        snake.push_tool(force);
        let arm = snake.arm_state();
        snake.step(&impedance_torques(&arm, &target, &gains, Some(&posture)).unwrap());
    }
    let arm = snake.arm_state();
    let offset = arm.base_from_tcp.translation.vector - start.base_from_tcp.translation.vector;
    let space = OperationalSpace::of(&arm).unwrap();
    (
        space.inertia_position * offset.component_mul(&gains.kp_position),
        offset.norm(),
    )
}

#[test]
fn a_displaced_tool_pushes_back_with_lambda_kp_dx() {
    let gains = Impedance {
        kp_position: Vector3::new(150.0, 100.0, 250.0),
        ..Impedance::default()
    };
    for (n, force) in [
        (7, Vector3::new(6.0, -3.0, 2.0)),
        (8, Vector3::new(-2.0, 4.0, -5.0)),
    ] {
        let (felt, distance) = displacement_under(n, force, gains);
        assert!(
            distance > 5e-3,
            "the push moved the tool by {distance} m only"
        );
        assert!(
            (felt - force).norm() < 0.02 * force.norm(),
            "n = {n}: {felt} against {force}"
        );
    }
}

#[test]
fn a_stiffer_tool_gives_way_less() {
    let force = Vector3::new(4.0, 0.0, 3.0);
    let at = |kp: f64| {
        let gains = Impedance::uniform(kp, 150.0);
        displacement_under(7, force, gains).1
    };
    assert!(at(300.0) < 0.6 * at(150.0));
}

/// How far the tool goes towards a step of its target, as a fraction of it: the farthest, and in the end.
fn step_response(damping_ratio: f64) -> (f64, f64) {
    let mut snake = Snake::new(7, &bent(7));
    let start = snake.arm_state();
    let step = Vector3::new(0.0, 0.03, -0.02);
    let mut goal = start.base_from_tcp;
    goal.translation.vector += step;
    let target = ToolTarget::at_rest(goal);
    let posture = Posture::soft(start.positions.clone());
    let gains = Impedance {
        damping_ratio,
        ..Impedance::default()
    };
    let (mut farthest, mut last): (f64, f64) = (0.0, 0.0);
    for _ in 0..2000 {
        let arm = snake.arm_state();
        snake.step(&impedance_torques(&arm, &target, &gains, Some(&posture)).unwrap());
        let moved = arm.base_from_tcp.translation.vector - start.base_from_tcp.translation.vector;
        last = moved.dot(&step) / step.norm_squared();
        farthest = farthest.max(last);
    }
    (farthest, last)
}

#[test]
fn a_damping_ratio_of_one_hardly_overshoots() {
    // Not exactly critical: position and rotation are damped apart, but the arm couples them.
    let (farthest, last) = step_response(1.0);
    assert!(farthest < 1.1, "to {farthest} of the step");
    assert!((last - 1.0).abs() < 0.01, "rests at {last} of the step");
    let undamped = step_response(0.1).0;
    assert!(
        undamped > farthest + 0.1,
        "a tenth of the damping only goes to {undamped}"
    );
}

#[test]
fn the_rotation_error_is_the_rotation_vector_in_the_base_frame() {
    let mut snake = Snake::new(7, &bent(7));
    let start = snake.arm_state();
    let turn = Vector3::new(0.2, -0.1, 0.3);
    let mut goal = start.base_from_tcp;
    goal.rotation = nalgebra::UnitQuaternion::from_scaled_axis(turn) * goal.rotation;
    let target = ToolTarget::at_rest(goal);
    for _ in 0..3000 {
        let arm = snake.arm_state();
        snake.step(&impedance_torques(&arm, &target, &Impedance::default(), None).unwrap());
    }
    let arm = snake.arm_state();
    assert!(arm.base_from_tcp.rotation.angle_to(&goal.rotation) < 1e-3);
    assert!((arm.base_from_tcp.translation.vector - goal.translation.vector).norm() < 1e-3);
}

#[test]
fn null_space_motion_leaves_the_tool_still() {
    let mut snake = Snake::new(8, &bent(8));
    let start = snake.arm_state();
    let target = ToolTarget::at_rest(start.base_from_tcp);
    let mut elsewhere = start.positions.clone();
    elsewhere[2] += 0.8;
    elsewhere[4] -= 0.6;
    // Slow, since Eq. 3.1 leaves J̇ q̇ to the feedback.
    let posture = Posture {
        positions: elsewhere,
        kp: 4.0,
    };
    let mut tool_moved: f64 = 0.0;
    for _ in 0..3000 {
        let arm = snake.arm_state();
        snake.step(
            &impedance_torques(&arm, &target, &Impedance::default(), Some(&posture)).unwrap(),
        );
        let error = arm.base_from_tcp.translation.vector - start.base_from_tcp.translation.vector;
        tool_moved = tool_moved.max(error.norm());
    }
    let arm = snake.arm_state();
    let joints_moved = (&arm.positions - &start.positions).norm();
    assert!(
        joints_moved > 0.15,
        "the posture moved the joints by {joints_moved} rad only"
    );
    assert!(tool_moved < 1e-3, "the tool moved by {tool_moved} m");
}

#[test]
fn bad_input_is_an_error() {
    let mut snake = Snake::new(7, &bent(7));
    let arm = snake.arm_state();
    let target = ToolTarget::at_rest(arm.base_from_tcp);
    let short = Posture::soft(DVector::zeros(6));
    let error = impedance_torques(&arm, &target, &Impedance::default(), Some(&short)).unwrap_err();
    assert_eq!(error.to_string(), "posture has 6 values, expected 7");
    let nan = Impedance {
        kp_position: Vector3::repeat(f64::NAN),
        ..Impedance::default()
    };
    assert!(impedance_torques(&arm, &target, &nan, None).is_err());
    let mut broken = arm.clone();
    broken.mass[(0, 0)] = -1.0;
    let error = OperationalSpace::of(&broken).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the arm's 7 x 7 mass matrix is not positive definite"
    );
}

#[test]
fn a_stretched_arm_stays_finite() {
    // Straight up: the tool cannot move along the arm, J M⁻¹ Jᵀ is singular.
    let mut snake = Snake::new(7, &[0.0; 7]);
    let arm = snake.arm_state();
    let mut goal = arm.base_from_tcp;
    goal.translation.vector.z += 0.05;
    let torques = impedance_torques(
        &arm,
        &ToolTarget::at_rest(goal),
        &Impedance::default(),
        None,
    )
    .unwrap();
    assert!(
        torques
            .iter()
            .all(|torque| torque.is_finite() && torque.abs() < 1e3),
        "{torques}"
    );
    assert_eq!(guarded_inverse(&Matrix3::zeros()), Matrix3::zeros());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn projected_torques_do_not_accelerate_the_tool(
        q in prop::collection::vec(0.25_f64..1.2, 8),
        torque in prop::collection::vec(-5.0_f64..5.0, 8),
    ) {
        let mut snake = Snake::new(8, &q);
        let arm = snake.arm_state();
        let space = OperationalSpace::of(&arm).unwrap();
        let projected = &space.null_space * DVector::from_vec(torque.clone());
        let acceleration = arm.mass.clone().cholesky().unwrap().solve(&projected);
        let tool: Vector6<f64> = &arm.jacobian * acceleration;
        let free = arm.mass.clone().cholesky().unwrap().solve(&DVector::from_vec(torque));
        let unprojected: Vector6<f64> = &arm.jacobian * free;
        // Exact but for the guard, which random postures may touch.
        prop_assert!(tool.norm() < 0.05 * unprojected.norm() + 1e-6, "{} of {}", tool.norm(), unprojected.norm());
    }

    #[test]
    fn a_well_conditioned_inverse_is_exact(a in prop::collection::vec(-1.0_f64..1.0, 9)) {
        let root = Matrix3::from_vec(a) + Matrix3::identity() * 2.5;
        let matrix = root * root.transpose();
        let product = matrix * guarded_inverse(&matrix);
        let eigen = matrix.symmetric_eigenvalues();
        prop_assume!(eigen.min() > 0.01 * eigen.max());
        prop_assert!((product - Matrix3::identity()).norm() < 1e-9);
    }
}
