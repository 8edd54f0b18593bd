//! The natural policy gradient, alone or with demonstrations.

use serde::{Deserialize, Serialize};

use super::advantage::{advantages, normalise, returns};
use super::batch::Batch;
use super::conjugate::{add, dot, solve};
use super::error::{check_finite, check_range, check_size};
use super::policy::divergence;
use super::{Baseline, Demonstrations, GaussianPolicy, PolicyGradientError, Trajectory};
use crate::elementwise::all_finite;

/// Lengths that are tried for one update, each half of the one before.
const N_WAYS_MAX: usize = 10;

/// How a policy is improved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NaturalGradientParams {
    /// d, twice the divergence from one policy to the next, to second order. The dissertation's code: 0.05.
    pub step: f64,
    /// What a reward is worth one step later, from 0 to 1. DAPG's code: 0.995.
    pub discount: f64,
    /// lambda of the advantages, from 0 to 1. DAPG's code: 0.97.
    pub lambda: f64,
    /// Products with the Fisher matrix for one update. DAPG's code: 10.
    pub n_products: usize,
    /// Added to the diagonal of the Fisher matrix. DAPG's code: 1e-4.
    pub damping: f64,
    /// lambda_0, the first weight of a demonstrated step. The dissertation's code: 0.01.
    pub demonstration_weight: f64,
    /// lambda_1, what is left of that weight after an update. The dissertation's code: 0.95.
    pub demonstration_decay: f64,
}

impl Default for NaturalGradientParams {
    fn default() -> Self {
        Self {
            step: 0.05,
            discount: 0.995,
            lambda: 0.97,
            n_products: 10,
            damping: 1e-4,
            demonstration_weight: 1e-2,
            demonstration_decay: 0.95,
        }
    }
}

impl NaturalGradientParams {
    fn check(&self) -> Result<(), PolicyGradientError> {
        let positive = "a finite number above 0";
        check_range("step", self.step, self.step > 0.0, positive)?;
        let not_negative = "a finite number of at least 0";
        check_range("damping", self.damping, self.damping >= 0.0, not_negative)?;
        let weight = self.demonstration_weight;
        check_range("demonstration_weight", weight, weight >= 0.0, not_negative)?;
        let n = self.n_products;
        check_range("n_products", n as f64, n > 0, "at least 1")?;
        for (field, found) in [
            ("discount", self.discount),
            ("lambda", self.lambda),
            ("demonstration_decay", self.demonstration_decay),
        ] {
            let good = (0.0..=1.0).contains(&found);
            check_range(field, found, good, "a number from 0 to 1")?;
        }
        Ok(())
    }
}

/// A policy that is being improved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NaturalGradient {
    params: NaturalGradientParams,
    policy: GaussianPolicy,
    baseline: Baseline,
    demonstrations: Option<Demonstrations>,
    n_updates: u32,
}

/// What an update found and did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NaturalUpdate {
    /// Mean of the rollouts' sums of rewards.
    pub mean_return: f64,
    /// Mean divergence from the policy before to the one after.
    pub divergence: f64,
    /// Share of the variance of returns that the baseline foresaw, at most 1.
    pub foreseen: f64,
}

impl NaturalGradient {
    /// Begins with a policy; with demonstrations it is DAPG, without them NPG.
    ///
    /// # Errors
    /// [`PolicyGradientError`] when a parameter is out of its range, or demonstrations are of other sizes than the
    /// policy, without a step or not finite.
    pub fn new(
        policy: GaussianPolicy,
        demonstrations: Option<Demonstrations>,
        params: NaturalGradientParams,
    ) -> Result<Self, PolicyGradientError> {
        params.check()?;
        if let Some(shown) = &demonstrations {
            policy.check(shown)?;
        }
        Ok(Self {
            params,
            policy,
            baseline: Baseline::default(),
            demonstrations,
            n_updates: 0,
        })
    }

    /// The policy as it is now.
    #[must_use]
    pub fn policy(&self) -> &GaussianPolicy {
        &self.policy
    }

    /// Updates made.
    #[must_use]
    pub fn n_updates(&self) -> u32 {
        self.n_updates
    }

    /// Learns from rollouts of [`Self::policy`]. When all were alike, and there are no demonstrations, the policy
    /// stays.
    ///
    /// # Errors
    /// [`PolicyGradientError`] when there is no rollout, one has no step, a size differs or a number is not finite;
    /// nothing has changed then.
    pub fn tell(
        &mut self,
        trajectories: &[Trajectory],
    ) -> Result<NaturalUpdate, PolicyGradientError> {
        let told = self.gather(trajectories)?;
        let n = told.advantages.len();
        let rows: Vec<usize> = (0..n).collect();
        let policy = &self.policy;
        let mut batch = Batch::of(policy, &told.observations, &told.actions, &rows);
        let before = (batch.evaluate(policy).to_vec(), policy.log_std.clone());
        let mut gradient = batch.gradient(policy, |row| (told.advantages[row] / n as f64) as f32);
        if let Some(shown) = &self.demonstrations {
            let NaturalGradientParams {
                demonstration_weight,
                demonstration_decay,
                ..
            } = self.params;
            let weight = demonstration_weight * demonstration_decay.powf(self.n_updates.into());
            let rows: Vec<usize> = (0..shown.actions.len() / policy.n_action()).collect();
            let mut batch = Batch::of(policy, &shown.observations, &shown.actions, &rows);
            batch.evaluate(policy);
            let weight = (weight / n as f64) as f32;
            add(&mut gradient, 1.0, &batch.gradient(policy, |_| weight));
        }
        let product = |direction: &[_]| batch.fisher_product(policy, direction);
        let (damping, n_products) = (self.params.damping, self.params.n_products);
        let natural = solve(product, &gradient, damping, n_products);
        let slope = dot(&gradient, &natural);
        let mut changed = (self.policy.clone(), 0.0);
        let mut way = (self.params.step / slope).sqrt();
        // No slope, no way.
        for _ in 0..if slope > 0.0 { N_WAYS_MAX } else { 0 } {
            let mut lanes = self.policy.lanes();
            add(&mut lanes, way, &natural);
            if !all_finite(&lanes) {
                return Err(PolicyGradientError::Diverged);
            }
            let mut tried = self.policy.clone();
            tried.set_lanes(&lanes);
            let after = (batch.evaluate(&tried), tried.log_std.as_slice());
            let before = (before.0.as_slice(), before.1.as_slice());
            let divergence = divergence(before, after, n, tried.n_action());
            if divergence <= self.params.step {
                changed = (tried, divergence);
                break;
            }
            way *= 0.5;
        }
        let (changed, divergence) = changed;
        let update = NaturalUpdate {
            mean_return: told.mean_return,
            divergence,
            foreseen: told.foreseen,
        };
        self.policy = changed;
        self.baseline = told.baseline;
        self.n_updates = self.n_updates.saturating_add(1);
        Ok(update)
    }

    /// Checks rollouts and lays them side by side, with advantages by the baseline of the update before.
    fn gather(&self, trajectories: &[Trajectory]) -> Result<Told, PolicyGradientError> {
        let what = "trajectories";
        if trajectories.is_empty() {
            return Err(PolicyGradientError::Empty { what });
        }
        let (n_observation, n_action) = (self.policy.n_observation(), self.policy.n_action());
        let mut told = Told::default();
        let mut rollouts = Vec::new();
        let mut values = Vec::new();
        for trajectory in trajectories {
            let n = trajectory.rewards.len();
            if n == 0 {
                return Err(PolicyGradientError::Empty { what: "rewards" });
            }
            let observations = &trajectory.observations;
            check_size("observations", observations.len(), n * n_observation)?;
            check_size("actions", trajectory.actions.len(), n * n_action)?;
            check_finite("observations", observations)?;
            check_finite("actions", &trajectory.actions)?;
            check_finite("rewards", &trajectory.rewards)?;
            let of_steps = self.baseline.values(n_observation, observations);
            let NaturalGradientParams {
                discount, lambda, ..
            } = self.params;
            told.advantages
                .extend(advantages(trajectory, &of_steps, discount, lambda));
            told.observations.extend(observations);
            told.actions.extend(&trajectory.actions);
            told.mean_return += trajectory
                .rewards
                .iter()
                .copied()
                .map(f64::from)
                .sum::<f64>()
                / trajectories.len() as f64;
            rollouts.push((
                observations.as_slice(),
                returns(&trajectory.rewards, discount),
            ));
            values.extend(of_steps);
        }
        told.foreseen = foreseen(rollouts.iter().flat_map(|(_, returns)| returns), &values);
        told.baseline = Baseline::fit(n_observation, &rollouts);
        normalise(&mut told.advantages);
        Ok(told)
    }
}

/// Rollouts side by side.
#[derive(Debug, Default)]
struct Told {
    observations: Vec<f32>,
    actions: Vec<f32>,
    /// Normalised.
    advantages: Vec<f64>,
    /// Fitted to these rollouts.
    baseline: Baseline,
    mean_return: f64,
    foreseen: f64,
}

/// Share of the variance of `found` that `expected` explains; 0 where there is none.
fn foreseen<'a>(found: impl Iterator<Item = &'a f64> + Clone, expected: &[f64]) -> f64 {
    let n = expected.len() as f64;
    let mean = found.clone().sum::<f64>() / n;
    let variance: f64 = found.clone().map(|x| (x - mean).powi(2)).sum();
    let left: f64 = found.zip(expected).map(|(x, y)| (x - y).powi(2)).sum();
    if variance > 0.0 {
        1.0 - left / variance
    } else {
        0.0
    }
}
