//! Partitions: an option divided until where it starts says where it ends.
//!
//! Planning with symbols needs *subgoal* options, whose outcome does not depend on where they start
//! (dissertation 2.1.3; Konidaris, Kaelbling & Lozano-Perez, JAIR 61, 2018). An option that is not is divided:
//!
//! 1. by mask, and within a mask by DBSCAN on the changed variables of s';
//! 2. where the start states of two such clusters are of one DBSCAN cluster, those samples are split off;
//! 3. clusters whose start states then overlap as a whole are one partition, and its outcomes come
//!    with probabilities.
//!
//! The procedure and its defaults are those of the reference (partition.py of skills-to-symbols), with
//! what the dissertation's own code adds for few samples. We differ in one thing: start states that are nothing
//! but noise overlap with none, where the reference's count of clusters would merge them with any.

use std::collections::BTreeMap;

use crate::clustering::{Clusters, DbscanParams, DisjointSets, dbscan};
use crate::samples::{Bounds, Distinct, Samples};
use crate::transitions::Transitions;

/// How options are divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartitionParams {
    /// DBSCAN radius on effects; default 0.05 (the reference's `effect_epsilon`).
    pub effect_epsilon: f64,
    /// DBSCAN radius on start states; default 0.05 (the reference's `init_epsilon`).
    pub init_epsilon: f64,
    /// Least samples around a core point; default 5 (the reference's `effect_min_samples` and `init_min_samples`).
    pub n_samples_min: usize,
    /// Least samples of an effect, and of a core point where an effect has few samples; default 3, as
    /// in the dissertation's code: max(3, min(10, n / 10)) there, with 5 for the 10 here.
    pub n_samples_few: usize,
}

impl Default for PartitionParams {
    fn default() -> Self {
        Self {
            effect_epsilon: 0.05,
            init_epsilon: 0.05,
            n_samples_min: 5,
            n_samples_few: 3,
        }
    }
}

/// One part of an option, with the transitions it stands on.
#[derive(Debug, Clone, PartialEq)]
pub struct Partition {
    /// The option, as its index.
    pub option: usize,
    /// Its outcomes, with all of their transitions.
    pub outcomes: Vec<OutcomeSamples>,
}

/// The transitions of one outcome: the same variables changed, to like values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutcomeSamples {
    /// The variables that changed, ascending.
    pub mask: Vec<usize>,
    /// The transitions, ascending.
    pub rows: Vec<usize>,
}

impl Partition {
    /// The transitions of all outcomes.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.outcomes.iter().flat_map(|o| o.rows.iter().copied())
    }

    /// How many transitions there are.
    pub fn n_rows(&self) -> usize {
        self.outcomes.iter().map(|o| o.rows.len()).sum()
    }

    /// How often an outcome came of it.
    pub fn probability(&self, outcome: usize) -> f64 {
        self.outcomes[outcome].rows.len() as f64 / self.n_rows() as f64
    }
}

/// The transitions that no partition stands on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// The option, as its index.
    pub option: usize,
    /// The variables that changed.
    pub mask: Vec<usize>,
    /// How many transitions.
    pub n_rows: usize,
    /// Why.
    pub reason: LeftOutReason,
}

/// Why transitions were left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftOutReason {
    /// The option changed nothing.
    NoChange,
    /// The option moved the base and nothing else: that is for the path planner.
    OnlyMoved,
    /// The same variables changed too seldom to say to what.
    TooFew,
    /// Their effects were like no other.
    Noise,
}

/// Divides every option; what could not be used is named.
pub fn partition(
    transitions: &Transitions,
    params: &PartitionParams,
) -> (Vec<Partition>, Vec<LeftOut>) {
    partition_unless(transitions, params, &mut |_, _| false)
}

/// As [`partition`], but the effects of an option stay as step 1 has them where `are_apart` says that something
/// other than the variables of these states tells them apart.
pub(crate) fn partition_unless(
    transitions: &Transitions,
    params: &PartitionParams,
    are_apart: &mut dyn FnMut(usize, &[OutcomeSamples]) -> bool,
) -> (Vec<Partition>, Vec<LeftOut>) {
    let mut groups: BTreeMap<(usize, &[usize]), Vec<usize>> = BTreeMap::new();
    for i in 0..transitions.len() {
        let key = (transitions.option(i), transitions.mask(i));
        groups.entry(key).or_default().push(i);
    }
    let (mut partitions, mut left_out) = (Vec::new(), Vec::new());
    for option in 0..transitions.options().len() {
        let mut effects = Vec::new();
        for ((_, mask), rows) in groups.range((option, &[][..])..(option + 1, &[][..])) {
            let (found, without) = cluster_effects(transitions, option, mask, rows, params);
            effects.extend(found);
            left_out.extend(without);
        }
        if effects.len() > 1 && are_apart(option, &effects) {
            partitions.extend(effects.into_iter().map(|effect| Partition {
                option,
                outcomes: vec![effect],
            }));
            continue;
        }
        let mut clusters = Vec::new();
        for effect in effects {
            split_shared_starts(transitions, &mut clusters, effect, params);
        }
        partitions.extend(merge_overlapping(transitions, option, clusters, params));
    }
    (partitions, left_out)
}

/// Step 1: the transitions of one mask by where they end.
fn cluster_effects(
    transitions: &Transitions,
    option: usize,
    mask: &[usize],
    rows: &[usize],
    params: &PartitionParams,
) -> (Vec<OutcomeSamples>, Option<LeftOut>) {
    let without = |n_rows, reason| LeftOut {
        option,
        mask: mask.to_vec(),
        n_rows,
        reason,
    };
    if mask.is_empty() {
        return (
            Vec::new(),
            Some(without(rows.len(), LeftOutReason::NoChange)),
        );
    }
    if rows.len() < params.n_samples_few {
        return (Vec::new(), Some(without(rows.len(), LeftOutReason::TooFew)));
    }
    let effects = Distinct::of(
        &transitions
            .next_states()
            .project_rows(rows.iter().copied(), mask),
    );
    let n_samples_min = (rows.len() / 10).clamp(
        params.n_samples_few,
        params.n_samples_min.max(params.n_samples_few),
    );
    let clusters = dbscan(
        &effects.points,
        &effects.weights,
        &DbscanParams {
            epsilon: params.effect_epsilon,
            min_weight: n_samples_min as f64,
        },
    );
    let outcome = |rows| OutcomeSamples {
        mask: mask.to_vec(),
        rows,
    };
    // Where no effect is like another, the spread itself is the effect, as in the dissertation's code.
    if clusters.n_clusters == 0 {
        return (vec![outcome(rows.to_vec())], None);
    }
    let mut found = vec![Vec::new(); clusters.n_clusters];
    let mut n_noise = 0;
    for (place, &row) in rows.iter().enumerate() {
        match clusters.labels[effects.point_of_row[place]] {
            Some(label) => found[label].push(row),
            None => n_noise += 1,
        }
    }
    let noise = (n_noise > 0).then(|| without(n_noise, LeftOutReason::Noise));
    (found.into_iter().map(outcome).collect(), noise)
}

/// The start states of some transitions, clustered.
struct Starts {
    distinct: Distinct,
    clusters: Clusters,
}

impl Starts {
    fn of(
        transitions: &Transitions,
        rows: impl IntoIterator<Item = usize>,
        params: &PartitionParams,
    ) -> Self {
        let mut states = Samples::new(transitions.variables().len());
        for row in rows {
            states.push(transitions.states().row(row));
        }
        let distinct = Distinct::of(&states);
        let clusters = dbscan(
            &distinct.points,
            &distinct.weights,
            &DbscanParams {
                epsilon: params.init_epsilon,
                min_weight: params.n_samples_min as f64,
            },
        );
        Self { distinct, clusters }
    }

    /// The cluster of each transition.
    fn labels(&self) -> impl Iterator<Item = Option<usize>> {
        self.distinct
            .point_of_row
            .iter()
            .map(|&point| self.clusters.labels[point])
    }
}

fn bounds(transitions: &Transitions, rows: &[usize]) -> Option<Bounds> {
    transitions.states().select(rows).bounds()
}

/// Whether the boxes around the start states come as near as neighbours do. Far boxes share no cluster.
fn are_near(transitions: &Transitions, a: &[usize], b: &[usize], params: &PartitionParams) -> bool {
    match (bounds(transitions, a), bounds(transitions, b)) {
        (Some(a), Some(b)) => a.distance_squared(&b) <= params.init_epsilon.powi(2),
        _ => false,
    }
}

/// Step 2: takes a new cluster in; what it shares with those there, on either side, gets its own cluster.
fn split_shared_starts(
    transitions: &Transitions,
    clusters: &mut Vec<OutcomeSamples>,
    mut new: OutcomeSamples,
    params: &PartitionParams,
) {
    let mut split_off = Vec::new();
    for existing in clusters.iter_mut() {
        if !are_near(transitions, &existing.rows, &new.rows, params) {
            continue;
        }
        let (existing_shared, new_shared) =
            shared_starts(transitions, &existing.rows, &new.rows, params);
        split_off.extend(split(existing, &existing_shared));
        split_off.extend(split(&mut new, &new_shared));
    }
    clusters.extend(split_off);
    clusters.push(new);
}

/// Which transitions of either side start in a cluster that both sides start in.
fn shared_starts(
    transitions: &Transitions,
    existing: &[usize],
    new: &[usize],
    params: &PartitionParams,
) -> (Vec<bool>, Vec<bool>) {
    let rows = existing.iter().chain(new).copied();
    let starts = Starts::of(transitions, rows, params);
    let labels: Vec<Option<usize>> = starts.labels().collect();
    let (existing, new) = labels.split_at(existing.len());
    let present = |side: &[Option<usize>]| {
        let mut present = vec![false; starts.clusters.n_clusters];
        side.iter()
            .flatten()
            .for_each(|&label| present[label] = true);
        present
    };
    let (in_existing, in_new) = (present(existing), present(new));
    // Noise goes with its side where all clusters of that side are shared.
    let shared = |side: &[Option<usize>], own: &[bool], other: &[bool]| -> Vec<bool> {
        let all_shared = own.iter().zip(other).all(|(own, other)| !own || *other);
        let is_shared = |label: &Option<usize>| match label {
            Some(label) => own[*label] && other[*label],
            None => all_shared,
        };
        side.iter().map(is_shared).collect()
    };
    (
        shared(existing, &in_existing, &in_new),
        shared(new, &in_new, &in_existing),
    )
}

/// Takes out what is shared, unless that is all or nothing.
fn split(cluster: &mut OutcomeSamples, shared: &[bool]) -> Option<OutcomeSamples> {
    if shared.iter().all(|s| *s) || !shared.iter().any(|s| *s) {
        return None;
    }
    let side = |wanted: bool| {
        let pairs = cluster.rows.iter().zip(shared);
        pairs
            .filter(|(_, s)| **s == wanted)
            .map(|(row, _)| *row)
            .collect()
    };
    let (taken, kept) = (side(true), side(false));
    cluster.rows = kept;
    Some(OutcomeSamples {
        mask: cluster.mask.clone(),
        rows: taken,
    })
}

/// Step 3: clusters whose start states overlap are outcomes of one partition.
fn merge_overlapping(
    transitions: &Transitions,
    option: usize,
    clusters: Vec<OutcomeSamples>,
    params: &PartitionParams,
) -> Vec<Partition> {
    let n_alone: Vec<usize> = clusters
        .iter()
        .map(|c| {
            Starts::of(transitions, c.rows.iter().copied(), params)
                .clusters
                .n_clusters
        })
        .collect();
    let mut sets = DisjointSets::new(clusters.len());
    for i in 0..clusters.len() {
        for j in i + 1..clusters.len() {
            let (a, b) = (&clusters[i].rows, &clusters[j].rows);
            if n_alone[i].min(n_alone[j]) == 0 || !are_near(transitions, a, b, params) {
                continue;
            }
            let both = Starts::of(transitions, a.iter().chain(b).copied(), params);
            if both.clusters.n_clusters <= n_alone[i].max(n_alone[j]) {
                sets.join(i, j);
            }
        }
    }
    let mut merged: BTreeMap<usize, Vec<OutcomeSamples>> = BTreeMap::new();
    for (i, cluster) in clusters.into_iter().enumerate() {
        merged.entry(sets.find(i)).or_default().push(cluster);
    }
    let partition = |outcomes| Partition { option, outcomes };
    merged.into_values().map(partition).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transitions::Transition;

    /// (start, option, end) of a point on a line with a switch.
    fn record(steps: impl IntoIterator<Item = ([f64; 2], usize, [f64; 2])>) -> Transitions {
        let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        let mut transitions = Transitions::new(names(&["place", "switch"]), names(&["go", "flip"]));
        for (state, option, next_state) in steps {
            transitions
                .push(&Transition {
                    state: &state,
                    option,
                    next_state: &next_state,
                    mask: None,
                    executable: &[true, true],
                    episode: 0,
                    reward: None,
                    goal_achieved: false,
                })
                .unwrap();
        }
        transitions
    }

    fn around(centre: f64, i: u32) -> f64 {
        centre + 0.001 * f64::from(i % 7)
    }

    fn divide(transitions: &Transitions) -> (Vec<Partition>, Vec<LeftOut>) {
        partition(transitions, &PartitionParams::default())
    }

    #[test]
    fn where_an_option_starts_says_where_it_ends() {
        let from_left = (0..20).map(|i| ([around(0.1, i), 0.0], 0, [around(0.5, i + 2), 0.0]));
        let from_right = (0..30).map(|i| ([around(0.9, i), 0.0], 0, [around(0.7, i + 3), 0.0]));
        let (partitions, left_out) = divide(&record(from_left.chain(from_right)));
        assert_eq!(partitions.len(), 2, "{partitions:?}");
        assert_eq!(partitions[0].n_rows(), 20);
        assert!(partitions.iter().all(|p| p.outcomes.len() == 1));
        assert!(left_out.is_empty());
    }

    /// From one place the option ends sometimes here and sometimes there.
    #[test]
    fn chance_gives_outcomes_with_probabilities() {
        let steps = (0..40).map(|i| {
            let end = if i % 4 == 0 { 0.2 } else { 0.8 };
            ([around(0.5, i), 0.0], 0, [around(end, i), 0.0])
        });
        let (partitions, _) = divide(&record(steps));
        assert_eq!(partitions.len(), 1, "{partitions:?}");
        let mut probabilities = [0, 1].map(|o| partitions[0].probability(o));
        probabilities.sort_by(f64::total_cmp);
        assert_eq!(probabilities, [0.25, 0.75]);
    }

    /// From the left surely, from the right by chance: the shared starts are split off the first outcome.
    #[test]
    fn shared_starts_are_split_off() {
        let sure = (0..20).map(|i| ([around(0.1, i), 0.0], 0, [around(0.5, i + 2), 0.0]));
        let chance = (0..40).map(|i| {
            let end = if i % 2 == 0 { 0.5 } else { 0.7 };
            ([around(0.9, i), 0.0], 0, [around(end, i + 2), 0.0])
        });
        let (partitions, _) = divide(&record(sure.chain(chance)));
        let mut shape: Vec<_> = partitions
            .iter()
            .map(|p| (p.n_rows(), p.outcomes.len()))
            .collect();
        shape.sort_unstable();
        assert_eq!(shape, [(20, 1), (40, 2)], "{partitions:?}");
    }

    /// Nothing is used that says nothing, and nothing is lost silently.
    #[test]
    fn what_is_left_out_is_named() {
        let moves = (0..20).map(|i| ([around(0.1, i), 0.0], 0, [around(0.5, i + 2), 0.0]));
        let idle = (0..3).map(|_| ([0.3, 0.0], 0, [0.3, 0.0]));
        let seldom = (0..2).map(|_| ([0.3, 0.0], 1, [0.3, 1.0]));
        let far = [([0.1, 0.0], 0, [3.0, 0.0])];
        let transitions = record(moves.chain(idle).chain(seldom).chain(far));
        let (partitions, left_out) = divide(&transitions);
        assert_eq!(partitions.len(), 1);
        let reasons: Vec<_> = left_out
            .iter()
            .map(|l| (l.option, l.n_rows, l.reason))
            .collect();
        assert_eq!(
            reasons,
            [
                (0, 3, LeftOutReason::NoChange),
                (0, 1, LeftOutReason::Noise),
                (1, 2, LeftOutReason::TooFew),
            ]
        );
        let n_used: usize = partitions.iter().map(Partition::n_rows).sum();
        assert_eq!(n_used + 6, transitions.len());
    }

    #[test]
    fn effects_that_are_all_noise_are_one_wide_effect() {
        let steps = (0..6).map(|i| ([around(0.1, i), 0.0], 0, [1.0 + f64::from(i), 0.0]));
        let (partitions, _) = divide(&record(steps));
        assert_eq!(partitions.len(), 1);
        assert_eq!(partitions[0].n_rows(), 6);
    }

    #[test]
    fn no_transitions_give_no_partitions() {
        assert_eq!(divide(&record([])), (Vec::new(), Vec::new()));
    }
}
