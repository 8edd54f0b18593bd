//! RRT*: a tree that is rewired towards shortest paths.
//!
//! Method: Karaman & Frazzoli, "Sampling-based algorithms for optimal motion planning", IJRR 30(7), 2011,
//! algorithm 6 in its k-nearest form, k = e (1 + 1/n) ln N. All iterations are spent, or nodes, whichever cap
//! comes first. Samples are goals with a fixed probability, and once there is a path, samples that cannot
//! be on a shorter one are passed over (Gammell et al., "Informed RRT*", 2014, by rejection).

use rand::{Rng, RngExt as _};

use super::tree::{NodeIdx, Tree};
use super::{FoundPath, Search, SearchLimit, SearchOptions, StateValidity, is_motion_valid};
use crate::joint_space::JointSpace;

/// Probability that a sample is a goal.
const GOAL_BIAS: f64 = 0.05;

/// Searches a short path from `start` to any of `goals`, all taken to be valid.
pub fn rrt_star(
    space: &JointSpace,
    validity: &mut impl StateValidity,
    start: &[f64],
    goals: &[Vec<f64>],
    options: &SearchOptions,
    rng: &mut impl Rng,
) -> Search {
    let mut star = Star::new(space, options, start);
    let mut best: Option<Arrival> = None;
    let mut sample = vec![0.0; space.n()];
    let mut iterations = 0;
    let mut limit = SearchLimit::Iterations;
    while iterations < options.iterations_max {
        if star.tree.len() >= options.n_nodes_max {
            limit = SearchLimit::Nodes;
            break;
        }
        iterations += 1;
        let goal_idx = (rng.random_bool(GOAL_BIAS) && !goals.is_empty())
            .then(|| rng.random_range(0..goals.len()));
        match goal_idx {
            Some(goal_idx) => sample.copy_from_slice(&goals[goal_idx]),
            None => space.sample_into(rng, &mut sample),
        }
        if let Some(best) = &best {
            let shortest =
                |goal: &Vec<f64>| space.distance(start, &sample) + space.distance(&sample, goal);
            if goals
                .iter()
                .all(|goal| shortest(goal) >= star.costs[best.node])
            {
                continue;
            }
        }
        let Some(new) = star.grow(validity, &sample) else {
            continue;
        };
        // A goal is joined as soon as a new node is within one edge of it.
        for (goal_idx, goal) in goals.iter().enumerate() {
            let distance = space.distance(star.tree.q(new), goal);
            let cost = star.costs[new] + distance;
            let improves = best
                .as_ref()
                .is_none_or(|best| cost < star.costs[best.node]);
            if distance <= options.range
                && improves
                && is_motion_valid(space, validity, star.tree.q(new), goal, options.step)
            {
                best = Some(Arrival {
                    node: star.add(goal, new, distance),
                    goal_idx,
                });
            }
        }
    }
    let path = best.ok_or(limit).map(|best| {
        let (mut waypoints, _) = star.tree.to_root(best.node);
        waypoints.reverse();
        FoundPath {
            waypoints,
            goal_idx: best.goal_idx,
        }
    });
    Search {
        path,
        n_nodes: star.tree.len(),
        iterations,
    }
}

/// A node at a goal.
struct Arrival {
    node: NodeIdx,
    goal_idx: usize,
}

/// The tree with the cost of reaching each node from the start.
struct Star<'a> {
    space: &'a JointSpace,
    options: &'a SearchOptions,
    tree: Tree,
    costs: Vec<f64>,
    children: Vec<Vec<NodeIdx>>,
}

impl<'a> Star<'a> {
    fn new(space: &'a JointSpace, options: &'a SearchOptions, start: &[f64]) -> Self {
        let mut tree = Tree::new(space.n());
        tree.add_root(start);
        Self {
            space,
            options,
            tree,
            costs: vec![0.0],
            children: vec![Vec::new()],
        }
    }

    /// Adds a node at most one edge towards the sample, under its best parent, and rewires its neighbours.
    fn grow(&mut self, validity: &mut impl StateValidity, sample: &[f64]) -> Option<NodeIdx> {
        let (nearest, distance) = self.tree.nearest(self.space, sample);
        let t = (self.options.range / distance).min(1.0);
        let q = self.space.interpolate(self.tree.q(nearest), sample, t);
        let near = self.neighbours(&q);
        // 1. The parent with the lowest cost of those that can reach it; they are tried cheapest first.
        let mut parents: Vec<(f64, NodeIdx, f64)> = near
            .iter()
            .map(|&(distance, node)| (self.costs[node] + distance, node, distance))
            .collect();
        parents.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let step = self.options.step;
        let (_, parent, distance) = parents.into_iter().find(|&(_, node, _)| {
            is_motion_valid(self.space, validity, self.tree.q(node), &q, step)
        })?;
        let new = self.add(&q, parent, distance);
        // 2. Neighbours for which the new node is a shorter way.
        for (distance, node) in near {
            let cost = self.costs[new] + distance;
            if cost < self.costs[node]
                && is_motion_valid(self.space, validity, &q, self.tree.q(node), step)
            {
                self.rewire(node, new, cost);
            }
        }
        Some(new)
    }

    fn add(&mut self, q: &[f64], parent: NodeIdx, distance: f64) -> NodeIdx {
        let new = self.tree.add(q, parent);
        self.costs.push(self.costs[parent] + distance);
        self.children.push(Vec::new());
        self.children[parent].push(new);
        new
    }

    /// Puts `node` under `parent` at its new cost, and what is below it with it.
    fn rewire(&mut self, node: NodeIdx, parent: NodeIdx, cost: f64) {
        if let Some(old) = self.tree.parent(node) {
            self.children[old].retain(|&child| child != node);
        }
        self.tree.set_parent(node, parent);
        self.children[parent].push(node);
        let saved = self.costs[node] - cost;
        let mut below = vec![node];
        while let Some(node) = below.pop() {
            self.costs[node] -= saved;
            below.extend_from_slice(&self.children[node]);
        }
    }

    /// The nearest k nodes, with their distances.
    fn neighbours(&self, q: &[f64]) -> Vec<(f64, NodeIdx)> {
        let n = self.tree.len() as f64;
        let k = (std::f64::consts::E * (1.0 + 1.0 / self.space.n() as f64) * n.ln()).ceil();
        let k = (k as usize).max(1);
        let mut near: Vec<(f64, NodeIdx)> = (0..self.tree.len())
            .map(|node| (self.space.distance(self.tree.q(node), q), node))
            .collect();
        let by_distance =
            |a: &(f64, NodeIdx), b: &(f64, NodeIdx)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if near.len() > k {
            near.select_nth_unstable_by(k - 1, by_distance);
            near.truncate(k);
        }
        near.sort_by(by_distance);
        near
    }
}
