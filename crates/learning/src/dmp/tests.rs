use super::*;
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};
use proptest::prelude::*;

const STEP_S: f64 = 0.01;

/// Share of the way of a minimum-jerk motion at a share of its duration.
fn min_jerk(share: f64) -> f64 {
    share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share)
}

/// Minimum-jerk motion of a second; `bump` leaves the straight line and comes back.
fn reach(start: &DVector<f64>, goal: &DVector<f64>, bump: f64) -> Vec<DVector<f64>> {
    (0..=100)
        .map(|k| {
            let share = f64::from(k) / 100.0;
            let aside = bump * (share * (1.0 - share)).powi(3);
            start + (goal - start) * min_jerk(share) + DVector::from_element(start.len(), aside)
        })
        .collect()
}

/// Minimum-jerk turn of a second by a rotation vector.
fn turn(start: &UnitQuaternion<f64>, by: &Vector3<f64>) -> Vec<UnitQuaternion<f64>> {
    (0..=100)
        .map(|k| UnitQuaternion::from_scaled_axis(by * min_jerk(f64::from(k) / 100.0)) * start)
        .collect()
}

fn positions(
    dmp: &PositionDmp,
    motion: &PositionMotion,
    step_s: f64,
    n_steps: usize,
) -> Vec<DVector<f64>> {
    let mut rollout = dmp.run(motion).unwrap();
    let mut found = vec![rollout.state().position.clone()];
    found.extend((0..n_steps).map(|_| rollout.advance(step_s).unwrap().position.clone()));
    found
}

fn rotations(dmp: &OrientationDmp, motion: &OrientationMotion) -> Vec<UnitQuaternion<f64>> {
    let mut rollout = dmp.run(motion).unwrap();
    let mut found = vec![rollout.state().rotation];
    found.extend((0..100).map(|_| rollout.advance(STEP_S).unwrap().rotation));
    found
}

fn learned(demonstration: &[DVector<f64>]) -> PositionDmp {
    PositionDmp::learn(demonstration, STEP_S, &DmpParams::default()).unwrap()
}

prop_compose! {
    fn point()(values in prop::collection::vec(-2.0..2.0f64, 3)) -> DVector<f64> {
        DVector::from_vec(values)
    }
}

prop_compose! {
    fn rotation_vector(max: f64)(axis in prop::array::uniform3(-1.0..1.0f64), angle in 0.0..max) -> Vector3<f64> {
        Vector3::from(axis).try_normalize(1e-3).map_or_else(Vector3::zeros, |axis| axis * angle)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn the_goal_is_reached_whatever_the_weights(
        start in point(), goal in point(), duration_s in 0.1..10.0f64,
        weights in prop::collection::vec(-1000.0..1000.0f64, 90),
    ) {
        let mut dmp = learned(&reach(&start, &goal, 0.0));
        dmp.forcing_mut().set_weights(DMatrix::from_vec(3, 30, weights)).unwrap();
        let motion = PositionMotion { duration_s, ..dmp.demonstrated() };
        let mut rollout = dmp.run(&motion).unwrap();
        let end = rollout.advance(4.0 * duration_s).unwrap();
        prop_assert!((&end.position - &goal).amax() < 1e-5, "{end:?}, goal {goal}");
        prop_assert!(end.velocity.amax() * duration_s < 1e-4, "{end:?}");
    }

    #[test]
    fn a_demonstration_is_reproduced(start in point(), goal in point(), bump in -20.0..20.0f64) {
        let demonstration = reach(&start, &goal, bump);
        let dmp = learned(&demonstration);
        // Measured: 0.24 % of the way and 0.65 % of the bump's height, which is bump / 64.
        let error_max = 3e-3 * (&goal - &start).amax() + 8e-3 * bump.abs() / 64.0 + 1e-9;
        for (found, wanted) in positions(&dmp, &dmp.demonstrated(), STEP_S, 100).iter().zip(&demonstration) {
            prop_assert!((found - wanted).amax() <= error_max, "{found} {wanted}");
        }
    }

    #[test]
    fn another_duration_is_the_same_path(start in point(), goal in point(), factor in 0.1..10.0f64) {
        let dmp = learned(&reach(&start, &goal, 3.0));
        let motion = dmp.demonstrated();
        let slower = PositionMotion { duration_s: factor * motion.duration_s, ..motion.clone() };
        let (one, other) = (positions(&dmp, &motion, 0.013, 90), positions(&dmp, &slower, 0.013 * factor, 90));
        for (a, b) in one.iter().zip(&other) {
            prop_assert!((a - b).amax() < 1e-9, "{a} {b}");
        }
    }

    /// The invariance of Ijspeert et al. 2013: other starts and goals give the same path, moved and stretched.
    #[test]
    fn scaled_shapes_are_stretched(start in point(), way in prop::array::uniform3(0.5..2.0f64), stretch in -3.0..3.0f64, moved in point()) {
        let way = DVector::from_row_slice(&way);
        let dmp = learned(&reach(&start, &(&start + &way), 3.0));
        let scaling = ShapeScaling::WithDisplacement;
        let motion = PositionMotion {
            start: moved.clone(), goal: &moved + stretch * &way, scaling, ..dmp.demonstrated()
        };
        let (one, other) = (positions(&dmp, &dmp.demonstrated(), STEP_S, 100), positions(&dmp, &motion, STEP_S, 100));
        for (a, b) in one.iter().zip(&other) {
            prop_assert!(((a - &start) * stretch - (b - &moved)).amax() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn a_turn_is_reproduced_and_another_goal_reached(
        start in rotation_vector(3.0), by in rotation_vector(2.5), other in rotation_vector(0.5),
    ) {
        let start = UnitQuaternion::from_scaled_axis(start);
        let demonstration = turn(&start, &by);
        let dmp = OrientationDmp::learn(&demonstration, STEP_S, &DmpParams::default()).unwrap();
        for (found, wanted) in rotations(&dmp, dmp.demonstrated()).iter().zip(&demonstration) {
            prop_assert!(found.angle_to(wanted) < 3e-3 * by.norm() + 1e-6, "{found} {wanted}");
            prop_assert!((found.norm() - 1.0).abs() < 1e-12);
        }
        let goal = UnitQuaternion::from_scaled_axis(other) * dmp.demonstrated().goal;
        let mut rollout = dmp.run(dmp.demonstrated()).unwrap();
        rollout.set_goal(goal).unwrap();
        let end = rollout.advance(4.0).unwrap();
        prop_assert!(end.rotation.angle_to(&goal) < 1e-5, "{end:?}");
    }

    /// No frame is special: what is shown turned is run turned.
    #[test]
    fn turned_demonstrations_give_turned_runs(start in rotation_vector(3.0), by in rotation_vector(2.5), frame in rotation_vector(3.0)) {
        let frame = UnitQuaternion::from_scaled_axis(frame);
        let demonstration = turn(&UnitQuaternion::from_scaled_axis(start), &by);
        let turned: Vec<_> = demonstration.iter().map(|rotation| frame * rotation).collect();
        let [one, other] = [&demonstration, &turned].map(|shown| {
            let dmp = OrientationDmp::learn(shown, STEP_S, &DmpParams::default()).unwrap();
            rotations(&dmp, dmp.demonstrated())
        });
        for (a, b) in one.iter().zip(&other) {
            prop_assert!((frame * a).angle_to(b) < 1e-6, "{a} {b}");
        }
    }
}

#[test]
fn a_goal_that_moves_is_followed() {
    let (start, goal) = (DVector::zeros(2), DVector::from_element(2, 1.0));
    let dmp = learned(&reach(&start, &goal, 0.0));
    let mut rollout = dmp.run(&dmp.demonstrated()).unwrap();
    rollout.advance(0.5).unwrap();
    let moved = DVector::from_row_slice(&[2.0, -1.0]);
    rollout.set_goal(moved.clone()).unwrap();
    let end = rollout.advance(2.0).unwrap();
    assert!((&end.position - moved).amax() < 1e-4, "{end:?}");
    assert!((end.time_s - 2.5).abs() < 1e-9);
}

#[test]
fn a_dimension_that_stays_stays() {
    let (start, goal) = (DVector::zeros(2), DVector::from_row_slice(&[1.0, 0.0]));
    let dmp = learned(&reach(&start, &goal, 0.0));
    let scaling = ShapeScaling::WithDisplacement;
    let motion = PositionMotion {
        scaling,
        ..dmp.demonstrated()
    };
    for position in positions(&dmp, &motion, STEP_S, 100) {
        assert_eq!(position[1], 0.0);
    }
}

#[test]
fn a_step_of_any_length_ends_at_the_same_place() {
    let (start, goal) = (DVector::zeros(1), DVector::from_element(1, 1.0));
    let dmp = learned(&reach(&start, &goal, 0.0));
    let mut whole = dmp.run(&dmp.demonstrated()).unwrap();
    let end = whole.advance(0.5).unwrap().position[0];
    let parts = positions(&dmp, &dmp.demonstrated(), 0.001, 500);
    assert!((end - parts[500][0]).abs() < 1e-4, "{end}");
}

#[test]
fn parameters_are_weights_goal_and_speed() {
    let (start, goal) = (DVector::zeros(2), DVector::from_row_slice(&[1.0, -2.0]));
    let dmp = learned(&reach(&start, &goal, 3.0));
    let motion = dmp.demonstrated();
    let mut parameters = dmp.parameters(&motion);
    assert_eq!(parameters.len(), 2 * 30 + 2 + 1);
    assert_eq!(dmp.parameter_blocks(), [30, 30, 2, 1]);
    let (same, run) = dmp.with_parameters(&motion, &parameters).unwrap();
    assert_eq!(same, dmp);
    assert_eq!(run, motion, "a duration of one second comes back as it was");
    parameters[31] = 17.0;
    parameters[61] = 5.0;
    parameters[62] = 2.0_f64.ln();
    let (other, run) = dmp.with_parameters(&motion, &parameters).unwrap();
    assert_eq!(other.forcing().weights()[(1, 1)], 17.0);
    assert_eq!(run.goal[1], 5.0);
    assert!((run.duration_s - 0.5).abs() < 1e-15);
    assert!(dmp.with_parameters(&motion, &parameters[1..]).is_err());
    parameters[0] = f64::NAN;
    assert!(dmp.with_parameters(&motion, &parameters).is_err());
}

#[test]
fn kernels_act_in_their_turn_and_share_one() {
    let dmp = learned(&reach(
        &DVector::zeros(2),
        &DVector::from_element(2, 1.0),
        0.0,
    ));
    let activity = dmp
        .parameter_activity(&dmp.demonstrated(), 1.0 / 29.0, 30)
        .unwrap();
    assert_eq!(activity.shape(), (63, 30));
    for step in 0..30 {
        let shares = activity.column(step);
        assert!((shares.rows(0, 30).sum() - 1.0).abs() < 1e-12);
        assert_eq!(shares.rows(0, 30), shares.rows(30, 30));
        assert_eq!(shares.rows(0, 30).imax(), step, "each centre is a step's");
        assert_eq!(shares.rows(60, 3).min(), 1.0);
    }
}

/// Without a force the spring's motion is `(g - y) = (g - y0) (1 + l t) exp(-l t)`, with `l = alpha_z / (2 tau)`.
#[test]
fn a_free_spring_is_the_closed_form() {
    let (start, goal) = (DVector::zeros(1), DVector::from_element(1, 1.0));
    let mut dmp = learned(&reach(&start, &goal, 0.0));
    dmp.forcing_mut()
        .set_weights(DMatrix::zeros(1, 30))
        .unwrap();
    let mut rollout = dmp.run(&dmp.demonstrated()).unwrap();
    for k in 1..=40 {
        let lt = 12.5 * 0.05 * f64::from(k);
        let state = rollout.advance(0.05).unwrap();
        let wanted = 1.0 - (1.0 + lt) * (-lt).exp();
        assert!(
            (state.position[0] - wanted).abs() < 1e-13,
            "{state:?} for {wanted}"
        );
        let wanted = 12.5 * lt * (-lt).exp();
        assert!(
            (state.velocity[0] - wanted).abs() < 1e-12,
            "{state:?} for {wanted}"
        );
    }
}

#[test]
fn longer_steps_than_the_kernels_allow_are_divided() {
    let (start, goal) = (DVector::zeros(1), DVector::from_element(1, 1.0));
    let mut dmp = learned(&reach(&start, &goal, 0.0));
    let weights = DMatrix::from_fn(1, 30, |_, i| if i % 2 == 0 { 300.0 } else { -300.0 });
    dmp.forcing_mut().set_weights(weights).unwrap();
    let (coarse, fine) = (
        positions(&dmp, &dmp.demonstrated(), 0.05, 20),
        positions(&dmp, &dmp.demonstrated(), 0.000_5, 2_000),
    );
    let furthest = fine.iter().map(|at| at[0].abs()).fold(0.0, f64::max);
    for (k, position) in coarse.iter().enumerate() {
        let error = (position[0] - fine[100 * k][0]).abs();
        assert!(error < 1e-3 * furthest, "{error} of {furthest} at {k}");
    }
}

#[test]
fn what_cannot_be_learned_or_run_is_refused() {
    let params = DmpParams::default();
    let shown = reach(&DVector::zeros(2), &DVector::from_element(2, 1.0), 0.0);
    let learn = |shown: &[DVector<f64>], step_s, params: &DmpParams| {
        PositionDmp::learn(shown, step_s, params)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        learn(&shown[..4], STEP_S, &params),
        "the demonstration has 4 samples, expected at least 30"
    );
    assert_eq!(
        learn(&[], STEP_S, &params),
        "the demonstration has 0 samples, expected at least 30"
    );
    assert_eq!(
        learn(&shown, f64::NAN, &params),
        "step is NaN, expected a positive finite number"
    );
    let one_kernel = DmpParams {
        n_kernels: 1,
        ..params
    };
    assert_eq!(
        learn(&shown, STEP_S, &one_kernel),
        "number of kernels is 1, expected at least 2"
    );
    let mut odd = shown.clone();
    odd[7] = DVector::zeros(3);
    assert_eq!(
        learn(&odd, STEP_S, &params),
        "sample has 3 entries, expected 2"
    );
    odd[7] = DVector::from_element(2, f64::NAN);
    assert_eq!(
        learn(&odd, STEP_S, &params),
        "sample has a component that is not finite"
    );

    let mut dmp = learned(&shown);
    assert!(dmp.forcing_mut().set_weights(DMatrix::zeros(2, 5)).is_err());
    let motion = dmp.demonstrated();
    let goal = DVector::zeros(3);
    assert!(
        dmp.run(&PositionMotion {
            goal,
            ..motion.clone()
        })
        .is_err()
    );
    let duration_s = 0.0;
    assert!(
        dmp.run(&PositionMotion {
            duration_s,
            ..motion.clone()
        })
        .is_err()
    );
    let mut rollout = dmp.run(&motion).unwrap();
    for step_s in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        assert!(rollout.advance(step_s).is_err(), "{step_s}");
    }
}
