//! Gaussian policies: cloned from demonstrations, and improved by the natural policy gradient, alone or with
//! demonstrations at its side (DAPG).
//!
//! ```text
//! a ~ N(mu(o), diag(sigma)^2)                              mu: a network, sigma: parameters of their own
//! g = mean A log pi(a|o)' + w / N sum_demo log pi(a|o)'    w = lambda_0 lambda_1^k in update k, or 0
//! F = mean J^T diag(sigma)^-2 J, and 2 for ln sigma        J: derivatives of mu by the parameters
//! theta <- theta + sqrt(d / g^T F^-1 g) F^-1 g             d: twice the divergence of an update
//! ```
//!
//! `F^-1 g` is found by conjugate gradients; products with F are exact and need no matrix. A are advantages by
//! generalised advantage estimation over a fitted baseline, brought to mean 0 and deviation 1.
//!
//! Sources: Kakade, "A Natural Policy Gradient", NIPS 2001; Rajeswaran, Lowrey, Todorov & Kakade, "Towards
//! Generalization and Simplicity in Continuous Control", NIPS 2017, arXiv 1703.02660 (the step's size); Schulman et
//! al., "High-Dimensional Continuous Control Using Generalized Advantage Estimation", ICLR 2016, arXiv 1506.02438;
//! Rajeswaran et al., "Learning Complex Dexterous Manipulation with Deep Reinforcement Learning and Demonstrations",
//! RSS 2018, arXiv 1709.10087 (DAPG). The last weighs demonstrations with the largest advantage, too; its code, and
//! the dissertation's, which normalise advantages, do not, and nor do we.
//!
//! Where we differ: the step above is right to second order alone. One that moves the policy by more than d, twice what
//! it should, is halved until it does not.
//!
//! [`NaturalGradient::policy`] is what rollouts are made with, anywhere and in any order; [`NaturalGradient::tell`]
//! takes them. All state is data: a learner that was stored in between goes on to the bit.

mod advantage;
mod baseline;
mod batch;
mod cloning;
mod conjugate;
mod error;
mod natural;
mod policy;

pub use baseline::Baseline;
pub use cloning::{CloningParams, clone_behaviour};
pub use error::PolicyGradientError;
pub use natural::{NaturalGradient, NaturalGradientParams, NaturalUpdate};
pub use policy::{GaussianParams, GaussianPolicy, GaussianState};

use serde::{Deserialize, Serialize};

use crate::replay::Ending;

/// Observations and what was done, row after row.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Demonstrations {
    /// `n_observation` numbers a step.
    pub observations: Vec<f32>,
    /// `n_action` numbers a step.
    pub actions: Vec<f32>,
}

/// One rollout of a policy.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// What was observed before each action, `n_observation` numbers a step.
    pub observations: Vec<f32>,
    /// What was done, `n_action` numbers a step.
    pub actions: Vec<f32>,
    /// What it earned, one number a step.
    pub rewards: Vec<f32>,
    /// How it ended; after [`Ending::Terminal`] nothing more could be earned.
    pub ending: Ending,
}

#[cfg(test)]
mod tests;
