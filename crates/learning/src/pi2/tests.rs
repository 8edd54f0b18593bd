use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::{Exploration, Pi2Cma, Pi2Error, Pi2Params};

const ADAPTED: Pi2Params = Pi2Params {
    eliteness: 10.0,
    exploration: Exploration::Adapted {
        share: 0.5,
        std_min: 0.1,
        std_max: 2.0,
    },
};

fn search(n: usize, block_sizes: &[usize], params: Pi2Params) -> Pi2Cma {
    let mean = (0..n).map(|i| i as f64).collect();
    let std = (0..n).map(|i| 1.0 + 0.5 * i as f64).collect();
    Pi2Cma::new(mean, std, block_sizes, params, 7).unwrap()
}

/// The covariance of a search with one block.
fn covariance(search: &Pi2Cma) -> DMatrix<f64> {
    let lower = search.blocks[0].factor();
    let n = search.mean.len();
    let columns: Vec<DVector<f64>> = (0..n)
        .map(|i| {
            let mut unit = vec![0.0; n];
            unit[i] = 1.0;
            let mut column = vec![0.0; n];
            lower.add_product(&unit, &mut column);
            DVector::from_vec(column)
        })
        .collect();
    let lower = DMatrix::from_columns(&columns);
    &lower * lower.transpose()
}

/// The update as the paper prints it, for one block and costs far from the bounds.
#[test]
fn an_update_is_the_formula() {
    let mut found = search(3, &[3], ADAPTED);
    let before = covariance(&found);
    let samples = found.ask(5);
    let costs = [3.0, -1.0, 7.0, 0.0, 2.0];
    found.tell(&samples, &costs).unwrap();

    let weights: Vec<f64> = costs
        .iter()
        .map(|cost| (-10.0 * (cost + 1.0) / 8.0_f64).exp())
        .collect();
    let sum: f64 = weights.iter().sum();
    let mut mean = DVector::from_vec(vec![0.0, 1.0, 2.0]);
    let mut wanted = 0.5 * before;
    let old = mean.clone();
    for (sample, weight) in samples.iter().zip(&weights) {
        let away = DVector::from_column_slice(sample) - &old;
        mean += weight / sum * &away;
        wanted += 0.5 * weight / sum * &away * away.transpose();
    }
    assert!((DVector::from_column_slice(found.mean()) - mean).amax() < 1e-12);
    assert!((covariance(&found) - wanted).amax() < 1e-12, "{found:?}");
}

/// With one cost at the first step and equal activity, the form per step is the black-box form; a parameter that is
/// active only at steps after the cost does not move.
#[test]
fn steps_weigh_by_what_is_still_to_come() {
    let mut whole = search(3, &[3], ADAPTED);
    let mut by_step = whole.clone();
    let samples = whole.ask(4);
    let costs = [3.0, -1.0, 7.0, 0.0];
    whole.tell(&samples, &costs).unwrap();
    let each: Vec<Vec<f64>> = costs.iter().map(|cost| vec![*cost, 5.0, 0.0]).collect();
    let activity = DMatrix::from_row_slice(3, 3, &[1.0, 1.0, 1.0, 0.5, 0.0, 2.0, 0.0, 1.0, 1.0]);
    by_step.tell_per_step(&samples, &each, &activity).unwrap();
    for (a, b) in by_step.mean()[..2].iter().zip(whole.mean()) {
        assert!((a - b).abs() < 1e-12, "{by_step:?} {whole:?}");
    }
    assert_eq!(by_step.mean()[2], 2.0);
    assert!((covariance(&by_step) - covariance(&whole)).amax() < 1e-12);
}

/// Two steps, worked out by hand: at the second only the second cost counts.
#[test]
fn steps_are_averaged_by_activity_and_time_left() {
    let mut found = search(1, &[1], ADAPTED);
    let samples = vec![vec![1.0], vec![-1.0]];
    let costs = vec![vec![4.0, 0.0], vec![0.0, 1.0]];
    let activity = DMatrix::from_row_slice(1, 2, &[1.0, 3.0]);
    found.tell_per_step(&samples, &costs, &activity).unwrap();
    let worse = (-10.0_f64).exp();
    // At the first step the second rollout is better, at the second the first.
    let (first, second) = ((worse - 1.0) / (1.0 + worse), (1.0 - worse) / (1.0 + worse));
    let wanted = (2.0 * 1.0 * first + 1.0 * 3.0 * second) / (2.0 + 3.0);
    assert!((found.mean()[0] - wanted).abs() < 1e-12, "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn exploration_stays_within_its_bounds(
        seed in 0..1000_u64, costs in prop::collection::vec(-1e3..1e3f64, 60),
    ) {
        let mut found = Pi2Cma::new(vec![0.0; 4], vec![1.0, 2.0, 3.0, 4.0], &[3, 1], ADAPTED, seed).unwrap();
        for costs in costs.chunks_exact(5) {
            let samples = found.ask(5);
            // Samples farther away than were asked, so that the covariance would grow.
            let samples: Vec<Vec<f64>> = samples.iter().map(|sample| {
                sample.iter().zip(found.mean()).map(|(x, mean)| mean + 5.0 * (x - mean)).collect()
            }).collect();
            found.tell(&samples, costs).unwrap();
            for (std, first) in found.std().iter().zip(1..=4) {
                let share = std / f64::from(first);
                prop_assert!((0.1 - 1e-12..=2.0 + 1e-12).contains(&share), "{share}");
            }
            prop_assert!(found.ask(2).iter().flatten().all(|x| x.is_finite()));
        }
    }

    /// Costs count by their order and distances alone, and a permutation of samples changes only roundings.
    #[test]
    fn costs_may_be_moved_and_stretched(shift in -1e3..1e3f64, stretch in 0.1..1e3f64, costs in prop::collection::vec(0.0..1.0f64, 6)) {
        let mut one = search(2, &[2], ADAPTED);
        let mut other = one.clone();
        let mut samples = one.ask(6);
        one.tell(&samples, &costs).unwrap();
        let mut moved: Vec<f64> = costs.iter().map(|cost| shift + stretch * cost).collect();
        samples.reverse();
        moved.reverse();
        other.tell(&samples, &moved).unwrap();
        for (a, b) in one.mean().iter().zip(other.mean()) {
            prop_assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }
}

#[test]
fn samples_have_the_asked_moments() {
    let mut found = search(3, &[2, 1], ADAPTED);
    let samples = found.ask(6);
    found
        .tell(&samples, &[1.0, 4.0, 2.0, 8.0, 5.0, 7.0])
        .unwrap();
    let n = 20_000;
    let samples = found.ask(n);
    let average = |term: &dyn Fn(&[f64]) -> f64| {
        samples.iter().map(|sample| term(sample)).sum::<f64>() / n as f64
    };
    let means: Vec<f64> = (0..3).map(|i| average(&|sample| sample[i])).collect();
    let moment =
        |i: usize, j: usize| average(&|sample| (sample[i] - means[i]) * (sample[j] - means[j]));
    let std = found.std();
    for i in 0..3 {
        // Five standard errors.
        let error = 5.0 * std[i] / (n as f64).sqrt();
        assert!((means[i] - found.mean()[i]).abs() < error);
        assert!((moment(i, i) / (std[i] * std[i]) - 1.0).abs() < 0.05);
        assert!(
            i == 2 || moment(i, 2).abs() < error * std[2],
            "blocks are independent"
        );
    }
    let wanted = found.blocks[0].clone().into_covariance()[1];
    assert!((moment(0, 1) - wanted).abs() < 0.05 * std[0] * std[1]);
    assert!(
        wanted.abs() > 0.2 * std[0] * std[1],
        "a case with correlation"
    );
}

#[test]
fn a_stored_search_goes_on_to_the_bit() {
    let mut found = search(5, &[2, 3], ADAPTED);
    let cost = |sample: &Vec<f64>| sample.iter().map(|x| (x - 3.0).powi(2)).sum::<f64>();
    let go_on = |search: &mut Pi2Cma| {
        let samples = search.ask(6);
        let costs: Vec<f64> = samples.iter().map(cost).collect();
        search.tell(&samples, &costs).unwrap();
    };
    go_on(&mut found);
    let text = serde_json::to_string(&found).unwrap();
    let mut again: Pi2Cma = serde_json::from_str(&text).unwrap();
    assert_eq!(again, found);
    for search in [&mut found, &mut again] {
        (0..3).for_each(|_| go_on(search));
    }
    assert_eq!(again, found);
    let bad = text.replace("\"n_updates\":1", "\"n_updates\":1,\"n_samples\":2");
    assert!(serde_json::from_str::<Pi2Cma>(&bad).is_err());
    let mut state: super::Pi2State = serde_json::from_str(&text).unwrap();
    state.covariances[0][0] = -1.0;
    assert_eq!(
        Pi2Cma::try_from(state).unwrap_err().to_string(),
        "variance is -1, expected a number of at least 0"
    );
}

#[test]
fn a_bowl_is_descended() {
    for exploration in [ADAPTED.exploration, Exploration::Decayed { factor: 0.9 }] {
        let params = Pi2Params {
            exploration,
            ..ADAPTED
        };
        let target = [3.0, -2.0, 0.5, 1.0];
        let cost = |x: &[f64]| {
            x.iter()
                .zip(target)
                .map(|(x, t)| (x - t).powi(2))
                .sum::<f64>()
        };
        let mut found = Pi2Cma::new(vec![0.0; 4], vec![1.0; 4], &[4], params, 1).unwrap();
        for _ in 0..40 {
            let samples = found.ask(10);
            let costs: Vec<f64> = samples.iter().map(|sample| cost(sample)).collect();
            found.tell(&samples, &costs).unwrap();
        }
        assert!(
            cost(found.mean()) < 0.05,
            "{exploration:?}: {:?}",
            found.mean()
        );
    }
}

#[test]
fn equal_costs_move_nothing() {
    let mut found = search(3, &[3], ADAPTED);
    let before = found.clone();
    let samples = found.ask(4);
    found.tell(&samples, &[2.0; 4]).unwrap();
    assert_eq!((found.mean(), found.std()), (before.mean(), before.std()));
    let costs = vec![vec![1.0, 2.0]; 4];
    found
        .tell_per_step(&samples, &costs, &DMatrix::from_element(3, 2, 1.0))
        .unwrap();
    assert_eq!((found.mean(), found.std()), (before.mean(), before.std()));
    assert_ne!(
        found.ask(1),
        before.ask(1),
        "an update later, other samples"
    );
}

#[test]
fn bad_numbers_are_refused_and_change_nothing() {
    let mut found = search(2, &[2], ADAPTED);
    let before = found.clone();
    let samples = found.ask(3);
    let refused = |result: Result<(), Pi2Error>| result.unwrap_err().to_string();
    assert_eq!(
        refused(found.tell(&samples, &[1.0, f64::NAN, 2.0])),
        "entry 1 of costs is NaN, expected a finite number"
    );
    assert_eq!(
        refused(found.tell(&samples, &[1.0])),
        "costs has 1 entries, expected 3"
    );
    assert_eq!(
        refused(found.tell(&samples[..1], &[1.0])),
        "there are 1 samples, expected at least 2"
    );
    let activity = DMatrix::from_element(2, 4, -1.0);
    let costs = vec![vec![0.0; 4]; 3];
    assert_eq!(
        refused(found.tell_per_step(&samples, &costs, &activity)),
        "activity is -1, expected a number of at least 0"
    );
    let costs = vec![vec![0.0; 3]; 3];
    assert!(found.tell_per_step(&samples, &costs, &activity).is_err());
    assert_eq!(found, before);

    let make = |std: f64, sizes: &[usize], params| {
        Pi2Cma::new(vec![0.0; 2], vec![std; 2], sizes, params, 0)
    };
    assert!(make(-1.0, &[2], ADAPTED).is_err());
    assert!(make(1.0, &[1], ADAPTED).is_err());
    assert!(
        make(
            1.0,
            &[2],
            Pi2Params {
                eliteness: 0.0,
                ..ADAPTED
            }
        )
        .is_err()
    );
    for exploration in [
        Exploration::Decayed { factor: 1.5 },
        Exploration::Adapted {
            share: 2.0,
            std_min: 0.0,
            std_max: 1.0,
        },
        Exploration::Adapted {
            share: 0.5,
            std_min: 2.0,
            std_max: 1.0,
        },
    ] {
        assert!(
            make(
                1.0,
                &[2],
                Pi2Params {
                    exploration,
                    ..ADAPTED
                }
            )
            .is_err()
        );
    }
}
