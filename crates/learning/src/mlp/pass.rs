//! The memory of one pass through a network.

use crate::panels::{Lanes, ZERO, n_panels};

use super::Architecture;
use super::norm::Normalised;

/// What a forward pass leaves for the backward pass, for one batch size.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    pub(super) n_rows: usize,
    /// Members of the last forward pass.
    pub(super) n_members: usize,
    /// Rows of sixteen that the outputs of one member fill.
    output_size: usize,
    /// After the activation, layer by layer; members side by side.
    pub(super) outputs: Vec<Vec<Lanes>>,
    /// Derivatives by the outputs, and then by the sums, of each layer.
    pub(super) deltas: Vec<Vec<Lanes>>,
    pub(super) norms: Vec<Normalised>,
    /// One weight matrix, transposed.
    pub(super) transposed: Vec<Lanes>,
    pub(super) input_delta: Vec<Lanes>,
    pub(super) single_input: Vec<Lanes>,
}

impl Pass {
    /// Memory for passes of `n_rows` inputs through a network of this form.
    #[must_use]
    pub fn new(architecture: &Architecture, n_rows: usize) -> Self {
        let widths: Vec<usize> = architecture
            .hidden
            .iter()
            .chain([&architecture.n_outputs])
            .map(|units| n_panels(*units))
            .collect();
        let per_layer = || -> Vec<Vec<Lanes>> {
            widths
                .iter()
                .map(|width| vec![ZERO; width * architecture.n_members * n_rows])
                .collect()
        };
        let n_inputs = n_panels(architecture.n_inputs);
        let transposed = [architecture.n_inputs]
            .iter()
            .chain(&architecture.hidden)
            .zip(architecture.hidden.iter().chain([&architecture.n_outputs]))
            .map(|(inputs, outputs)| n_panels(*inputs) * outputs)
            .max();
        let norms = if architecture.layer_norm {
            architecture
                .hidden
                .iter()
                .map(|units| Normalised::new(*units, architecture.n_members, n_rows))
                .collect()
        } else {
            Vec::new()
        };
        Self {
            n_rows,
            n_members: architecture.n_members,
            output_size: n_panels(architecture.n_outputs) * n_rows,
            outputs: per_layer(),
            deltas: per_layer(),
            norms,
            transposed: vec![ZERO; transposed.unwrap_or(0)],
            input_delta: vec![ZERO; n_inputs * n_rows],
            single_input: vec![ZERO; n_inputs],
        }
    }

    /// Outputs of a member: one row per input row, panel after panel.
    pub(crate) fn output(&self, member: usize) -> &[Lanes] {
        &self.outputs[self.outputs.len() - 1][member * self.output_size..][..self.output_size]
    }

    /// Where the derivatives by the outputs of a member are to be written before a backward pass; the lanes beyond
    /// its outputs are to stay zero.
    pub(crate) fn output_delta_mut(&mut self, member: usize) -> &mut [Lanes] {
        let last = self.deltas.len() - 1;
        &mut self.deltas[last][member * self.output_size..][..self.output_size]
    }
}
