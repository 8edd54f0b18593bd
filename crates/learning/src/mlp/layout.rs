//! Where each weight of a network lies among its parameters.
//!
//! All parameters are one run of rows of sixteen, so that the optimiser, the soft update and the search for a NaN go
//! over them without knowing layers. A layer with one output keeps its weights as a row, since a column would fill
//! one lane of sixteen.

use crate::panels::{Lanes, Panels, WIDTH, n_panels};

use super::Architecture;

/// A matrix in panels among the parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Block {
    pub(super) start: usize,
    n_rows: usize,
    n_cols: usize,
}

impl Block {
    fn size(&self) -> usize {
        self.n_rows * n_panels(self.n_cols)
    }

    pub(super) fn range(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.size()
    }

    pub(super) fn of<'a>(&self, parameters: &'a [Lanes]) -> &'a [Lanes] {
        &parameters[self.range()]
    }

    pub(super) fn panels<'a>(&self, parameters: &'a [Lanes]) -> Panels<'a> {
        Panels::new(&parameters[self.start..], self.n_rows, self.n_cols)
    }

    /// The same matrix of another member.
    fn of_member(self, member: usize) -> Self {
        Self {
            start: self.start + member * self.size(),
            ..self
        }
    }

    /// Rows and columns.
    pub(crate) fn shape(&self) -> [usize; 2] {
        [self.n_rows, self.n_cols]
    }

    /// Every element, row by row.
    pub(crate) fn for_each_mut(&self, parameters: &mut [Lanes], mut act: impl FnMut(&mut f32)) {
        for row in 0..self.n_rows {
            for column in 0..self.n_cols {
                let at = self.start + column / WIDTH * self.n_rows + row;
                act(&mut parameters[at][column % WIDTH]);
            }
        }
    }

    /// Every element, row by row.
    pub(crate) fn elements<'a>(
        &'a self,
        parameters: &'a [Lanes],
    ) -> impl Iterator<Item = f32> + 'a {
        (0..self.n_rows).flat_map(move |row| {
            (0..self.n_cols).map(move |column| {
                parameters[self.start + column / WIDTH * self.n_rows + row][column % WIDTH]
            })
        })
    }
}

/// A block with the name under which it is stored.
#[derive(Debug, Clone)]
pub(crate) struct Tensor {
    /// `MEMBER.LAYER.weight|bias|gain|shift`.
    pub(crate) name: String,
    pub(crate) block: Block,
}

/// One layer of all members; the blocks are those of the first member, and the others' follow them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layer {
    pub(super) n_inputs: usize,
    pub(super) n_outputs: usize,
    pub(super) weights: Block,
    pub(super) bias: Block,
    /// Gain and shift of the layer normalisation.
    pub(super) norm: Option<(Block, Block)>,
    /// Whether the weights lie as a row.
    pub(super) is_row: bool,
    /// Where the next layer begins.
    pub(super) end: usize,
}

impl Layer {
    /// Columns of the matrix in which the members' outputs lie side by side, each from a new panel on.
    pub(super) fn n_columns(&self, n_members: usize) -> usize {
        (n_members - 1) * n_panels(self.n_outputs) * WIDTH + self.n_outputs
    }

    pub(super) fn weights_of(&self, member: usize) -> Block {
        self.weights.of_member(member)
    }

    pub(super) fn bias_of(&self, member: usize) -> Block {
        self.bias.of_member(member)
    }

    pub(super) fn norm_of(&self, member: usize) -> Option<(Block, Block)> {
        self.norm
            .map(|(gain, shift)| (gain.of_member(member), shift.of_member(member)))
    }
}

pub(super) fn layers(architecture: &Architecture) -> Vec<Layer> {
    let mut end = 0;
    let mut place = |n_rows, n_cols| {
        let block = Block {
            start: end,
            n_rows,
            n_cols,
        };
        end += block.size() * architecture.n_members;
        (block, end)
    };
    let outputs = architecture.hidden.iter().chain([&architecture.n_outputs]);
    let inputs = [&architecture.n_inputs]
        .into_iter()
        .chain(&architecture.hidden);
    inputs
        .zip(outputs)
        .enumerate()
        .map(|(l, (&n_inputs, &n_outputs))| {
            let is_output = l == architecture.hidden.len();
            let is_row = is_output && n_outputs == 1;
            let (weights, _) = if is_row {
                place(1, n_inputs)
            } else {
                place(n_inputs, n_outputs)
            };
            let (bias, mut end) = place(1, n_outputs);
            let norm = (architecture.layer_norm && !is_output).then(|| {
                let (gain, _) = place(1, n_outputs);
                let (shift, after) = place(1, n_outputs);
                end = after;
                (gain, shift)
            });
            Layer {
                n_inputs,
                n_outputs,
                weights,
                bias,
                norm,
                is_row,
                end,
            }
        })
        .collect()
}

pub(super) fn tensors(layers: &[Layer], n_members: usize) -> Vec<Tensor> {
    let mut tensors = Vec::new();
    for member in 0..n_members {
        for (l, layer) in layers.iter().enumerate() {
            let mut add = |kind, block| {
                tensors.push(Tensor {
                    name: format!("{member}.{l}.{kind}"),
                    block,
                });
            };
            add("weight", layer.weights_of(member));
            add("bias", layer.bias_of(member));
            if let Some((gain, shift)) = layer.norm_of(member) {
                add("gain", gain);
                add("shift", shift);
            }
        }
    }
    tensors
}
