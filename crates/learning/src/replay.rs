//! What was lived through, to learn from again: a ring of transitions.

use std::collections::TryReserveError;

use rand::Rng;

use crate::panels::{Lanes, WIDTH, ZERO, n_panels};

/// How a step left an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Ending {
    /// The episode goes on.
    Goes,
    /// The task is over, by success or by failure: nothing can be earned after this step.
    Terminal,
    /// The episode was cut off, as by a time limit: what could have been earned afterwards still counts.
    Cut,
}

impl Ending {
    /// Whether the episode is over.
    #[must_use]
    pub fn is_over(self) -> bool {
        self != Self::Goes
    }
}

/// One step of the environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition<'a> {
    /// What was observed before.
    pub observation: &'a [f32],
    /// What was done, each component in -1..=1.
    pub action: &'a [f32],
    /// What it earned.
    pub reward: f32,
    /// What was observed after.
    pub next_observation: &'a [f32],
    /// Whether the episode was over then.
    pub ending: Ending,
}

/// A ring of the latest transitions.
///
/// Its memory is reserved whole at the start; the system provides it as it is filled.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    n_observation: usize,
    n_action: usize,
    /// Per transition: observation and action in one row, and the next observation in another, each from a new panel.
    rows: Vec<Lanes>,
    rewards: Vec<f32>,
    endings: Vec<Ending>,
    capacity: usize,
    /// Where the next transition goes.
    next: usize,
}

impl Replay {
    /// An empty ring.
    ///
    /// # Errors
    ///
    /// When the system has no memory for so many transitions.
    pub(crate) fn new(
        n_observation: usize,
        n_action: usize,
        capacity: usize,
    ) -> Result<Self, TryReserveError> {
        let mut replay = Self {
            n_observation,
            n_action,
            rows: Vec::new(),
            rewards: Vec::new(),
            endings: Vec::new(),
            capacity,
            next: 0,
        };
        let n_lanes = replay.row_size().saturating_mul(capacity);
        replay.rows.try_reserve_exact(n_lanes)?;
        replay.rewards.try_reserve_exact(capacity)?;
        replay.endings.try_reserve_exact(capacity)?;
        Ok(replay)
    }

    /// Rows of sixteen per transition.
    fn row_size(&self) -> usize {
        n_panels(self.n_observation + self.n_action) + n_panels(self.n_observation)
    }

    /// Transitions it holds.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rewards.len()
    }

    /// Whether it holds none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rewards.is_empty()
    }

    /// Transitions it can hold.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// A transition by its place in memory, which is not its age once the ring is full.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<Transition<'_>> {
        let (reward, ending) = (*self.rewards.get(index)?, *self.endings.get(index)?);
        let [before, after] = self.row(index).map(<[Lanes]>::as_flattened);
        let (observation, rest) = before.split_at(self.n_observation);
        Some(Transition {
            observation,
            action: &rest[..self.n_action],
            reward,
            next_observation: &after[..self.n_observation],
            ending,
        })
    }

    /// Adds a transition, over the oldest one when there is no room.
    pub(crate) fn push(&mut self, transition: &Transition<'_>) {
        let (n_observation, n_action) = (self.n_observation, self.n_action);
        let at = self.next;
        if at == self.rewards.len() {
            self.rows.resize((at + 1) * self.row_size(), ZERO);
            self.rewards.push(transition.reward);
            self.endings.push(transition.ending);
        }
        let [before, after] = self.row_mut(at).map(<[Lanes]>::as_flattened_mut);
        before[..n_observation].copy_from_slice(transition.observation);
        before[n_observation..][..n_action].copy_from_slice(transition.action);
        after[..n_observation].copy_from_slice(transition.next_observation);
        self.rewards[at] = transition.reward;
        self.endings[at] = transition.ending;
        self.next = (at + 1) % self.capacity;
    }

    /// Where the next transition goes.
    pub(crate) fn next(&self) -> usize {
        self.next
    }

    /// Goes on at another place of the ring, as a stored one did.
    pub(crate) fn go_on_at(&mut self, next: usize) {
        self.next = next;
    }

    /// Draws transitions, each with the same probability and with replacement, into a batch.
    pub(crate) fn sample_into(&self, rng: &mut impl Rng, batch: &mut Batch) {
        let n_rows = batch.rewards.len();
        let n_stored = self.len() as u32;
        for row in 0..n_rows {
            let index = below(rng, n_stored) as usize;
            let [before, after] = self.row(index);
            for (p, lanes) in before.iter().enumerate() {
                batch.inputs[p * n_rows + row] = *lanes;
            }
            for (p, lanes) in after.iter().enumerate() {
                batch.next_inputs[p * n_rows + row] = *lanes;
            }
            batch.rewards[row] = self.rewards[index];
            batch.goes_on[row] = f32::from(self.endings[index] != Ending::Terminal);
        }
    }

    fn row(&self, index: usize) -> [&[Lanes]; 2] {
        let (before, after) = (
            n_panels(self.n_observation + self.n_action),
            n_panels(self.n_observation),
        );
        let row = &self.rows[index * (before + after)..][..before + after];
        let (before, after) = row.split_at(before);
        [before, after]
    }

    fn row_mut(&mut self, index: usize) -> [&mut [Lanes]; 2] {
        let (before, after) = (
            n_panels(self.n_observation + self.n_action),
            n_panels(self.n_observation),
        );
        let row = &mut self.rows[index * (before + after)..][..before + after];
        let (before, after) = row.split_at_mut(before);
        [before, after]
    }
}

/// Transitions in panels, one row each.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Batch {
    /// Observation and action side by side: what a critic reads.
    pub(crate) inputs: Vec<Lanes>,
    /// The next observation, and room for an action.
    pub(crate) next_inputs: Vec<Lanes>,
    pub(crate) rewards: Vec<f32>,
    /// 0 after a terminal step, else 1.
    pub(crate) goes_on: Vec<f32>,
}

impl Batch {
    pub(crate) fn new(n_observation: usize, n_action: usize, n_rows: usize) -> Self {
        let size = n_panels(n_observation + n_action) * n_rows;
        Self {
            inputs: vec![ZERO; size],
            next_inputs: vec![ZERO; size],
            rewards: vec![0.0; n_rows],
            goes_on: vec![0.0; n_rows],
        }
    }
}

/// A number below `n`, each with exactly the same probability.
///
/// Lemire, "Fast Random Integer Generation in an Interval", ACM TOMACS 29 (2019), doi 10.1145/3230636, algorithm 5.
fn below(rng: &mut impl Rng, n: u32) -> u32 {
    let mut product = u64::from(rng.next_u32()) * u64::from(n);
    if (product as u32) < n {
        let threshold = n.wrapping_neg() % n;
        while (product as u32) < threshold {
            product = u64::from(rng.next_u32()) * u64::from(n);
        }
    }
    (product >> 32) as u32
}

/// Writes rows of numbers into the columns of a matrix in panels from column `first` on.
pub(crate) fn write_columns(
    lanes: &mut [Lanes],
    n_rows: usize,
    first: usize,
    n_cols: usize,
    mut value: impl FnMut(usize, usize) -> f32,
) {
    for column in 0..n_cols {
        let (panel, lane) = ((first + column) / WIDTH, (first + column) % WIDTH);
        for (row, lanes) in lanes[panel * n_rows..][..n_rows].iter_mut().enumerate() {
            lanes[lane] = value(row, column);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::{Batch, Ending, Replay, Transition, below};

    fn push(replay: &mut Replay, value: f32, ending: Ending) {
        replay.push(&Transition {
            observation: &[value; 18],
            action: &[-value; 3],
            reward: 10.0 * value,
            next_observation: &[value + 0.5; 18],
            ending,
        });
    }

    proptest! {
        #[test]
        fn a_ring_holds_the_latest(capacity in 1_usize..20, n in 0_u16..50) {
            let mut replay = Replay::new(18, 3, capacity).unwrap();
            for value in 0..n {
                push(&mut replay, f32::from(value), Ending::Goes);
            }
            prop_assert_eq!(replay.len(), capacity.min(usize::from(n)));
            let mut held: Vec<f32> = (0..replay.len())
                .map(|index| replay.get(index).unwrap().observation[17])
                .collect();
            held.sort_by(f32::total_cmp);
            let first = usize::from(n).saturating_sub(capacity);
            let wanted: Vec<f32> = (first..usize::from(n)).map(|value| value as f32).collect();
            prop_assert_eq!(held, wanted);
            prop_assert!(replay.get(replay.len()).is_none());
        }
    }

    #[test]
    fn a_transition_comes_back_as_it_was() {
        let mut replay = Replay::new(18, 3, 4).unwrap();
        for ending in [Ending::Goes, Ending::Terminal, Ending::Cut] {
            push(&mut replay, 2.0, ending);
            let found = replay.get(replay.len() - 1).unwrap();
            assert_eq!(found.observation, [2.0; 18]);
            assert_eq!(found.action, [-2.0; 3]);
            assert_eq!(found.reward, 20.0);
            assert_eq!(found.next_observation, [2.5; 18]);
            assert_eq!(found.ending, ending);
        }
    }

    #[test]
    fn a_batch_has_one_transition_per_row_and_only_the_end_of_a_task_ends_the_future() {
        let mut replay = Replay::new(18, 3, 8).unwrap();
        push(&mut replay, 1.0, Ending::Goes);
        push(&mut replay, 2.0, Ending::Terminal);
        push(&mut replay, 3.0, Ending::Cut);
        let n_rows = 64;
        let mut batch = Batch::new(18, 3, n_rows);
        replay.sample_into(&mut ChaCha8Rng::seed_from_u64(1), &mut batch);
        let mut seen = [0; 3];
        for row in 0..n_rows {
            let value = batch.inputs[row][0];
            let tail = &batch.inputs[n_rows + row];
            assert_eq!(tail[..5], [value, value, -value, -value, -value]);
            assert_eq!(batch.next_inputs[row], [value + 0.5; 16]);
            assert_eq!(batch.rewards[row], 10.0 * value);
            assert_eq!(batch.goes_on[row], if value == 2.0 { 0.0 } else { 1.0 });
            seen[value as usize - 1] += 1;
        }
        assert!(seen.iter().all(|n| *n > 0), "{seen:?}");
    }

    /// 6,000 draws of 6 numbers: each count is within five standard deviations of a thousand.
    #[test]
    fn draws_are_even() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut counts = [0_i32; 6];
        for _ in 0..6_000 {
            counts[below(&mut rng, 6) as usize] += 1;
        }
        let deviation = (6_000.0 * (1.0 / 6.0) * (5.0 / 6.0_f64)).sqrt();
        for count in counts {
            assert!(
                f64::from(count - 1_000).abs() < 5.0 * deviation,
                "{counts:?}"
            );
        }
    }
}
