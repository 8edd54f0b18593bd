use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector2;
use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use super::*;

const PICK: SkillOnClass = SkillOnClass { skill: 0, class: 0 };
const PRESS: SkillOnClass = SkillOnClass { skill: 1, class: 1 };

fn pose(x: f64, y: f64, yaw: f64) -> Pose2 {
    Pose2::new(Vector2::new(x, y), yaw)
}

/// A base so far from the object in some direction, facing it.
fn facing(world_from_object: &Pose2, distance: f64, bearing: f64) -> Pose2 {
    let place = distance * Vector2::new(bearing.cos(), bearing.sin());
    world_from_object * Pose2::new(place, bearing + PI)
}

proptest! {
    #[test]
    fn relative_frames_move_with_the_object(
        x in -3.0..3.0, y in -3.0..3.0, yaw in -PI..PI, d in 0.1..3.0, b in -PI..PI, turn in -3.0..3.0
    ) {
        let object = pose(x, y, yaw);
        let base = facing(&object, d, b) * pose(0.0, 0.0, turn);
        for frame in [PoseFrame::Object, PoseFrame::Polar] {
            let here = frame.variables(&object, &base);
            let there = frame.variables(&Pose2::identity(), &object.inv_mul(&base));
            prop_assert_eq!(here.len(), frame.n_variables());
            for (a, b) in here.iter().zip(&there) {
                prop_assert!((a - b).abs() < 1e-9, "{here:?} {there:?}");
            }
        }
        let polar = PoseFrame::Polar.variables(&object, &base);
        prop_assert!((polar[0] - d).abs() < 1e-9);
        prop_assert!((polar[1] - b.cos()).abs() < 1e-9 && (polar[2] - b.sin()).abs() < 1e-9);
        prop_assert!((polar[3] + turn).abs() < 1e-9);
        let global = PoseFrame::Global.variables(&object, &base);
        prop_assert!((global[0] - base.translation.x).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_taught_where_all_is_known(mean in -20.0..20.0, variance in 0.0..50.0) {
        let choice = choice::nats(mean, variance);
        prop_assert!((0.0..=std::f64::consts::LN_2).contains(&choice));
        prop_assert!(choice::nats(mean, 0.0).abs() < 1e-12);
        // The more the process may vary where both outcomes are as likely, the more is taught.
        prop_assert!(choice::nats(0.0, variance + 1.0) > choice::nats(0.0, variance));
    }
}

/// Tries in one home tell about another, and those on one skill about the next, until it is known to differ.
#[test]
fn what_was_learned_goes_along_to_the_next_home() {
    let mut learner = NavigationLearner::shared(PoseFrame::Polar, 2, 2);
    let first = pose(1.0, 2.0, 0.0);
    for (i, distance) in [0.5, 0.7, 0.9, 1.8, 2.2, 2.7].into_iter().enumerate() {
        let base = facing(&first, distance, i as f64);
        learner.see(&first, &base);
        learner.learn(PICK, &first, &base, distance < 1.0);
    }
    assert_eq!(learner.n_tries(), 6);
    let next = pose(-4.0, 3.0, FRAC_PI_2);
    let mut p = |on, distance| {
        learner
            .probability(on, &next, &facing(&next, distance, 1.0))
            .unwrap()
    };
    assert!(p(PICK, 0.7) > 0.75, "{}", p(PICK, 0.7));
    assert!(p(PICK, 0.7) > p(PICK, 2.5) + 0.3, "{}", p(PICK, 2.5));
    assert!(p(PRESS, 0.7) > p(PRESS, 2.5) + 0.1);
    // An untried skill is less certain than the one that was tried.
    assert!(p(PRESS, 0.7) < p(PICK, 0.7));
}

#[test]
fn before_any_try_all_is_as_likely() {
    let object = Pose2::identity();
    let kernel = GpKernel {
        amplitude: 1.0,
        lengths: vec![1.0; 3],
    };
    let learners = [
        NavigationLearner::alone(PoseFrame::Polar),
        NavigationLearner::shared(PoseFrame::Object, 3, 2),
        NavigationLearner::with_kernel(PoseFrame::Global, kernel),
    ];
    for mut learner in learners {
        let base = facing(&object, 1.3, 0.4);
        let p = learner.probability(PICK, &object, &base).unwrap();
        assert!((p - 0.5).abs() < 1e-9, "{p}");
    }
}

/// Proposals are accepted as often as they are likely to succeed.
#[test]
fn proposals_are_accepted_with_their_probability() {
    let object = Pose2::identity();
    let mut learner = NavigationLearner::alone(PoseFrame::Polar);
    for (distance, succeeded) in [(0.6, true), (0.8, true), (2.0, false), (2.4, false)] {
        for bearing in [0.0, TAU / 3.0] {
            let base = facing(&object, distance, bearing);
            learner.see(&object, &base);
            learner.learn(PICK, &object, &base, succeeded);
        }
    }
    let base = facing(&object, 1.2, 0.3);
    let p = learner.probability(PICK, &object, &base).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let n = 2000;
    let mut accept = || learner.accept(PICK, &object, &base, &mut rng).unwrap();
    let n_accepted = (0..n).filter(|_| accept()).count();
    // Five standard deviations of a binomial.
    let error = (n_accepted as f64 / f64::from(n) - p).abs();
    assert!(
        error < 5.0 * (0.25 / f64::from(n)).sqrt(),
        "{n_accepted} {p}"
    );
}

#[test]
fn a_place_is_worth_its_success_its_news_and_its_way() {
    let choice = Choice {
        probability: 0.6,
        nats: 0.3,
        travel_m: 4.0,
    };
    let weights = Weights {
        teach_per_nat: 0.5,
        travel_per_m: 0.1,
    };
    assert!((choice.worth(&weights) - 0.35).abs() < 1e-12);
}

#[test]
fn a_pose_that_is_no_number_is_an_error() {
    let mut learner = NavigationLearner::alone(PoseFrame::Object);
    learner.learn(PICK, &Pose2::identity(), &pose(f64::NAN, 0.0, 0.0), true);
    let error = learner.symbol().unwrap_err();
    assert!(matches!(error, GpError::NotFinite { .. }), "{error}");
}
