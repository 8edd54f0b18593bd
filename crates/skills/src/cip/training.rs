//! Learning π_c and I_c: episodes, updates, and evaluations that change neither.
//!
//! Thesis 3.3: after each episode as many updates as it had steps; every ten episodes ten rollouts of the policy as it
//! is. Randomness is drawn anew for each episode and each evaluation from the seed and its number, so that evaluating
//! more often changes nothing, and a run that was stopped goes on as if it never was.
//!
//! With demonstrations ([`Trainer::begin_shown`], thesis Chapter 4 for the skills of Chapter 3) the first episodes are the
//! robot's own plan, the object's motion with the noise of exploration: they count like any other, their steps are in the replay,
//! and after the last one π_c is cloned from them.

use std::path::Path;

use factotum_descriptions::TaskSpec;
use factotum_learning::bandit::BanditError;
use factotum_learning::checkpoint::{self, CheckpointError, Identity};
use factotum_learning::environment::{
    EpisodeError, evaluate_episode, explore_episode, shown_episode,
};
use factotum_learning::td3::{Policy, Td3, Td3Error};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::action::N_ACTION;
use super::ending::FailureKind;
use super::environment::{CipEnvironment, CipError, Mode, Phase, PhaseWatch, Summary};
use super::grasp_search::search_grasps;
use super::initiation::{GraspInitiation, InitiationError, KnownGrasp};
use super::observation::n_observation;
use super::rig::Rig;
use super::setting::CipSetting;

/// Steps of Adam in which π_c is cloned from what was shown.
const CLONING_STEPS: u64 = 2000;

/// What a stream of random numbers is for.
#[derive(Debug, Clone, Copy)]
enum Purpose {
    Grasps = 1,
    Episode = 2,
    Evaluation = 3,
    Judgement = 4,
}

/// A stream of a seed: its purpose in the upper, a number in the lower bits.
fn stream(seed: u64, purpose: Purpose, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((purpose as u64) << 48) | number);
    rng
}

/// Why training stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainingError<E: std::error::Error + 'static> {
    /// The environment.
    #[error(transparent)]
    Environment(#[from] CipError<E>),
    /// The learner: such as a number that is none.
    #[error("episode {episode}: {source}")]
    Learner {
        /// Training episodes that were whole before.
        episode: u64,
        /// What it says.
        source: Td3Error,
    },
    /// The learner's parameters.
    #[error(transparent)]
    Parameters(#[from] Td3Error),
    /// Nothing can be grasped.
    #[error(
        "no grasp of task `{task}` survived: {n_points} points of its grasp region were seen and {n_generated} grasps \
         generated, but none could be reached, held and shaken; move `placement`, or check `grasp_region` and that the \
         region is narrower than the gripper's {aperture_m:.3} m"
    )]
    NoGrasp {
        /// The task.
        task: String,
        /// Points of its cloud.
        n_points: usize,
        /// Grasps from them.
        n_generated: usize,
        /// What the gripper opens to.
        aperture_m: f64,
    },
    /// I_c.
    #[error(transparent)]
    Initiation(#[from] InitiationError),
    /// A checkpoint.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// What a checkpoint says of grasps and progress cannot be read.
    #[error("`{path}`: its notes are not of this program: {reason}")]
    Notes {
        /// The file.
        path: String,
        /// What stands against them.
        reason: String,
    },
}

/// A training episode, as in `metrics.jsonl`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRecord {
    /// Number, from 1.
    pub episode: u64,
    /// Steps of the policy until its end, of all episodes.
    pub env_steps: u64,
    /// Whether it ended in β_c.
    pub success: bool,
    /// Whether a joint came within 5 degrees of its limit.
    pub violation: bool,
    /// Steps of this episode.
    pub steps: u32,
    /// Largest contact force on a finger, N.
    pub peak_force_n: f64,
    /// Grasp it began from.
    pub grasp: Option<usize>,
    /// What B said.
    pub failure: Option<FailureKind>,
}

/// An evaluation, as in `metrics.jsonl`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EvaluationRecord {
    /// Training episodes before it.
    pub episode: u64,
    /// Training steps before it.
    pub env_steps: u64,
    /// Rollouts.
    pub rollouts: u32,
    /// Share of rollouts that ended in β_c.
    pub success_rate: f64,
    /// Share in which a joint came within 5 degrees of its limit.
    pub violation_rate: f64,
    /// Median over the rollouts of the largest contact force on a finger, N.
    pub peak_force_n: f64,
    /// Median time of the rollouts that succeeded, seconds.
    pub time_to_success_secs: Option<f64>,
}

/// How far a run is, beside its learner: the notes of a checkpoint.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// Training episodes that are whole.
    pub n_episodes: u64,
    /// Steps in them.
    pub n_env_steps: u64,
    /// Those of them with a violation.
    pub n_violations: u64,
    /// I_c.
    pub grasps: Vec<KnownGrasp>,
}

/// A run of learning.
#[derive(Debug)]
pub struct Trainer<R> {
    environment: CipEnvironment<R>,
    learner: Td3,
    identity: Identity,
    seed: u64,
    n_shown: u64,
    progress: Progress,
}

impl<R: Rig> Trainer<R> {
    /// A run from the beginning: grasps are searched if the setting has a head, and `each` is told of every one.
    ///
    /// # Errors
    /// [`TrainingError`], such as for a task without a grasp that survives.
    pub fn new(
        rig: R,
        task: &TaskSpec,
        setting: CipSetting,
        seed: u64,
        each: &mut dyn FnMut(usize, bool),
    ) -> Result<Self, TrainingError<R::Error>> {
        let identity = identity(&rig, task);
        let learner = Td3::new(
            identity.n_observation,
            identity.n_action,
            setting.td3.clone(),
            seed,
        )?;
        let mut environment = CipEnvironment::new(rig, task, setting, None)?;
        if environment.setting().head {
            let mut rng = stream(seed, Purpose::Grasps, 0);
            let found = search_grasps(&mut environment, &task.placement, &mut rng, each)?;
            if found.grasps.is_empty() {
                return Err(TrainingError::NoGrasp {
                    task: task.name.clone(),
                    n_points: found.n_points,
                    n_generated: found.n_generated,
                    aperture_m: environment.rig().anatomy().aperture_max_m,
                });
            }
            let bandit = environment.setting().bandit;
            environment.set_initiation(GraspInitiation::new(&found.grasps, bandit)?);
        }
        Ok(Self {
            environment,
            learner,
            identity,
            seed,
            n_shown: 0,
            progress: Progress::default(),
        })
    }

    /// A run that goes on from a checkpoint of [`Self::save`].
    ///
    /// # Errors
    /// [`TrainingError`] if the checkpoint cannot be read, or is of another task or robot.
    pub fn resume(
        rig: R,
        task: &TaskSpec,
        setting: CipSetting,
        seed: u64,
        checkpoint: &Path,
    ) -> Result<Self, TrainingError<R::Error>> {
        let identity = identity(&rig, task);
        let (learner, notes) = checkpoint::load(checkpoint, &identity)?;
        let progress: Progress =
            serde_json::from_str(&notes).map_err(|error| TrainingError::Notes {
                path: checkpoint.display().to_string(),
                reason: error.to_string(),
            })?;
        let initiation = (!progress.grasps.is_empty())
            .then(|| GraspInitiation::new(&progress.grasps, setting.bandit))
            .transpose()?;
        Ok(Self {
            environment: CipEnvironment::new(rig, task, setting, initiation)?,
            learner,
            identity,
            seed,
            n_shown: 0,
            progress,
        })
    }

    /// Makes the first `n` episodes of the run the robot's own plan.
    pub fn begin_shown(&mut self, n: u64) {
        self.n_shown = n;
    }

    /// Tells `watch` of every phase from now on.
    pub fn set_watch(&mut self, watch: PhaseWatch) {
        self.environment.set_watch(watch);
    }

    /// What it learns on.
    pub fn environment(&self) -> &CipEnvironment<R> {
        &self.environment
    }

    /// How far it is.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// For what it learns.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// What it learned on, and the policy as it is now.
    pub fn into_parts(self) -> (CipEnvironment<R>, Policy) {
        let policy = self.policy();
        (self.environment, policy)
    }

    /// The policy as it is now.
    pub fn policy(&self) -> Policy {
        self.learner.policy()
    }

    /// Whether an evaluation is due.
    pub fn is_evaluation_due(&self) -> bool {
        let every = u64::from(self.environment.setting().evaluate_every.max(1));
        self.progress.n_episodes.is_multiple_of(every)
    }

    /// One episode to learn from, and the updates it has earned.
    ///
    /// # Errors
    /// [`TrainingError`]; the learner is then as after its last good step.
    pub fn episode(&mut self) -> Result<EpisodeRecord, TrainingError<R::Error>> {
        let episode = self.progress.n_episodes + 1;
        let mut rng = stream(self.seed, Purpose::Episode, episode);
        self.environment.set_mode(Mode::Learn);
        let (learner, environment) = (&mut self.learner, &mut self.environment);
        let explored = if episode <= self.n_shown {
            let show = |environment: &CipEnvironment<R>, action: &mut [f32]| {
                action.copy_from_slice(&environment.planned_action());
            };
            shown_episode(learner, environment, &mut rng, show)
        } else {
            explore_episode(learner, environment, &mut rng)
        };
        explored.map_err(|error| stopped(episode, error))?;
        self.environment.enter(Phase::Updates);
        let updated = self.learner.update_owed().and_then(|_last| {
            if episode == self.n_shown {
                self.learner.clone_recorded(CLONING_STEPS)?;
            }
            Ok(())
        });
        updated.map_err(|source| TrainingError::Learner { episode, source })?;
        let summary = self.environment.summary();
        self.progress.n_episodes = episode;
        self.progress.n_env_steps += u64::from(summary.n_steps);
        self.progress.n_violations += u64::from(summary.violation);
        Ok(EpisodeRecord {
            episode,
            env_steps: self.progress.n_env_steps,
            success: summary.success,
            violation: summary.violation,
            steps: summary.n_steps,
            peak_force_n: summary.peak_force_n,
            grasp: summary.grasp,
            failure: summary.failure,
        })
    }

    /// Rollouts of the policy as it is; neither it nor I_c learns from them.
    ///
    /// # Errors
    /// [`TrainingError`] of the rig.
    pub fn evaluate(&mut self) -> Result<EvaluationRecord, TrainingError<R::Error>> {
        self.environment.enter(Phase::Evaluation);
        let n = self.environment.setting().evaluation_rollouts;
        let mut rng = stream(self.seed, Purpose::Evaluation, self.progress.n_episodes);
        let mut policy = self.learner.policy();
        let summaries = roll_out(&mut self.environment, &mut policy, n, &mut rng)?;
        Ok(evaluation(&self.progress, &summaries))
    }

    /// Stores all that is needed to go on.
    ///
    /// # Errors
    /// [`TrainingError::Checkpoint`] if the file cannot be written; an older one stays then.
    pub fn save(&mut self, checkpoint: &Path) -> Result<(), TrainingError<R::Error>> {
        if let Some(initiation) = self.environment.initiation() {
            self.progress.grasps = initiation.grasps();
        }
        let notes = serde_json::to_string(&self.progress).unwrap_or_default();
        Ok(checkpoint::save(
            checkpoint,
            &self.learner,
            &self.identity,
            &notes,
        )?)
    }
}

/// Rollouts of a finished policy on fresh random numbers of a seed.
///
/// # Errors
/// [`TrainingError`] of the rig.
pub fn judge<R: Rig>(
    environment: &mut CipEnvironment<R>,
    policy: &mut Policy,
    rollouts: u32,
    seed: u64,
) -> Result<(EvaluationRecord, Vec<Summary>), TrainingError<R::Error>> {
    let mut rng = stream(seed, Purpose::Judgement, 0);
    let summaries = roll_out(environment, policy, rollouts, &mut rng)?;
    Ok((evaluation(&Progress::default(), &summaries), summaries))
}

/// For what a rig and a task train.
pub fn identity<R: Rig>(rig: &R, task: &TaskSpec) -> Identity {
    let anatomy = rig.anatomy();
    Identity {
        task: task.name.clone(),
        robot: anatomy.robot.description().name.clone(),
        n_observation: n_observation(anatomy),
        n_action: N_ACTION,
    }
}

fn roll_out<R: Rig>(
    environment: &mut CipEnvironment<R>,
    policy: &mut Policy,
    rollouts: u32,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Summary>, TrainingError<R::Error>> {
    environment.set_mode(Mode::Evaluate);
    let mut summaries: Vec<Summary> = Vec::new();
    for rollout in 0..rollouts {
        match evaluate_episode(policy, environment, rng) {
            Ok(_) => summaries.push(environment.summary()),
            // Where nothing can be taken hold of at all, the task is wrong; now and then, it is the skill that failed.
            Err(EpisodeError::Environment(CipError::NoGrasp { .. }))
                if rollout + 1 < rollouts
                    || summaries.iter().any(|summary| summary.n_steps > 0) =>
            {
                summaries.push(Summary {
                    failure: Some(FailureKind::NoGrasp),
                    ..Summary::default()
                });
            }
            Err(error) => return Err(stopped(0, error)),
        }
    }
    Ok(summaries)
}

fn stopped<E: std::error::Error + 'static>(
    episode: u64,
    error: EpisodeError<CipError<E>>,
) -> TrainingError<E> {
    match error {
        EpisodeError::Environment(error) => TrainingError::Environment(error),
        EpisodeError::Learner(source) => TrainingError::Learner { episode, source },
    }
}

fn evaluation(progress: &Progress, summaries: &[Summary]) -> EvaluationRecord {
    let n = summaries.len().max(1) as f64;
    let share =
        |holds: fn(&Summary) -> bool| summaries.iter().filter(|s| holds(s)).count() as f64 / n;
    let times = summaries
        .iter()
        .filter(|summary| summary.success)
        .map(|summary| summary.secs);
    let begun = summaries.iter().filter(|summary| summary.n_steps > 0);
    let forces = begun.map(|summary| summary.peak_force_n);
    EvaluationRecord {
        episode: progress.n_episodes,
        env_steps: progress.n_env_steps,
        rollouts: u32::try_from(summaries.len()).unwrap_or(u32::MAX),
        success_rate: share(|summary| summary.success),
        violation_rate: share(|summary| summary.violation),
        peak_force_n: median(forces.collect()).unwrap_or(0.0),
        time_to_success_secs: median(times.collect()),
    }
}

/// The middle of some values, or the mean of the two in the middle.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let upper = *values.get(n / 2)?;
    let lower = *values.get((n.max(1) - 1) / 2)?;
    Some(0.5 * (lower + upper))
}

impl<E: std::error::Error + 'static> From<BanditError> for TrainingError<E> {
    fn from(error: BanditError) -> Self {
        Self::Initiation(InitiationError::Bandit(error))
    }
}
