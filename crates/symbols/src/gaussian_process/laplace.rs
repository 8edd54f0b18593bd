//! The posterior of f at the samples, its marginal likelihood, and that likelihood's gradient.

use super::low_rank::{
    add_scaled, backward, decompose, dot, forward, inner_factor, times, transposed_times, whiten,
};
use super::{GpKernel, logistic};
use crate::samples::Samples;

/// Gain of a Newton step below which the mode is found.
const GAIN_MIN: f64 = 1e-7;

const N_STEPS_MAX: usize = 100;

/// Laplace's approximation at the mode.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Laplace {
    /// L, by columns.
    columns: Vec<Vec<f64>>,
    /// L C⁻ᵀ with C Cᵀ = I + Lᵀ W L, by columns.
    white: Vec<Vec<f64>>,
    /// f at the mode.
    mode: Vec<f64>,
    /// ∇ ln p(y | f) = K⁻¹ f: 1 or 0 less the probability.
    residual: Vec<f64>,
    /// W, the negative second derivatives of ln p(y | f).
    weights: Vec<f64>,
    log_marginal_likelihood: f64,
}

impl Laplace {
    /// Finds the mode by Newton's method, from K `start` if that is as long as the labels, else from 0.
    pub(super) fn new(kernel: &GpKernel, points: &Samples, labels: &[bool], start: &[f64]) -> Self {
        let n = labels.len();
        let columns = decompose(kernel, points);
        let image = |a: &[f64]| times(&columns, &transposed_times(&columns, a), n);
        let log_likelihood = |f: &[f64]| -> f64 {
            let term = |(f, y): (&f64, &bool)| {
                let margin = if *y { *f } else { -*f };
                // -ln(1 + e^-m), for great |m| too.
                margin.min(0.0) - (-margin.abs()).exp().ln_1p()
            };
            f.iter().zip(labels).map(term).sum()
        };
        let mut a = if start.len() == n {
            start.to_vec()
        } else {
            vec![0.0; n]
        };
        let mut f = image(&a);
        let mut objective = log_likelihood(&f) - 0.5 * dot(&a, &f);
        for _ in 0..N_STEPS_MAX {
            let (residual, weights) = derivatives(&f, labels);
            let b: Vec<f64> = (0..n).map(|i| weights[i] * f[i] + residual[i]).collect();
            let factor = inner_factor(&columns, &weights);
            let inner = backward(&factor, &forward(&factor, &transposed_times(&columns, &b)));
            let explained = times(&columns, &inner, n);
            let full: Vec<f64> = (0..n).map(|i| b[i] - weights[i] * explained[i]).collect();
            let full_f = image(&full);
            // A full step may overshoot; halves of it do not for long.
            let mut step = 1.0;
            let mut gain = 0.0;
            while step > 1e-4 {
                let mix = |old: &[f64], new: &[f64]| -> Vec<f64> {
                    old.iter()
                        .zip(new)
                        .map(|(o, n)| o + step * (n - o))
                        .collect()
                };
                let (next_a, next_f) = (mix(&a, &full), mix(&f, &full_f));
                let next = log_likelihood(&next_f) - 0.5 * dot(&next_a, &next_f);
                if next >= objective {
                    gain = next - objective;
                    (a, f, objective) = (next_a, next_f, next);
                    break;
                }
                step *= 0.5;
            }
            if gain < GAIN_MIN {
                break;
            }
        }
        let (residual, weights) = derivatives(&f, labels);
        let factor = inner_factor(&columns, &weights);
        let half_log_det: f64 = factor.iter().enumerate().map(|(i, row)| row[i].ln()).sum();
        Self {
            white: whiten(&columns, &factor),
            columns,
            mode: f,
            residual,
            weights,
            log_marginal_likelihood: objective - half_log_det,
        }
    }

    pub(super) fn log_marginal_likelihood(&self) -> f64 {
        self.log_marginal_likelihood
    }

    /// ∇ ln p(y | f) at the mode.
    pub(super) fn residual(&self) -> &Vec<f64> {
        &self.residual
    }

    /// The mean of f where the kernel to the samples is `kernel`, and how much of its variance the samples explain:
    /// kᵀ R k with R = W − V Vᵀ and V = W L C⁻ᵀ.
    pub(super) fn predict(&self, kernel: &[f64]) -> (f64, f64) {
        let weighted: Vec<f64> = kernel
            .iter()
            .zip(&self.weights)
            .map(|(k, w)| k * w)
            .collect();
        let inner: f64 = self
            .white
            .iter()
            .map(|column| dot(column, &weighted).powi(2))
            .sum();
        (dot(kernel, &self.residual), dot(kernel, &weighted) - inner)
    }

    /// The gradient along (ln σ, ln ℓ_1, ...): Algorithm 5.1 of Rasmussen & Williams.
    pub(super) fn gradient(&self, kernel: &GpKernel, points: &Samples) -> Vec<f64> {
        let n = self.mode.len();
        let n_lengths = kernel.lengths.len();
        let v: Vec<Vec<f64>> = (self.white.iter())
            .map(|column| {
                column
                    .iter()
                    .zip(&self.weights)
                    .map(|(x, w)| x * w)
                    .collect()
            })
            .collect();
        // How the mode's move changes the log determinant: s₂.
        let mut implicit = vec![0.0; n];
        for column in &self.white {
            for (s, x) in implicit.iter_mut().zip(column) {
                *s += x * x;
            }
        }
        for ((s, w), f) in implicit.iter_mut().zip(&self.weights).zip(&self.mode) {
            // W = p (1 − p), and its derivative is W (1 − 2p).
            *s *= -0.5 * w * (1.0 - 2.0 * logistic(*f));
        }
        // ln σ: ∂K = 2 K.
        let trace: f64 = (v.iter().zip(&self.white)).map(|(v, t)| dot(v, t)).sum();
        let twice: Vec<f64> = self.mode.iter().map(|f| 2.0 * f).collect();
        let mut gradient = vec![dot(&self.residual, &self.mode) - trace];
        gradient[0] += dot(&implicit, &self.moved(&v, &twice));
        // ln ℓ_m: ∂K_ij = K_ij (x_im − x_jm)² / ℓ_m², all m in one pass over the pairs.
        let variance = kernel.amplitude.powi(2);
        let mut traces = vec![0.0; n_lengths];
        let mut images = vec![vec![0.0; n]; n_lengths];
        let mut outer = vec![0.0; n];
        for i in 0..n {
            outer[..i].fill(0.0);
            for column in &v {
                add_scaled(&mut outer[..i], column[i], &column[..i]);
            }
            let own = points.row(i);
            for j in 0..i {
                let other = points.row(j);
                let k = variance * kernel.correlation(own, other);
                for m in 0..n_lengths {
                    let slope = k * ((own[m] - other[m]) / kernel.lengths[m]).powi(2);
                    traces[m] -= 2.0 * outer[j] * slope;
                    images[m][i] += slope * self.residual[j];
                    images[m][j] += slope * self.residual[i];
                }
            }
        }
        for (trace, image) in traces.iter().zip(&images) {
            let explicit = 0.5 * dot(&self.residual, image) - 0.5 * trace;
            gradient.push(explicit + dot(&implicit, &self.moved(&v, image)));
        }
        gradient
    }

    /// How the mode moves with ∂K ∇ ln p: (I − K R) b.
    fn moved(&self, v: &[Vec<f64>], b: &[f64]) -> Vec<f64> {
        let n = b.len();
        let inner = times(v, &transposed_times(v, b), n);
        let rb: Vec<f64> = (0..n).map(|i| self.weights[i] * b[i] - inner[i]).collect();
        let krb = times(&self.columns, &transposed_times(&self.columns, &rb), n);
        b.iter().zip(krb).map(|(b, k)| b - k).collect()
    }
}

/// ∇ ln p(y | f) and W.
fn derivatives(f: &[f64], labels: &[bool]) -> (Vec<f64>, Vec<f64>) {
    let probability: Vec<f64> = f.iter().map(|f| logistic(*f)).collect();
    let residual = probability
        .iter()
        .zip(labels)
        .map(|(p, y)| f64::from(u8::from(*y)) - p)
        .collect();
    (
        residual,
        probability.iter().map(|p| p * (1.0 - p)).collect(),
    )
}
