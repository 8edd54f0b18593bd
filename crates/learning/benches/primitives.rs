//! Movement primitives, locally weighted regression and PI²-CMA at the sizes of an arm: 7 joints, 32 kernels.
//!
//! ```text
//! cargo x bench learning
//! ```
//!
//! With the argument `paced` it answers each line it reads, so that `experiments/policy-search/peers.py` can measure
//! it in turn with its peers.

#![expect(clippy::print_stdout, reason = "answers in paced mode")]

use std::f64::consts::PI;
use std::hint::black_box;

use divan::{AllocProfiler, Bencher};
use factotum_learning::dmp::{DmpError, DmpParams, PositionDmp};
use factotum_learning::lwr::{LocalModel, LocallyWeightedRegression, ReceptiveFields};
use factotum_learning::pi2::{Exploration, Pi2Cma, Pi2Params};
use nalgebra::{DMatrix, DVector};

#[global_allocator]
static ALLOC: AllocProfiler = AllocProfiler::system();

const N_JOINTS: usize = 7;
const N_KERNELS: usize = 32;
const STEP_S: f64 = 0.01;
const N_STEPS: usize = 100;
/// Rollouts or fits in answer to one line.
const N_PACED: usize = 200;

fn main() -> Result<(), DmpError> {
    if std::env::args().any(|argument| argument == "paced") {
        return paced();
    }
    divan::main();
    Ok(())
}

/// A second of motion of seven joints: minimum jerk, and a swing aside that differs from joint to joint.
fn demonstration(n_samples: usize) -> Vec<DVector<f64>> {
    (0..n_samples)
        .map(|k| {
            let t = k as f64 / (n_samples - 1) as f64;
            let way = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
            DVector::from_fn(N_JOINTS, |joint, _| {
                let size = (joint + 1) as f64;
                0.2 * size * way + 0.1 * (PI * t).sin().powi(3) * (size * t).cos()
            })
        })
        .collect()
}

fn learned(n_samples: usize) -> Result<PositionDmp, DmpError> {
    let params = DmpParams {
        n_kernels: N_KERNELS,
        ..DmpParams::default()
    };
    let step_s = 1.0 / (n_samples - 1) as f64;
    PositionDmp::learn(&demonstration(n_samples), step_s, &params)
}

/// The positions of a run, one column a step.
fn rollout(dmp: &PositionDmp) -> Result<DMatrix<f64>, DmpError> {
    let mut run = dmp.run(&dmp.demonstrated())?;
    let mut path = DMatrix::zeros(N_JOINTS, N_STEPS + 1);
    path.set_column(0, &run.state().position);
    for k in 1..=N_STEPS {
        path.set_column(k, &run.advance(STEP_S)?.position);
    }
    Ok(path)
}

fn paced() -> Result<(), DmpError> {
    let dmp = learned(101)?;
    for line in std::io::stdin().lines().map_while(Result::ok) {
        match line.as_str() {
            "rollout" => {
                for _ in 0..N_PACED {
                    black_box(rollout(black_box(&dmp))?);
                }
            }
            "learn 101" | "learn 1001" => {
                let n_samples = if line.ends_with("1001") { 1001 } else { 101 };
                for _ in 0..N_PACED {
                    black_box(learned(black_box(n_samples))?);
                }
            }
            _ => {
                // Errors against the demonstration: at the end, and the worst on the way.
                let (path, shown) = (rollout(&dmp)?, demonstration(N_STEPS + 1));
                let off = |k: usize| (path.column(k) - &shown[k]).amax();
                let worst = (0..=N_STEPS).map(off).fold(0.0, f64::max);
                println!("{} {}", off(N_STEPS), worst);
                continue;
            }
        }
        println!("{N_PACED}");
    }
    Ok(())
}

#[divan::bench]
fn rollout_of_a_second(bencher: Bencher<'_, '_>) {
    let Ok(dmp) = learned(101) else { return };
    bencher.bench_local(|| rollout(black_box(&dmp)));
}

/// The steps alone: nothing is allocated.
#[divan::bench]
fn hundred_steps(bencher: Bencher<'_, '_>) {
    let Ok(dmp) = learned(101) else { return };
    bencher
        .with_inputs(|| dmp.run(&dmp.demonstrated()))
        .bench_local_refs(|run| {
            let Ok(run) = run else { return };
            for _ in 0..N_STEPS {
                black_box(run.advance(STEP_S).is_ok());
            }
        });
}

#[divan::bench(args = [101, 1001])]
fn learn(bencher: Bencher<'_, '_>, n_samples: usize) {
    bencher.bench_local(|| learned(black_box(n_samples)));
}

/// Seven outputs over one input, planes of their own at 32 places.
#[divan::bench(args = [101, 1001])]
fn regression_affine(bencher: Bencher<'_, '_>, n_samples: usize) {
    let outputs = DMatrix::from_columns(&demonstration(n_samples));
    let inputs = DMatrix::from_fn(1, n_samples, |_, k| k as f64 / (n_samples - 1) as f64);
    let centers = DMatrix::from_fn(1, N_KERNELS, |_, i| i as f64 / (N_KERNELS - 1) as f64);
    let widths = DMatrix::from_element(1, N_KERNELS, 1e3);
    let Ok(fields) = ReceptiveFields::new(&centers, &widths) else {
        return;
    };
    bencher.bench_local(|| {
        let fields = black_box(fields.clone());
        LocallyWeightedRegression::fit(fields, LocalModel::Affine, &inputs, &outputs)
    });
}

const N_PARAMETERS: usize = N_JOINTS * N_KERNELS;
const N_SAMPLES: usize = 20;

/// A block for each joint, or one for all.
const BLOCKS: [&[usize]; 2] = [&[N_KERNELS; N_JOINTS], &[N_PARAMETERS]];

fn search(blocks: &[usize]) -> Option<(Pi2Cma, Vec<Vec<f64>>, Vec<f64>)> {
    let params = Pi2Params {
        exploration: Exploration::Adapted {
            share: 0.5,
            std_min: 0.03,
            std_max: 10.0,
        },
        ..Pi2Params::default()
    };
    let mean = vec![0.0; N_PARAMETERS];
    let mut search = Pi2Cma::new(mean, vec![1.0; N_PARAMETERS], blocks, params, 1).ok()?;
    let mut told = None;
    // After a few updates the covariance is full.
    for _ in 0..5 {
        let samples = search.ask(N_SAMPLES);
        let costs: Vec<f64> = samples
            .iter()
            .map(|sample| sample.iter().map(|x| (x - 1.0).powi(2)).sum())
            .collect();
        search.tell(&samples, &costs).ok()?;
        told = Some((samples, costs));
    }
    let (samples, costs) = told?;
    Some((search, samples, costs))
}

#[divan::bench(args = [7, 1])]
fn pi2cma_ask(bencher: Bencher<'_, '_>, n_blocks: usize) {
    let Some((search, ..)) = search(BLOCKS[usize::from(n_blocks == 1)]) else {
        return;
    };
    bencher.bench_local(|| black_box(&search).ask(N_SAMPLES));
}

#[divan::bench(args = [7, 1])]
fn pi2cma_tell(bencher: Bencher<'_, '_>, n_blocks: usize) {
    let Some((search, samples, costs)) = search(BLOCKS[usize::from(n_blocks == 1)]) else {
        return;
    };
    bencher
        .with_inputs(|| search.clone())
        .bench_local_refs(|search| search.tell(black_box(&samples), &costs));
}

/// The form per time step, over a second in a hundred steps.
#[divan::bench]
fn pi2cma_tell_per_step(bencher: Bencher<'_, '_>) {
    let Some((search, samples, costs)) = search(BLOCKS[0]) else {
        return;
    };
    let Ok(dmp) = learned(101) else { return };
    let Ok(activity) = dmp.parameter_activity(&dmp.demonstrated(), STEP_S, N_STEPS) else {
        return;
    };
    let activity = activity.rows(0, N_PARAMETERS).into_owned();
    let costs: Vec<Vec<f64>> = costs
        .iter()
        .enumerate()
        .map(|(k, cost)| {
            (0..N_STEPS)
                .map(|step| cost * ((step + k) as f64).cos())
                .collect()
        })
        .collect();
    bencher
        .with_inputs(|| search.clone())
        .bench_local_refs(|search| search.tell_per_step(black_box(&samples), &costs, &activity));
}
