//! The subgoal property: where an option ends does not depend on where it started.
//!
//! Partitions are made so that Pr(s' | o, s) = Pr(s' | o) (dissertation 2.1.3); effects as densities stand on
//! that. Whether it came true is checked for each outcome: among transitions that started nearest to each other, do the ends
//! lie nearer to each other than those of transitions at random? The mean distance of ends over nearest neighbours of starts
//! is compared with the same under random pairings (a permutation test; Mantel, Cancer Research 27, 1967, has the idea).

use rand::Rng;
use rand::seq::SliceRandom as _;

use crate::partition::OutcomeSamples;
use crate::samples::Samples;
use crate::transitions::Transitions;

/// How the property is checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubgoalParams {
    /// Most transitions of an outcome that are looked at; default 200.
    pub n_samples_max: usize,
    /// Random pairings; default 99, so that one check in a hundred fails by chance.
    pub n_pairings: usize,
    /// Mean distance of ends below which they are one place, in the units of the variables; default 0.05, as for effects
    /// ([`PartitionParams`](crate::partition::PartitionParams)).
    pub epsilon: f64,
}

impl Default for SubgoalParams {
    fn default() -> Self {
        Self {
            n_samples_max: 200,
            n_pairings: 99,
            epsilon: 0.05,
        }
    }
}

/// What the check found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubgoalCheck {
    /// Mean distance between the ends of transitions that started nearest to each other.
    pub neighbours: f64,
    /// Mean distance between the ends of any two.
    pub any_two: f64,
    /// Whether the ends are one place, or depend on the start by no more than chance.
    pub holds: bool,
}

/// Checks an outcome; `None` from fewer than eight transitions, which tell nothing.
pub fn check_subgoal(
    transitions: &Transitions,
    outcome: &OutcomeSamples,
    params: &SubgoalParams,
    rng: &mut dyn Rng,
) -> Option<SubgoalCheck> {
    const N_SAMPLES_MIN: usize = 8;
    let mut rows = outcome.rows.clone();
    rows.shuffle(rng);
    rows.truncate(params.n_samples_max);
    if rows.len() < N_SAMPLES_MIN {
        return None;
    }
    let starts = transitions.states().select(&rows);
    let ends = transitions
        .next_states()
        .project_rows(rows.iter().copied(), &outcome.mask);
    let n = rows.len();
    let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
    let any_two = pairs.map(|(i, j)| distance(&ends, i, j)).sum::<f64>() / (n * (n - 1) / 2) as f64;
    let nearest: Vec<usize> = (0..n).filter_map(|i| nearest_start(&starts, i)).collect();
    let mut order: Vec<usize> = (0..n).collect();
    let mean = |order: &[usize]| {
        let of_pair = |(i, &j): (usize, &usize)| distance(&ends, order[i], order[j]);
        nearest.iter().enumerate().map(of_pair).sum::<f64>() / n as f64
    };
    let neighbours = mean(&order);
    let is_chance = (0..params.n_pairings).any(|_| {
        order.shuffle(rng);
        mean(&order) <= neighbours
    });
    Some(SubgoalCheck {
        neighbours,
        any_two,
        holds: is_chance || any_two < params.epsilon,
    })
}

/// The other transition that started nearest to `i`; the first among equals.
fn nearest_start(starts: &Samples, i: usize) -> Option<usize> {
    let others = (0..starts.len()).filter(|&j| j != i);
    others.min_by(|&a, &b| distance(starts, i, a).total_cmp(&distance(starts, i, b)))
}

fn distance(points: &Samples, i: usize, j: usize) -> f64 {
    let squares = points.row(i).iter().zip(points.row(j));
    squares.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::transitions::Transition;

    /// A thousand steps on a line, each ending where `end` says.
    fn check(n: usize, end: impl Fn(f64, &mut ChaCha8Rng) -> f64) -> Option<SubgoalCheck> {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut transitions = Transitions::new(vec!["place".to_owned()], vec!["go".to_owned()]);
        for _ in 0..n {
            let start = uniform(&mut rng);
            transitions
                .push(&Transition {
                    state: &[start],
                    option: 0,
                    next_state: &[end(start, &mut rng)],
                    mask: Some(&[0]),
                    executable: &[true],
                    episode: 0,
                    reward: None,
                    goal_achieved: false,
                })
                .unwrap();
        }
        let outcome = OutcomeSamples {
            mask: vec![0],
            rows: (0..n).collect(),
        };
        check_subgoal(&transitions, &outcome, &SubgoalParams::default(), &mut rng)
    }

    fn uniform(rng: &mut ChaCha8Rng) -> f64 {
        rng.random()
    }

    #[test]
    fn an_end_by_chance_or_always_the_same_is_a_subgoal() {
        assert!(check(1000, |_, rng| uniform(rng)).unwrap().holds);
        let same = check(1000, |start, _| 0.5 + 0.01 * start).unwrap();
        assert!(same.holds && same.any_two < 0.01, "{same:?}");
    }

    #[test]
    fn an_end_that_goes_with_the_start_is_none() {
        let found = check(1000, |start, rng| 0.3 * start + 0.02 * uniform(rng)).unwrap();
        assert!(!found.holds, "{found:?}");
        assert!(found.neighbours < 0.5 * found.any_two, "{found:?}");
    }

    #[test]
    fn a_few_transitions_tell_nothing() {
        assert_eq!(check(7, |start, _| start), None);
    }
}
