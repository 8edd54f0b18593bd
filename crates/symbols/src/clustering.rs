//! DBSCAN on points with weights (Ester, Kriegel, Sander & Xu, "A density-based algorithm for
//! discovering clusters", KDD 1996).
//!
//! A point is a *core* point if the points within `epsilon` of it, itself included, weigh at least
//! `min_weight`. Core points within `epsilon` of each other are of one cluster. A point that is not
//! core is of the first cluster with a core point within `epsilon`, and *noise* without one.
//!
//! The result is that of the textbook's loop over all pairs, for points that come as often as they
//! weigh. We get there over a k-d tree whose leaves are no wider than `epsilon`: a leaf's points are all
//! neighbours of each other, so a leaf that is heavy enough is core as a whole, and pairs of leaves that are of one
//! cluster already need not be looked at. That takes about n log n steps where points are dense.

use crate::samples::{Bounds, Samples, distance_squared_up_to};

/// When points are neighbours and how many make a cluster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DbscanParams {
    /// Greatest distance of neighbours, in the units of the variables.
    pub epsilon: f64,
    /// Least weight within `epsilon` of a core point.
    pub min_weight: f64,
}

/// The cluster of each point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clusters {
    /// For each point its cluster, counted from 0 by their first core points; `None` is noise.
    pub labels: Vec<Option<usize>>,
    /// How many clusters.
    pub n_clusters: usize,
}

/// Clusters points of the given weights.
///
/// # Panics
/// If there are not as many weights as points.
pub fn dbscan(points: &Samples, weights: &[f64], params: &DbscanParams) -> Clusters {
    assert_eq!(points.len(), weights.len(), "a weight for each point");
    if points.is_empty() {
        return Clusters {
            labels: Vec::new(),
            n_clusters: 0,
        };
    }
    let mut clustering = Clustering {
        tree: Tree::new(points, params.epsilon),
        points,
        weights,
        epsilon_squared: params.epsilon * params.epsilon,
        is_core: vec![false; points.len()],
        sets: DisjointSets::new(points.len()),
    };
    clustering.find_core_points(params.min_weight);
    clustering.join_leaves();
    clustering.join_nodes(0, 0);
    clustering.labels()
}

struct Clustering<'a> {
    tree: Tree,
    points: &'a Samples,
    weights: &'a [f64],
    epsilon_squared: f64,
    is_core: Vec<bool>,
    sets: DisjointSets,
}

impl Clustering<'_> {
    fn are_neighbours(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.points.row(a), self.points.row(b));
        distance_squared_up_to(a, b, self.epsilon_squared) <= self.epsilon_squared
    }

    fn find_core_points(&mut self, min_weight: f64) {
        for node in &self.tree.nodes {
            let NodeKind::Leaf { begin, end, tight } = node.kind else {
                continue;
            };
            let members = &self.tree.order[begin..end];
            let own: f64 = members.iter().map(|&i| self.weights[i]).sum();
            for &i in members {
                self.is_core[i] =
                    (tight && own >= min_weight) || self.weight_around(i, min_weight) >= min_weight;
            }
        }
    }

    /// The weight within epsilon of a point; stops counting at `enough`.
    fn weight_around(&self, i: usize, enough: f64) -> f64 {
        let mut sum = 0.0;
        self.tree
            .visit_near(self.points.row(i), self.epsilon_squared, &mut |j| {
                if self.are_neighbours(i, j) {
                    sum += self.weights[j];
                }
                sum < enough
            });
        sum
    }

    /// Core points of one tight leaf are neighbours.
    fn join_leaves(&mut self) {
        for node in &self.tree.nodes {
            if let NodeKind::Leaf {
                begin,
                end,
                tight: true,
            } = node.kind
            {
                let mut core = self.tree.order[begin..end]
                    .iter()
                    .filter(|&&i| self.is_core[i]);
                if let Some(&first) = core.next() {
                    core.for_each(|&i| self.sets.join(first, i));
                }
            }
        }
    }

    /// Joins the core points of two nodes that are neighbours.
    fn join_nodes(&mut self, a: usize, b: usize) {
        let (na, nb) = (&self.tree.nodes[a], &self.tree.nodes[b]);
        if na.bounds.distance_squared(&nb.bounds) > self.epsilon_squared {
            return;
        }
        match (na.kind, nb.kind) {
            (NodeKind::Inner { left, right }, _) if a == b => {
                self.join_nodes(left, left);
                self.join_nodes(left, right);
                self.join_nodes(right, right);
            }
            (NodeKind::Inner { left, right }, _) => {
                self.join_nodes(left, b);
                self.join_nodes(right, b);
            }
            (_, NodeKind::Inner { left, right }) => {
                self.join_nodes(a, left);
                self.join_nodes(a, right);
            }
            (
                NodeKind::Leaf { begin, end, tight },
                NodeKind::Leaf {
                    begin: other_begin,
                    end: other_end,
                    tight: other_tight,
                },
            ) => {
                if tight && a == b {
                    return;
                }
                for place in begin..end {
                    let i = self.tree.order[place];
                    if !self.is_core[i] {
                        continue;
                    }
                    for other_place in other_begin..other_end {
                        let j = self.tree.order[other_place];
                        if !self.is_core[j] {
                            continue;
                        }
                        let joined = self.sets.are_joined(i, j);
                        if joined || self.are_neighbours(i, j) {
                            self.sets.join(i, j);
                            if tight && other_tight {
                                return; // each leaf is one set, so all of both are joined now
                            }
                        }
                    }
                }
            }
        }
    }

    fn labels(mut self) -> Clusters {
        let n = self.points.len();
        let mut label_of_set = vec![None; n];
        let mut labels = vec![None; n];
        let mut n_clusters = 0;
        for i in (0..n).filter(|&i| self.is_core[i]) {
            let set = self.sets.find(i);
            labels[i] = Some(*label_of_set[set].get_or_insert_with(|| {
                n_clusters += 1;
                n_clusters - 1
            }));
        }
        for i in (0..n).filter(|&i| !self.is_core[i]) {
            let mut first: Option<usize> = None;
            self.tree
                .visit_near(self.points.row(i), self.epsilon_squared, &mut |j| {
                    if self.is_core[j] && self.are_neighbours(i, j) {
                        first = match (first, labels[j]) {
                            (Some(a), Some(b)) => Some(a.min(b)),
                            (a, b) => a.or(b),
                        };
                    }
                    first != Some(0)
                });
            labels[i] = first;
        }
        Clusters { labels, n_clusters }
    }
}

/// A k-d tree over points that splits its widest side until a leaf is no wider than epsilon across
/// (*tight*) or has no two different points.
struct Tree {
    nodes: Vec<Node>,
    /// The points; those of a leaf lie side by side.
    order: Vec<usize>,
}

struct Node {
    bounds: Bounds,
    kind: NodeKind,
}

#[derive(Clone, Copy)]
enum NodeKind {
    Inner {
        left: usize,
        right: usize,
    },
    Leaf {
        begin: usize,
        end: usize,
        tight: bool,
    },
}

impl Tree {
    /// Leaves of so few points are not worth splitting.
    const N_POINTS_LOOSE: usize = 4;

    fn new(points: &Samples, epsilon: f64) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            order: (0..points.len()).collect(),
        };
        tree.build(points, epsilon * epsilon, 0, points.len());
        tree
    }

    fn build(&mut self, points: &Samples, epsilon_squared: f64, begin: usize, end: usize) -> usize {
        let first = points.row(self.order[begin]);
        let mut bounds = Bounds {
            min: first.to_vec(),
            max: first.to_vec(),
        };
        for &i in &self.order[begin..end] {
            bounds.include(points.row(i));
        }
        let sides = || {
            bounds
                .min
                .iter()
                .zip(&bounds.max)
                .map(|(min, max)| max - min)
        };
        let tight = sides().map(|side| side * side).sum::<f64>() <= epsilon_squared;
        let node = self.nodes.len();
        let widest = sides().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        self.nodes.push(Node {
            bounds: bounds.clone(),
            kind: NodeKind::Leaf { begin, end, tight },
        });
        let Some((axis, _)) = widest.filter(|_| !tight && end - begin > Self::N_POINTS_LOOSE)
        else {
            return node;
        };
        let middle = begin + (end - begin) / 2;
        self.order[begin..end].select_nth_unstable_by(middle - begin, |&a, &b| {
            points.row(a)[axis]
                .total_cmp(&points.row(b)[axis])
                .then(a.cmp(&b))
        });
        let left = self.build(points, epsilon_squared, begin, middle);
        let right = self.build(points, epsilon_squared, middle, end);
        self.nodes[node].kind = NodeKind::Inner { left, right };
        node
    }

    /// Calls for each point of each leaf near the place, until the callee has seen enough (`false`).
    fn visit_near(&self, place: &[f64], epsilon_squared: f64, see: &mut impl FnMut(usize) -> bool) {
        let mut todo = vec![0];
        while let Some(node) = todo.pop() {
            let node = &self.nodes[node];
            let sides = place
                .iter()
                .zip(node.bounds.min.iter().zip(&node.bounds.max));
            let gap: f64 = sides
                .map(|(x, (min, max))| (min - x).max(x - max).max(0.0).powi(2))
                .sum();
            if gap > epsilon_squared {
                continue;
            }
            match node.kind {
                NodeKind::Inner { left, right } => todo.extend([right, left]),
                NodeKind::Leaf { begin, end, .. } => {
                    if !self.order[begin..end].iter().all(|&j| see(j)) {
                        return;
                    }
                }
            }
        }
    }
}

/// Union-find with halving of paths; the lower index leads.
#[derive(Debug, Clone)]
pub(crate) struct DisjointSets {
    parent: Vec<usize>,
}

impl DisjointSets {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            parent: (0..n).collect(),
        }
    }

    pub(crate) fn find(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b)] = a.min(b);
    }

    fn are_joined(&mut self, a: usize, b: usize) -> bool {
        self.find(a) == self.find(b)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PARAMS: DbscanParams = DbscanParams {
        epsilon: 1.0,
        min_weight: 3.0,
    };

    /// The definition, over all pairs.
    fn textbook(points: &Samples, weights: &[f64], params: &DbscanParams) -> Clusters {
        let n = points.len();
        let near = |a: usize, b: usize| {
            distance_squared_up_to(points.row(a), points.row(b), f64::INFINITY)
                <= params.epsilon * params.epsilon
        };
        let around = |i| (0..n).filter(move |&j| near(i, j));
        let is_core: Vec<bool> = (0..n)
            .map(|i| around(i).map(|j| weights[j]).sum::<f64>() >= params.min_weight)
            .collect();
        let mut labels: Vec<Option<usize>> = vec![None; n];
        let mut n_clusters = 0;
        for first in 0..n {
            if !is_core[first] || labels[first].is_some() {
                continue;
            }
            let mut todo = vec![first];
            while let Some(i) = todo.pop() {
                if labels[i].is_none() {
                    labels[i] = Some(n_clusters);
                    if is_core[i] {
                        todo.extend(around(i));
                    }
                }
            }
            n_clusters += 1;
        }
        Clusters { labels, n_clusters }
    }

    proptest! {
        #[test]
        fn it_is_what_the_definition_says(
            rows in prop::collection::vec(([0.0..6.0, 0.0..6.0], 1_u8..4), 0..60),
            min_weight in 1.0..8.0,
        ) {
            let points = Samples::from_rows(2, rows.iter().map(|(row, _)| row));
            let weights: Vec<_> = rows.iter().map(|(_, w)| f64::from(*w)).collect();
            let params = DbscanParams { min_weight, ..PARAMS };
            prop_assert_eq!(dbscan(&points, &weights, &params), textbook(&points, &weights, &params));
        }

        /// A weight of 2 is the same point twice.
        #[test]
        fn weights_stand_for_repeats(rows in prop::collection::vec([0_u8..5, 0..5], 0..40)) {
            let rows = Samples::from_rows(2, rows.iter().map(|r| r.map(f64::from)));
            let distinct = crate::samples::Distinct::of(&rows);
            let once = dbscan(&distinct.points, &distinct.weights, &PARAMS);
            let each = textbook(&rows, &vec![1.0; rows.len()], &PARAMS);
            prop_assert_eq!(once.n_clusters, each.n_clusters);
            for i in 0..rows.len() {
                let label = once.labels[distinct.point_of_row[i]];
                prop_assert_eq!(label.is_none(), each.labels[i].is_none());
            }
        }
    }

    #[test]
    fn nothing_and_points_without_variables_are_no_trouble() {
        assert_eq!(dbscan(&Samples::new(3), &[], &PARAMS).n_clusters, 0);
        let nowhere = Samples::from_rows(0, [[], [], []]);
        assert_eq!(dbscan(&nowhere, &[1.0; 3], &PARAMS).labels, [Some(0); 3]);
    }

    /// The thousandfold repeats and long chains of recorded data.
    #[test]
    fn a_chain_is_one_cluster_and_a_lone_point_noise() {
        let chain = (0..500)
            .map(|i| [f64::from(i) * 0.9, 0.0])
            .chain([[0.0, 50.0]]);
        let points = Samples::from_rows(2, chain);
        let clusters = dbscan(&points, &vec![1.0; 501], &PARAMS);
        assert_eq!(clusters.n_clusters, 1);
        assert_eq!(clusters.labels[500], None);
        assert!(clusters.labels[..500].iter().all(|l| *l == Some(0)));
    }
}
