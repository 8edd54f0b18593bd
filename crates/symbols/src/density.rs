//! Densities of states: kernel density estimates whose bandwidth is chosen by cross-validation.
//!
//! ```text
//! p(x) = Σ_i w_i N(x; x_i, h² I) / Σ_i w_i
//! ```
//!
//! (Rosenblatt 1956, Parzen 1962; dissertation 5.4.) The bandwidth h is that with the greatest
//! likelihood of held-out samples. The distances of a held-out sample to all others serve every
//! bandwidth, and the search goes from coarse to fine. To leave variables out of such a density is to
//! leave them out of its samples, with no more sampling and no other bandwidth needed.

use std::f64::consts::TAU;

use rand::seq::SliceRandom as _;
use rand::{Rng, RngExt as _};
use rand_distr::{Distribution as _, StandardNormal};

use crate::samples::{Distinct, Samples};

/// Which bandwidths to choose from and how.
#[derive(Debug, Clone, PartialEq)]
pub struct BandwidthGrid {
    /// The bandwidths, ascending, in the units of the variables.
    pub bandwidths: Vec<f64>,
    /// Folds of the cross-validation.
    pub n_folds: usize,
}

impl Default for BandwidthGrid {
    /// 0.001, 0.002, ..., 0.099 in 3 folds, as in the reference of dissertation 5.4
    /// (`effect_bandwidth_range` of skills-to-symbols).
    fn default() -> Self {
        Self {
            bandwidths: (1..100).map(|i| 0.001 * f64::from(i)).collect(),
            n_folds: 3,
        }
    }
}

impl BandwidthGrid {
    /// Steps of the coarse pass.
    const STRIDE: usize = 8;

    /// The likeliest bandwidth and the log-likelihood per held-out sample; the least bandwidth and no
    /// likelihood where there are fewer than two samples.
    ///
    /// # Panics
    /// If there are no bandwidths.
    pub fn search(&self, samples: &Distinct, rng: &mut dyn Rng) -> (f64, Option<f64>) {
        let n_folds = self.n_folds.min(samples.n_rows());
        if n_folds < 2 {
            return (self.bandwidths[0], None);
        }
        let folds = deal(samples, n_folds, rng);
        let n = self.bandwidths.len();
        let mut scores: Vec<Option<f64>> = vec![None; n];
        let mut wanted: Vec<usize> = (0..n).step_by(Self::STRIDE).chain([n - 1]).collect();
        let mut stride = Self::STRIDE;
        loop {
            wanted.retain(|&i| scores[i].is_none());
            wanted.dedup();
            let bandwidths: Vec<f64> = wanted.iter().map(|&i| self.bandwidths[i]).collect();
            for (&i, score) in wanted.iter().zip(held_out(samples, &folds, &bandwidths)) {
                scores[i] = Some(score);
            }
            let best = best_of(&scores);
            if stride == 1 {
                return (self.bandwidths[best], scores[best]);
            }
            stride /= 2;
            wanted = vec![best.saturating_sub(stride), (best + stride).min(n - 1)];
        }
    }
}

/// The first of the greatest scores.
fn best_of(scores: &[Option<f64>]) -> usize {
    let mut best = 0;
    for i in 1..scores.len() {
        if scores[i] > scores[best] {
            best = i;
        }
    }
    best
}

/// How much of each point's weight is held out in each fold.
fn deal(samples: &Distinct, n_folds: usize, rng: &mut dyn Rng) -> Vec<Vec<f64>> {
    let mut rows: Vec<usize> = samples.point_of_row.clone();
    rows.sort_unstable();
    rows.shuffle(rng);
    let mut folds = vec![vec![0.0; samples.points.len()]; n_folds];
    for (k, point) in rows.into_iter().enumerate() {
        folds[k % n_folds][point] += 1.0;
    }
    folds
}

/// The log-likelihood per held-out sample at each bandwidth.
fn held_out(samples: &Distinct, folds: &[Vec<f64>], bandwidths: &[f64]) -> Vec<f64> {
    let n = samples.points.len();
    let n_variables = samples.points.n_variables() as f64;
    let rates: Vec<f64> = bandwidths.iter().map(|h| 0.5 / (h * h)).collect();
    let fold_weights: Vec<f64> = folds.iter().map(|test| test.iter().sum()).collect();
    let total: f64 = samples.weights.iter().sum();
    let mut scores = vec![0.0; bandwidths.len()];
    let mut distances = vec![0.0; n];
    for i in 0..n {
        let row = samples.points.row(i);
        for (j, other) in samples.points.rows().enumerate() {
            distances[j] = row
                .iter()
                .zip(other)
                .map(|(a, b)| (a - b).powi(2))
                .sum::<f64>();
        }
        for (test, fold_weight) in folds.iter().zip(&fold_weights) {
            if test[i] == 0.0 {
                continue;
            }
            let nearest = (0..n)
                .filter(|&j| samples.weights[j] > test[j])
                .map(|j| distances[j])
                .fold(f64::INFINITY, f64::min);
            for (score, rate) in scores.iter_mut().zip(&rates) {
                // Relative to the nearest, so that a sample far from all others has a likelihood still.
                let cutoff = nearest + NEGLIGIBLE / rate;
                let mut sum = 0.0;
                for j in 0..n {
                    let weight = samples.weights[j] - test[j];
                    if weight > 0.0 && distances[j] <= cutoff {
                        sum += weight * (-rate * (distances[j] - nearest)).exp();
                    }
                }
                let log_kernel = sum.ln() - rate * nearest;
                let log_scale = 0.5 * n_variables * (rate / (0.5 * TAU)).ln();
                *score += test[i] * (log_kernel + log_scale - (total - fold_weight).ln());
            }
        }
    }
    scores.iter_mut().for_each(|score| *score /= total);
    scores
}

/// A kernel e^-NEGLIGIBLE of the nearest one does not count.
const NEGLIGIBLE: f64 = 30.0;

/// A density over some of the state variables.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelDensity {
    variables: Vec<usize>,
    samples: Distinct,
    bandwidth: f64,
    held_out_log_likelihood: Option<f64>,
}

impl KernelDensity {
    /// Fits to samples of the given state variables, one column each.
    ///
    /// # Panics
    /// If there are no samples, or not as many columns as variables.
    pub fn fit(
        variables: &[usize],
        samples: &Samples,
        grid: &BandwidthGrid,
        rng: &mut dyn Rng,
    ) -> Self {
        assert!(!samples.is_empty(), "samples to fit a density to");
        assert_eq!(variables.len(), samples.n_variables(), "columns");
        let samples = Distinct::of(samples);
        let (bandwidth, held_out_log_likelihood) = grid.search(&samples, rng);
        Self {
            variables: variables.to_vec(),
            samples,
            bandwidth,
            held_out_log_likelihood,
        }
    }

    /// The state variables it is a density of, ascending.
    pub fn variables(&self) -> &[usize] {
        &self.variables
    }

    /// The samples it stands on, each point once.
    pub fn samples(&self) -> &Distinct {
        &self.samples
    }

    /// The bandwidth h, in the units of the variables.
    pub fn bandwidth(&self) -> f64 {
        self.bandwidth
    }

    /// The log-likelihood per held-out sample at this bandwidth; `None` from one sample.
    pub fn held_out_log_likelihood(&self) -> Option<f64> {
        self.held_out_log_likelihood
    }

    /// ln p(x).
    pub fn log_density(&self, point: &[f64]) -> f64 {
        let rate = 0.5 / (self.bandwidth * self.bandwidth);
        let logs: Vec<f64> = (self.samples.points.rows().zip(&self.samples.weights))
            .map(|(row, w)| {
                let squared: f64 = row.iter().zip(point).map(|(a, b)| (a - b).powi(2)).sum();
                w.ln() - rate * squared
            })
            .collect();
        let greatest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = logs.iter().map(|log| (log - greatest).exp()).sum();
        let log_scale = 0.5 * self.variables.len() as f64 * (rate / (0.5 * TAU)).ln();
        greatest + sum.ln() + log_scale - (self.samples.n_rows() as f64).ln()
    }

    /// The mean of each variable.
    pub fn mean(&self) -> Vec<f64> {
        let mut mean = vec![0.0; self.variables.len()];
        for (row, w) in self.samples.points.rows().zip(&self.samples.weights) {
            mean.iter_mut().zip(row).for_each(|(m, x)| *m += w * x);
        }
        let n = self.samples.n_rows() as f64;
        mean.iter_mut().for_each(|m| *m /= n);
        mean
    }

    /// The standard deviation of each variable, that of the kernel included.
    pub fn deviation(&self) -> Vec<f64> {
        let mean = self.mean();
        let mut variance = vec![0.0; self.variables.len()];
        for (row, w) in self.samples.points.rows().zip(&self.samples.weights) {
            for ((v, x), m) in variance.iter_mut().zip(row).zip(&mean) {
                *v += w * (x - m).powi(2);
            }
        }
        let n = self.samples.n_rows() as f64;
        let of_kernel = self.bandwidth * self.bandwidth;
        variance
            .into_iter()
            .map(|v| (v / n + of_kernel).sqrt())
            .collect()
    }

    /// Draws states.
    pub fn sample(&self, n: usize, rng: &mut dyn Rng) -> Samples {
        let mut out = Samples::new(self.variables.len());
        for _ in 0..n {
            let row = rng.random_range(0..self.samples.n_rows());
            let centre = self.samples.points.row(self.samples.point_of_row[row]);
            let drawn: Vec<f64> = centre
                .iter()
                .map(|x| {
                    let normal: f64 = StandardNormal.sample(rng);
                    x + self.bandwidth * normal
                })
                .collect();
            out.push(&drawn);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn fit(rows: &[[f64; 1]]) -> KernelDensity {
        let samples = Samples::from_rows(1, rows);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        KernelDensity::fit(&[0], &samples, &BandwidthGrid::default(), &mut rng)
    }

    fn normal_rows(n: usize, deviation: f64, seed: u64) -> Vec<[f64; 1]> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        (0..n).map(|_| [0.5 + deviation * normal()]).collect()
    }

    #[test]
    fn a_density_integrates_to_one() {
        let density = fit(&[[0.2], [0.2], [0.21], [0.6], [0.65]]);
        let step = 1e-4;
        let sum: f64 = (0..10_000)
            .map(|i| density.log_density(&[f64::from(i) * step]).exp() * step)
            .sum();
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        assert!((density.mean()[0] - 0.372).abs() < 1e-12);
    }

    /// On average near Silverman's rule for a normal density, 1.06 σ n^(-1/5); single draws vary by a factor of 2.
    #[test]
    fn the_bandwidth_fits_the_spread() {
        let bandwidth = |seed| fit(&normal_rows(400, 0.1, seed)).bandwidth();
        let mean = (0..8).map(bandwidth).sum::<f64>() / 8.0;
        let ratio = mean / (1.06 * 0.1 * 400_f64.powf(-0.2));
        assert!((0.7..1.4).contains(&ratio), "{ratio}");
    }

    /// From coarse to fine finds what trying every bandwidth finds.
    #[test]
    fn the_search_is_as_good_as_the_whole_grid() {
        let grid = BandwidthGrid::default();
        for (n, deviation) in [(30, 0.02), (100, 0.05), (300, 0.3)] {
            let samples = Distinct::of(&Samples::from_rows(1, normal_rows(n, deviation, 2)));
            let mut rng = ChaCha8Rng::seed_from_u64(3);
            let (_, found) = grid.search(&samples, &mut rng.clone());
            let folds = deal(&samples, 3, &mut rng);
            let all = held_out(&samples, &folds, &grid.bandwidths);
            let best = all.into_iter().fold(f64::NEG_INFINITY, f64::max);
            assert!(found.unwrap() > best - 1e-3, "{found:?} of {best}");
        }
    }

    #[test]
    fn what_never_varies_gets_the_least_bandwidth_and_samples_stay_there() {
        let density = fit(&[[0.7]; 9]);
        assert_eq!(density.bandwidth(), 0.001);
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let drawn = density.sample(50, &mut rng);
        assert!(drawn.rows().all(|row| (row[0] - 0.7).abs() < 0.006));
        assert_eq!(fit(&[[0.7]]).held_out_log_likelihood(), None);
    }

    #[test]
    fn draws_come_from_where_the_samples_are() {
        let density = fit(&[[0.0], [0.0], [0.0], [1.0]]);
        let drawn = density.sample(2000, &mut ChaCha8Rng::seed_from_u64(5));
        let near_one = drawn.rows().filter(|row| row[0] > 0.5).count();
        assert!((400..600).contains(&near_one), "{near_one}");
    }
}
