//! Derivatives of the outputs along a direction in the parameters.
//!
//! ```text
//! t_0 = x dW_0 + db_0        t_l = (f'(z_{l-1}) t_{l-1}) W_l + y_{l-1} dW_l + db_l
//! ```
//!
//! Pearlmutter, "Fast Exact Multiplication by the Hessian", Neural Computation 6 (1994), doi 10.1162/neco.1994.6.1.147:
//! what he calls R-forward.

use crate::elementwise::{gate_by_relu, gate_by_tanh};
use crate::panels::{Finish, Lanes, Panels, ZERO, dot_into, multiply_into, n_panels};

use super::layout::Layer;
use super::{Activation, Architecture, Mlp, Pass};

/// Memory for one batch size.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tangent {
    /// Of the layer before, and of this one.
    now: Vec<Lanes>,
    next: Vec<Lanes>,
    product: Vec<Lanes>,
}

impl Tangent {
    pub(crate) fn new(architecture: &Architecture, n_rows: usize) -> Self {
        let units = architecture.hidden.iter().chain([&architecture.n_outputs]);
        let widest = units.map(|units| n_panels(*units)).max().unwrap_or(0);
        let memory = || vec![ZERO; widest * n_rows];
        Self {
            now: memory(),
            next: memory(),
            product: memory(),
        }
    }
}

impl Mlp {
    /// Derivatives of the outputs, which lie as they do, along `direction`, which lies as the parameters do, at the
    /// pass that [`Self::forward`] left for the same `input`.
    ///
    /// For networks of one member without layer normalisation.
    pub(crate) fn tangent<'t>(
        &self,
        input: Panels<'_>,
        pass: &Pass,
        direction: &[Lanes],
        memory: &'t mut Tangent,
    ) -> &'t [Lanes] {
        assert_eq!(self.architecture.n_members, 1, "members of a network");
        assert!(!self.architecture.layer_norm, "a normalised network");
        let n_rows = pass.n_rows;
        let Tangent { now, next, product } = memory;
        let mut size = 0;
        for (l, layer) in self.layers.iter().enumerate() {
            size = n_panels(layer.n_outputs) * n_rows;
            let out = &mut next[..size];
            let before = match l.checked_sub(1) {
                None => input,
                Some(before) => Panels::new(&pass.outputs[before], n_rows, layer.n_inputs),
            };
            multiply_layer(layer, before, direction, Some(direction), out);
            if l > 0 {
                let product = &mut product[..size];
                let moved = Panels::new(now, n_rows, layer.n_inputs);
                multiply_layer(layer, moved, &self.parameters, None, product);
                for (out, product) in out
                    .as_flattened_mut()
                    .iter_mut()
                    .zip(product.as_flattened())
                {
                    *out += product;
                }
            }
            let is_output = l + 1 == self.layers.len();
            let activation = if is_output {
                self.architecture.output_activation
            } else {
                self.architecture.hidden_activation
            };
            match activation {
                Activation::Tanh => gate_by_tanh(out, &pass.outputs[l][..size]),
                Activation::Relu => gate_by_relu(out, &pass.outputs[l][..size]),
                Activation::Linear => {}
            }
            std::mem::swap(now, next);
        }
        &now[..size]
    }
}

/// `out = a W + b` with the weights of `parameters`, and the bias of `biases` if any.
fn multiply_layer(
    layer: &Layer,
    a: Panels<'_>,
    parameters: &[Lanes],
    biases: Option<&[Lanes]>,
    out: &mut [Lanes],
) {
    let weights = layer.weights_of(0);
    let bias = biases.map(|biases| layer.bias_of(0).of(biases));
    if layer.is_row {
        let bias = bias.map_or(0.0, |bias| bias[0][0]);
        dot_into(a, weights.of(parameters), bias, out);
    } else {
        multiply_into(a, weights.panels(parameters), bias, Finish::Keep, out);
    }
}
