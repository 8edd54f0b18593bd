//! PI²-CMA on the via-point problem: how good is what it finds in 40 updates of 10 rollouts?
//!
//! ```text
//! cargo run --release -p factotum-learning --example via_point > experiments/policy-search/via_point.jsonl
//! ```
//!
//! The problem, the primitive and the numbers are those of dmpbbo's demonstration `demo_bbo_of_dmps`, written anew, so
//! that the figures can be laid side by side: the cost before the first update is the same to all digits given, 1.135
//! and 0.495. A primitive of half a second, at rest until its forces are learned, is
//! to pass near a point at 0.3 s (in one dimension) or at any time (in two), without much acceleration.
//!
//! ```text
//! tau y' = z,  tau z' = k (g(t) - y) - d z + s(t) sum_i w_i exp(-(x - c_i)^2 / (2 b^2)),  k = d^2 / 4,  d = 20
//! tau g' = 15 (y_end - g)       x = t / tau, at most 1       s: falls from 1 to 0 about 0.85 tau
//! J = max(0, distance to the point - 0.1) + 0.00005 mean y''^2
//! ```

#![expect(clippy::print_stdout, reason = "prints what it found")]

use factotum_learning::pi2::{Exploration, Pi2Cma, Pi2Error, Pi2Params};

const TAU_S: f64 = 0.5;
const STEP_S: f64 = 0.01;
/// One and a half durations.
const N_STEPS: usize = 75;
const N_KERNELS: usize = 10;
const N_UPDATES: usize = 40;
const N_ROLLOUTS: usize = 10;
const SEEDS: std::ops::Range<u64> = 0..10;

fn main() -> Result<(), Pi2Error> {
    let with = |exploration| Pi2Params {
        exploration,
        ..Pi2Params::default()
    };
    let share_of_dmpbbo = Exploration::Adapted {
        share: 0.5,
        std_min: 1000.0_f64.powf(-0.5),
        std_max: 10.0,
    };
    let searches = [
        ("cma", Pi2Params::default()),
        ("cma, dmpbbo's share and bound", with(share_of_dmpbbo)),
        ("decay", with(Exploration::Decayed { factor: 0.9 })),
    ];
    for n_dims in [1, 2] {
        let problem = Problem::new(n_dims);
        for (name, params) in searches {
            for seed in SEEDS {
                let costs = learn(&problem, params, seed)?;
                let line = serde_json::json!({
                    "n_dims": n_dims, "search": name, "seed": seed, "costs": costs,
                });
                println!("{line}");
            }
        }
    }
    Ok(())
}

/// Cost of the mean before the first update and after each.
fn learn(problem: &Problem, params: Pi2Params, seed: u64) -> Result<Vec<f64>, Pi2Error> {
    let n = problem.start.len() * N_KERNELS;
    let std = 1000.0_f64.sqrt();
    let mut search = Pi2Cma::new(vec![0.0; n], vec![std; n], &[n], params, seed)?;
    let mut costs = vec![problem.cost(search.mean())];
    for _ in 0..N_UPDATES {
        let samples = search.ask(N_ROLLOUTS);
        let told: Vec<f64> = samples.iter().map(|sample| problem.cost(sample)).collect();
        search.tell(&samples, &told)?;
        costs.push(problem.cost(search.mean()));
    }
    Ok(costs)
}

struct Problem {
    start: Vec<f64>,
    goal: Vec<f64>,
}

impl Problem {
    fn new(n_dims: usize) -> Self {
        let (start, goal) = ([1.8, 2.0], [4.0, 3.0]);
        Self {
            start: start[..n_dims].to_vec(),
            goal: goal[..n_dims].to_vec(),
        }
    }

    fn cost(&self, weights: &[f64]) -> f64 {
        let n_dims = self.start.len();
        let runs: Vec<Vec<[f64; 2]>> = (0..n_dims)
            .map(|dim| {
                rollout(
                    self.start[dim],
                    self.goal[dim],
                    &weights[dim * N_KERNELS..][..N_KERNELS],
                )
            })
            .collect();
        let distance = |k: usize| {
            let square: f64 = runs.iter().map(|run| (run[k][0] - 3.0).powi(2)).sum();
            square.sqrt()
        };
        let off = if n_dims == 1 {
            distance((0.3 / STEP_S).round() as usize)
        } else {
            (0..=N_STEPS).map(distance).fold(f64::INFINITY, f64::min)
        };
        let effort: f64 = runs
            .iter()
            .flatten()
            .map(|[_, acceleration]| acceleration.powi(2))
            .sum();
        (off - 0.1).max(0.0) + 5e-5 * effort / (n_dims * (N_STEPS + 1)) as f64
    }
}

/// Position and acceleration at each step, by Euler's rule, as dmpbbo integrates springs.
fn rollout(start: f64, goal: f64, weights: &[f64]) -> Vec<[f64; 2]> {
    let (mut y, mut z) = (start, 0.0);
    (0..=N_STEPS)
        .map(|k| {
            let t = k as f64 * STEP_S;
            let pulled_to = goal + (start - goal) * (-15.0 * t / TAU_S).exp();
            let force = gate(t) * forcing((t / TAU_S).min(1.0), weights);
            let change = (100.0 * (pulled_to - y) - 20.0 * z + force) / TAU_S;
            let now = [y, change / TAU_S];
            y += STEP_S * z / TAU_S;
            z += STEP_S * change;
            now
        })
        .collect()
}

/// A logistic fall whose inflection is at 0.85 of the duration.
fn gate(t: f64) -> f64 {
    1.0 / (1.0 + (15.0 * (t / TAU_S - 0.85)).exp())
}

/// Kernels evenly over the phase that meet their neighbours at 0.9 of their height.
fn forcing(phase: f64, weights: &[f64]) -> f64 {
    let gap = 1.0 / (N_KERNELS - 1) as f64;
    let square = (0.5 * gap).powi(2) / (-2.0 * 0.9_f64.ln());
    let kernels = weights.iter().enumerate();
    kernels
        .map(|(i, weight)| weight * (-0.5 * (phase - i as f64 * gap).powi(2) / square).exp())
        .sum()
}
