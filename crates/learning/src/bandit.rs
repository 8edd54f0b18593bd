//! A choice among arms that each succeed or fail, such as the grasps from which a skill is tried.
//!
//! ```text
//! choice = argmax_a  s_a / n_a + c sqrt(ln t / n_a)
//! ```
//!
//! with s_a successes in n_a tries of arm a, and t tries of all arms. Auer, Cesa-Bianchi & Fischer, "Finite-time
//! Analysis of the Multiarmed Bandit Problem", Machine Learning 47 (2002), doi 10.1023/A:1013689704352, figure 1:
//! UCB1 has c = sqrt 2 for rewards within 0..=1. The dissertation (section 3.2.1) names UCB over success rates and no
//! constant; its code has c = 1, t one higher and n_a + 1 under the root ([`Untried::CountsAsOne`]).

use serde::{Deserialize, Serialize};

/// What an arm that was never tried is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Untried {
    /// More than any other: each arm is tried once, in order, before one is tried twice. As UCB1 has it.
    #[default]
    First,
    /// As if the bonus had seen it once: an arm that succeeds is stayed with sooner. As the dissertation's code has
    /// it; with fifty grasps and a hundred episodes, half of the episodes are saved.
    CountsAsOne,
}

/// How a [`Bandit`] chooses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BanditParams {
    /// c: how much ignorance is worth, at least 0; default 1, as in the dissertation's code.
    pub exploration: f64,
    /// What an arm that was never tried is worth.
    pub untried: Untried,
}

impl Default for BanditParams {
    fn default() -> Self {
        Self {
            exploration: 1.0,
            untried: Untried::default(),
        }
    }
}

/// What is known of one arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arm {
    /// Tries of it.
    pub n_tries: u32,
    /// Tries that succeeded.
    pub n_successes: u32,
}

impl Arm {
    /// Share of tries that succeeded; zero without a try.
    #[must_use]
    pub fn success_rate(&self) -> f64 {
        if self.n_tries == 0 {
            return 0.0;
        }
        f64::from(self.n_successes) / f64::from(self.n_tries)
    }
}

/// Why a bandit could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BanditError {
    /// There is nothing to choose from.
    #[error("a bandit has 0 arms, expected at least 1")]
    NoArms,
    /// The bonus cannot be computed.
    #[error("exploration is {found}, expected a finite number of at least 0")]
    Exploration {
        /// The value given.
        found: f64,
    },
    /// Counts that cannot be.
    #[error(
        "arm {index} has {n_successes} successes in {n_tries} tries, expected no more successes than tries"
    )]
    Counts {
        /// Which arm.
        index: usize,
        /// Its successes.
        n_successes: u32,
        /// Its tries.
        n_tries: u32,
    },
}

/// Tries and successes of a fixed set of arms, and the rule that chooses among them.
///
/// Looking does not change it: an evaluation asks for [`Self::best`] or [`Self::choose`] and records nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Bandit {
    params: BanditParams,
    arms: Vec<Arm>,
}

impl Bandit {
    /// A bandit over arms with what is known of them, such as [`Arm::default`] for nothing.
    ///
    /// # Errors
    ///
    /// When there is no arm, or a number is out of its range.
    pub fn new(params: BanditParams, arms: Vec<Arm>) -> Result<Self, BanditError> {
        if arms.is_empty() {
            return Err(BanditError::NoArms);
        }
        let found = params.exploration;
        if !(found.is_finite() && found >= 0.0) {
            return Err(BanditError::Exploration { found });
        }
        for (index, arm) in arms.iter().enumerate() {
            if arm.n_successes > arm.n_tries {
                return Err(BanditError::Counts {
                    index,
                    n_successes: arm.n_successes,
                    n_tries: arm.n_tries,
                });
            }
        }
        Ok(Self { params, arms })
    }

    /// What is known of each arm.
    #[must_use]
    pub fn arms(&self) -> &[Arm] {
        &self.arms
    }

    /// The arm to try next; of equals the first.
    #[must_use]
    pub fn choose(&self) -> usize {
        let n_total: f64 = self.arms.iter().map(|arm| f64::from(arm.n_tries)).sum();
        first_maximum(self.arms.iter().map(|arm| {
            let n = f64::from(arm.n_tries);
            let (t, n) = match self.params.untried {
                Untried::First if arm.n_tries == 0 => return f64::INFINITY,
                Untried::First => (n_total, n),
                Untried::CountsAsOne => (n_total + 1.0, n + 1.0),
            };
            arm.success_rate() + self.params.exploration * (t.ln() / n).sqrt()
        }))
    }

    /// The arm that succeeded most often for its tries; of equals the one with more tries, then the first.
    #[must_use]
    pub fn best(&self) -> usize {
        let n_most = self.arms.iter().map(|arm| arm.n_tries).max().unwrap_or(0);
        let rate = first_maximum(self.arms.iter().map(Arm::success_rate));
        let rate = self.arms[rate].success_rate();
        first_maximum(self.arms.iter().map(|arm| {
            let share = f64::from(arm.n_tries) / f64::from(n_most.max(1));
            if arm.success_rate() < rate {
                -1.0
            } else {
                share
            }
        }))
    }

    /// Keeps what came of a try; an arm that does not exist changes nothing.
    pub fn record(&mut self, arm: usize, success: bool) {
        if let Some(arm) = self.arms.get_mut(arm) {
            arm.n_tries = arm.n_tries.saturating_add(1);
            arm.n_successes = arm
                .n_successes
                .saturating_add(u32::from(success))
                .min(arm.n_tries);
        }
    }
}

fn first_maximum(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, value) in values.enumerate() {
        if value > best.1 {
            best = (index, value);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::{Arm, Bandit, BanditError, BanditParams, Untried};

    fn arm(n_successes: u32, n_tries: u32) -> Arm {
        Arm {
            n_tries,
            n_successes,
        }
    }

    fn params(untried: Untried) -> BanditParams {
        BanditParams {
            untried,
            ..BanditParams::default()
        }
    }

    #[test]
    fn the_choice_is_the_formula() {
        // 0.5 + sqrt(ln 12 / 4) = 1.288, 0.75 + sqrt(ln 12 / 8) = 1.307.
        let bandit = |untried, arms| Bandit::new(params(untried), arms).unwrap();
        assert_eq!(
            bandit(Untried::First, vec![arm(2, 4), arm(6, 8)]).choose(),
            1
        );
        // 0.5 + sqrt(ln 102 / 2) = 2.02, 0.9 + sqrt(ln 102 / 100) = 1.115.
        assert_eq!(
            bandit(Untried::First, vec![arm(90, 100), arm(1, 2)]).choose(),
            1
        );
        assert_eq!(
            bandit(Untried::First, vec![arm(1, 1), arm(0, 0), arm(0, 0)]).choose(),
            1
        );
        // sqrt(ln 2 / 1) = 0.83 for the untried arm, 1 + sqrt(ln 2 / 2) = 1.59 for the one that succeeded.
        assert_eq!(
            bandit(Untried::CountsAsOne, vec![arm(0, 0), arm(1, 1)]).choose(),
            1
        );
        assert_eq!(
            bandit(Untried::CountsAsOne, vec![arm(0, 1), arm(0, 0)]).choose(),
            1
        );
    }

    #[test]
    fn the_best_arm_is_found_and_mostly_chosen() {
        for untried in [Untried::First, Untried::CountsAsOne] {
            let rates = [0.2, 0.5, 0.9, 0.3];
            let mut rng = ChaCha8Rng::seed_from_u64(3);
            let mut bandit = Bandit::new(params(untried), vec![Arm::default(); 4]).unwrap();
            for _ in 0..400 {
                let chosen = bandit.choose();
                bandit.record(chosen, rng.random_bool(rates[chosen]));
            }
            assert_eq!(bandit.best(), 2);
            assert!(bandit.arms()[2].n_tries > 200, "{:?}", bandit.arms());
        }
    }

    #[test]
    fn of_equal_rates_the_better_known_is_best() {
        let bandit = Bandit::new(
            BanditParams::default(),
            vec![arm(1, 1), arm(5, 5), arm(5, 5), arm(8, 9)],
        );
        assert_eq!(bandit.unwrap().best(), 1);
    }

    #[test]
    fn impossible_bandits_are_refused() {
        let refused = |params, arms| Bandit::new(params, arms).unwrap_err();
        assert_eq!(
            refused(BanditParams::default(), vec![]),
            BanditError::NoArms
        );
        let bad = BanditParams {
            exploration: -1.0,
            ..BanditParams::default()
        };
        assert_eq!(
            refused(bad, vec![arm(0, 0)]),
            BanditError::Exploration { found: -1.0 }
        );
        assert_eq!(
            refused(BanditParams::default(), vec![arm(0, 0), arm(3, 2)]).to_string(),
            "arm 1 has 3 successes in 2 tries, expected no more successes than tries"
        );
    }
}
