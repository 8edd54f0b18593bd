//! TD3 updates per second at the sizes of a contact skill, beside the matrix products alone.
//!
//! Observation 50, action 13, two hidden layers of 64, batch 256, one thread. The parts of each round are measured in
//! turn, so that a machine that slows down slows down all of them, and the ratios hold.
//!
//! ```text
//! cargo x bench learning
//! ```
//!
//! With the argument `paced` it makes 250 updates of 64 x 64 for each line it reads and answers with a line, so that
//! `experiments/td3-updates` can measure it in turn with its peers.

#![expect(clippy::print_stdout, reason = "a benchmark prints what it measured")]

use std::hint::black_box;
use std::time::Instant;

use factotum_learning::replay::{Ending, Transition};
use factotum_learning::td3::{Td3, Td3Error, Td3Params};
use nalgebra::DMatrix;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

const N_OBSERVATION: usize = 50;
const N_ACTION: usize = 13;
const BATCH: usize = 256;
const UNITS: usize = 64;
/// Short, so that many rounds pass while nothing else runs on the processor.
const N_UPDATES: u32 = 50;
const N_ROUNDS: usize = 150;
const N_UPDATES_PACED: u32 = 250;

fn main() -> Result<(), Td3Error> {
    if std::env::args().any(|argument| argument == "paced") {
        return paced();
    }
    let plain = Td3Params::default();
    let with_norm = Td3Params {
        critic_layer_norm: true,
        ..Td3Params::default()
    };
    let wide = Td3Params {
        hidden: vec![256, 256],
        ..Td3Params::default()
    };
    let mut plain = learner(plain)?;
    let mut with_norm = learner(with_norm)?;
    let mut wide = learner(wide)?;
    let mut products = Products::new();
    let mut rows: [Vec<f64>; 4] = Default::default();
    for _ in 0..N_ROUNDS {
        rows[0].push(per_second(N_UPDATES, || plain.update().map(drop))?);
        rows[1].push(per_second(N_UPDATES, || {
            products.of_one_update();
            Ok(())
        })?);
        rows[2].push(per_second(N_UPDATES / 2, || with_norm.update().map(drop))?);
        rows[3].push(per_second(N_UPDATES / 10, || wide.update().map(drop))?);
    }
    let bound = median(&rows[1]);
    println!(
        "TD3, observation {N_OBSERVATION}, action {N_ACTION}, batch {BATCH}, one thread, {N_ROUNDS} rounds"
    );
    println!("| | updates/s, median | least | most | of the products alone |");
    println!("|---|---|---|---|---|");
    for (name, rates) in [
        "64 x 64",
        "64 x 64, its products alone by `matrixmultiply`",
        "64 x 64, layer normalisation",
        "256 x 256",
    ]
    .iter()
    .zip(&rows)
    {
        let least = rates.iter().copied().fold(f64::INFINITY, f64::min);
        let most = rates.iter().copied().fold(0.0, f64::max);
        let middle = median(rates);
        println!(
            "| {name} | {middle:.0} | {least:.0} | {most:.0} | {:.2} |",
            middle / bound
        );
    }
    Ok(())
}

/// Updates for each line read, until there is none.
fn paced() -> Result<(), Td3Error> {
    let mut learner = learner(Td3Params::default())?;
    for _ in std::io::stdin().lines().map_while(Result::ok) {
        for _ in 0..N_UPDATES_PACED {
            learner.update()?;
        }
        println!("{N_UPDATES_PACED}");
    }
    Ok(())
}

/// A learner with five thousand transitions.
fn learner(params: Td3Params) -> Result<Td3, Td3Error> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let params = Td3Params {
        replay_capacity: 5_000,
        ..params
    };
    let mut learner = Td3::new(N_OBSERVATION, N_ACTION, params, 1)?;
    let mut next = [0.0; N_OBSERVATION];
    let mut action = [0.0; N_ACTION];
    for step in 0..5_000 {
        let observation = next;
        next.fill_with(|| rng.random_range(-1.0..1.0));
        action.fill_with(|| rng.random_range(-1.0..1.0));
        learner.record(&Transition {
            observation: &observation,
            action: &action,
            reward: rng.random_range(0.0..0.1),
            next_observation: &next,
            ending: if step % 100 == 99 {
                Ending::Cut
            } else {
                Ending::Goes
            },
        })?;
    }
    Ok(learner)
}

fn per_second(n: u32, mut act: impl FnMut() -> Result<(), Td3Error>) -> Result<f64, Td3Error> {
    let start = Instant::now();
    for _ in 0..n {
        act()?;
    }
    Ok(f64::from(n) / start.elapsed().as_secs_f64())
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// The matrix products of one update and nothing else, by `matrixmultiply`, which `nalgebra` hands large products to.
///
/// Only their sizes are those of an update. The twin critics' first layers are one product, as in the learner.
struct Products {
    n_updates: u32,
    of_critics: Vec<Product>,
    of_policy: Vec<Product>,
}

struct Product {
    a: DMatrix<f32>,
    b: DMatrix<f32>,
    out: DMatrix<f32>,
}

impl Products {
    fn new() -> Self {
        let (input, hidden) = (N_OBSERVATION + N_ACTION, UNITS);
        let policy = [
            (BATCH, N_OBSERVATION, hidden),
            (BATCH, hidden, hidden),
            (BATCH, hidden, N_ACTION),
        ];
        let critic = [(BATCH, hidden, hidden), (BATCH, hidden, 1)];
        let critics = [&[(BATCH, input, 2 * hidden)][..], &critic, &critic].concat();
        let critic_back = [
            (hidden, BATCH, 1),
            (hidden, BATCH, hidden),
            (BATCH, 1, hidden),
            (BATCH, hidden, hidden),
        ];
        let of_critics = [
            &policy[..],
            &critics,
            &critics,
            &[(input, BATCH, 2 * hidden)],
            &critic_back,
            &critic_back,
        ]
        .concat();
        let to_input = [
            (BATCH, input, hidden),
            (BATCH, hidden, hidden),
            (BATCH, hidden, 1),
            (BATCH, 1, hidden),
            (BATCH, hidden, hidden),
            (BATCH, hidden, N_ACTION),
        ];
        let policy_back = [
            (hidden, BATCH, N_ACTION),
            (hidden, BATCH, hidden),
            (N_OBSERVATION, BATCH, hidden),
            (BATCH, N_ACTION, hidden),
            (BATCH, hidden, hidden),
        ];
        let of_policy = [&policy[..], &to_input, &policy_back].concat();
        let matrices = |sizes: Vec<(usize, usize, usize)>| {
            let matrix = |rows, columns| DMatrix::from_element(rows, columns, 0.25_f32);
            sizes
                .into_iter()
                .map(|(rows, inner, columns)| Product {
                    a: matrix(rows, inner),
                    b: matrix(inner, columns),
                    out: matrix(rows, columns),
                })
                .collect()
        };
        Self {
            n_updates: 0,
            of_critics: matrices(of_critics),
            of_policy: matrices(of_policy),
        }
    }

    fn of_one_update(&mut self) {
        self.n_updates += 1;
        let of_policy = if self.n_updates.is_multiple_of(2) {
            &mut self.of_policy[..]
        } else {
            &mut []
        };
        for Product { a, b, out } in self.of_critics.iter_mut().chain(of_policy) {
            black_box(out).gemm(1.0, a, b, 0.0);
        }
    }
}
