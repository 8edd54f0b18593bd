use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::*;

/// A disc of positives among negatives, of which some labels are wrong.
fn disc(n: usize, noise: f64, seed: u64) -> Labelled {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut positive, mut negative) = (Samples::new(2), Samples::new(2));
    for _ in 0..n {
        let point: [f64; 2] = [rng.random(), rng.random()];
        let inside = (point[0] - 0.5).hypot(point[1] - 0.5) < 0.3;
        if inside != (rng.random::<f64>() < noise) {
            positive.push(&point);
        } else {
            negative.push(&point);
        }
    }
    Labelled::new(&positive, &negative, 3, &mut rng)
}

fn classifier(data: &Labelled, params: SvmParams) -> SupportVectorClassifier {
    let kernel = Kernel::new(&data.points);
    SupportVectorClassifier::train(data, &kernel, params)
}

const PARAMS: SvmParams = SvmParams {
    cost: 5.0,
    gamma: 10.0,
};

/// The conditions of Karush, Kuhn and Tucker, and the equality.
#[test]
fn the_solution_is_optimal() {
    let data = disc(200, 0.1, 1);
    let signs = data.signs();
    let bounds = balanced_bounds(&data.weights, data.n_negative, PARAMS.cost);
    let kernel = Kernel::new(&data.points);
    let rows = kernel.at(PARAMS.gamma);
    let solution = solve(&rows, &signs, &bounds, None);
    let sum: f64 = signs.iter().zip(&solution.alpha).map(|(y, a)| y * a).sum();
    assert!(sum.abs() < 1e-9, "{sum}");
    let mut n_kinds = [0; 3];
    for i in 0..signs.len() {
        let margin = signs[i] * solution.decision(i, &signs);
        let (alpha, bound) = (solution.alpha[i], bounds[i]);
        assert!((0.0..=bound).contains(&alpha));
        let (kind, right) = match (alpha == 0.0, alpha == bound) {
            (true, _) => (0, margin > 1.0 - 2e-3),
            (_, true) => (1, margin < 1.0 + 2e-3),
            _ => (2, (margin - 1.0).abs() < 2e-3),
        };
        n_kinds[kind] += 1;
        assert!(right, "margin {margin} at {alpha} of {bound}");
    }
    assert!(n_kinds.iter().all(|n| *n > 0), "{n_kinds:?}");
}

/// Started from the solution of a lower C, the search ends at the same decision values.
#[test]
fn a_warm_start_changes_the_way_and_not_the_end() {
    let data = disc(150, 0.1, 2);
    let signs = data.signs();
    let kernel = Kernel::new(&data.points);
    let rows = kernel.at(6.0);
    let bounds = |cost| balanced_bounds(&data.weights, data.n_negative, cost);
    let low = solve(&rows, &signs, &bounds(1.0), None);
    let warm = solve(&rows, &signs, &bounds(9.0), Some(&low));
    let cold = solve(&rows, &signs, &bounds(9.0), None);
    for i in 0..signs.len() {
        let gap = warm.decision(i, &signs) - cold.decision(i, &signs);
        assert!(gap.abs() < 5e-3, "{gap}");
    }
}

#[test]
fn a_point_that_comes_twice_weighs_two() {
    let rows = [[0.1], [0.1], [0.4], [0.4], [0.4], [0.9]];
    let positive = Samples::from_rows(1, [[0.6], [0.6], [0.8]]);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let once = Labelled::new(&positive, &Samples::from_rows(1, rows), 3, &mut rng);
    assert_eq!(once.weights, [2.0, 3.0, 1.0, 2.0, 1.0]);
    let mut each = Labelled {
        points: Samples::from_rows(1, rows),
        weights: vec![1.0; 9],
        n_negative: 6,
        folds: Vec::new(),
    };
    positive.rows().for_each(|row| each.points.push(row));
    let decide = |data: &Labelled, point: f64| classifier(data, PARAMS).decision(&[point]);
    for point in [0.0, 0.3, 0.65, 0.85, 1.0] {
        let gap = decide(&once, point) - decide(&each, point);
        assert!(gap.abs() < 3e-3, "{point}: {gap}");
    }
    // Seen through no variable at all, everything is one point of each class.
    assert_eq!(once.project(&[]).weights, [6.0, 3.0]);
}

/// Bayes' classifier is right 9 times in 10 here, on held-out samples too.
#[test]
fn a_noisy_disc_is_learned_with_honest_probabilities() {
    let (train, test) = (disc(400, 0.1, 3), disc(2000, 0.1, 4));
    let kernel = Kernel::new(&train.points);
    let found = SvmGrid::default().search(&train, &kernel);
    assert!(found.score > 0.83, "{found:?}");
    let svm = SupportVectorClassifier::train(&train, &kernel, found.params);
    let n = test.points.len();
    let likelihood: f64 = (0..n)
        .map(|i| {
            let p = svm.probability(test.points.row(i));
            if i < test.n_negative {
                (1.0 - p).ln()
            } else {
                p.ln()
            }
        })
        .sum();
    // Bayes' classifier has -0.325; guessing the class's share -0.65.
    assert!(likelihood / n as f64 > -0.42, "{}", likelihood / n as f64);
    assert!(svm.probability(&[0.5, 0.5]) > 0.75);
    assert!(svm.probability(&[0.05, 0.05]) < 0.25);
}

/// From coarse to fine finds what looking at every cell finds.
#[test]
fn the_search_is_as_good_as_the_whole_grid() {
    let grid = SvmGrid::default();
    for seed in 0..4 {
        let data = disc(150, 0.15, 10 + seed);
        let kernel = Kernel::new(&data.points);
        let found = grid.search(&data, &kernel);
        let mut best: f64 = 0.0;
        for &cost in &grid.costs {
            for &gamma in &grid.gammas {
                let params = SvmParams { cost, gamma };
                let score = grid::cross_validate(&data, &kernel, params, 0.0).unwrap();
                best = best.max(score);
            }
        }
        assert!(found.score > best - 0.01, "{} of {best}", found.score);
    }
}

#[test]
fn two_samples_are_enough_not_to_fail() {
    let data = Labelled::new(
        &Samples::from_rows(1, [[1.0]]),
        &Samples::from_rows(1, [[0.0]]),
        3,
        &mut ChaCha8Rng::seed_from_u64(0),
    );
    assert_eq!(data.n_folds(), 0);
    let svm = classifier(&data, PARAMS);
    assert!(svm.decision(&[1.0]) > 0.0 && svm.decision(&[0.0]) < 0.0);
    assert!(svm.probability(&[1.0]) > svm.probability(&[0.0]));
}

#[test]
fn the_same_seed_gives_the_same_classifier() {
    let data = disc(80, 0.2, 7);
    assert_eq!(classifier(&data, PARAMS), classifier(&data, PARAMS));
}
