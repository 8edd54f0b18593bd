//! What a step is worth on average: ridge regression of returns on the observation, its squares, and powers of time.
//!
//! Duan, Chen, Houthooft, Schulman & Abbeel, "Benchmarking Deep Reinforcement Learning for Continuous Control", ICML
//! 2016, arXiv 1604.06778: the linear feature baseline. Where we differ: observations are standardised first, and time
//! is a share of the longest rollout. The dissertation's code fits a network.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Added to the sum of squares of each feature. The dissertation's code: 1e-3.
const RIDGE: f64 = 1e-3;
/// Standardised observations are cut here, so that what was never seen is not extrapolated far.
const LIMIT: f64 = 10.0;
const N_POWERS: i32 = 4;

/// A fitted value of observations and times; zero before it is fitted.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    shift: Vec<f64>,
    scale: Vec<f64>,
    n_steps: f64,
    coefficients: Vec<f64>,
}

impl Baseline {
    /// Fits to rollouts: observations row after row, and the return of each step.
    pub(super) fn fit(n_observation: usize, rollouts: &[(&[f32], Vec<f64>)]) -> Self {
        let rows = || {
            rollouts
                .iter()
                .flat_map(|(observations, _)| observations.chunks_exact(n_observation))
        };
        let n = rows().count() as f64;
        let mut fitted = Self {
            n_steps: rollouts
                .iter()
                .map(|(_, returns)| returns.len())
                .max()
                .unwrap_or(1) as f64,
            ..Self::default()
        };
        for i in 0..n_observation {
            let mean = rows().map(|row| f64::from(row[i])).sum::<f64>() / n;
            let square = rows()
                .map(|row| (f64::from(row[i]) - mean).powi(2))
                .sum::<f64>()
                / n;
            let std = square.sqrt();
            fitted.shift.push(mean);
            fitted.scale.push(if std > 1e-6 * mean.abs().max(1e-6) {
                std
            } else {
                1.0
            });
        }
        let n_features = fitted.features(0, &vec![0.0; n_observation]).len();
        let mut squares = DMatrix::identity(n_features, n_features) * RIDGE;
        let mut along = DVector::zeros(n_features);
        for (observations, returns) in rollouts {
            let rows = observations.chunks_exact(n_observation);
            for (t, (row, value)) in rows.zip(returns).enumerate() {
                let features = DVector::from_vec(fitted.features(t, row));
                squares.ger(1.0, &features, &features, 1.0);
                along.axpy(*value, &features, 1.0);
            }
        }
        // The ridge makes it positive; without a decomposition nothing is known.
        let solved = squares.cholesky().map(|squares| squares.solve(&along));
        fitted.coefficients = solved.map_or_else(Vec::new, |solved| solved.as_slice().to_vec());
        fitted
    }

    /// The values of a rollout's steps, for observations row after row.
    pub(super) fn values(&self, n_observation: usize, observations: &[f32]) -> Vec<f64> {
        let rows = observations.chunks_exact(n_observation).enumerate();
        rows.map(|(t, row)| {
            if self.coefficients.is_empty() {
                return 0.0;
            }
            let features = self.features(t, row);
            features
                .iter()
                .zip(&self.coefficients)
                .map(|(x, c)| x * c)
                .sum()
        })
        .collect()
    }

    fn features(&self, t: usize, observation: &[f32]) -> Vec<f64> {
        let components = observation.iter().zip(self.shift.iter().zip(&self.scale));
        let standard: Vec<f64> = components
            .map(|(x, (shift, scale))| ((f64::from(*x) - shift) / scale).clamp(-LIMIT, LIMIT))
            .collect();
        let time = t as f64 / self.n_steps;
        let squares = standard.iter().map(|x| x * x);
        standard
            .iter()
            .copied()
            .chain(squares)
            .chain((0..=N_POWERS).map(|power| time.powi(power)))
            .collect()
    }
}
