//! The form of a network, and what makes one impossible.

use serde::{Deserialize, Serialize};

/// What a unit does to the sum it receives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// Nothing.
    Linear,
    /// Negative sums become zero.
    Relu,
    /// The hyperbolic tangent.
    Tanh,
}

/// The form of a network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Architecture {
    /// Numbers it reads.
    pub n_inputs: usize,
    /// Units of each hidden layer, from the input on; at least one layer.
    pub hidden: Vec<usize>,
    /// Numbers that each member gives.
    pub n_outputs: usize,
    /// Of every hidden layer.
    pub hidden_activation: Activation,
    /// Of the output layer.
    pub output_activation: Activation,
    /// Whether the sums of each hidden layer are normalised before the activation.
    pub layer_norm: bool,
    /// Networks of this form that read the same input.
    pub n_members: usize,
}

impl Architecture {
    pub(super) fn check(&self) -> Result<(), NetworkError> {
        let sizes = [
            ("inputs", self.n_inputs),
            ("outputs", self.n_outputs),
            ("members", self.n_members),
            ("hidden layers", self.hidden.len()),
        ];
        let hidden = self
            .hidden
            .iter()
            .map(|units| ("units in a hidden layer", *units));
        match sizes.into_iter().chain(hidden).find(|(_, size)| *size == 0) {
            Some((what, _)) => Err(NetworkError::Empty { what }),
            None => Ok(()),
        }
    }
}

/// Why there is no such network.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// A size of zero.
    #[error("number of {what} is 0, expected at least 1")]
    Empty {
        /// Whose number.
        what: &'static str,
    },
}
