//! Multilayer perceptrons with forward and backward passes written by hand.
//!
//! ```text
//! z_l = y_{l-1} W_l + b_l        y_l = f(z_l), or f(norm(z_l)) with layer normalisation
//! dW_l = y_{l-1}ᵀ dz_l           db_l = sum of the rows of dz_l           dy_{l-1} = dz_l W_lᵀ
//! ```
//!
//! A network may have several **members**: networks of one form that read the same input, such as TD3's twin critics.
//! Their first layers lie side by side and are one product.
//!
//! Weights are initialised uniformly within `±1 / sqrt(n_inputs of the layer)`, as PyTorch's linear layers are, which
//! the dissertation's code builds on. Layer normalisation: Ba, Kiros & Hinton, 2016, arXiv 1607.06450.
//!
//! Nothing is allocated in a pass; a [`Pass`] holds the memory of one batch size.

mod architecture;
mod layout;
mod norm;
mod pass;
mod tangent;

pub use architecture::{Activation, Architecture, NetworkError};
pub use pass::Pass;
pub(crate) use tangent::Tangent;

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use crate::elementwise::{gate_by_relu, gate_by_tanh, relu_in_place, tanh_in_place};
use crate::panels::{
    Finish, Lanes, Panels, ZERO, dot_into, multiply_into, multiply_transposed_into, n_panels,
    sum_rows_into, transpose_into,
};
pub(crate) use layout::Tensor;
use layout::{Layer, layers};
use norm::{normalise, normalise_back};

/// A network, or several that read the same input.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp {
    architecture: Architecture,
    layers: Vec<Layer>,
    parameters: Vec<Lanes>,
}

impl Mlp {
    /// A network with random weights.
    ///
    /// # Errors
    ///
    /// When the architecture has no hidden layer, or a layer without a unit.
    pub fn new(architecture: Architecture, rng: &mut ChaCha8Rng) -> Result<Self, NetworkError> {
        architecture.check()?;
        let layers = layers(&architecture);
        let n_lanes = layers.last().map_or(0, |layer| layer.end);
        let mut network = Self {
            architecture,
            layers,
            parameters: vec![ZERO; n_lanes],
        };
        network.initialise(rng);
        Ok(network)
    }

    fn initialise(&mut self, rng: &mut ChaCha8Rng) {
        for layer in &self.layers {
            let bound = 1.0 / (layer.n_inputs as f32).sqrt();
            for member in 0..self.architecture.n_members {
                for block in [layer.weights_of(member), layer.bias_of(member)] {
                    block.for_each_mut(&mut self.parameters, |value| {
                        *value = rng.random_range(-bound..bound);
                    });
                }
                if let Some((gain, _)) = layer.norm_of(member) {
                    gain.for_each_mut(&mut self.parameters, |value| *value = 1.0);
                }
            }
        }
    }

    /// Its form.
    #[must_use]
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// Multiplies the weights and biases of the output layer: zero makes a network that says nothing yet, which a
    /// learned correction of a given action begins with.
    pub fn scale_output(&mut self, factor: f32) {
        if let Some(layer) = self.layers.last() {
            for value in self.parameters[layer.weights.start..].as_flattened_mut() {
                *value *= factor;
            }
        }
    }

    /// Adds to the biases of the output layer, one value for each output.
    pub(crate) fn shift_output(&mut self, by: &[f32]) {
        let Some(layer) = self.layers.last() else {
            return;
        };
        for member in 0..self.architecture.n_members {
            let mut by = by.iter();
            layer
                .bias_of(member)
                .for_each_mut(&mut self.parameters, |bias| {
                    *bias += by.next().copied().unwrap_or(0.0);
                });
        }
    }

    /// Output of the first member for one input.
    ///
    /// # Panics
    ///
    /// When `pass` was made for another network or for several rows, or a slice has another size.
    pub fn evaluate_into(&self, input: &[f32], pass: &mut Pass, output: &mut [f32]) {
        assert_eq!(
            input.len(),
            self.architecture.n_inputs,
            "inputs of a network"
        );
        assert_eq!(
            output.len(),
            self.architecture.n_outputs,
            "outputs of a network"
        );
        assert_eq!(pass.n_rows, 1, "rows of a pass for one input");
        let mut row = std::mem::take(&mut pass.single_input);
        row.as_flattened_mut()[..input.len()].copy_from_slice(input);
        self.forward(Panels::new(&row, 1, input.len()), 1, pass);
        pass.single_input = row;
        output.copy_from_slice(&pass.output(0).as_flattened()[..output.len()]);
    }

    pub(crate) fn parameters(&self) -> &[Lanes] {
        &self.parameters
    }

    pub(crate) fn parameters_mut(&mut self) -> &mut [Lanes] {
        &mut self.parameters
    }

    /// The dense tensors in which this network's numbers, or others that lie as they do, are stored.
    pub(crate) fn tensors(&self) -> Vec<Tensor> {
        layout::tensors(&self.layers, self.architecture.n_members)
    }

    /// Evaluates the first `n_members` members on every row of `input`; the outputs stay in `pass`.
    pub(crate) fn forward(&self, input: Panels<'_>, n_members: usize, pass: &mut Pass) {
        let hidden_activation = self.architecture.hidden_activation;
        let n_rows = pass.n_rows;
        pass.n_members = n_members;
        for (l, layer) in self.layers.iter().enumerate() {
            let is_output = l + 1 == self.layers.len();
            let activation = if is_output {
                self.architecture.output_activation
            } else {
                hidden_activation
            };
            let finish = match activation {
                Activation::Relu if layer.norm.is_none() => Finish::Relu,
                _ => Finish::Keep,
            };
            let (before, rest) = pass.outputs.split_at_mut(l);
            let output = &mut rest[0][..n_members * n_panels(layer.n_outputs) * n_rows];
            match before.last() {
                None => {
                    let n_columns = layer.n_columns(n_members);
                    let weights = &self.parameters[layer.weights.start..];
                    let bias = &self.parameters[layer.bias.start..];
                    let weights = Panels::new(weights, layer.n_inputs, n_columns);
                    multiply_into(input, weights, Some(bias), finish, output);
                }
                Some(before) => {
                    for (member, output) in output
                        .chunks_exact_mut(n_panels(layer.n_outputs) * n_rows)
                        .enumerate()
                    {
                        let at = member * n_panels(layer.n_inputs) * n_rows;
                        let x = Panels::new(&before[at..], n_rows, layer.n_inputs);
                        let weights = layer.weights_of(member);
                        let bias = layer.bias_of(member).of(&self.parameters);
                        if layer.is_row {
                            dot_into(x, weights.of(&self.parameters), bias[0][0], output);
                        } else {
                            let weights = weights.panels(&self.parameters);
                            multiply_into(x, weights, Some(bias), finish, output);
                        }
                    }
                }
            }
            if layer.norm.is_some() {
                normalise(
                    layer,
                    &self.parameters,
                    n_members,
                    output,
                    &mut pass.norms[l],
                );
            }
            match activation {
                Activation::Tanh => tanh_in_place(output),
                Activation::Relu if layer.norm.is_some() || layer.is_row => relu_in_place(output),
                Activation::Relu | Activation::Linear => {}
            }
        }
    }

    /// Derivatives by every parameter, for the derivatives by the outputs in [`Pass::output_delta_mut`] of the pass
    /// that [`Self::forward`] left for the same `input` with all members.
    pub(crate) fn backward(&self, input: Panels<'_>, pass: &mut Pass, gradient: &mut [Lanes]) {
        assert_eq!(
            pass.n_members, self.architecture.n_members,
            "members in a pass"
        );
        self.back(pass, Some((input, gradient)));
    }

    /// Derivatives by the inputs from the panel `first` on, for the first member alone; they lie one row per input
    /// row, panel after panel.
    pub(crate) fn backward_to_input<'p>(&self, pass: &'p mut Pass, first: usize) -> &'p [Lanes] {
        assert_eq!(pass.n_members, 1, "members in a pass");
        self.back(pass, None);
        let layer = &self.layers[0];
        let weights = layer.weights_of(0).panels(&self.parameters);
        transpose_into(weights, &mut pass.transposed);
        let transposed = Panels::new(&pass.transposed, layer.n_outputs, layer.n_inputs);
        let delta = Panels::new(&pass.deltas[0], pass.n_rows, layer.n_outputs);
        let n_panels = n_panels(layer.n_inputs) - first;
        let out = &mut pass.input_delta[..n_panels * pass.n_rows];
        let wanted = transposed.after_panels(first);
        multiply_into(delta, wanted, None, Finish::Keep, out);
        out
    }

    /// Carries the derivatives from the outputs back to before the activation of the first layer, and on the way
    /// writes those by the parameters.
    fn back(&self, pass: &mut Pass, mut gradient: Option<(Panels<'_>, &mut [Lanes])>) {
        let (n_rows, n_members) = (pass.n_rows, pass.n_members);
        for (l, layer) in self.layers.iter().enumerate().rev() {
            let is_output = l + 1 == self.layers.len();
            let (deltas_before, deltas) = pass.deltas.split_at_mut(l);
            let size = n_members * n_panels(layer.n_outputs) * n_rows;
            let (delta, y) = (&mut deltas[0][..size], &pass.outputs[l][..size]);
            match (is_output, self.architecture.hidden_activation) {
                (true, _) => match self.architecture.output_activation {
                    Activation::Tanh => gate_by_tanh(delta, y),
                    Activation::Relu => gate_by_relu(delta, y),
                    Activation::Linear => {}
                },
                (false, Activation::Tanh) => gate_by_tanh(delta, y),
                // The product that made this delta has gated it.
                (false, Activation::Relu | Activation::Linear) => {}
            }
            if layer.norm.is_some() {
                let gradient = gradient.as_mut().map(|(_, gradient)| &mut **gradient);
                normalise_back(
                    layer,
                    &self.parameters,
                    n_members,
                    delta,
                    &pass.norms[l],
                    gradient,
                );
            }
            if let Some((input, gradient)) = &mut gradient {
                let n_columns = layer.n_columns(n_members);
                let bias = &mut gradient[layer.bias.start..][..n_panels(n_columns)];
                sum_rows_into(Panels::new(delta, n_rows, n_columns), bias);
                if l == 0 {
                    let size = n_panels(n_columns) * layer.n_inputs;
                    let out = &mut gradient[layer.weights.start..][..size];
                    multiply_transposed_into(*input, Panels::new(delta, n_rows, n_columns), out);
                }
            }
            if l == 0 {
                continue;
            }
            let gated = self.architecture.hidden_activation == Activation::Relu;
            for member in 0..n_members {
                let at = member * n_panels(layer.n_outputs) * n_rows;
                let delta = Panels::new(&delta[at..], n_rows, layer.n_outputs);
                let size = n_panels(layer.n_inputs) * n_rows;
                let y_before = &pass.outputs[l - 1][member * size..][..size];
                let x = Panels::new(y_before, n_rows, layer.n_inputs);
                let weights = layer.weights_of(member);
                if let Some((_, gradient)) = &mut gradient {
                    let out = &mut gradient[weights.range()];
                    if layer.is_row {
                        multiply_transposed_into(delta, x, out);
                    } else {
                        multiply_transposed_into(x, delta, out);
                    }
                }
                let weights = weights.panels(&self.parameters);
                let transposed = if layer.is_row {
                    weights
                } else {
                    transpose_into(weights, &mut pass.transposed);
                    Panels::new(&pass.transposed, layer.n_outputs, layer.n_inputs)
                };
                let finish = if gated {
                    Finish::Gate(y_before)
                } else {
                    Finish::Keep
                };
                let out = &mut deltas_before[l - 1][member * size..][..size];
                multiply_into(delta, transposed, None, finish, out);
            }
        }
    }
}

#[cfg(test)]
mod tests;
