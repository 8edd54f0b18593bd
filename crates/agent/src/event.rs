//! What the executive tells whoever watches, and what the watcher may wish.

use factotum_geometry::Pose2;
use factotum_semantic_map::{Aosm, TopologicalGraph};

use crate::Checkpoint;

/// Something the executive did or found.
#[derive(Debug, Clone)]
pub enum Event<'a> {
    /// A sentence for people.
    Log {
        /// The robot's clock, seconds.
        time_secs: f64,
        /// How much it matters.
        level: LogLevel,
        /// The sentence.
        text: String,
    },
    /// The map or its objects changed.
    Map {
        /// The map as it is now.
        aosm: &'a Aosm,
        /// Regions and edges, if they have been grounded.
        graph: &'a TopologicalGraph,
        /// Where the robot believes to be.
        map_from_base: Pose2,
    },
    /// A plan was made, or a step of it changed.
    Plan {
        /// All steps, navigation included.
        steps: &'a [StepView],
    },
    /// The robot is at rest: with this, the map and its own state, another executive can go on from here.
    Checkpoint {
        /// The map as it is now.
        aosm: &'a Aosm,
        /// The rest.
        checkpoint: &'a Checkpoint,
    },
}

/// How much a message matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogLevel {
    /// Progress.
    Info,
    /// Something went wrong and was mended.
    Warning,
    /// Something went wrong.
    Error,
}

/// A step of a plan as shown to people.
#[derive(Debug, Clone, PartialEq)]
pub struct StepView {
    /// Operator, or `navigate`.
    pub action: String,
    /// Its arguments.
    pub args: Vec<String>,
    /// Driving or handling.
    pub kind: StepKind,
    /// How it goes.
    pub state: StepState,
    /// How often it was tried.
    pub attempts: usize,
    /// Why it failed or was skipped.
    pub reason: Option<String>,
}

/// Driving or handling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepKind {
    /// The base drives.
    Navigate,
    /// A skill runs.
    Manipulate,
}

/// How a step goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepState {
    /// Not begun.
    Pending,
    /// Under way.
    Running,
    /// Done, as the robot believes.
    Done,
    /// Failed.
    Failed,
    /// Left out, because the plan changed.
    Skipped,
}

/// What the watcher wishes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// Go on.
    GoOn,
    /// Stop the robot and end the run, keeping everything.
    Stop,
}

/// Whoever watches the executive. It may block, which pauses the robot between steps.
pub trait Observer {
    /// Told of everything; what it wishes is done at the next safe moment.
    fn observe(&mut self, event: &Event<'_>) -> Wish;
}

impl<F: FnMut(&Event<'_>) -> Wish> Observer for F {
    fn observe(&mut self, event: &Event<'_>) -> Wish {
        self(event)
    }
}
