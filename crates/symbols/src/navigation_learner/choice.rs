//! Which place to try next: where it pays, with what a later try gains by it.
//!
//! ```text
//! worth(x) = P(y = 1 | x) + w_teach I(y; f | x) − w_travel d(x)
//! ```
//!
//! P is the symbol's probability, d the way there, and I the mutual information of the outcome of the try and the
//! process (Houlsby et al., *Bayesian active learning for classification and preference learning*, 2011): how much is not
//! known of the process there, not how likely either outcome is.

use crate::gaussian_process::GpClassifier;

/// What the parts of a place's worth count, in tries that succeed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// For a nat that a try teaches.
    pub teach_per_nat: f64,
    /// For a metre on the way.
    pub travel_per_m: f64,
}

/// A place that can be tried, and what speaks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// How likely the try succeeds.
    pub probability: f64,
    /// What it teaches, nats.
    pub nats: f64,
    /// How far it is, metres.
    pub travel_m: f64,
}

impl Choice {
    /// What speaks for a point of the symbol's variables.
    pub(super) fn new(symbol: &GpClassifier, point: &[f64], travel_m: f64) -> Self {
        let (mean, variance) = symbol.latent(point);
        Self {
            probability: symbol.probability(point),
            nats: nats(mean, variance),
            travel_m,
        }
    }

    /// Its worth, in tries that succeed.
    pub fn worth(&self, weights: &Weights) -> f64 {
        self.probability + weights.teach_per_nat * self.nats - weights.travel_per_m * self.travel_m
    }
}

/// The mutual information of f ~ N(mean, variance) and an outcome with P(y = 1 | f) = 1 / (1 + exp(−f)), nats: the entropy of the
/// outcome less what of it stays once f is known, both over the same points of f, so that it is never below 0.
pub(super) fn nats(mean: f64, variance: f64) -> f64 {
    /// Points of f, evenly over this many standard deviations to either side.
    const N_POINTS: u32 = 21;
    const WIDTH: f64 = 4.0;
    let term = |p: f64| if p > 0.0 { -p * p.ln() } else { 0.0 };
    let entropy = |p: f64| term(p) + term(1.0 - p);
    let [mut weights, mut outcome, mut known] = [0.0; 3];
    for i in 0..N_POINTS {
        let at = WIDTH * (2.0 * f64::from(i) / f64::from(N_POINTS - 1) - 1.0);
        let weight = (-0.5 * at * at).exp();
        let p = 1.0 / (1.0 + (-mean - at * variance.sqrt()).exp());
        weights += weight;
        outcome += weight * p;
        known += weight * entropy(p);
    }
    (entropy(outcome / weights) - known / weights).max(0.0)
}
