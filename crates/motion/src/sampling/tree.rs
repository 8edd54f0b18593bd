//! A tree of configurations with nearest-neighbour search.
//!
//! Neighbours are found by a linear scan over flat storage: with a few thousand nodes a scan costs about
//! as much as one collision check, and unlike a k-d tree it needs no care for joints that wrap around.

use crate::joint_space::JointSpace;

/// Node of a [`Tree`].
pub(super) type NodeIdx = usize;

#[derive(Debug)]
pub(super) struct Tree {
    n_joints: usize,
    positions: Vec<f64>,
    /// Parent of each node; a root is its own parent.
    parents: Vec<NodeIdx>,
}

impl Tree {
    pub(super) fn new(n_joints: usize) -> Self {
        Self {
            n_joints,
            positions: Vec::new(),
            parents: Vec::new(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.parents.len()
    }

    pub(super) fn q(&self, node: NodeIdx) -> &[f64] {
        &self.positions[node * self.n_joints..(node + 1) * self.n_joints]
    }

    pub(super) fn add_root(&mut self, q: &[f64]) -> NodeIdx {
        self.add(q, self.len())
    }

    pub(super) fn add(&mut self, q: &[f64], parent: NodeIdx) -> NodeIdx {
        self.positions.extend_from_slice(q);
        self.parents.push(parent);
        self.len() - 1
    }

    pub(super) fn parent(&self, node: NodeIdx) -> Option<NodeIdx> {
        let parent = self.parents[node];
        (parent != node).then_some(parent)
    }

    pub(super) fn set_parent(&mut self, node: NodeIdx, parent: NodeIdx) {
        self.parents[node] = parent;
    }

    /// The node nearest to `q`, and its distance.
    pub(super) fn nearest(&self, space: &JointSpace, q: &[f64]) -> (NodeIdx, f64) {
        let mut best = (0, f64::INFINITY);
        for node in 0..self.len() {
            let distance = space.distance_below(self.q(node), q, best.1);
            if distance < best.1 {
                best = (node, distance);
            }
        }
        best
    }

    /// Configurations from `node` to its root, both included, and the root.
    pub(super) fn to_root(&self, node: NodeIdx) -> (Vec<Vec<f64>>, NodeIdx) {
        let mut path = vec![self.q(node).to_vec()];
        let mut at = node;
        while let Some(parent) = self.parent(at) {
            at = parent;
            path.push(self.q(at).to_vec());
        }
        (path, at)
    }
}
