//! Which place to try next: where it pays, with what a later try gains by it.
//!
//! ```text
//! worth(x) = P(y = 1 | x) + w_teach I(y; f | x) − w_travel d(x)
//! ```
//!
//! P is the symbol's probability, d the way there, and I the mutual information of the outcome of the try and the
//! process (Houlsby et al., *Bayesian active learning for classification and preference learning*, 2011): how much is not
//! known of the process there, not how likely either outcome is.

use std::f64::consts::{LN_2, PI};

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

/// The mutual information of f ~ N(mean, variance) and an outcome with P(y = 1 | f) = 1 / (1 + exp(−f)), nats: Houlsby's
/// closed form, with the logistic function taken as the normal distribution's of √(π/8) f.
pub(super) fn nats(mean: f64, variance: f64) -> f64 {
    let (mean, variance) = (mean * (PI / 8.0).sqrt(), variance * PI / 8.0);
    let p = normal_cdf(mean / (1.0 + variance).sqrt());
    let entropy = |p: f64| if p > 0.0 { -p * p.ln() } else { 0.0 };
    let all = entropy(p) + entropy(1.0 - p);
    // The entropy that stays once f is known, about ln 2 exp(−f² / c²) with c² = π ln 2 / 2.
    let c2 = PI * LN_2 / 2.0;
    let known =
        LN_2 * (c2 / (variance + c2)).sqrt() * (-mean * mean / (2.0 * (variance + c2))).exp();
    (all - known).max(0.0)
}

/// The normal distribution, by the logistic function it is close to, as everywhere in this crate.
fn normal_cdf(x: f64) -> f64 {
    1.0 / (1.0 + (-x * (8.0 / PI).sqrt()).exp())
}
