//! Behaviour cloning: the policy under which demonstrations are most likely.

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::batch::Batch;
use super::error::check_range;
use super::{Demonstrations, GaussianPolicy, PolicyGradientError};
use crate::adam::Adam;
use crate::elementwise::all_finite;

/// How demonstrations are cloned, by Adam on the likelihood of batches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CloningParams {
    /// Times that all demonstrations are gone through. Dissertation: 10.
    pub n_epochs: usize,
    /// Steps in a batch. The dissertation's code: 32.
    pub batch_size: usize,
    /// Step of Adam. The dissertation's code: 1e-3.
    pub learning_rate: f64,
}

impl Default for CloningParams {
    fn default() -> Self {
        Self {
            n_epochs: 10,
            batch_size: 32,
            learning_rate: 1e-3,
        }
    }
}

/// Makes a policy more like what was shown, and returns the mean of `ln pi(a|o)` before and after each epoch.
///
/// # Errors
/// [`PolicyGradientError`] when a size differs, there is no step, or a number is not finite or out of its range.
pub fn clone_behaviour(
    policy: &mut GaussianPolicy,
    shown: &Demonstrations,
    params: &CloningParams,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<f64>, PolicyGradientError> {
    let n_steps = policy.check(shown)?;
    let rate = params.learning_rate;
    check_range("learning_rate", rate, rate > 0.0, "a finite number above 0")?;
    let size = params.batch_size;
    check_range("batch_size", size as f64, size > 0, "at least 1")?;
    let mut lanes = policy.lanes();
    let mut adam = Adam::new(lanes.len(), rate);
    let mut order: Vec<usize> = (0..n_steps).collect();
    let mut all = Batch::of(policy, &shown.observations, &shown.actions, &order);
    all.evaluate(policy);
    let mut likelihoods = vec![all.log_likelihood(policy)];
    for _ in 0..params.n_epochs {
        shuffle(&mut order, rng);
        for rows in order.chunks(size) {
            let mut batch = Batch::of(policy, &shown.observations, &shown.actions, rows);
            batch.evaluate(policy);
            // Adam descends.
            let weight = -1.0 / rows.len() as f32;
            let gradient = batch.gradient(policy, |_| weight);
            adam.step(&mut lanes, &gradient);
            if !all_finite(&lanes) {
                return Err(PolicyGradientError::Diverged);
            }
            policy.set_lanes(&lanes);
            lanes = policy.lanes();
        }
        all.evaluate(policy);
        likelihoods.push(all.log_likelihood(policy));
    }
    Ok(likelihoods)
}

/// Every order alike (Fisher & Yates).
fn shuffle(order: &mut [usize], rng: &mut ChaCha8Rng) {
    for last in (1..order.len()).rev() {
        order.swap(last, rng.random_range(0..=last));
    }
}
