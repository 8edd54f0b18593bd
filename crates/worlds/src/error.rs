//! What can be wrong with a world.

use std::path::PathBuf;

use factotum_control::ControlError;
use factotum_descriptions::DescriptionError;
use factotum_geometry::grid::GridError;
use factotum_physics::PhysicsError;

/// Why a world could not be made, stepped or judged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A description could not be read.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The engine refused.
    #[error("{what}: {source}")]
    Physics {
        /// What was being done.
        what: &'static str,
        /// The engine's word.
        source: PhysicsError,
    },
    /// A control law refused.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A value in a scene file is out of its range, or two contradict each other.
    #[error("`{}`: `{field}` is {found}, expected {wanted}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Dotted path of the field.
        field: String,
        /// What the file says.
        found: String,
        /// What would be right.
        wanted: String,
    },
    /// A name that the scene does not know.
    #[error(
        "{kind} `{name}` is not in scene `{scene}`; available: {}",
        list(available)
    )]
    UnknownName {
        /// `chore`, `object` or `class`.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The scene.
        scene: String,
        /// The names it has.
        available: Vec<String>,
    },
    /// The robot starts where it touches the home.
    #[error(
        "robot `{robot}` starts at ({x_m:.2}, {y_m:.2}) m touching `{geom}` of scene `{scene}`"
    )]
    StartOccupied {
        /// The robot.
        robot: String,
        /// The scene.
        scene: String,
        /// Where it starts.
        x_m: f64,
        /// Where it starts.
        y_m: f64,
        /// What it touches.
        geom: String,
    },
    /// Objects could not be placed without touching each other.
    #[error("no free place for object `{object}` of scene `{scene}` in {attempts} attempts")]
    NoPlace {
        /// The object.
        object: String,
        /// The scene.
        scene: String,
        /// Attempts made.
        attempts: usize,
    },
    /// A grid could not be made.
    #[error("true map: {0}")]
    Grid(#[from] GridError),
    /// A snapshot cannot be written or read.
    #[error("snapshot: {reason}")]
    Snapshot {
        /// What stands against it.
        reason: String,
    },
}

impl WorldError {
    /// Says what was being done when the engine refused.
    pub(crate) fn physics(what: &'static str) -> impl FnOnce(PhysicsError) -> Self {
        move |source| Self::Physics { what, source }
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}
