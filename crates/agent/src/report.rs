//! What was planned and what was done.

use factotum_task_planning::operator::GroundAction;

/// What the executive did for a chore, and what it believes came of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RunReport {
    /// The last manipulation-only plan.
    pub plan: Vec<GroundAction>,
    /// Everything that was executed, in order.
    pub executed: Vec<ExecutedStep>,
    /// Plans made after the first.
    pub n_replans: usize,
    /// Whether the robot believes the goal to hold. Whether it does is for the judge to say.
    pub is_believed_done: bool,
    /// Why the chore was given up, in one sentence.
    pub reason: Option<String>,
    /// Robot time from start to end, seconds.
    pub robot_secs: f64,
}

/// One executed step.
#[derive(Debug, Clone, PartialEq)]
pub struct ExecutedStep {
    /// Operator, or `navigate`.
    pub action: String,
    /// Its arguments.
    pub args: Vec<String>,
    /// The learned skill that was used, if one was.
    pub learned: Option<String>,
    /// `done`, or why it failed.
    pub outcome: String,
    /// Whether it was done.
    pub is_done: bool,
    /// Tries so far of this step of the plan, this one included.
    pub attempts: usize,
    /// Robot time it took, seconds.
    pub robot_secs: f64,
}
