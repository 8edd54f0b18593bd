//! RRT-Connect.
//!
//! Method: Kuffner & LaValle, "RRT-Connect: An Efficient Approach to Single-Query Path Planning", ICRA 2000.
//! Differs: the goal tree has a root for every goal; the first motion tried is the straight one from the
//! start to each goal; the smaller tree grows next, so that neither starves.

use rand::Rng;

use super::tree::{NodeIdx, Tree};
use super::{FoundPath, Search, SearchLimit, SearchOptions, StateValidity, is_motion_valid};
use crate::joint_space::JointSpace;

/// Searches a path from `start` to any of `goals`, all taken to be valid.
pub fn rrt_connect(
    space: &JointSpace,
    validity: &mut impl StateValidity,
    start: &[f64],
    goals: &[Vec<f64>],
    options: &SearchOptions,
    rng: &mut impl Rng,
) -> Search {
    // 1. The straight motion needs no tree.
    for (goal_idx, goal) in goals.iter().enumerate() {
        if is_motion_valid(space, validity, start, goal, options.step) {
            let waypoints = vec![start.to_vec(), goal.clone()];
            let path = Ok(FoundPath {
                waypoints,
                goal_idx,
            });
            return Search {
                path,
                n_nodes: 1 + goals.len(),
                iterations: 0,
            };
        }
    }
    // 2. Grow one tree a step towards a sample and the other all the way towards the new node.
    let mut grower = Grower {
        space,
        validity,
        options,
        q: vec![0.0; space.n()],
    };
    let mut from_start = Tree::new(space.n());
    from_start.add_root(start);
    let mut from_goal = Tree::new(space.n());
    for goal in goals {
        from_goal.add_root(goal);
    }
    let mut sample = vec![0.0; space.n()];
    for iterations in 1..=options.iterations_max {
        let n_nodes = from_start.len() + from_goal.len();
        if n_nodes >= options.n_nodes_max {
            return Search {
                path: Err(SearchLimit::Nodes),
                n_nodes,
                iterations,
            };
        }
        space.sample_into(rng, &mut sample);
        let grows_start = from_start.len() <= from_goal.len();
        let (grown, other) = if grows_start {
            (&mut from_start, &mut from_goal)
        } else {
            (&mut from_goal, &mut from_start)
        };
        let (nearest, _) = grown.nearest(space, &sample);
        let (Extension::Advanced(new) | Extension::Reached(new)) =
            grower.extend(grown, nearest, &sample)
        else {
            continue;
        };
        let bridge = grown.q(new).to_vec();
        if let Some(met) = grower.connect(other, &bridge) {
            let (start_node, goal_node) = if grows_start { (new, met) } else { (met, new) };
            let path = Ok(join(&from_start, start_node, &from_goal, goal_node));
            let n_nodes = from_start.len() + from_goal.len();
            return Search {
                path,
                n_nodes,
                iterations,
            };
        }
    }
    Search {
        path: Err(SearchLimit::Iterations),
        n_nodes: from_start.len() + from_goal.len(),
        iterations: options.iterations_max,
    }
}

/// The path through two nodes of the same configuration, one in each tree.
fn join(from_start: &Tree, start_node: NodeIdx, from_goal: &Tree, goal_node: NodeIdx) -> FoundPath {
    let (mut waypoints, _) = from_start.to_root(start_node);
    waypoints.reverse();
    let (to_goal, goal_idx) = from_goal.to_root(goal_node);
    waypoints.extend(to_goal.into_iter().skip(1));
    FoundPath {
        waypoints,
        goal_idx,
    }
}

enum Extension {
    Trapped,
    Advanced(NodeIdx),
    Reached(NodeIdx),
}

struct Grower<'a, V> {
    space: &'a JointSpace,
    validity: &'a mut V,
    options: &'a SearchOptions,
    q: Vec<f64>,
}

impl<V: StateValidity> Grower<'_, V> {
    /// One edge of at most `range` from `node` towards `target`.
    fn extend(&mut self, tree: &mut Tree, node: NodeIdx, target: &[f64]) -> Extension {
        let distance = self.space.distance(tree.q(node), target);
        let reaches = distance <= self.options.range;
        if reaches {
            self.q.copy_from_slice(target);
        } else {
            let t = self.options.range / distance;
            self.space
                .interpolate_into(tree.q(node), target, t, &mut self.q);
        }
        if !is_motion_valid(
            self.space,
            self.validity,
            tree.q(node),
            &self.q,
            self.options.step,
        ) {
            return Extension::Trapped;
        }
        let new = tree.add(&self.q, node);
        if reaches {
            Extension::Reached(new)
        } else {
            Extension::Advanced(new)
        }
    }

    /// Edges towards `target` until it is reached or something is in the way.
    fn connect(&mut self, tree: &mut Tree, target: &[f64]) -> Option<NodeIdx> {
        let (mut node, _) = tree.nearest(self.space, target);
        loop {
            match self.extend(tree, node, target) {
                Extension::Trapped => return None,
                Extension::Advanced(new) => node = new,
                Extension::Reached(new) => return Some(new),
            }
        }
    }
}
