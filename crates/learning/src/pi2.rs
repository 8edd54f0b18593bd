//! PI²-CMA: search for the parameters of a policy by trying neighbours and averaging them by what they cost.
//!
//! ```text
//! theta_k ~ N(theta, S)                                     e_k = theta_k - theta
//! P_k     = exp(-h (J_k - min J) / (max J - min J)) / sum   h: eliteness
//! theta  <- theta + sum_k P_k e_k
//! S      <- (1 - a) S + a sum_k P_k e_k e_kᵀ                 a: share
//! ```
//!
//! The black-box form ([`Pi2Cma::tell`]) weighs a sample by the cost J of its whole rollout. The form per time step
//! ([`Pi2Cma::tell_per_step`]) has weights `P_ki` for each step i by the cost still to come, and averages over the
//! steps, early steps more than late ones, and for each parameter by its activity `g_di` then:
//!
//! ```text
//! W_kd = sum_i (N - i) g_di P_ki / sum_i (N - i) g_di       theta_d <- theta_d + sum_k W_kd e_kd
//! w_k  = sum_i (N - i) P_ki / sum_i (N - i)                 S <- (1 - a) S + a sum_k w_k e_k e_kᵀ
//! ```
//!
//! Sources: Theodorou, Buchli & Schaal, "A Generalized Path Integral Control Approach to Reinforcement Learning", JMLR
//! 11 (2010), 3137-3181; Stulp & Sigaud, "Path Integral Policy Improvement with Covariance Matrix Adaptation", ICML
//! 2012, arXiv 1206.4621. Exploration is constant over a rollout, as in the second; so the black-box form is what its
//! authors call PI^BB.
//!
//! Where we differ: standard deviations are kept within bounds instead of eigenvalues, which needs no decomposition;
//! costs that are all equal say nothing, so nothing moves then, where uniform weights would let the parameters drift.
//!
//! [`Pi2Cma::ask`] changes nothing: what is asked depends on the seed and the number of updates alone. So rollouts can
//! be made anywhere and in any order, and a search that was stored in between goes on to the bit.

mod covariance;
mod error;
mod params;
mod weights;

pub use error::Pi2Error;
pub use params::{Exploration, Pi2Params, Pi2State};

use nalgebra::DMatrix;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use serde::{Deserialize, Serialize};

use covariance::Block;
use error::{check_finite, check_size};
use weights::{StepWeights, share_by_cost};

/// A search under way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Pi2State", into = "Pi2State")]
pub struct Pi2Cma {
    params: Pi2Params,
    seed: u64,
    n_updates: u64,
    mean: Vec<f64>,
    /// Standard deviations at the start, to which the bounds are relative.
    first_std: Vec<f64>,
    blocks: Vec<Block>,
}

impl Pi2Cma {
    /// Begins at parameters and standard deviations.
    ///
    /// `block_sizes` divides the parameters into runs that are explored together; parameters of different blocks stay
    /// independent. One block per dimension of a primitive is the form of the paper; a single one learns all
    /// correlations, blocks of one learn none.
    ///
    /// # Errors
    /// [`Pi2Error`] when a size differs, or a number is not finite or out of its range.
    pub fn new(
        mean: Vec<f64>,
        std: Vec<f64>,
        block_sizes: &[usize],
        params: Pi2Params,
        seed: u64,
    ) -> Result<Self, Pi2Error> {
        params.check()?;
        if mean.is_empty() {
            return Err(Pi2Error::Empty { what: "parameters" });
        }
        check_finite("parameters", &mean)?;
        check_size("standard deviations", std.len(), mean.len())?;
        check_size("blocks, in all", block_sizes.iter().sum(), mean.len())?;
        if let Some(found) = std.iter().find(|std| !(std.is_finite() && **std >= 0.0)) {
            return Err(Pi2Error::OutOfRange {
                name: "standard deviation",
                found: *found,
                wanted: "a finite number of at least 0",
            });
        }
        let mut start = 0;
        let blocks = block_sizes.iter().map(|size| {
            let block = Block::of_std(start, &std[start..start + size]);
            start += size;
            block
        });
        Ok(Self {
            params,
            seed,
            n_updates: 0,
            blocks: blocks.collect(),
            mean,
            first_std: std,
        })
    }

    /// The parameters found so far.
    #[must_use]
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Standard deviation with which each parameter is explored now.
    #[must_use]
    pub fn std(&self) -> Vec<f64> {
        self.blocks.iter().flat_map(Block::std).collect()
    }

    /// Updates made.
    #[must_use]
    pub fn n_updates(&self) -> u64 {
        self.n_updates
    }

    /// Parameters to try next; asking again gives the same, and of more the first are the same.
    #[must_use]
    pub fn ask(&self, n_samples: usize) -> Vec<Vec<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.n_updates);
        let factors: Vec<_> = self.blocks.iter().map(Block::factor).collect();
        let mut normal = vec![0.0; self.mean.len()];
        (0..n_samples)
            .map(|_| {
                normal.fill_with(|| StandardNormal.sample(&mut rng));
                let mut sample = self.mean.clone();
                for (block, factor) in self.blocks.iter().zip(&factors) {
                    let range = block.range();
                    factor.add_product(&normal[range.clone()], &mut sample[range]);
                }
                sample
            })
            .collect()
    }

    /// Learns from what whole rollouts cost, less is better.
    ///
    /// # Errors
    /// [`Pi2Error`] when there are not as many costs as samples, or fewer than two, or a number is not finite.
    pub fn tell(&mut self, samples: &[Vec<f64>], costs: &[f64]) -> Result<(), Pi2Error> {
        self.check_samples(samples)?;
        check_size("costs", costs.len(), samples.len())?;
        check_finite("costs", costs)?;
        if let Some(shares) = share_by_cost(costs, self.params.eliteness) {
            self.update(samples, &shares, |sample, _| shares[sample]);
        } else {
            self.rest();
        }
        Ok(())
    }

    /// Learns from what each step of each rollout cost, less is better.
    ///
    /// `activity` is `(n_parameters, n_steps)`: how much each parameter had to say at each step, such as the
    /// activation of its kernel, or 1 for a goal.
    ///
    /// # Errors
    /// [`Pi2Error`] when a size differs, there are fewer than two samples, or a number is not finite.
    pub fn tell_per_step(
        &mut self,
        samples: &[Vec<f64>],
        costs: &[Vec<f64>],
        activity: &DMatrix<f64>,
    ) -> Result<(), Pi2Error> {
        self.check_samples(samples)?;
        check_size("costs", costs.len(), samples.len())?;
        check_size("activity, rows", activity.nrows(), self.mean.len())?;
        for costs in costs {
            check_size("costs of a rollout", costs.len(), activity.ncols())?;
            check_finite("costs", costs)?;
        }
        check_finite("activity", activity.as_slice())?;
        if let Some(found) = activity.iter().find(|value| **value < 0.0) {
            return Err(Pi2Error::OutOfRange {
                name: "activity",
                found: *found,
                wanted: "a number of at least 0",
            });
        }
        let weights = StepWeights::new(costs, activity, self.params.eliteness);
        if let Some(StepWeights {
            of_rollouts,
            of_parameters,
        }) = weights
        {
            self.update(samples, &of_rollouts, |sample, parameter| {
                of_parameters[(sample, parameter)]
            });
        } else {
            self.rest();
        }
        Ok(())
    }

    fn check_samples(&self, samples: &[Vec<f64>]) -> Result<(), Pi2Error> {
        if samples.len() < 2 {
            return Err(Pi2Error::TooFewSamples {
                found: samples.len(),
            });
        }
        for sample in samples {
            check_size("sample", sample.len(), self.mean.len())?;
            check_finite("sample", sample)?;
        }
        Ok(())
    }

    /// Moves the mean by the samples weighted for each parameter, and the covariance by the samples weighted whole.
    fn update(
        &mut self,
        samples: &[Vec<f64>],
        shares: &[f64],
        share_of: impl Fn(usize, usize) -> f64,
    ) {
        let away = DMatrix::from_fn(self.mean.len(), samples.len(), |parameter, sample| {
            samples[sample][parameter] - self.mean[parameter]
        });
        for (parameter, mean) in self.mean.iter_mut().enumerate() {
            *mean += (0..samples.len())
                .map(|sample| share_of(sample, parameter) * away[(parameter, sample)])
                .sum::<f64>();
        }
        if let Exploration::Adapted { share, .. } = self.params.exploration {
            for block in &mut self.blocks {
                block.blend(share, shares, &away);
            }
        }
        self.rest();
    }

    /// What is done after every update, whatever it learned.
    fn rest(&mut self) {
        for block in &mut self.blocks {
            match self.params.exploration {
                Exploration::Adapted {
                    std_min, std_max, ..
                } => {
                    let first = &self.first_std[block.range()];
                    block.bound(first, std_min, std_max);
                }
                Exploration::Decayed { factor } => block.scale(factor),
            }
        }
        self.n_updates += 1;
    }
}

impl TryFrom<Pi2State> for Pi2Cma {
    type Error = Pi2Error;

    fn try_from(state: Pi2State) -> Result<Self, Pi2Error> {
        let sizes: Vec<usize> = state.block_sizes.clone();
        let mut search = Self::new(
            state.mean,
            state.first_std,
            &sizes,
            state.params,
            state.seed,
        )?;
        search.n_updates = state.n_updates;
        check_size("covariances", state.covariances.len(), sizes.len())?;
        for (block, covariance) in search.blocks.iter_mut().zip(state.covariances) {
            block.set(covariance)?;
        }
        Ok(search)
    }
}

impl From<Pi2Cma> for Pi2State {
    fn from(search: Pi2Cma) -> Self {
        Self {
            params: search.params,
            seed: search.seed,
            n_updates: search.n_updates,
            mean: search.mean,
            first_std: search.first_std,
            block_sizes: search
                .blocks
                .iter()
                .map(|block| block.range().len())
                .collect(),
            covariances: search
                .blocks
                .into_iter()
                .map(Block::into_covariance)
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests;
