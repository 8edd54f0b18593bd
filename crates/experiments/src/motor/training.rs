//! Learning a motor skill into its folder, from the beginning or from where it stopped.

use std::sync::atomic::{AtomicBool, Ordering};

use factotum_descriptions::{RecordedMotion, TaskSpec};
use factotum_skills::bootstrap::PlannedDemo;
use factotum_worlds::TaskRig;
use serde::{Deserialize, Serialize};

use super::search::{MotorSearch, SearchState, begin};
use super::{MotorError, MotorFolder, MotorRecord, MotorRig, MotorRollout};

/// An epoch, as in `metrics.jsonl`; 0 is the policy that it began with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EpochRecord {
    /// Number of updates made.
    pub epoch: u64,
    /// Rollouts learned from so far.
    pub rollouts: u64,
    /// Sum of rewards of the policy after the update.
    #[serde(rename = "return")]
    pub total_reward: f64,
    /// Share of the epoch's exploring rollouts that succeeded; at 0, whether the policy does.
    pub success_rate: f64,
    /// Where the policy after the update leaves the object's joint, rad or m.
    pub object_state: f64,
    /// Whether that is a success.
    pub success: bool,
    /// Mean sum of rewards of the epoch's exploring rollouts; at 0, that of the policy.
    pub explored_return: f64,
}

/// How a training run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorSummary {
    /// The policy that it began with.
    pub first: EpochRecord,
    /// The last epoch.
    pub last: EpochRecord,
    /// Return of an arm that never moves.
    pub still_return: f64,
    /// Whether all epochs were made.
    pub complete: bool,
}

/// A motor skill to be learned.
#[derive(Debug, Clone, Copy)]
pub struct MotorTraining<'a> {
    /// Where it is kept.
    pub folder: &'a MotorFolder,
    /// The task.
    pub task: &'a TaskSpec,
    /// What it is learned with.
    pub record: &'a MotorRecord,
    /// Recorded motions to begin with; a run that goes on has those of its folder.
    pub recorded: &'a [RecordedMotion],
    /// Epochs in all.
    pub n_epochs: u64,
    /// Whether to go on from the folder's search; else the folder must not hold a run.
    pub resume: bool,
}

impl MotorTraining<'_> {
    /// Learns until all epochs are made, or `stop`; `planned` hears of the plan, `tell` of every epoch.
    ///
    /// # Errors
    /// [`MotorError`]; what was learned until the last epoch stays in the folder.
    pub fn run(
        &self,
        stop: &AtomicBool,
        planned: &mut dyn FnMut(&PlannedDemo),
        tell: &mut dyn FnMut(&EpochRecord),
    ) -> Result<MotorSummary, MotorError> {
        let folder = self.folder;
        let recorded = if self.resume {
            folder.demonstrations()?
        } else {
            self.recorded.to_vec()
        };
        let mut rig = MotorRig::new(self.task)?;
        let (mut search, demo) = begin(&mut rig, self.record, &recorded)?;
        // What cannot begin leaves nothing behind.
        if !self.resume {
            folder.begin(self.record, self.recorded)?;
        }
        if let Some(demo) = &demo {
            planned(demo);
        }
        let stored = if self.resume { folder.search()? } else { None };
        let n_done = match stored {
            Some(state) => {
                search
                    .restore(state)
                    .map_err(|reason| folder.not_this(reason))?;
                search.n_updates() + 1
            }
            None => 0,
        };
        let kept = folder.keep_epochs(n_done)?;
        let mut keep = |search: &dyn MotorSearch, epoch: EpochRecord| {
            folder.append(&epoch)?;
            folder.write_search(&search.state())?;
            tell(&epoch);
            Ok::<(), MotorError>(())
        };
        let mut first = kept.first().copied();
        let mut last = kept.last().copied();
        if first.is_none() {
            let rollout = search.roll_out(&mut rig, &mut |_| {})?;
            let epoch = EpochRecord {
                epoch: search.n_updates(),
                rollouts: 0,
                total_reward: rollout.total_reward,
                success_rate: f64::from(u8::from(rollout.success)),
                object_state: rollout.object_state,
                success: rollout.success,
                explored_return: rollout.total_reward,
            };
            keep(search.as_ref(), epoch)?;
            (first, last) = (Some(epoch), Some(epoch));
        }
        while search.n_updates() < self.n_epochs && !stop.load(Ordering::Relaxed) {
            let explored = search.epoch(&mut rig, self.record.rollouts as usize)?;
            let rollout = search.roll_out(&mut rig, &mut |_| {})?;
            let n = explored.len().max(1) as f64;
            let epoch = EpochRecord {
                epoch: search.n_updates(),
                rollouts: search.n_updates() * u64::from(self.record.rollouts),
                total_reward: rollout.total_reward,
                success_rate: explored.iter().filter(|one| one.success).count() as f64 / n,
                object_state: rollout.object_state,
                success: rollout.success,
                explored_return: explored.iter().map(|one| one.total_reward).sum::<f64>() / n,
            };
            keep(search.as_ref(), epoch)?;
            last = Some(epoch);
        }
        let missing = || folder.not_this("no epoch".to_owned());
        Ok(MotorSummary {
            first: first.ok_or_else(missing)?,
            last: last.ok_or_else(missing)?,
            still_return: rig.still_return(),
            complete: search.n_updates() >= self.n_epochs,
        })
    }

    /// Rolls out the folder's policy; `watch` sees the rig after every step.
    ///
    /// # Errors
    /// [`MotorError`] without a policy, or when the physics breaks down.
    pub fn judge(&self, watch: &mut dyn FnMut(&TaskRig)) -> Result<MotorRollout, MotorError> {
        let state = self.folder.search()?;
        let state = state.ok_or_else(|| self.folder.not_this("there is none yet".to_owned()))?;
        self.judge_after(Some(state), watch)
    }

    /// Rolls out the policy that it began with.
    ///
    /// # Errors
    /// [`MotorError`] where there is no plan any more, or when the physics breaks down.
    pub fn judge_first(&self, watch: &mut dyn FnMut(&TaskRig)) -> Result<MotorRollout, MotorError> {
        self.judge_after(None, watch)
    }

    fn judge_after(
        &self,
        state: Option<SearchState>,
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<MotorRollout, MotorError> {
        let mut rig = MotorRig::new(self.task)?;
        let (mut search, _) = begin(&mut rig, self.record, &self.folder.demonstrations()?)?;
        if let Some(state) = state {
            let restored = search.restore(state);
            restored.map_err(|reason| self.folder.not_this(reason))?;
        }
        search.roll_out(&mut rig, watch)
    }
}
