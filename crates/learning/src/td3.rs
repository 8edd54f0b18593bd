//! TD3: a deterministic policy and two critics, learned from a ring of transitions.
//!
//! ```text
//! a'  = clip(π'(s') + clip(N(0, σ'), -c, c), -1, 1)                 target policy smoothing
//! y   = r + γ goes_on min(Q'_1(s', a'), Q'_2(s', a'))               clipped double Q-learning
//! Q_i   descends on mean (Q_i(s, a) - y)²
//! π     ascends on mean Q_1(s, π(s)), every d-th update             delayed policy update
//! θ' <- θ' + τ (θ - θ'), with it                                    targets
//! ```
//!
//! Fujimoto, van Hoof & Meger, "Addressing Function Approximation Error in Actor-Critic Methods", ICML 2018, arXiv
//! 1802.09477, algorithm 1. Actions are within -1..=1; [`crate::action`] carries them to an environment's bounds.
//! What the dissertation's text and its code say of each number stands at [`Td3Params`].
//!
//! Where we differ: updates are owed by steps ([`Td3Params::updates_per_step`]) and made when the caller asks, such as
//! after an episode; steps of the warm-up owe none.
//!
//! The same seed and the same calls give the same bytes on one machine, and a learner that was stored and loaded
//! ([`crate::checkpoint`]) goes on as if it had never stopped.

mod error;
mod params;
mod policy;

pub use error::Td3Error;
pub use params::{ParamsError, Td3Params};
pub use policy::Policy;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::adam::Adam;
use crate::elementwise::{all_finite, blend};
use crate::mlp::{Activation, Architecture, Mlp, Pass};
use crate::panels::{Lanes, Panels, WIDTH, ZERO};
use crate::replay::{Batch, Replay, Transition, write_columns};
use error::{check_finite, check_observation, check_size};

/// Streams of random numbers, by purpose.
const INITIALISE: u64 = 0;
const EXPLORE: u64 = 1;
const UPDATE: u64 = 2;

/// Policy, critics, what they learn from, and how far they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Td3 {
    pub(crate) params: Td3Params,
    pub(crate) n_observation: usize,
    pub(crate) n_action: usize,
    pub(crate) policy: Learned,
    /// The twin critics, as two members of one network.
    pub(crate) critics: Learned,
    pub(crate) replay: Replay,
    pub(crate) counters: Counters,
    pub(crate) exploring: ChaCha8Rng,
    pub(crate) updating: ChaCha8Rng,
    memory: Memory,
}

/// A network with its target and its optimiser.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Learned {
    pub(crate) network: Mlp,
    pub(crate) target: Mlp,
    pub(crate) adam: Adam,
    pass: Pass,
    gradient: Vec<Lanes>,
}

/// How far a learner is.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counters {
    /// Transitions recorded.
    pub n_env_steps: u64,
    /// Updates of the critics.
    pub n_updates: u64,
    /// Updates that recorded steps have earned and that were not made yet.
    pub n_updates_owed: f64,
}

/// What an update found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Update {
    /// Mean squared error of both critics, summed.
    pub critic_loss: f32,
    /// Mean value of the batch by the first critic.
    pub mean_value: f32,
}

/// Memory that an update works in.
#[derive(Debug, Clone, PartialEq)]
struct Memory {
    batch: Batch,
    /// y.
    targets: Vec<f32>,
    /// A policy's pass for one observation.
    single: Pass,
}

impl Learned {
    fn new(network: Mlp, params: &Td3Params) -> Self {
        let n_lanes = network.parameters().len();
        Self {
            target: network.clone(),
            adam: Adam::new(n_lanes, params.learning_rate),
            pass: Pass::new(network.architecture(), params.batch_size),
            gradient: vec![ZERO; n_lanes],
            network,
        }
    }

    fn step(&mut self) {
        let parameters = self.network.parameters_mut();
        self.adam.step(parameters, &self.gradient);
    }

    fn move_target(&mut self, share: f32) {
        blend(
            self.target.parameters_mut(),
            self.network.parameters(),
            share,
        );
    }
}

impl Td3 {
    /// A learner that knows nothing yet.
    ///
    /// # Errors
    ///
    /// When a parameter is out of its range, or a size is zero.
    pub fn new(
        n_observation: usize,
        n_action: usize,
        params: Td3Params,
        seed: u64,
    ) -> Result<Self, Td3Error> {
        params.check()?;
        let stream = |purpose| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(purpose);
            rng
        };
        let mut rng = stream(INITIALISE);
        let policy = params.policy_architecture(n_observation, n_action);
        let mut policy = Mlp::new(policy, &mut rng)?;
        policy.scale_output(params.policy_output_scale);
        let first_action = &params.policy_first_action;
        if !first_action.is_empty() {
            check_size("first action of the policy", first_action.len(), n_action)?;
            let biases: Vec<f32> = first_action.iter().map(|value| value.atanh()).collect();
            policy.shift_output(&biases);
        }
        let critics = Architecture {
            n_inputs: n_observation + n_action,
            hidden: params.hidden.clone(),
            n_outputs: 1,
            hidden_activation: params.hidden_activation,
            output_activation: Activation::Linear,
            layer_norm: params.critic_layer_norm,
            n_members: 2,
        };
        let critics = Mlp::new(critics, &mut rng)?;
        let capacity = params.replay_capacity;
        let replay = Replay::new(n_observation, n_action, capacity);
        // That there is no memory is all the reason there is.
        let replay = replay.map_err(|_no_memory| Td3Error::Memory { capacity })?;
        Ok(Self {
            n_observation,
            n_action,
            memory: Memory {
                batch: Batch::new(n_observation, n_action, params.batch_size),
                targets: vec![0.0; params.batch_size],
                single: Pass::new(policy.architecture(), 1),
            },
            policy: Learned::new(policy, &params),
            critics: Learned::new(critics, &params),
            replay,
            counters: Counters::default(),
            exploring: stream(EXPLORE),
            updating: stream(UPDATE),
            params,
        })
    }

    /// What it was made with.
    #[must_use]
    pub fn params(&self) -> &Td3Params {
        &self.params
    }

    /// How far it is.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// What it has lived through.
    #[must_use]
    pub fn replay(&self) -> &Replay {
        &self.replay
    }

    /// The policy as it is now, to evaluate or to keep; using it changes nothing here.
    #[must_use]
    pub fn policy(&self) -> Policy {
        Policy::of(self.policy.network.clone())
    }

    /// An action to explore with: of the policy with noise, or any at all during the warm-up.
    ///
    /// # Errors
    ///
    /// When a slice has another size than the learner was made for, or a number is not finite.
    pub fn explore_into(
        &mut self,
        observation: &[f32],
        action: &mut [f32],
    ) -> Result<(), Td3Error> {
        self.check_sizes(observation, action)?;
        check_observation(observation)?;
        if self.counters.n_env_steps < self.params.warmup_steps {
            action.fill_with(|| self.exploring.random_range(-1.0..=1.0));
            return Ok(());
        }
        self.policy
            .network
            .evaluate_into(observation, &mut self.memory.single, action);
        self.explore_about(action);
        Ok(())
    }

    /// Adds the noise of exploration to an action.
    pub fn explore_about(&mut self, action: &mut [f32]) {
        let deviation = self.params.exploration_noise as f32;
        for component in action {
            let noise: f32 = self.exploring.sample(StandardNormal);
            *component = (*component + deviation * noise).clamp(-1.0, 1.0);
        }
    }

    /// Keeps a step of the environment to learn from.
    ///
    /// # Errors
    ///
    /// When a slice has another size, or a number is NaN or infinite; nothing is kept then.
    pub fn record(&mut self, transition: &Transition<'_>) -> Result<(), Td3Error> {
        self.record_of_another(transition)?;
        self.counters.n_env_steps += 1;
        if self.counters.n_env_steps > self.params.warmup_steps {
            self.counters.n_updates_owed += self.params.updates_per_step;
        }
        Ok(())
    }

    /// Keeps a step that was not this learner's own, such as of a demonstration: it counts as no step of the
    /// environment and earns no updates.
    ///
    /// # Errors
    ///
    /// As [`Self::record`].
    pub fn record_of_another(&mut self, transition: &Transition<'_>) -> Result<(), Td3Error> {
        self.check_sizes(transition.observation, transition.action)?;
        self.check_sizes(transition.next_observation, transition.action)?;
        let step = self.counters.n_env_steps + 1;
        check_finite("observation", transition.observation, step)?;
        check_finite("action", transition.action, step)?;
        check_finite("reward", &[transition.reward], step)?;
        check_finite("next observation", transition.next_observation, step)?;
        self.replay.push(transition);
        Ok(())
    }

    /// Makes the whole updates that recorded steps have earned; the last one's findings, if there was one.
    ///
    /// # Errors
    ///
    /// As [`Self::update`].
    pub fn update_owed(&mut self) -> Result<Option<Update>, Td3Error> {
        let mut last = None;
        while self.counters.n_updates_owed >= 1.0 {
            last = Some(self.update()?);
            self.counters.n_updates_owed -= 1.0;
        }
        Ok(last)
    }

    /// One update of the critics and, when its turn has come, of the policy and the targets.
    ///
    /// # Errors
    ///
    /// When nothing was recorded yet. When a loss or a derivative is NaN or infinite: the step it would have led to
    /// is not taken, so every weight and moment stays finite, as it was after the last good step.
    pub fn update(&mut self) -> Result<Update, Td3Error> {
        if self.replay.is_empty() {
            return Err(Td3Error::NothingRecorded);
        }
        let update = self.counters.n_updates + 1;
        self.replay
            .sample_into(&mut self.updating, &mut self.memory.batch);
        self.find_targets();
        let found = self.update_critics(update)?;
        if update.is_multiple_of(u64::from(self.params.policy_delay)) {
            self.update_policy(update)?;
            let share = self.params.target_share as f32;
            self.critics.move_target(share);
            self.policy.move_target(share);
        }
        self.counters.n_updates = update;
        Ok(found)
    }

    /// Makes the policy, and its target, do what was done in all that was recorded, by so many steps of Adam on the mean squared
    /// difference; the last one's difference.
    ///
    /// # Errors
    ///
    /// When nothing was recorded yet, or a derivative is NaN or infinite; the policy is then as after the last good step.
    pub fn clone_recorded(&mut self, n_steps: u64) -> Result<f32, Td3Error> {
        if self.replay.is_empty() {
            return Err(Td3Error::NothingRecorded);
        }
        let (n_observation, n_action) = (self.n_observation, self.n_action);
        let mut difference = 0.0;
        for step in 1..=n_steps {
            let batch = &mut self.memory.batch;
            self.replay.sample_into(&mut self.updating, batch);
            let n_rows = batch.rewards.len();
            let Learned {
                network,
                pass,
                gradient,
                ..
            } = &mut self.policy;
            let observations = Panels::new(&batch.inputs, n_rows, n_observation);
            network.forward(observations, 1, pass);
            let lane = |column: usize, row| (column / WIDTH * n_rows + row, column % WIDTH);
            let n_values = (n_rows * n_action) as f32;
            let done = pass.output(0).to_vec();
            difference = 0.0;
            let inputs = &batch.inputs;
            let delta = pass.output_delta_mut(0);
            write_columns(delta, n_rows, 0, n_action, |row, column| {
                let (at, of) = lane(column, row);
                let (shown_at, shown_of) = lane(n_observation + column, row);
                let off = done[at][of] - inputs[shown_at][shown_of];
                difference += off * off / n_values;
                2.0 * off / n_values
            });
            network.backward(observations, pass, gradient);
            if !all_finite(gradient) {
                return Err(Td3Error::NotFinite {
                    what: "derivative of the policy's difference",
                    at: step,
                });
            }
            self.policy.step();
        }
        let learned = self.policy.network.parameters();
        self.policy.target.parameters_mut().copy_from_slice(learned);
        Ok(difference)
    }

    /// y of the batch.
    fn find_targets(&mut self) {
        let Memory { batch, targets, .. } = &mut self.memory;
        let (n_rows, n_observation) = (targets.len(), self.n_observation);
        let deviation = self.params.target_noise as f32;
        let clip = self.params.target_noise_clip as f32;
        let pass = &mut self.policy.pass;
        let observations = Panels::new(&batch.next_inputs, n_rows, n_observation);
        self.policy.target.forward(observations, 1, pass);
        let rng = &mut self.updating;
        write_columns(
            &mut batch.next_inputs,
            n_rows,
            n_observation,
            self.n_action,
            |row, column| {
                let noise: f32 = rng.sample(StandardNormal);
                let noise = (deviation * noise).clamp(-clip, clip);
                let action = pass.output(0)[column / WIDTH * n_rows + row][column % WIDTH];
                (action + noise).clamp(-1.0, 1.0)
            },
        );
        let pass = &mut self.critics.pass;
        let inputs = Panels::new(&batch.next_inputs, n_rows, n_observation + self.n_action);
        self.critics.target.forward(inputs, 2, pass);
        let discount = self.params.discount as f32;
        let values = pass.output(0).iter().zip(pass.output(1));
        let rewards = batch.rewards.iter().zip(&batch.goes_on);
        for ((target, (first, second)), (reward, goes_on)) in
            targets.iter_mut().zip(values).zip(rewards)
        {
            *target = reward + discount * goes_on * first[0].min(second[0]);
        }
    }

    fn update_critics(&mut self, update: u64) -> Result<Update, Td3Error> {
        let Memory { batch, targets, .. } = &self.memory;
        let Learned {
            network,
            pass,
            gradient,
            ..
        } = &mut self.critics;
        let n_rows = targets.len();
        let inputs = Panels::new(&batch.inputs, n_rows, self.n_observation + self.n_action);
        network.forward(inputs, 2, pass);
        let share = 1.0 / n_rows as f32;
        let mean_value = share * pass.output(0).iter().map(|value| value[0]).sum::<f32>();
        let mut critic_loss = 0.0;
        for member in 0..2 {
            for (row, target) in targets.iter().enumerate() {
                let error = pass.output(member)[row][0] - target;
                pass.output_delta_mut(member)[row][0] = 2.0 * share * error;
                critic_loss += share * error * error;
            }
        }
        check_finite("loss of the critics", &[critic_loss], update)?;
        network.backward(inputs, pass, gradient);
        if !all_finite(gradient) {
            return Err(Td3Error::NotFinite {
                what: "derivative of the critics' loss",
                at: update,
            });
        }
        self.critics.step();
        Ok(Update {
            critic_loss,
            mean_value,
        })
    }

    fn update_policy(&mut self, update: u64) -> Result<(), Td3Error> {
        let (n_observation, n_action) = (self.n_observation, self.n_action);
        let batch = &mut self.memory.batch;
        let n_rows = batch.rewards.len();
        let Learned {
            network,
            pass,
            gradient,
            ..
        } = &mut self.policy;
        let observations = Panels::new(&batch.inputs, n_rows, n_observation);
        network.forward(observations, 1, pass);
        let lane = |column: usize, row| (column / WIDTH * n_rows + row, column % WIDTH);
        write_columns(
            &mut batch.inputs,
            n_rows,
            n_observation,
            n_action,
            |row, column| {
                let (at, lane) = lane(column, row);
                pass.output(0)[at][lane]
            },
        );
        let inputs = Panels::new(&batch.inputs, n_rows, n_observation + n_action);
        let critic = &mut self.critics.pass;
        self.critics.network.forward(inputs, 1, critic);
        for delta in critic.output_delta_mut(0) {
            delta[0] = -1.0 / n_rows as f32;
        }
        let first_panel = n_observation / WIDTH;
        let by_input = self.critics.network.backward_to_input(critic, first_panel);
        let first_lane = n_observation % WIDTH;
        write_columns(
            pass.output_delta_mut(0),
            n_rows,
            0,
            n_action,
            |row, column| {
                let (at, lane) = lane(first_lane + column, row);
                by_input[at][lane]
            },
        );
        let observations = Panels::new(&batch.inputs, n_rows, n_observation);
        network.backward(observations, pass, gradient);
        if !all_finite(gradient) {
            return Err(Td3Error::NotFinite {
                what: "derivative of the policy's value",
                at: update,
            });
        }
        self.policy.step();
        Ok(())
    }

    fn check_sizes(&self, observation: &[f32], action: &[f32]) -> Result<(), Td3Error> {
        check_size("observation", observation.len(), self.n_observation)?;
        check_size("action", action.len(), self.n_action)
    }
}

#[cfg(test)]
mod tests;
