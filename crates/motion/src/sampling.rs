//! Sampling-based planners over any validity check.
//!
//! They know nothing of robots: a [`JointSpace`] gives distance and samples, a [`StateValidity`] says
//! whether a configuration is free. A motion is free when configurations at most `step` apart along it
//! are; both ends of every search are explicit caps.

mod motion;
mod rrt_connect;
mod rrt_star;
mod shortcut;
mod tree;

pub use motion::is_motion_valid;
pub use rrt_connect::rrt_connect;
pub use rrt_star::rrt_star;
pub use shortcut::shortcut;

use crate::joint_space::JointSpace;

/// Says whether a configuration is free.
pub trait StateValidity {
    /// Whether the configuration is free.
    fn is_valid(&mut self, q: &[f64]) -> bool;
}

impl<F: FnMut(&[f64]) -> bool> StateValidity for F {
    fn is_valid(&mut self, q: &[f64]) -> bool {
        self(q)
    }
}

/// Caps and resolution of a search; lengths in the joint metric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchOptions {
    /// Cap: nodes of all trees together.
    pub n_nodes_max: usize,
    /// Cap: samples drawn.
    pub iterations_max: usize,
    /// Distance of validity checks along a motion.
    pub step: f64,
    /// Longest edge of a tree.
    pub range: f64,
}

/// Which cap ended a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchLimit {
    /// The trees are full.
    Nodes,
    /// The samples are used up.
    Iterations,
    /// Paths were found, but each collides between its checked configurations, at every resolution tried.
    Resolution,
}

/// What came of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// The path from the start to a goal, or the cap that ended the search.
    pub path: Result<FoundPath, SearchLimit>,
    /// Nodes of all trees.
    pub n_nodes: usize,
    /// Samples drawn.
    pub iterations: usize,
}

/// A path in configurations, straight between them; continuous joints may jump by whole turns.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundPath {
    /// From the start to the goal.
    pub waypoints: Vec<Vec<f64>>,
    /// Which goal.
    pub goal_idx: usize,
}

/// Chains waypoints so that each is the equivalent nearest to the one before: continuous joints count turns.
pub fn unwrap_turns(space: &JointSpace, path: &mut [Vec<f64>]) {
    for i in 1..path.len() {
        let (before, rest) = path.split_at_mut(i);
        let (before, q) = (&before[i - 1], &mut rest[0]);
        for j in 0..space.n() {
            if space.limits()[j].continuous {
                q[j] = before[j] + space.difference(j, before[j], q[j]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
