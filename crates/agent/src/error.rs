//! Faults that end a run. A chore that cannot be done is no fault: it is in the report.

use factotum_control::RobotError;
use factotum_geometry::grid::GridError;
use factotum_geometry::sensing::DepthFrameError;
use factotum_motion::MotionError;
use factotum_perception::class_surface::AppearanceError;
use factotum_perception::detect::DetectError;
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
    /// A class's model cannot be sampled.
    #[error(transparent)]
    Appearance(#[from] AppearanceError),
    /// A class cannot be detected.
    #[error(transparent)]
    Detect(#[from] DetectError),
    /// The camera's picture contradicts itself.
    #[error("camera: {0}")]
    Camera(#[from] DepthFrameError),
    /// A scan cannot be put into the map.
    #[error("map: {0}")]
    Grid(#[from] GridError),
    /// The robot cannot tell where in the stored map it is.
    #[error("cannot find myself in the map: {verdict}")]
    NotInMap {
        /// What the last scan said.
        verdict: String,
    },
    /// The observer wished to stop.
    #[error("stopped on request")]
    Stopped,
}
