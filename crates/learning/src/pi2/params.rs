//! What is chosen before a search, and what is kept of it.

use serde::{Deserialize, Serialize};

use super::Pi2Error;

/// How a search weighs and explores.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pi2Params {
    /// h: the worst rollout weighs `exp(-h)` of the best. Theodorou et al. use 10.
    pub eliteness: f64,
    /// What becomes of the exploration.
    pub exploration: Exploration,
}

impl Default for Pi2Params {
    fn default() -> Self {
        Self {
            eliteness: 10.0,
            exploration: Exploration::Adapted {
                share: 0.2,
                std_min: 0.1,
                std_max: 10.0,
            },
        }
    }
}

/// What an update makes of the exploration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Exploration {
    /// It follows the better samples: PI²-CMA.
    Adapted {
        /// Share of the samples in the new covariance, from 0 to 1. Default 0.2, the best of five on the via-point
        /// problem (`experiments/policy-search`).
        share: f64,
        /// Least standard deviation of a parameter, as a share of its first.
        std_min: f64,
        /// Largest standard deviation of a parameter, as a multiple of its first.
        std_max: f64,
    },
    /// Standard deviations shrink by a factor, whatever was found.
    Decayed {
        /// The factor, above 0 and at most 1.
        factor: f64,
    },
}

impl Pi2Params {
    pub(super) fn check(&self) -> Result<(), Pi2Error> {
        let check = |name, found: f64, good: bool, wanted| {
            if good && found.is_finite() {
                return Ok(());
            }
            Err(Pi2Error::OutOfRange {
                name,
                found,
                wanted,
            })
        };
        let positive = "a finite number above 0";
        check("eliteness", self.eliteness, self.eliteness > 0.0, positive)?;
        match self.exploration {
            Exploration::Adapted {
                share,
                std_min,
                std_max,
            } => {
                let in_share = (0.0..=1.0).contains(&share);
                check("share", share, in_share, "a number from 0 to 1")?;
                let wanted = "a finite number of at least 0";
                check("std_min", std_min, std_min >= 0.0, wanted)?;
                let wanted = "a finite number above 0 and not below std_min";
                let good = std_max > 0.0 && std_max >= std_min;
                check("std_max", std_max, good, wanted)
            }
            Exploration::Decayed { factor } => {
                let good = factor > 0.0 && factor <= 1.0;
                check("factor", factor, good, "a number above 0 and at most 1")
            }
        }
    }
}

/// A search as it is stored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pi2State {
    /// How it weighs and explores.
    pub params: Pi2Params,
    /// Of all random numbers.
    pub seed: u64,
    /// Updates made.
    pub n_updates: u64,
    /// The parameters found so far.
    pub mean: Vec<f64>,
    /// Standard deviations at the start.
    pub first_std: Vec<f64>,
    /// Parameters in each block.
    pub block_sizes: Vec<usize>,
    /// Of each block the lower triangle of its covariance, column after column.
    pub covariances: Vec<Vec<f64>>,
}
