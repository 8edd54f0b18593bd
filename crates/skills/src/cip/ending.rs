//! When a skill ends: the success indicator β_c of the task, and the failure classifier B, which is the same for all.
//!
//! Thesis 3.2.1: β_c is true once the object's joint is beyond a threshold. B is true once a joint is within 5 degrees
//! of its limit, or contact was lost for a while; the time-out is of section 3.3. A step in which both are true counts
//! as failed, which is stricter than the experiments' code.
//!
//! Beside these, B can notice that nothing moves any more ([`FailureClassifier::stuck_steps`]) and that the arm cannot
//! go on within σ ([`FailureClassifier::cornered_steps`]); neither is used in the dissertation's settings.

use factotum_descriptions::TaskSpec;
use factotum_geometry::Pose;
use serde::{Deserialize, Serialize};

use super::hand_motion::HandMotion;
use super::rig::Reading;

/// β_c: whether the object's joint is beyond its goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SuccessIndicator {
    /// Where the joint starts, rad or m.
    pub start: f64,
    /// Beyond which it is done.
    pub goal: f64,
}

impl SuccessIndicator {
    /// β_c of a task.
    pub fn of(task: &TaskSpec) -> Self {
        Self {
            start: task.start,
            goal: task.goal,
        }
    }

    /// How far the joint has come from start (0) to goal (1).
    pub fn progress(&self, reading: &Reading) -> f64 {
        (reading.object_joint - self.start) / (self.goal - self.start)
    }

    /// Tool poses from a grasp along the object's motion to its goal, the grasp first; all in the base frame.
    pub fn tool_motion(
        &self,
        motion: &HandMotion,
        base_from_object: &Pose,
        base_from_tcp: &Pose,
    ) -> Vec<Pose> {
        const N_POSES: usize = 12;
        let object_from_tcp = base_from_object.inverse() * base_from_tcp;
        let at = |share: f64| {
            let way = [self.start, self.start + (self.goal - self.start) * share];
            motion.tool(way, |moved| base_from_object * moved * object_from_tcp)
        };
        (0..N_POSES)
            .map(|i| at(i as f64 / (N_POSES - 1) as f64))
            .collect()
    }

    /// β_c.
    pub fn holds(&self, reading: &Reading) -> bool {
        self.progress(reading) > 1.0
    }
}

/// Why a skill failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureKind {
    /// A joint of the arm came too near to its limit.
    JointLimit,
    /// The gripper touched nothing for too long.
    ContactLost,
    /// The object did not move for too long.
    Stuck,
    /// The guard kept the arm from its limits for too long.
    Cornered,
    /// It took too long.
    TimeOut,
    /// Nothing could be taken hold of, so that it did not even begin.
    NoGrasp,
}

impl FailureKind {
    /// What happened, as a reason.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::JointLimit => "a joint of the arm came too near to its limit",
            Self::ContactLost => "the gripper lost the object",
            Self::Stuck => "the object did not move any more",
            Self::Cornered => "the arm could not go on without a joint at its limit",
            Self::TimeOut => "it took too long",
            Self::NoGrasp => "nothing could be taken hold of",
        }
    }
}

/// B: whether the skill has failed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FailureClassifier {
    /// Nearer than this to a joint limit is a failure, and a violation, rad.
    pub limit_rad: f64,
    /// Steps without contact; `None` where the skill begins without.
    pub contact_lost_steps: Option<u32>,
    /// Steps without any new progress.
    pub stuck_steps: Option<u32>,
    /// Steps within twice `limit_rad` of a limit.
    pub cornered_steps: Option<u32>,
    /// Steps at most.
    pub steps_max: u32,
}

/// What B remembers of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FailureMemory {
    n_steps: u32,
    n_without_contact: u32,
    n_without_progress: u32,
    n_cornered: u32,
    best_progress: f64,
}

impl FailureClassifier {
    /// B of the dissertation: 5 degrees, contact, time.
    pub fn of_episode(steps_max: u32, contact_lost_steps: Option<u32>) -> Self {
        Self {
            limit_rad: 5.0_f64.to_radians(),
            contact_lost_steps,
            stuck_steps: None,
            cornered_steps: None,
            steps_max,
        }
    }

    /// Whether a joint came too near to its limit in the last step.
    pub fn is_violated(&self, reading: &Reading) -> bool {
        reading.limit_distance_rad < self.limit_rad
    }

    /// B after a step.
    pub fn judge(
        &self,
        memory: &mut FailureMemory,
        reading: &Reading,
        progress: f64,
    ) -> Option<FailureKind> {
        /// Share of the way that counts as progress.
        const PROGRESS_MIN: f64 = 1e-3;
        /// Within this multiple of the failure distance the arm is cornered.
        const CORNER: f64 = 2.0;
        memory.n_steps += 1;
        let count =
            |counter: &mut u32, holds: bool| *counter = if holds { *counter + 1 } else { 0 };
        count(&mut memory.n_without_contact, !reading.touching);
        let is_progress = progress > memory.best_progress + PROGRESS_MIN;
        count(&mut memory.n_without_progress, !is_progress);
        memory.best_progress = memory.best_progress.max(progress);
        count(
            &mut memory.n_cornered,
            reading.limit_distance_rad < CORNER * self.limit_rad,
        );
        let reached = |limit: Option<u32>, n: u32| limit.is_some_and(|limit| n >= limit);
        if self.is_violated(reading) {
            Some(FailureKind::JointLimit)
        } else if reached(self.contact_lost_steps, memory.n_without_contact) {
            Some(FailureKind::ContactLost)
        } else if reached(self.stuck_steps, memory.n_without_progress) {
            Some(FailureKind::Stuck)
        } else if reached(self.cornered_steps, memory.n_cornered) {
            Some(FailureKind::Cornered)
        } else if memory.n_steps >= self.steps_max {
            Some(FailureKind::TimeOut)
        } else {
            None
        }
    }
}
