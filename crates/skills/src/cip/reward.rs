//! What a step of the policy earns (thesis 3.3), beside what it costs.

use factotum_learning::replay::Ending;
use serde::{Deserialize, Serialize};

/// What is earned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reward {
    /// 1 for success, and potential-based shaping, γ Φ(s') - Φ(s) with progress as Φ (Ng, Harada & Russell, ICML 1999): the text.
    /// An end keeps its potential, so that what was gained before a failure stays gained.
    #[default]
    Progress,
    /// The same with a potential of 0 at every end, which is what leaves the best policies what they are. A failure takes back all
    /// that was gained: an attempt that moved the object halfway has earned as much as one that let go at once.
    Potential,
    /// 1 for success, else what was gained beyond the best so far, in the joint's unit: the code.
    Ratchet,
}

/// A step, by progress: 0 at the start and 1 at the goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Advance {
    pub(super) before: f64,
    pub(super) after: f64,
    /// The most in the episode until then.
    pub(super) best: f64,
    pub(super) is_success: bool,
    pub(super) ending: Ending,
}

impl Reward {
    /// What a step earns with discount γ, for a joint that goes `way` rad or m from start to goal.
    pub(super) fn earned(self, step: &Advance, discount: f64, way: f64) -> f64 {
        let potential = |progress: f64| progress.clamp(0.0, 1.0);
        let success = f64::from(u8::from(step.is_success));
        match (self, step.ending) {
            (Self::Potential, Ending::Terminal) => success - potential(step.before),
            (Self::Progress | Self::Potential, _) => {
                success + discount * potential(step.after) - potential(step.before)
            }
            (Self::Ratchet, _) if step.is_success => 1.0,
            (Self::Ratchet, _) => ((step.after - step.best) * way).clamp(0.0, 0.5),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISCOUNT: f64 = 0.9;

    /// Discounted sum of what an episode earns that goes through these places.
    fn total(reward: Reward, way: &[f64], is_success: bool) -> f64 {
        let n = way.len() - 1;
        let steps = way.windows(2).enumerate().map(|(i, pair)| {
            let is_last = i + 1 == n;
            let step = Advance {
                before: pair[0],
                after: pair[1],
                best: way[..=i].iter().copied().fold(0.0, f64::max),
                is_success: is_success && is_last,
                ending: if is_last {
                    Ending::Terminal
                } else {
                    Ending::Goes
                },
            };
            DISCOUNT.powi(i as i32) * reward.earned(&step, DISCOUNT, 2.0)
        });
        steps.sum()
    }

    fn assert_near(found: f64, wanted: f64) {
        assert!((found - wanted).abs() < 1e-12, "{found}, not {wanted}");
    }

    #[test]
    fn shaping_adds_the_potential_of_the_end_and_nothing_else() {
        let way = [0.0, 0.3, 0.1, 0.5];
        assert_near(total(Reward::Progress, &way, false), DISCOUNT.powi(3) * 0.5);
        assert_near(total(Reward::Potential, &way, false), 0.0);
        let whole = [0.0, 0.6, 1.2];
        assert_near(
            total(Reward::Progress, &whole, true),
            DISCOUNT + DISCOUNT.powi(2),
        );
        assert_near(total(Reward::Potential, &whole, true), DISCOUNT);
    }

    #[test]
    fn an_attempt_that_failed_halfway_is_worth_more_than_letting_go() {
        let [halfway, letting_go] = [[0.0, 0.2, 0.5], [0.0, 0.0, 0.0]];
        let gain = |reward| total(reward, &halfway, false) - total(reward, &letting_go, false);
        assert!(gain(Reward::Progress) > 0.1);
        assert_near(gain(Reward::Potential), 0.0);
        assert!(gain(Reward::Ratchet) > 0.1);
    }

    #[test]
    fn the_ratchet_pays_for_new_ground_alone_and_at_most_a_half() {
        assert_near(total(Reward::Ratchet, &[0.0, 0.2, 0.1, 0.2], false), 0.4);
        assert_near(total(Reward::Ratchet, &[0.0, 0.9], false), 0.5);
        assert_near(total(Reward::Ratchet, &[0.0, 1.1], true), 1.0);
    }
}
