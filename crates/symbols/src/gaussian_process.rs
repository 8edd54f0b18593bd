//! Gaussian process classification, for symbols with few samples such as navigation symbols.
//!
//! ```text
//! f ~ GP(0, k),   P(y = 1 | x) = 1 / (1 + exp(−f(x))),   k(a, b) = σ² exp(−½ Σ_m (a_m − b_m)² / ℓ_m²)
//! ```
//!
//! The posterior of f is approximated by Laplace's method, and σ and the ℓ_m (one a variable: automatic
//! relevance determination) are those of the greatest marginal likelihood times their priors, climbed along its
//! gradient (Rasmussen & Williams, *Gaussian Processes for Machine Learning*, 2006, Algorithms 3.1, 3.2 and 5.1). The
//! dissertation's navigation symbols are such classifiers (5.4), with fixed σ = ℓ = 1 in its code.
//!
//! Where we differ:
//!
//! - ln σ and ln ℓ_m have normal priors around the data's own spread, so that few or one-sided samples cannot
//!   drive a length to nothing or to infinity;
//! - the kernel is taken as L Lᵀ with as many columns as it has rank, to 10⁻⁴ of σ², by pivoted Cholesky
//!   decomposition. Kernels of a few smooth variables have little rank, so that n³ becomes n r²;
//! - the climb starts on a part of the samples and ends on all of them;
//! - probabilities are averaged over f by MacKay's approximation (Neural Computation 4, 1992).

mod climb;
mod laplace;
mod low_rank;
#[cfg(test)]
mod tests;

use crate::samples::Samples;
use climb::{Place, climb};
use laplace::Laplace;

/// Why no classifier can be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpError {
    /// Not as many labels as samples.
    #[error("{n_labels} labels for {n_samples} samples")]
    Labels {
        /// Labels given.
        n_labels: usize,
        /// Samples given.
        n_samples: usize,
    },
    /// A value that is no finite number.
    #[error("variable {variable} of sample {sample} is {found}, wanted a finite number")]
    NotFinite {
        /// The sample.
        sample: usize,
        /// The variable.
        variable: usize,
        /// The value.
        found: f64,
    },
}

/// What is believed of the kernel before any sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpPrior {
    /// Median of σ; default 4, with which f spans probabilities from 0.02 to 0.98 within one σ.
    pub amplitude_median: f64,
    /// Median of ℓ_m in standard deviations of variable m; default 1.
    pub length_median: f64,
    /// Standard deviation of ln σ and ln ℓ_m; default 1.5, a factor of 20 either way within two of them.
    pub log_deviation: f64,
}

impl Default for GpPrior {
    fn default() -> Self {
        Self {
            amplitude_median: 4.0,
            length_median: 1.0,
            log_deviation: 1.5,
        }
    }
}

/// σ and ℓ.
#[derive(Debug, Clone, PartialEq)]
pub struct GpKernel {
    /// σ, the spread of f.
    pub amplitude: f64,
    /// ℓ_m, in the units of the variables.
    pub lengths: Vec<f64>,
}

impl GpKernel {
    /// exp(−½ Σ_m (a_m − b_m)² / ℓ_m²), the kernel over σ².
    fn correlation(&self, a: &[f64], b: &[f64]) -> f64 {
        let terms = a.iter().zip(b).zip(&self.lengths);
        (-0.5 * terms.map(|((a, b), l)| ((a - b) / l).powi(2)).sum::<f64>()).exp()
    }

    /// (ln σ, ln ℓ_1, ...).
    fn logs(&self) -> Vec<f64> {
        std::iter::once(self.amplitude.ln())
            .chain(self.lengths.iter().map(|l| l.ln()))
            .collect()
    }

    fn from_logs(logs: &[f64]) -> Self {
        Self {
            amplitude: logs[0].exp(),
            lengths: logs[1..].iter().map(|l| l.exp()).collect(),
        }
    }
}

/// A fitted classifier.
#[derive(Debug, Clone, PartialEq)]
pub struct GpClassifier {
    kernel: GpKernel,
    points: Samples,
    laplace: Laplace,
}

impl GpClassifier {
    /// Samples on which the climb starts.
    const N_SAMPLES_START: usize = 160;

    /// Fits to samples and whether each is positive. No samples, or samples of one class, leave much to the prior.
    ///
    /// # Errors
    /// Another number of labels, or a value that is not finite.
    pub fn fit(points: &Samples, labels: &[bool], prior: &GpPrior) -> Result<Self, GpError> {
        check(points, labels)?;
        let centre = centre(points, prior);
        Ok(Self::climbed(points, labels, &centre, prior.log_deviation))
    }

    /// Fits with a prior around a kernel, whose lengths come from elsewhere than the samples: ln σ and ln ℓ_m are
    /// normal around its own, with this standard deviation.
    ///
    /// # Errors
    /// Another number of labels, or a value that is not finite.
    ///
    /// # Panics
    /// If the kernel has another number of lengths than the samples have variables.
    pub fn fit_near(
        points: &Samples,
        labels: &[bool],
        kernel: &GpKernel,
        log_deviation: f64,
    ) -> Result<Self, GpError> {
        check(points, labels)?;
        assert_eq!(kernel.lengths.len(), points.n_variables(), "lengths");
        Ok(Self::climbed(points, labels, &kernel.logs(), log_deviation))
    }

    /// The posterior for a kernel that is given and stays as it is.
    ///
    /// # Errors
    /// Another number of labels, or a value that is not finite.
    ///
    /// # Panics
    /// If the kernel has another number of lengths than the samples have variables.
    pub fn with_kernel(
        points: &Samples,
        labels: &[bool],
        kernel: GpKernel,
    ) -> Result<Self, GpError> {
        check(points, labels)?;
        assert_eq!(kernel.lengths.len(), points.n_variables(), "lengths");
        Ok(Self::posterior(points, labels, kernel))
    }

    /// The kernel of the greatest posterior, where its logarithms are normal around `centre`.
    fn climbed(points: &Samples, labels: &[bool], centre: &[f64], log_deviation: f64) -> Self {
        let starts = starts(centre);
        let log_prior = |logs: &[f64]| -> f64 {
            let z = logs
                .iter()
                .zip(centre)
                .map(|(x, c)| (x - c) / log_deviation);
            z.map(|z| -0.5 * z * z).sum()
        };
        // The log posterior of the hyperparameters, but for a constant, and its gradient.
        let objective = |points: &Samples, labels: &[bool], logs: &[f64], start: &mut Vec<f64>| {
            let kernel = GpKernel::from_logs(logs);
            let laplace = Laplace::new(&kernel, points, labels, start);
            let mut gradient = laplace.gradient(&kernel, points);
            for ((g, x), c) in gradient.iter_mut().zip(logs).zip(centre) {
                *g -= (x - c) / log_deviation.powi(2);
            }
            start.clone_from(laplace.residual());
            (
                laplace.log_marginal_likelihood() + log_prior(logs),
                gradient,
            )
        };
        let part = evenly(labels, Self::N_SAMPLES_START);
        let few = points.select(&part);
        let few_labels: Vec<bool> = part.iter().map(|&i| labels[i]).collect();
        let mut places: Vec<Place> = (starts.iter())
            .map(|logs| {
                let mut mode = Vec::new();
                let climbed = &mut |logs: &[f64]| objective(&few, &few_labels, logs, &mut mode);
                climb(Place::new(logs.clone()), climbed)
            })
            .collect();
        if part.len() < points.len() {
            // More samples may tell tops apart that few do not, so the starts stay in the race.
            let share = part.len() as f64 / points.len() as f64;
            places.extend(starts.iter().map(|logs| Place::new(logs.clone())));
            for place in &mut places {
                // As many samples more, as much more is the function bent.
                place.inverse = place.inverse.take().map(|inverse| inverse * share);
                let laplace = Laplace::new(&GpKernel::from_logs(&place.at), points, labels, &[]);
                place.value = laplace.log_marginal_likelihood() + log_prior(&place.at);
            }
            places.sort_by(|a, b| b.value.total_cmp(&a.value));
            places.truncate(1);
            let mut mode = Vec::new();
            let climbed = &mut |logs: &[f64]| objective(points, labels, logs, &mut mode);
            places = places
                .into_iter()
                .map(|place| climb(place, climbed))
                .collect();
        }
        places.sort_by(|a, b| b.value.total_cmp(&a.value));
        let logs = places.swap_remove(0).at;
        Self::posterior(points, labels, GpKernel::from_logs(&logs))
    }

    fn posterior(points: &Samples, labels: &[bool], kernel: GpKernel) -> Self {
        let laplace = Laplace::new(&kernel, points, labels, &[]);
        Self {
            points: points.clone(),
            kernel,
            laplace,
        }
    }

    /// σ and ℓ.
    pub fn kernel(&self) -> &GpKernel {
        &self.kernel
    }

    /// ln of the probability of the labels given the kernel, by Laplace's approximation.
    pub fn log_marginal_likelihood(&self) -> f64 {
        self.laplace.log_marginal_likelihood()
    }

    /// Mean and variance of f at a point.
    pub fn latent(&self, point: &[f64]) -> (f64, f64) {
        let variance = self.kernel.amplitude.powi(2);
        let kernel: Vec<f64> = (self.points.rows())
            .map(|row| variance * self.kernel.correlation(row, point))
            .collect();
        let (mean, explained) = self.laplace.predict(&kernel);
        (mean, (variance - explained).max(0.0))
    }

    /// How likely the point is positive.
    pub fn probability(&self, point: &[f64]) -> f64 {
        let (mean, variance) = self.latent(point);
        logistic(mean / (1.0 + std::f64::consts::PI * variance / 8.0).sqrt())
    }
}

fn logistic(f: f64) -> f64 {
    1.0 / (1.0 + (-f).exp())
}

fn check(points: &Samples, labels: &[bool]) -> Result<(), GpError> {
    if labels.len() != points.len() {
        return Err(GpError::Labels {
            n_labels: labels.len(),
            n_samples: points.len(),
        });
    }
    for (sample, row) in points.rows().enumerate() {
        if let Some(variable) = row.iter().position(|x| !x.is_finite()) {
            return Err(GpError::NotFinite {
                sample,
                variable,
                found: row[variable],
            });
        }
    }
    Ok(())
}

/// The middle of the prior, as logarithms: each length is in proportion to the spread of its variable (1 if it does not
/// vary).
fn centre(points: &Samples, prior: &GpPrior) -> Vec<f64> {
    let log_length = |spread: f64| (prior.length_median * spread).ln();
    std::iter::once(prior.amplitude_median.ln())
        .chain(points.spreads().into_iter().map(log_length))
        .collect()
}

/// Where the climbs start, as logarithms: first the middle of the prior, then the same with all lengths equal to their
/// geometric mean.
fn starts(centre: &[f64]) -> [Vec<f64>; 2] {
    let n_lengths = centre.len() - 1;
    let mean = centre[1..].iter().sum::<f64>() / n_lengths.max(1) as f64;
    let mut level = vec![mean; n_lengths + 1];
    level[0] = centre[0];
    [centre.to_vec(), level]
}

/// All samples, or about `n` at even steps through each class.
fn evenly(labels: &[bool], n: usize) -> Vec<usize> {
    if labels.len() <= n {
        return (0..labels.len()).collect();
    }
    let mut chosen = Vec::with_capacity(n);
    for class in [false, true] {
        let of_class: Vec<usize> = (0..labels.len()).filter(|&i| labels[i] == class).collect();
        let n_wanted = (n * of_class.len()).div_ceil(labels.len());
        chosen.extend((0..n_wanted).map(|k| of_class[k * of_class.len() / n_wanted]));
    }
    chosen.sort_unstable();
    chosen
}
