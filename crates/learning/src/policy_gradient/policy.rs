//! A policy that draws actions around what a network says.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use serde::{Deserialize, Serialize};

use super::error::{check_finite, check_range, check_size};
use super::{Demonstrations, PolicyGradientError};
use crate::mlp::{Activation, Architecture, Mlp, Pass};
use crate::panels::{Lanes, WIDTH, ZERO, n_panels};

/// Form of a policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GaussianParams {
    /// Units of the hidden layers, which end in hyperbolic tangents. Dissertation: 32, 32.
    pub hidden: Vec<usize>,
    /// Multiplies the first output layer, so that a policy begins by doing almost nothing. DAPG's code: 0.01.
    pub output_scale: f32,
    /// ln sigma at the start.
    pub log_std: f32,
    /// Least ln sigma. DAPG's code: -3.
    pub log_std_min: f32,
}

impl Default for GaussianParams {
    fn default() -> Self {
        Self {
            hidden: vec![32, 32],
            output_scale: 0.01,
            log_std: 0.0,
            log_std_min: -3.0,
        }
    }
}

/// A Gaussian whose mean is a network of the observation, and whose deviation is the same everywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "GaussianState", into = "GaussianState")]
pub struct GaussianPolicy {
    pub(super) network: Mlp,
    /// ln sigma, as the outputs of the network lie.
    pub(super) log_std: Vec<Lanes>,
    log_std_min: f32,
    shift: Vec<f32>,
    scale: Vec<f32>,
    single: Pass,
    standardised: Vec<f32>,
}

/// A policy as it is stored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaussianState {
    /// Components of an observation.
    pub n_observation: usize,
    /// Components of an action.
    pub n_action: usize,
    /// Units of the hidden layers.
    pub hidden: Vec<usize>,
    /// Least ln sigma.
    pub log_std_min: f32,
    /// Subtracted from observations.
    pub shift: Vec<f32>,
    /// Divides observations after that.
    pub scale: Vec<f32>,
    /// As [`GaussianPolicy::parameters`] gives them.
    pub parameters: Vec<f32>,
}

impl GaussianPolicy {
    /// A policy with random weights.
    ///
    /// # Errors
    /// [`PolicyGradientError`] when a size is zero or a number out of its range.
    pub fn new(
        n_observation: usize,
        n_action: usize,
        params: &GaussianParams,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, PolicyGradientError> {
        let (scale, log_std) = (f64::from(params.output_scale), f64::from(params.log_std));
        let log_std_min = f64::from(params.log_std_min);
        let wanted = "a finite number of at least 0";
        check_range("output_scale", scale, scale >= 0.0, wanted)?;
        check_range("log_std_min", log_std_min, true, "a finite number")?;
        let wanted = "a finite number of at least log_std_min";
        check_range("log_std", log_std, log_std >= log_std_min, wanted)?;
        let architecture = Architecture {
            n_inputs: n_observation,
            hidden: params.hidden.clone(),
            n_outputs: n_action,
            hidden_activation: Activation::Tanh,
            output_activation: Activation::Linear,
            layer_norm: false,
            n_members: 1,
        };
        let mut network = Mlp::new(architecture, rng)?;
        network.scale_output(params.output_scale);
        let mut lanes = vec![ZERO; n_panels(n_action)];
        lanes.as_flattened_mut()[..n_action].fill(params.log_std);
        Ok(Self {
            single: Pass::new(network.architecture(), 1),
            network,
            log_std: lanes,
            log_std_min: params.log_std_min,
            shift: vec![0.0; n_observation],
            scale: vec![1.0; n_observation],
            standardised: vec![0.0; n_observation],
        })
    }

    /// Components of an observation.
    #[must_use]
    pub fn n_observation(&self) -> usize {
        self.network.architecture().n_inputs
    }

    /// Components of an action.
    #[must_use]
    pub fn n_action(&self) -> usize {
        self.network.architecture().n_outputs
    }

    /// ln sigma of each component of an action.
    #[must_use]
    pub fn log_std(&self) -> &[f32] {
        &self.log_std.as_flattened()[..self.n_action()]
    }

    /// Brings observations from now on to mean 0 and deviation 1 by those of the demonstrations; components that do
    /// not vary are only shifted. To be done before anything is learned.
    ///
    /// # Errors
    /// [`PolicyGradientError`] when a size differs, there is no step, or a number is not finite.
    pub fn standardise_by(&mut self, shown: &Demonstrations) -> Result<(), PolicyGradientError> {
        let n_steps = self.check(shown)?;
        let n = self.n_observation();
        for i in 0..n {
            let values = || {
                shown.observations[i..]
                    .iter()
                    .step_by(n)
                    .copied()
                    .map(f64::from)
            };
            let mean = values().sum::<f64>() / n_steps as f64;
            let square = values().map(|x| (x - mean).powi(2)).sum::<f64>() / n_steps as f64;
            self.shift[i] = mean as f32;
            let std = square.sqrt() as f32;
            self.scale[i] = if std > f32::EPSILON * self.shift[i].abs().max(1.0) {
                std
            } else {
                1.0
            };
        }
        Ok(())
    }

    /// What it would do without noise. `&mut` is for the memory it works in; it learns nothing.
    ///
    /// # Errors
    /// [`PolicyGradientError`] when a size differs or the observation is not finite.
    pub fn mean_into(
        &mut self,
        observation: &[f32],
        action: &mut [f32],
    ) -> Result<(), PolicyGradientError> {
        check_size("observation", observation.len(), self.n_observation())?;
        check_size("action", action.len(), self.n_action())?;
        check_finite("observation", observation)?;
        for (i, value) in observation.iter().enumerate() {
            self.standardised[i] = self.standard(i, *value);
        }
        self.network
            .evaluate_into(&self.standardised, &mut self.single, action);
        Ok(())
    }

    /// Draws an action. It has no bounds; what an environment can do of it is the environment's affair.
    ///
    /// # Errors
    /// As [`Self::mean_into`].
    pub fn sample_into(
        &mut self,
        observation: &[f32],
        rng: &mut ChaCha8Rng,
        action: &mut [f32],
    ) -> Result<(), PolicyGradientError> {
        self.mean_into(observation, action)?;
        for (value, log_std) in action.iter_mut().zip(self.log_std()) {
            let noise: f32 = StandardNormal.sample(rng);
            *value += log_std.exp() * noise;
        }
        Ok(())
    }

    /// All that is learned: weights and biases layer by layer, matrices `(n_inputs, n_outputs)` row by row, then
    /// ln sigma.
    #[must_use]
    pub fn parameters(&self) -> Vec<f32> {
        let lanes = self.lanes();
        self.dense_of(&lanes)
    }

    /// Replaces [`Self::parameters`].
    ///
    /// # Errors
    /// [`PolicyGradientError`] when there is another number of parameters or one is not finite.
    pub fn set_parameters(&mut self, parameters: &[f32]) -> Result<(), PolicyGradientError> {
        check_size("parameters", parameters.len(), self.parameters().len())?;
        check_finite("parameters", parameters)?;
        let mut values = parameters.iter().copied();
        for tensor in self.network.tensors() {
            let lanes = self.network.parameters_mut();
            tensor.block.for_each_mut(lanes, |to| {
                *to = values.next().unwrap_or_default();
            });
        }
        for (to, from) in self.log_std.as_flattened_mut().iter_mut().zip(values) {
            *to = from;
        }
        Ok(())
    }

    /// Checks demonstrations and counts their steps.
    pub(super) fn check(&self, shown: &Demonstrations) -> Result<usize, PolicyGradientError> {
        let n_steps = shown.actions.len() / self.n_action();
        if n_steps == 0 {
            return Err(PolicyGradientError::Empty { what: "steps" });
        }
        check_size("actions", shown.actions.len(), n_steps * self.n_action())?;
        let wanted = n_steps * self.n_observation();
        check_size("observations", shown.observations.len(), wanted)?;
        check_finite("observations", &shown.observations)?;
        check_finite("actions", &shown.actions)?;
        Ok(n_steps)
    }

    /// A component of an observation as the network reads it.
    pub(super) fn standard(&self, component: usize, value: f32) -> f32 {
        (value - self.shift[component]) / self.scale[component]
    }

    /// `sigma^-2`, as the outputs of the network lie; 0 where there is none.
    pub(super) fn precisions(&self) -> Vec<Lanes> {
        let mut lanes = vec![ZERO; self.log_std.len()];
        let flat = lanes.as_flattened_mut();
        for (precision, log_std) in flat.iter_mut().zip(self.log_std()) {
            *precision = (-2.0 * log_std).exp();
        }
        lanes
    }

    /// Parameters of the network, then ln sigma: how gradients and directions lie, too.
    pub(super) fn lanes(&self) -> Vec<Lanes> {
        let mut lanes = self.network.parameters().to_vec();
        lanes.extend(&self.log_std);
        lanes
    }

    pub(super) fn set_lanes(&mut self, lanes: &[Lanes]) {
        let (network, log_std) = lanes.split_at(lanes.len() - self.log_std.len());
        self.network.parameters_mut().copy_from_slice(network);
        self.log_std.copy_from_slice(log_std);
        let n_action = self.n_action();
        for value in &mut self.log_std.as_flattened_mut()[..n_action] {
            *value = value.max(self.log_std_min);
        }
    }

    pub(super) fn dense_of(&self, lanes: &[Lanes]) -> Vec<f32> {
        let mut dense = Vec::new();
        for tensor in self.network.tensors() {
            dense.extend(tensor.block.elements(lanes));
        }
        let log_std = &lanes[self.network.parameters().len()..];
        dense.extend(&log_std.as_flattened()[..self.n_action()]);
        dense
    }
}

/// Mean divergence from one Gaussian policy to another over the rows of their means.
pub(super) fn divergence(
    (mean, log_std): (&[Lanes], &[Lanes]),
    (other_mean, other_log_std): (&[Lanes], &[Lanes]),
    n_rows: usize,
    n_action: usize,
) -> f64 {
    let mut sum = 0.0;
    for i in 0..n_action {
        let (panel, lane) = (i / WIDTH, i % WIDTH);
        let log = |lanes: &[Lanes]| f64::from(lanes[panel][lane]);
        let (a, b) = (log(log_std), log(other_log_std));
        let rows = panel * n_rows..(panel + 1) * n_rows;
        for (x, y) in mean[rows.clone()].iter().zip(&other_mean[rows]) {
            let away = f64::from(x[lane]) - f64::from(y[lane]);
            sum += b - a + 0.5 * ((2.0 * a).exp() + away * away) * (-2.0 * b).exp() - 0.5;
        }
    }
    sum / n_rows as f64
}

impl TryFrom<GaussianState> for GaussianPolicy {
    type Error = PolicyGradientError;

    fn try_from(state: GaussianState) -> Result<Self, PolicyGradientError> {
        use rand::SeedableRng as _;
        let params = GaussianParams {
            hidden: state.hidden,
            log_std: state.log_std_min,
            log_std_min: state.log_std_min,
            ..GaussianParams::default()
        };
        let mut nothing_random = ChaCha8Rng::seed_from_u64(0);
        let (n_observation, n_action) = (state.n_observation, state.n_action);
        let mut policy = Self::new(n_observation, n_action, &params, &mut nothing_random)?;
        policy.set_parameters(&state.parameters)?;
        check_size("shift", state.shift.len(), n_observation)?;
        check_size("scale", state.scale.len(), n_observation)?;
        check_finite("shift", &state.shift)?;
        for scale in state.scale.iter().copied().map(f64::from) {
            check_range("scale", scale, scale > 0.0, "a finite number above 0")?;
        }
        policy.shift = state.shift;
        policy.scale = state.scale;
        Ok(policy)
    }
}

impl From<GaussianPolicy> for GaussianState {
    fn from(policy: GaussianPolicy) -> Self {
        Self {
            n_observation: policy.n_observation(),
            n_action: policy.n_action(),
            hidden: policy.network.architecture().hidden.clone(),
            log_std_min: policy.log_std_min,
            parameters: policy.parameters(),
            shift: policy.shift,
            scale: policy.scale,
        }
    }
}
