//! What can go wrong in motion, apart from there being no path.

use factotum_descriptions::TrajectoryError;
use factotum_physics::PhysicsError;

/// An error of this crate: bad input or a fault, never "no solution".
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// A list of joint values has the wrong length.
    #[error("{what} has {found} values, expected {wanted}, one per chain joint")]
    Width {
        /// What the list is.
        what: &'static str,
        /// Values found.
        found: usize,
        /// Chain joints.
        wanted: usize,
    },
    /// A number is not finite.
    #[error("{what} is {found}, expected a finite number")]
    NotFinite {
        /// What the number is.
        what: &'static str,
        /// The number.
        found: f64,
    },
    /// A joint of the chain does not move the tool, so it is not between base and tool.
    #[error("joint `{joint}` does not move the tool frame `{tcp_site}`")]
    NotInChain {
        /// The joint.
        joint: String,
        /// The tool site.
        tcp_site: String,
    },
    /// A joint of the chain is neither hinge nor slide.
    #[error("joint `{joint}` has {n_dofs} degrees of freedom, expected a hinge or a slide")]
    NotHingeOrSlide {
        /// The joint.
        joint: String,
        /// Its degrees of freedom.
        n_dofs: usize,
    },
    /// A name that the scene does not have.
    #[error("{kind} `{name}` is not in the planning scene; available: {}", available.join(", "))]
    UnknownName {
        /// Kind of thing, as `obstacle`.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names it has.
        available: Vec<String>,
    },
    /// Two things with one name.
    #[error("two obstacles are named `{name}`, expected different names")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// A value out of its range.
    #[error("{what} is {found}, expected {wanted}")]
    Value {
        /// What the value is.
        what: &'static str,
        /// The value.
        found: String,
        /// What is allowed.
        wanted: &'static str,
    },
    /// A model does not load, or the engine failed.
    #[error(transparent)]
    Physics(#[from] PhysicsError),
    /// The timed path is not a trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
    /// The jerk-limited generator refused a segment.
    #[error("no jerk-limited motion over {length} from speed {speed_from} to {speed_to}: {reason}")]
    Timing {
        /// Length of the segment along the path.
        length: f64,
        /// Speed at its start.
        speed_from: f64,
        /// Speed at its end.
        speed_to: f64,
        /// The generator's words.
        reason: String,
    },
}
