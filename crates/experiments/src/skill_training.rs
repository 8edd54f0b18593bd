//! Training a skill into its folder, from the beginning or from where it stopped, and judging it.

use std::sync::atomic::{AtomicBool, Ordering};

use factotum_descriptions::TaskSpec;
use factotum_learning::checkpoint::{self, CheckpointError, Identity};
use factotum_learning::td3::Policy;
use factotum_skills::cip::environment::{CipEnvironment, CipError, PhaseWatch, Summary};
use factotum_skills::cip::initiation::GraspInitiation;
use factotum_skills::cip::perturbation::Perturbation;
use factotum_skills::cip::rig::{Rig as _, Watched};
use factotum_skills::cip::setting::CipSetting;
use factotum_skills::cip::training::{
    EpisodeRecord, EvaluationRecord, Trainer, TrainingError, identity, judge,
};
use factotum_skills::cip::{Primitive, PrimitiveError};
use factotum_worlds::{RigError, TaskRig};

use crate::skill_folder::{SkillFolder, SkillFolderError, SkillRecord};
use crate::storage::StorageError;

/// Why a skill could not be trained or judged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SkillError {
    /// The folder.
    #[error(transparent)]
    Folder(#[from] SkillFolderError),
    /// The rig.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The training.
    #[error(transparent)]
    Training(#[from] TrainingError<RigError>),
    /// The policy's file.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// It cannot be used elsewhere.
    #[error(transparent)]
    Primitive(#[from] PrimitiveError),
}

impl SkillError {
    /// Whether it is the user's to mend: a task, a folder, a file.
    pub fn is_of_input(&self) -> bool {
        match self {
            Self::Folder(SkillFolderError::Storage(error)) => {
                matches!(error, StorageError::Read { .. })
            }
            Self::Folder(_) => true,
            Self::Rig(error) => error.is_of_input(),
            Self::Training(error) => matches!(
                error,
                TrainingError::NoGrasp { .. }
                    | TrainingError::Checkpoint(_)
                    | TrainingError::Notes { .. }
                    | TrainingError::Environment(CipError::NoGrasp { .. })
            ),
            Self::Checkpoint(_) | Self::Primitive(_) => true,
        }
    }
}

/// What happens while a skill is trained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrainingEvent {
    /// A grasp was checked, and kept or not.
    Grasp {
        /// Its number.
        index: usize,
        /// Whether it survived.
        kept: bool,
    },
    /// An episode is over.
    Episode(EpisodeRecord),
    /// An evaluation is over.
    Evaluation(EvaluationRecord),
}

/// How a training run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainingSummary {
    /// Training episodes.
    pub n_episodes: u64,
    /// Steps in them.
    pub n_env_steps: u64,
    /// Training episodes with a joint near its limit.
    pub n_violations: u64,
    /// Grasps in I_c.
    pub n_grasps: usize,
    /// Best success rate of an evaluation.
    pub best_success_rate: Option<f64>,
    /// The last evaluation.
    pub last: Option<EvaluationRecord>,
    /// Whether all episodes were lived through.
    pub complete: bool,
}

/// A skill to be trained.
#[derive(Debug, Clone, Copy)]
pub struct Training<'a> {
    /// Where it is kept.
    pub folder: &'a SkillFolder,
    /// The task.
    pub task: &'a TaskSpec,
    /// What it is trained with.
    pub record: &'a SkillRecord,
    /// Training episodes in all.
    pub n_episodes: u64,
    /// Whether to go on from the folder's checkpoint, if it has one; else the folder must not hold a run.
    pub resume: bool,
}

impl Training<'_> {
    /// Trains until all episodes are lived through, or `stop`; `tell` hears what happens, `watch` what time is spent on.
    ///
    /// # Errors
    /// [`SkillError`]; what was learned until the last evaluation stays in the folder.
    pub fn run(
        &self,
        stop: &AtomicBool,
        watch: PhaseWatch,
        tell: &mut dyn FnMut(TrainingEvent),
    ) -> Result<TrainingSummary, SkillError> {
        let (mut trainer, mut best) = self.begin(tell)?;
        trainer.set_watch(watch);
        let mut last = None;
        while trainer.progress().n_episodes < self.n_episodes && !stop.load(Ordering::Relaxed) {
            let episode = trainer.episode()?;
            self.folder.append(&episode)?;
            tell(TrainingEvent::Episode(episode));
            if trainer.is_evaluation_due() || episode.episode == self.n_episodes {
                let evaluation = trainer.evaluate()?;
                self.keep(&mut trainer, &evaluation, &mut best)?;
                last = Some(evaluation);
                tell(TrainingEvent::Evaluation(evaluation));
            }
        }
        let progress = trainer.progress();
        let initiation = trainer.environment().initiation();
        Ok(TrainingSummary {
            n_episodes: progress.n_episodes,
            n_env_steps: progress.n_env_steps,
            n_violations: progress.n_violations,
            n_grasps: initiation.map_or(0, GraspInitiation::len),
            best_success_rate: best,
            last,
            complete: progress.n_episodes >= self.n_episodes,
        })
    }

    /// A trainer at the beginning or where it stopped, and the best success rate so far.
    fn begin(
        &self,
        tell: &mut dyn FnMut(TrainingEvent),
    ) -> Result<(Trainer<TaskRig>, Option<f64>), SkillError> {
        let Self {
            folder,
            task,
            record,
            ..
        } = *self;
        let rig = TaskRig::new(task)?;
        let setting = record.setting.clone();
        if self.resume && folder.checkpoint().is_file() {
            let mut trainer =
                Trainer::resume(rig, task, setting, record.seed, &folder.checkpoint())?;
            trainer.begin_shown(record.shown);
            let best = folder.keep_metrics(trainer.progress().n_episodes)?;
            return Ok((trainer, best));
        }
        if !self.resume {
            folder.begin(record)?;
        }
        folder.keep_metrics(0)?;
        let each = &mut |index, kept| tell(TrainingEvent::Grasp { index, kept });
        let mut trainer = Trainer::new(rig, task, setting, record.seed, each)?;
        trainer.begin_shown(record.shown);
        Ok((trainer, None))
    }

    /// Keeps an evaluation, all that is needed to go on from it, and the policy if none was better.
    fn keep(
        &self,
        trainer: &mut Trainer<TaskRig>,
        evaluation: &EvaluationRecord,
        best: &mut Option<f64>,
    ) -> Result<(), SkillError> {
        let folder = self.folder;
        folder.append(evaluation)?;
        if best.is_none_or(|best| evaluation.success_rate >= best) {
            *best = Some(evaluation.success_rate);
            checkpoint::save_policy(&folder.policy(), &trainer.policy(), trainer.identity(), "")?;
            let initiation = trainer.environment().initiation();
            folder.write_grasps(&initiation.map(GraspInitiation::grasps).unwrap_or_default())?;
        }
        // Last: a run that is killed before this lives through the same episodes again, to the same policy.
        trainer.save(&folder.checkpoint())?;
        Ok(())
    }
}

/// Which policy of a folder is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhichPolicy {
    /// That of the best evaluation.
    Best,
    /// That of the last checkpoint.
    Last,
}

impl WhichPolicy {
    /// Its name in commands.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Best => "best",
            Self::Last => "last",
        }
    }
}

/// A skill to be judged by rollouts that neither training nor its evaluations have seen.
#[derive(Debug, Clone, Copy)]
pub struct Judging<'a> {
    /// Where it is kept.
    pub folder: &'a SkillFolder,
    /// The task.
    pub task: &'a TaskSpec,
    /// What it was trained with.
    pub record: &'a SkillRecord,
    /// Which of its policies.
    pub which: WhichPolicy,
    /// What is otherwise than it was trained for.
    pub perturbation: Perturbation,
    /// Rollouts.
    pub rollouts: u32,
    /// Seed of the rollouts.
    pub seed: u64,
}

impl Judging<'_> {
    /// Judges it; `watch` sees the rig after every placing and every step.
    ///
    /// # Errors
    /// [`SkillError`], such as for a policy of another task or robot.
    pub fn run(
        &self,
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<(EvaluationRecord, Vec<Summary>), SkillError> {
        let Self {
            folder,
            task,
            record,
            which,
            perturbation,
            rollouts,
            seed,
        } = *self;
        let rig = Watched::new(TaskRig::perturbed(task, &perturbation)?, watch);
        let setting = record.setting.clone();
        let (mut environment, mut policy) = match which {
            WhichPolicy::Best => {
                let (policy, initiation) = best_of(folder, &identity(&rig, task), &setting)?;
                let environment = CipEnvironment::new(rig, task, setting, initiation)
                    .map_err(TrainingError::Environment)?;
                (environment, policy)
            }
            WhichPolicy::Last => {
                let checkpoint = folder.checkpoint();
                Trainer::resume(rig, task, setting, record.seed, &checkpoint)?.into_parts()
            }
        };
        environment.set_perturbation(perturbation);
        Ok(judge(&mut environment, &mut policy, rollouts, seed)?)
    }
}

/// The policy of a folder's best evaluation, and I_c if its setting has a head.
fn best_of(
    folder: &SkillFolder,
    identity: &Identity,
    setting: &CipSetting,
) -> Result<(Policy, Option<GraspInitiation>), SkillError> {
    let (policy, _) = checkpoint::load_policy(&folder.policy(), identity)?;
    let initiation = setting
        .head
        .then(|| GraspInitiation::read(&folder.grasps(), setting.bandit))
        .transpose()
        .map_err(TrainingError::Initiation)?;
    Ok((policy, initiation))
}

/// The skill of a folder as a primitive for any robot of its kind: the policy of the best evaluation, and I_c.
///
/// # Errors
/// [`SkillError`], such as for a policy of another task or robot, or a skill that was learned without a head.
pub fn primitive(
    folder: &SkillFolder,
    task: &TaskSpec,
    record: &SkillRecord,
) -> Result<Primitive, SkillError> {
    let rig = TaskRig::new(task)?;
    let setting = record.setting.clone();
    let (policy, initiation) = best_of(folder, &identity(&rig, task), &setting)?;
    let reading = rig.reading();
    let object_from_region = reading.base_from_object.inverse() * reading.region;
    let anatomy = rig.anatomy().clone();
    Ok(Primitive::new(
        task.clone(),
        anatomy,
        object_from_region,
        setting,
        policy,
        initiation,
    )?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_skill_is_whole_and_names_a_shipped_task() {
        let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        let mut n = 0;
        for entry in std::fs::read_dir(assets.join("skills")).unwrap() {
            let dir = entry.unwrap().path();
            if !dir.is_dir() {
                continue;
            }
            let folder = SkillFolder::at(&dir);
            let record = folder.record().unwrap();
            let file = assets
                .join("tasks")
                .join(&record.task)
                .with_extension("toml");
            let task = TaskSpec::load(&file).unwrap();
            assert!(!folder.checkpoint().exists(), "{}", dir.display());
            let primitive = primitive(&folder, &task, &record).unwrap();
            assert_eq!(primitive.task().name, task.name);
            n += 1;
        }
        assert!(n > 0);
    }
}
