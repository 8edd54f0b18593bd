//! What is chosen before learning.

use serde::{Deserialize, Serialize};

use crate::mlp::{Activation, Architecture};

/// How TD3 learns.
///
/// The defaults are those of the dissertation's text (section 3.2.1 for the networks, 3.3 for the rest). Where the
/// text says nothing, they are what its code uses, which leaves Stable-Baselines3's defaults. One number differs
/// between the two: the text has two hidden layers of 64, the code Stable-Baselines3's 400 and 300
/// ([`Td3Params::as_in_the_code`]). Neither normalises observations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Td3Params {
    /// Step of Adam for policy and critics. Text: 1e-4.
    pub learning_rate: f64,
    /// Units of the hidden layers of policy and critics. Text: 64, 64; code: 400, 300.
    pub hidden: Vec<usize>,
    /// Of the hidden layers. Code: ReLU.
    pub hidden_activation: Activation,
    /// Whether the critics' hidden layers are normalised, which steadies many updates per step (Ball et al., ICML
    /// 2023, arXiv 2302.02948). Code: no.
    pub critic_layer_norm: bool,
    /// Multiplies the policy's first output layer. 1 is an ordinary start; near 0 the policy begins by saying
    /// nothing, as a correction of a given action should.
    pub policy_output_scale: f32,
    /// The action that the policy begins about, each component above -1 and below 1; 0 if empty. Neither text nor code
    /// says.
    pub policy_first_action: Vec<f32>,
    /// Transitions per update. Code: 256.
    pub batch_size: usize,
    /// Transitions kept. Code: 1,000,000, which holds all of the dissertation's 25,000 steps.
    pub replay_capacity: usize,
    /// γ, what a reward is worth one step later, within 0..1. Code: 0.99.
    pub discount: f64,
    /// τ, the share of its way that a target goes, within 0..=1. Code: 0.005.
    pub target_share: f64,
    /// d: updates of the critics for one of the policy and the targets. Code: 2.
    pub policy_delay: u32,
    /// Standard deviation of the noise on explored actions, in units of half an action's range. Text: 0.05.
    pub exploration_noise: f64,
    /// σ', standard deviation of the noise on target actions. Code: 0.2.
    pub target_noise: f64,
    /// c, where that noise is cut. Code: 0.5.
    pub target_noise_clip: f64,
    /// Steps at the start with uniformly random actions, which earn no updates. Code: 100.
    pub warmup_steps: u64,
    /// Updates that each step earns. Code: 1, made after each episode.
    pub updates_per_step: f64,
}

impl Default for Td3Params {
    fn default() -> Self {
        Self {
            learning_rate: 1e-4,
            hidden: vec![64, 64],
            hidden_activation: Activation::Relu,
            critic_layer_norm: false,
            policy_output_scale: 1.0,
            policy_first_action: Vec::new(),
            batch_size: 256,
            replay_capacity: 1_000_000,
            discount: 0.99,
            target_share: 0.005,
            policy_delay: 2,
            exploration_noise: 0.05,
            target_noise: 0.2,
            target_noise_clip: 0.5,
            warmup_steps: 100,
            updates_per_step: 1.0,
        }
    }
}

/// A parameter out of its range.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{field}` is {found}, expected {wanted}")]
pub struct ParamsError {
    /// Which parameter.
    pub field: &'static str,
    /// Its value.
    pub found: String,
    /// Its range in words.
    pub wanted: &'static str,
}

impl Td3Params {
    /// The defaults with what the dissertation's code has in place of its text.
    #[must_use]
    pub fn as_in_the_code() -> Self {
        Self {
            hidden: vec![400, 300],
            ..Self::default()
        }
    }

    /// Checks every range.
    ///
    /// # Errors
    ///
    /// The first parameter that is out of its range.
    pub fn check(&self) -> Result<(), ParamsError> {
        let positive = "a finite number above 0";
        let not_negative = "a finite number of at least 0";
        let share = "a number above 0 and at most 1";
        let count = "at least 1";
        let in_share = |value: f64| value > 0.0 && value <= 1.0;
        let is_positive = |value: f64| value > 0.0 && value.is_finite();
        let is_not_negative = |value: f64| value >= 0.0 && value.is_finite();
        let index = "from 1 to 4294967295";
        let fits = |size: usize| size > 0 && u32::try_from(size).is_ok();
        let scale = f64::from(self.policy_output_scale);
        let hidden = !self.hidden.is_empty() && !self.hidden.contains(&0);
        let is_inside = |value: &f32| value.abs() < 1.0;
        let first_action = self.policy_first_action.iter().all(is_inside);
        let discount = (0.0..1.0).contains(&self.discount);
        let numbers = [
            (
                "learning_rate",
                self.learning_rate,
                is_positive(self.learning_rate),
                positive,
            ),
            (
                "policy_output_scale",
                scale,
                is_not_negative(scale),
                not_negative,
            ),
            (
                "discount",
                self.discount,
                discount,
                "a number of at least 0 and below 1",
            ),
            (
                "target_share",
                self.target_share,
                in_share(self.target_share),
                share,
            ),
            (
                "exploration_noise",
                self.exploration_noise,
                is_not_negative(self.exploration_noise),
                not_negative,
            ),
            (
                "target_noise",
                self.target_noise,
                is_not_negative(self.target_noise),
                not_negative,
            ),
            (
                "target_noise_clip",
                self.target_noise_clip,
                is_not_negative(self.target_noise_clip),
                not_negative,
            ),
            (
                "updates_per_step",
                self.updates_per_step,
                is_not_negative(self.updates_per_step),
                not_negative,
            ),
        ]
        .map(|(field, found, good, wanted)| (field, format!("{found}"), good, wanted));
        let others = [
            (
                "hidden",
                format!("{:?}", self.hidden),
                hidden,
                "at least one layer, each of at least 1 unit",
            ),
            (
                "policy_first_action",
                format!("{:?}", self.policy_first_action),
                first_action,
                "numbers above -1 and below 1",
            ),
            (
                "batch_size",
                self.batch_size.to_string(),
                fits(self.batch_size),
                index,
            ),
            (
                "replay_capacity",
                self.replay_capacity.to_string(),
                fits(self.replay_capacity),
                index,
            ),
            (
                "policy_delay",
                self.policy_delay.to_string(),
                self.policy_delay > 0,
                count,
            ),
        ];
        match numbers
            .into_iter()
            .chain(others)
            .find(|(_, _, good, _)| !good)
        {
            Some((field, found, _, wanted)) => Err(ParamsError {
                field,
                found,
                wanted,
            }),
            None => Ok(()),
        }
    }

    pub(crate) fn policy_architecture(
        &self,
        n_observation: usize,
        n_action: usize,
    ) -> Architecture {
        Architecture {
            n_inputs: n_observation,
            hidden: self.hidden.clone(),
            n_outputs: n_action,
            hidden_activation: self.hidden_activation,
            output_activation: Activation::Tanh,
            layer_norm: false,
            n_members: 1,
        }
    }
}
