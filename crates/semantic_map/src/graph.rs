//! The topological graph (V, E) of thesis 5.3: regions of the floor from which options can start, and which of them
//! the base can drive between.

use factotum_geometry::Pose2;
use factotum_task_planning::operator::GroundAction;

/// The topological graph of a map.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TopologicalGraph {
    /// V: one node per option.
    pub nodes: Vec<GraphNode>,
    /// E.
    pub edges: Vec<GraphEdge>,
}

/// A node: base poses sampled from the navigation symbol of an option, grounded at its object and in free space.
#[derive(Debug, Clone, PartialEq)]
pub struct GraphNode {
    /// The option.
    pub option: GroundAction,
    /// Base poses in the map; empty if the option can be started from nowhere known.
    pub map_from_base: Vec<Pose2>,
}

/// An undirected edge: the base can drive between the two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraphEdge {
    /// Indices of the nodes, the smaller first.
    pub nodes: [usize; 2],
    /// Length of the path that proves it, metres.
    pub length_m: f64,
}

impl TopologicalGraph {
    /// Builds the graph from its nodes, asking `path_length_m` for each pair whether the base can drive between a pose
    /// of the one and a pose of the other, and how far.
    ///
    /// Planning a path is no business of a map, so the planner comes as an argument.
    pub fn build(
        nodes: Vec<GraphNode>,
        mut path_length_m: impl FnMut(&Pose2, &Pose2) -> Option<f64>,
    ) -> Self {
        let mut edges = Vec::new();
        for a in 0..nodes.len() {
            for b in a + 1..nodes.len() {
                let ends = nodes[a]
                    .map_from_base
                    .first()
                    .zip(nodes[b].map_from_base.first());
                if let Some(length_m) = ends.and_then(|(from, to)| path_length_m(from, to)) {
                    edges.push(GraphEdge {
                        nodes: [a, b],
                        length_m,
                    });
                }
            }
        }
        Self { nodes, edges }
    }

    /// The graph with only the nodes for which `is_kept` holds, and the edges between them.
    #[must_use]
    pub fn filtered(&self, is_kept: impl Fn(&GraphNode) -> bool) -> Self {
        let mut kept: Vec<Option<usize>> = Vec::with_capacity(self.nodes.len());
        let mut nodes = Vec::new();
        for node in &self.nodes {
            kept.push(is_kept(node).then_some(nodes.len()));
            if is_kept(node) {
                nodes.push(node.clone());
            }
        }
        let renamed = |edge: &GraphEdge| {
            let [a, b] = edge.nodes.map(|node| kept.get(node).copied().flatten());
            Some(GraphEdge {
                nodes: [a?, b?],
                ..*edge
            })
        };
        let edges = self.edges.iter().filter_map(renamed).collect();
        Self { nodes, edges }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filtered_graph_keeps_the_edges_between_what_is_kept() {
        let node = |name: &str| GraphNode {
            option: GroundAction::new("pick", [name]),
            map_from_base: vec![Pose2::identity()],
        };
        let nodes = ["a", "b", "c"].map(node).to_vec();
        let graph = TopologicalGraph::build(nodes, |_, _| Some(1.5));
        assert_eq!(graph.edges.len(), 3);
        let fewer = graph.filtered(|node| node.option.args[0] != "b");
        assert_eq!(fewer.nodes, ["a", "c"].map(node));
        let edge = GraphEdge {
            nodes: [0, 1],
            length_m: 1.5,
        };
        assert_eq!(fewer.edges, [edge]);
    }
}
