use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::*;

/// A ring around an object within which a skill works, with some chance.
fn ring(n: usize, seed: u64) -> (Samples, Vec<bool>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut points = Samples::new(2);
    let mut labels = Vec::new();
    for _ in 0..n {
        let point = [
            4.0 * rng.random::<f64>() - 2.0,
            4.0 * rng.random::<f64>() - 2.0,
        ];
        let inside = (0.5..1.2).contains(&point[0].hypot(point[1]));
        points.push(&point);
        labels.push(inside != (rng.random::<f64>() < 0.05));
    }
    (points, labels)
}

fn fit(points: &Samples, labels: &[bool]) -> GpClassifier {
    GpClassifier::fit(points, labels, &GpPrior::default()).unwrap()
}

#[test]
fn the_gradient_is_that_of_the_likelihood() {
    let (points, labels) = ring(40, 1);
    let kernel = GpKernel {
        amplitude: 2.0,
        lengths: vec![0.6, 0.9],
    };
    let value = |logs: &[f64]| {
        Laplace::new(&GpKernel::from_logs(logs), &points, &labels, &[]).log_marginal_likelihood()
    };
    let gradient = Laplace::new(&kernel, &points, &labels, &[]).gradient(&kernel, &points);
    for m in 0..3 {
        let h = 1e-3;
        let moved = |by: f64| {
            let mut logs = kernel.logs();
            logs[m] += by;
            value(&logs)
        };
        let wanted = (moved(h) - moved(-h)) / (2.0 * h);
        assert!(
            (gradient[m] - wanted).abs() < 2e-3,
            "{m}: {} and {wanted}",
            gradient[m]
        );
    }
}

/// One sample by hand: f = σ² (1 − p(f)) at the mode, and ln Z from it.
#[test]
fn one_sample_is_as_on_paper() {
    let points = Samples::from_rows(1, [[0.3]]);
    let kernel = GpKernel {
        amplitude: 1.5,
        lengths: vec![1.0],
    };
    let gp = GpClassifier::with_kernel(&points, &[true], kernel).unwrap();
    let mut f = 0.0;
    for _ in 0..200 {
        f += 0.3 * (2.25 * (1.0 - logistic(f)) - f);
    }
    let (mean, variance) = gp.latent(&[0.3]);
    assert!((mean - f).abs() < 1e-6, "{mean} and {f}");
    let w = logistic(f) * (1.0 - logistic(f));
    assert!(
        (variance - 1.0 / (1.0 / 2.25 + w)).abs() < 1e-6,
        "{variance}"
    );
    let log_z = logistic(f).ln() - 0.5 * f * f / 2.25 - 0.5 * (2.25 * w).ln_1p();
    assert!((gp.log_marginal_likelihood() - log_z).abs() < 1e-6);
}

#[test]
fn a_ring_is_learned() {
    let (points, labels) = ring(400, 2);
    let gp = fit(&points, &labels);
    let (test, truth) = ring(1000, 3);
    let likelihood: f64 = (test.rows().zip(&truth))
        .map(|(row, y)| {
            let p = gp.probability(row);
            if *y { p.ln() } else { (1.0 - p).ln() }
        })
        .sum();
    // The best possible is -0.20; guessing the share gives -0.52.
    assert!(likelihood / 1000.0 > -0.34, "{}", likelihood / 1000.0);
    assert!(gp.probability(&[0.85, 0.0]) > 0.8);
    assert!(gp.probability(&[0.0, 0.0]) < 0.5);
}

/// Far from all samples nothing is known, and a variable that does not matter gets a long length.
#[test]
fn what_is_not_known_is_not_claimed() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut points = Samples::new(2);
    (0..120).for_each(|_| points.push(&[rng.random(), rng.random()]));
    let labels: Vec<bool> = points.rows().map(|row| row[0] > 0.5).collect();
    let gp = fit(&points, &labels);
    let lengths = &gp.kernel().lengths;
    assert!(lengths[1] > 2.0 * lengths[0], "{lengths:?}");
    assert!((gp.probability(&[500.0, 500.0]) - 0.5).abs() < 1e-9);
}

/// Few or one-sided samples cannot drive the kernel anywhere: scikit-learn's lengths reach 1e4 on such data.
#[test]
fn poor_data_stay_near_the_prior() {
    let check = |points: &Samples, labels: &[bool]| {
        let gp = fit(points, labels);
        let kernel = gp.kernel();
        assert!((0.1..50.0).contains(&kernel.amplitude), "{kernel:?}");
        assert!(
            kernel.lengths.iter().all(|l| (0.02..50.0).contains(l)),
            "{kernel:?}"
        );
        gp
    };
    let none = check(&Samples::new(2), &[]);
    assert_eq!(none.probability(&[0.0, 0.0]), 0.5);
    let (points, _) = ring(50, 5);
    let all = check(&points, &[true; 50]);
    assert!(all.probability(&[0.0, 0.0]) > 0.8);
    check(
        &Samples::from_rows(2, [[1.0, 1.0]; 6]),
        &[true, false, true, false, true, false],
    );
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let coin: Vec<bool> = (0..50).map(|_| rng.random()).collect();
    check(&points, &coin);
}

#[test]
fn bad_input_is_refused() {
    let (points, labels) = ring(10, 7);
    let error = GpClassifier::fit(&points, &labels[1..], &GpPrior::default()).unwrap_err();
    assert_eq!(error.to_string(), "9 labels for 10 samples");
    let nan = Samples::from_rows(2, [[0.0, 1.0], [f64::NAN, 0.0]]);
    let error = GpClassifier::fit(&nan, &[true, false], &GpPrior::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "variable 0 of sample 1 is NaN, wanted a finite number"
    );
}
