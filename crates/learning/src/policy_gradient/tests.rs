//! Against a plain evaluation in f64, its central differences and a dense Fisher matrix; and on a point to be held.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::advantage::{advantages, normalise, returns};
use super::batch::Batch;
use super::conjugate::solve;
use super::*;
use crate::panels::{Lanes, ZERO};

const N_OBSERVATION: usize = 3;
const N_STEPS: usize = 13;

fn policy(n_action: usize, rng: &mut ChaCha8Rng) -> GaussianPolicy {
    let params = GaussianParams {
        hidden: vec![5, 4],
        output_scale: 1.0,
        ..GaussianParams::default()
    };
    let mut policy = GaussianPolicy::new(N_OBSERVATION, n_action, &params, rng).unwrap();
    let mut parameters = policy.parameters();
    for value in &mut parameters {
        *value += rng.random_range(-0.3..0.3);
    }
    policy.set_parameters(&parameters).unwrap();
    policy
}

fn steps(n_action: usize, rng: &mut ChaCha8Rng) -> Demonstrations {
    let mut draw = |n: usize| (0..n).map(|_| rng.random_range(-1.0..1.0)).collect();
    Demonstrations {
        observations: draw(N_STEPS * N_OBSERVATION),
        actions: draw(N_STEPS * n_action),
    }
}

fn batch(policy: &GaussianPolicy, steps: &Demonstrations) -> Batch {
    let rows: Vec<usize> = (0..N_STEPS).collect();
    Batch::of(policy, &steps.observations, &steps.actions, &rows)
}

/// The mean for an observation, from dense parameters in f64.
fn mean(parameters: &[f64], observation: &[f32], n_action: usize) -> Vec<f64> {
    let sizes = [N_OBSERVATION, 5, 4, n_action];
    let mut y: Vec<f64> = observation.iter().copied().map(f64::from).collect();
    let mut rest = parameters;
    for (l, size) in sizes.windows(2).enumerate() {
        let (weights, after) = rest.split_at(size[0] * size[1]);
        let (bias, after) = after.split_at(size[1]);
        y = (0..size[1])
            .map(|o| {
                let z = bias[o]
                    + y.iter()
                        .enumerate()
                        .map(|(i, y)| y * weights[i * size[1] + o])
                        .sum::<f64>();
                if l < 2 { z.tanh() } else { z }
            })
            .collect();
        rest = after;
    }
    y
}

/// `sum_rows weight ln pi(a|o)` from dense parameters in f64.
fn log_likelihood(
    parameters: &[f64],
    steps: &Demonstrations,
    n_action: usize,
    weights: &[f64],
) -> f64 {
    let log_std = &parameters[parameters.len() - n_action..];
    (0..N_STEPS)
        .map(|row| {
            let mean = mean(
                parameters,
                &steps.observations[row * N_OBSERVATION..][..N_OBSERVATION],
                n_action,
            );
            let of_action: f64 = (0..n_action)
                .map(|i| {
                    let away = f64::from(steps.actions[row * n_action + i]) - mean[i];
                    let std = log_std[i].exp();
                    -0.5 * (away / std).powi(2) - log_std[i] - 0.5 * std::f64::consts::TAU.ln()
                })
                .sum();
            weights[row] * of_action
        })
        .sum()
}

fn in_f64(values: &[f32]) -> Vec<f64> {
    values.iter().copied().map(f64::from).collect()
}

/// Central differences of a function of the parameters.
fn differences(parameters: &[f64], of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    (0..parameters.len())
        .map(|i| {
            let at = |step: f64| {
                let mut moved = parameters.to_vec();
                moved[i] += step;
                of(&moved)
            };
            (at(1e-5) - at(-1e-5)) / 2e-5
        })
        .collect()
}

#[test]
fn likelihoods_and_gradients_are_those_of_the_formula() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for n_action in [1, 2, 17] {
        let policy = policy(n_action, &mut rng);
        let steps = steps(n_action, &mut rng);
        let parameters = in_f64(&policy.parameters());
        let mut batch = batch(&policy, &steps);
        batch.evaluate(&policy);
        let even = vec![1.0 / N_STEPS as f64; N_STEPS];
        let wanted = log_likelihood(&parameters, &steps, n_action, &even);
        let found = batch.log_likelihood(&policy);
        assert!(
            (found - wanted).abs() < 1e-5 * wanted.abs(),
            "{found} {wanted}"
        );

        let weights: Vec<f64> = (0..N_STEPS).map(|_| rng.random_range(-1.0..1.0)).collect();
        let gradient = batch.gradient(&policy, |row| weights[row] as f32);
        let wanted = differences(&parameters, |at| {
            log_likelihood(at, &steps, n_action, &weights)
        });
        let largest = wanted.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
        let found = policy.dense_of(&gradient);
        assert_eq!(found.len(), wanted.len());
        for (found, wanted) in found.iter().zip(&wanted) {
            assert!(
                (f64::from(*found) - wanted).abs() < 1e-4 * largest,
                "{found} {wanted}"
            );
        }
    }
}

/// `mean J^T diag(sigma)^-2 J`, and 2 for ln sigma, with J by central differences in f64.
fn dense_fisher(policy: &GaussianPolicy, steps: &Demonstrations) -> DMatrix<f64> {
    let n_action = policy.n_action();
    let parameters = in_f64(&policy.parameters());
    let n = parameters.len();
    let mut fisher = DMatrix::zeros(n, n);
    for observation in steps.observations.chunks_exact(N_OBSERVATION) {
        for i in 0..n_action {
            let row = DVector::from_vec(differences(&parameters, |at| {
                mean(at, observation, n_action)[i]
            }));
            let precision = (-2.0 * f64::from(policy.log_std()[i])).exp();
            fisher += precision / N_STEPS as f64 * &row * row.transpose();
        }
    }
    for i in n - n_action..n {
        fisher[(i, i)] += 2.0;
    }
    fisher
}

/// A direction in panels and as dense numbers.
fn direction(policy: &GaussianPolicy, rng: &mut ChaCha8Rng) -> (Vec<Lanes>, DVector<f64>) {
    let mut moved = policy.clone();
    let values: Vec<f32> = policy
        .parameters()
        .iter()
        .map(|_| rng.random_range(-2.0..2.0))
        .collect();
    moved.set_parameters(&values).unwrap();
    (moved.lanes(), DVector::from_vec(in_f64(&values)))
}

#[test]
fn fisher_products_are_those_of_the_dense_matrix() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for n_action in [1, 2, 17] {
        let policy = policy(n_action, &mut rng);
        let steps = steps(n_action, &mut rng);
        let fisher = dense_fisher(&policy, &steps);
        let mut batch = batch(&policy, &steps);
        batch.evaluate(&policy);
        for _ in 0..3 {
            let (lanes, dense) = direction(&policy, &mut rng);
            let wanted = &fisher * dense;
            let found = policy.dense_of(&batch.fisher_product(&policy, &lanes));
            for (found, wanted_at) in found.iter().zip(&wanted) {
                let error = (f64::from(*found) - wanted_at).abs();
                assert!(error < 1e-4 * wanted.amax(), "{found} {wanted_at}");
            }
        }
    }
}

#[test]
fn conjugate_gradients_solve_the_damped_system() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let policy = policy(2, &mut rng);
    let steps = steps(2, &mut rng);
    let damping = 0.5;
    let mut fisher = dense_fisher(&policy, &steps);
    for i in 0..fisher.nrows() {
        fisher[(i, i)] += damping;
    }
    let mut batch = batch(&policy, &steps);
    batch.evaluate(&policy);
    let (wanted, dense) = direction(&policy, &mut rng);
    let found = solve(|v| batch.fisher_product(&policy, v), &wanted, damping, 60);
    let exact = fisher.lu().solve(&dense).unwrap();
    for (found, exact_at) in policy.dense_of(&found).iter().zip(&exact) {
        assert!(
            (f64::from(*found) - exact_at).abs() < 1e-3 * exact.amax(),
            "{found} {exact_at}"
        );
    }
    let nothing = solve(|v| v.to_vec(), &[ZERO; 3], 0.0, 5);
    assert_eq!(nothing, [ZERO; 3], "no division by an empty residual");
}

#[test]
fn advantages_are_the_printed_sums() {
    let trajectory = |ending| Trajectory {
        observations: vec![],
        actions: vec![],
        rewards: vec![1.0, 2.0, 4.0],
        ending,
    };
    assert_eq!(returns(&[1.0, 2.0, 4.0], 0.5), [3.0, 4.0, 4.0]);
    let values = [10.0, 20.0, 30.0];
    // d = (1 + 0.5 * 20 - 10, 2 + 0.5 * 30 - 20, 4 - 30), and 15 more at the end when it was cut.
    let found = advantages(&trajectory(Ending::Terminal), &values, 0.5, 0.5);
    assert_eq!(
        found,
        [
            1.0 + 0.25 * (-3.0 + 0.25 * -26.0),
            -3.0 + 0.25 * -26.0,
            -26.0
        ]
    );
    let found = advantages(&trajectory(Ending::Cut), &values, 0.5, 0.5);
    assert_eq!(found[2], -11.0);
    // With lambda 1 they are returns less values.
    let found = advantages(&trajectory(Ending::Terminal), &values, 0.5, 1.0);
    assert_eq!(found, [3.0 - 10.0, 4.0 - 20.0, 4.0 - 30.0]);

    let mut values = vec![1.0, 3.0];
    normalise(&mut values);
    assert_eq!(values, [-1.0, 1.0]);
    let mut equal = vec![0.1 + 0.2; 3];
    normalise(&mut equal);
    assert!(equal.iter().all(|value| *value == 0.0));
}

#[test]
fn a_baseline_finds_what_it_can_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let observations: Vec<f32> = (0..400).map(|_| rng.random_range(-3.0..5.0)).collect();
    let value = |t: usize, row: &[f32]| {
        let (x, y) = (f64::from(row[0]), f64::from(row[1]));
        7.0 + 2.0 * x - y + 0.5 * x * x - 3.0 * t as f64
    };
    let of = |observations: &[f32]| -> Vec<f64> {
        observations
            .chunks_exact(2)
            .enumerate()
            .map(|(t, row)| value(t, row))
            .collect()
    };
    let rollouts: Vec<(&[f32], Vec<f64>)> = observations
        .chunks(40)
        .map(|rows| (rows, of(rows)))
        .collect();
    let fitted = Baseline::fit(2, &rollouts);
    for (rows, wanted) in &rollouts {
        for (found, wanted) in fitted.values(2, rows).iter().zip(wanted) {
            // The ridge pulls a little: values range over 60.
            assert!((found - wanted).abs() < 0.1, "{found} {wanted}");
        }
    }
    assert_eq!(
        Baseline::default().values(2, &observations[..4]),
        [0.0, 0.0]
    );
}

/// What a proportional controller does: `a = -0.5 x`, with some noise.
fn shown(rng: &mut ChaCha8Rng) -> Demonstrations {
    let observations: Vec<f32> = (0..400).map(|_| rng.random_range(1.0..3.0)).collect();
    let actions = observations
        .iter()
        .map(|x| -0.5 * x + rng.random_range(-0.1..0.1))
        .collect();
    Demonstrations {
        observations,
        actions,
    }
}

#[test]
fn a_demonstration_is_cloned() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let shown = shown(&mut rng);
    let mut policy = GaussianPolicy::new(1, 1, &GaussianParams::default(), &mut rng).unwrap();
    policy.standardise_by(&shown).unwrap();
    let params = CloningParams {
        n_epochs: 60,
        learning_rate: 1e-2,
        ..CloningParams::default()
    };
    let likelihoods = clone_behaviour(&mut policy, &shown, &params, &mut rng).unwrap();
    assert_eq!(likelihoods.len(), 61);
    assert!(likelihoods[60] > likelihoods[0] + 1.0, "{likelihoods:?}");
    for x in [1.2, 2.0, 2.8] {
        let mut action = [0.0];
        policy.mean_into(&[x], &mut action).unwrap();
        assert!((action[0] + 0.5 * x).abs() < 0.05, "{action:?} at {x}");
    }
    // The noise was uniform within 0.1, which has a deviation of 0.058.
    let std = policy.log_std()[0].exp();
    assert!((0.05..0.08).contains(&std), "{std}");
}

/// A point that an action moves and that is to be held at zero: `x += 0.2 a`, reward `-x^2 - 0.01 a^2`, 20 steps.
fn rollouts(policy: &GaussianPolicy, n: usize, rng: &mut ChaCha8Rng) -> Vec<Trajectory> {
    let mut policy = policy.clone();
    (0..n)
        .map(|_| {
            let mut x: f32 = rng.random_range(1.0..3.0);
            let mut trajectory = Trajectory {
                observations: vec![],
                actions: vec![],
                rewards: vec![],
                ending: Ending::Cut,
            };
            for _ in 0..20 {
                let mut action = [0.0];
                policy.sample_into(&[x], rng, &mut action).unwrap();
                trajectory.observations.push(x);
                trajectory.actions.push(action[0]);
                x += 0.2 * action[0];
                trajectory
                    .rewards
                    .push(-x * x - 0.01 * action[0] * action[0]);
            }
            trajectory
        })
        .collect()
}

fn learn(
    mut learner: NaturalGradient,
    n_updates: usize,
    rng: &mut ChaCha8Rng,
) -> (NaturalGradient, Vec<f64>) {
    let mut found = Vec::new();
    for _ in 0..n_updates {
        let told = rollouts(learner.policy(), 20, rng);
        let update = learner.tell(&told).unwrap();
        assert!(
            update.divergence > 0.0 && update.divergence <= 0.05,
            "{update:?}"
        );
        found.push(update.mean_return);
    }
    (learner, found)
}

#[test]
fn returns_improve() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let policy = GaussianPolicy::new(1, 1, &GaussianParams::default(), &mut rng).unwrap();
    let learner = NaturalGradient::new(policy, None, NaturalGradientParams::default()).unwrap();
    let (_, found) = learn(learner, 30, &mut rng);
    // Doing nothing earns about -87; the best controller about -10.
    let late = found[25..].iter().sum::<f64>() / 5.0;
    assert!(found[0] < -60.0 && late > -25.0, "{found:?}");
}

#[test]
fn demonstrations_help_and_their_weight_fades() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let shown = shown(&mut rng);
    let policy = GaussianPolicy::new(1, 1, &GaussianParams::default(), &mut rng).unwrap();
    let params = NaturalGradientParams {
        demonstration_weight: 1.0,
        ..NaturalGradientParams::default()
    };
    let likelihood = |policy: &GaussianPolicy| {
        let rows: Vec<usize> = (0..400).collect();
        let mut batch = Batch::of(policy, &shown.observations, &shown.actions, &rows);
        batch.evaluate(policy);
        batch.log_likelihood(policy)
    };
    // The first step is short enough for the second order to be right: twice the divergence is the step.
    let mut first = NaturalGradient::new(policy.clone(), None, params).unwrap();
    let update = first.tell(&rollouts(&policy, 20, &mut rng)).unwrap();
    assert!((0.015..0.035).contains(&update.divergence), "{update:?}");

    // Rollouts that say nothing: only the demonstrations move the policy.
    let mut silent = rollouts(&policy, 5, &mut rng);
    silent
        .iter_mut()
        .for_each(|trajectory| trajectory.rewards.fill(0.0));
    let mut with = NaturalGradient::new(policy.clone(), Some(shown.clone()), params).unwrap();
    with.tell(&silent).unwrap();
    assert!(likelihood(with.policy()) > likelihood(&policy) + 0.01);
    let mut without = NaturalGradient::new(policy.clone(), None, params).unwrap();
    let update = without.tell(&silent).unwrap();
    assert_eq!((without.policy(), update.divergence), (&policy, 0.0));

    let fading = NaturalGradientParams {
        demonstration_decay: 0.0,
        ..params
    };
    let mut faded = NaturalGradient::new(policy, Some(shown), fading).unwrap();
    faded.tell(&silent).unwrap();
    let once = faded.policy().clone();
    faded.tell(&silent).unwrap();
    assert_eq!(faded.policy(), &once, "nothing is left of the weight");
}

#[test]
fn a_stored_learner_goes_on_to_the_bit() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let shown = shown(&mut rng);
    let mut policy = GaussianPolicy::new(1, 1, &GaussianParams::default(), &mut rng).unwrap();
    policy.standardise_by(&shown).unwrap();
    let params = NaturalGradientParams::default();
    let learner = NaturalGradient::new(policy, Some(shown), params).unwrap();
    let (learner, _) = learn(learner, 2, &mut rng);
    let text = serde_json::to_string(&learner).unwrap();
    let again: NaturalGradient = serde_json::from_str(&text).unwrap();
    let mut same = rng.clone();
    let (learner, _) = learn(learner, 2, &mut rng);
    let (again, _) = learn(again, 2, &mut same);
    assert_eq!(learner.policy().parameters(), again.policy().parameters());
    assert_eq!(
        serde_json::to_string(&learner).unwrap(),
        serde_json::to_string(&again).unwrap()
    );
    let bad = text.replacen("\"n_observation\":1", "\"n_observation\":2", 1);
    assert!(serde_json::from_str::<NaturalGradient>(&bad).is_err());
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let policy = GaussianPolicy::new(1, 1, &GaussianParams::default(), &mut rng).unwrap();
    let mut learner =
        NaturalGradient::new(policy.clone(), None, NaturalGradientParams::default()).unwrap();
    let before = learner.clone();
    let good = rollouts(&policy, 1, &mut rng);
    let mut refused = |change: &dyn Fn(&mut Trajectory)| {
        let mut told = good.clone();
        change(&mut told[0]);
        learner.tell(&told).unwrap_err().to_string()
    };
    assert_eq!(
        refused(&|told| told.rewards[3] = f32::NAN),
        "entry 3 of rewards is NaN, expected a finite number"
    );
    assert_eq!(
        refused(&|told| told.actions.truncate(7)),
        "actions has 7 entries, expected 20"
    );
    assert_eq!(
        refused(&|told| told.rewards.clear()),
        "there are 0 rewards, expected at least 1"
    );
    assert_eq!(
        learner.tell(&[]).unwrap_err(),
        PolicyGradientError::Empty {
            what: "trajectories"
        }
    );
    assert_eq!(learner, before);

    let empty = Some(Demonstrations::default());
    let params = NaturalGradientParams::default();
    assert!(NaturalGradient::new(policy.clone(), empty, params).is_err());
    let step = 0.0;
    assert!(
        NaturalGradient::new(
            policy.clone(),
            None,
            NaturalGradientParams { step, ..params }
        )
        .is_err()
    );
    assert!(GaussianPolicy::new(0, 1, &GaussianParams::default(), &mut rng).is_err());
    let mut policy = policy;
    assert!(policy.mean_into(&[f32::NAN], &mut [0.0]).is_err());
    assert!(policy.set_parameters(&[1.0]).is_err());
}
