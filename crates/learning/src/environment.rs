//! What is acted on, and the loop of acting and learning.
//!
//! The dissertation's loop (section 3.3): an episode is lived through to its end, then the learner makes the updates
//! that its steps have earned; now and then a policy is evaluated, which changes nothing.

use rand_chacha::ChaCha8Rng;

use crate::replay::{Ending, Transition};
use crate::td3::{Policy, Td3, Td3Error, Update};

/// What an action led to, beside the next observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// What it earned.
    pub reward: f32,
    /// Whether the episode is over.
    pub ending: Ending,
}

/// Something that takes actions and can be begun again. Actions are within -1..=1.
pub trait Environment {
    /// Why it can go wrong.
    type Error;

    /// Components of an observation.
    fn n_observation(&self) -> usize;

    /// Components of an action.
    fn n_action(&self) -> usize;

    /// Begins an episode and writes the first observation.
    ///
    /// # Errors
    ///
    /// When no episode can be begun.
    fn reset_into(
        &mut self,
        rng: &mut ChaCha8Rng,
        observation: &mut [f32],
    ) -> Result<(), Self::Error>;

    /// Does an action and writes what is observed after it. Every episode ends at some step.
    ///
    /// # Errors
    ///
    /// When the action cannot be done.
    fn step_into(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Step, Self::Error>;
}

/// How an episode went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Episode {
    /// Steps it took.
    pub n_steps: u64,
    /// Sum of the rewards.
    pub total_reward: f64,
    /// How it ended.
    pub ending: Ending,
    /// The last update after it, if it was one to learn from.
    pub last_update: Option<Update>,
}

/// What stopped an episode.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EpisodeError<E> {
    /// The environment.
    #[error(transparent)]
    Environment(E),
    /// The learner or the policy.
    #[error(transparent)]
    Learner(#[from] Td3Error),
}

/// Explores for an episode, then makes the updates it has earned.
///
/// # Errors
///
/// What the environment or the learner says; what was recorded until then stays.
pub fn train_episode<E: Environment>(
    learner: &mut Td3,
    environment: &mut E,
    rng: &mut ChaCha8Rng,
) -> Result<Episode, EpisodeError<E::Error>> {
    let mut episode = explore_episode(learner, environment, rng)?;
    episode.last_update = learner.update_owed()?;
    Ok(episode)
}

/// Explores for an episode; the updates it has earned are owed.
///
/// # Errors
///
/// As [`train_episode`].
pub fn explore_episode<E: Environment>(
    learner: &mut Td3,
    environment: &mut E,
    rng: &mut ChaCha8Rng,
) -> Result<Episode, EpisodeError<E::Error>> {
    run_episode(
        environment,
        rng,
        learner,
        |learner, _, observation, action| learner.explore_into(observation, action),
        Td3::record,
    )
}

/// Does for an episode what `show` says, with the learner's noise of exploration; it counts as one of the learner's own.
///
/// # Errors
///
/// As [`train_episode`].
pub fn shown_episode<E: Environment>(
    learner: &mut Td3,
    environment: &mut E,
    rng: &mut ChaCha8Rng,
    show: impl Fn(&E, &mut [f32]),
) -> Result<Episode, EpisodeError<E::Error>> {
    run_episode(
        environment,
        rng,
        learner,
        |learner, environment, _, action| {
            show(environment, action);
            learner.explore_about(action);
            Ok(())
        },
        Td3::record,
    )
}

/// Follows a policy for an episode.
///
/// # Errors
///
/// What the environment or the policy says.
pub fn evaluate_episode<E: Environment>(
    policy: &mut Policy,
    environment: &mut E,
    rng: &mut ChaCha8Rng,
) -> Result<Episode, EpisodeError<E::Error>> {
    run_episode(
        environment,
        rng,
        policy,
        |policy, _, observation, action| policy.act_into(observation, action),
        |_, _| Ok(()),
    )
}

fn run_episode<E: Environment, A>(
    environment: &mut E,
    rng: &mut ChaCha8Rng,
    actor: &mut A,
    act: impl Fn(&mut A, &E, &[f32], &mut [f32]) -> Result<(), Td3Error>,
    record: impl Fn(&mut A, &Transition<'_>) -> Result<(), Td3Error>,
) -> Result<Episode, EpisodeError<E::Error>> {
    let mut observation = vec![0.0; environment.n_observation()];
    let mut next_observation = observation.clone();
    let mut action = vec![0.0; environment.n_action()];
    let mut episode = Episode {
        n_steps: 0,
        total_reward: 0.0,
        ending: Ending::Goes,
        last_update: None,
    };
    environment
        .reset_into(rng, &mut observation)
        .map_err(EpisodeError::Environment)?;
    while !episode.ending.is_over() {
        act(actor, environment, &observation, &mut action)?;
        let step = environment
            .step_into(&action, &mut next_observation)
            .map_err(EpisodeError::Environment)?;
        let transition = Transition {
            observation: &observation,
            action: &action,
            reward: step.reward,
            next_observation: &next_observation,
            ending: step.ending,
        };
        record(actor, &transition)?;
        std::mem::swap(&mut observation, &mut next_observation);
        episode.n_steps += 1;
        episode.total_reward += f64::from(step.reward);
        episode.ending = step.ending;
    }
    Ok(episode)
}
