//! The plan and how far it has come.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

/// The steps from now or before to the goal, navigation interleaved. A new plan replaces it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// How often the robot has planned anew in this job.
    pub replans: u32,
    /// The steps, in order.
    pub steps: Vec<PlanStep>,
}

/// One step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct PlanStep {
    /// Place in the plan, from 0.
    pub index: u32,
    /// Driving or acting.
    pub kind: StepKind,
    /// Name of the action.
    pub action: String,
    /// What it is done with.
    pub args: Vec<String>,
    /// How it stands.
    pub state: StepState,
    /// How often it was tried.
    pub attempts: u32,
    /// Why it failed, was tried again or was skipped: one sentence; empty when there is nothing to
    /// say.
    pub reason: String,
}

/// What a step moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum StepKind {
    /// The base drives.
    Navigate,
    /// The arm acts.
    Manipulate,
}

/// How a step stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum StepState {
    /// Not begun.
    Pending,
    /// Being done.
    Running,
    /// Done.
    Done,
    /// Tried, and given up.
    Failed,
    /// Not needed any more.
    Skipped,
}
