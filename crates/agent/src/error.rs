//! Faults that end a run. A chore that cannot be done is no fault: it is in the report.

use factotum_control::RobotError;
use factotum_motion::MotionError;
use factotum_semantic_map::MapError;
use factotum_skills::SkillError;
use factotum_task_planning::planner::PlannerError;

/// Why a run ended before its report could be honest.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AgentError {
    /// The robot does not answer or refused a command.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The map cannot answer.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A skill could not be tried.
    #[error(transparent)]
    Skill(#[from] SkillError),
    /// A model could not be loaded, or a motion planner was misused.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The task planner could not be run.
    #[error(transparent)]
    Planner(#[from] PlannerError),
    /// The planner's plan does not do what it says.
    #[error("planner `{planner}` gave a plan that fails its check: {problem}")]
    WrongPlan {
        /// The planner.
        planner: String,
        /// The validator's word.
        problem: String,
    },
    /// The observer wished to stop.
    #[error("stopped on request")]
    Stopped,
}
