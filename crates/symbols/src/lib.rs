//! Symbols: classifiers that say in which states an option can run.
//!
//! So far the house needs one kind, the *navigation symbol* σ^o of dissertation 5.3: a probabilistic
//! classifier over the robot's base pose relative to the object an option acts on. Because it lives
//! in the object's frame, it moves with the object and to other homes. Symbols learned from
//! transitions will stand beside it.
//!
//! Frames: `object_from_base` is the pose of the robot's base in the object's frame, seen from above;
//! x forward, y left; metres and radians.

mod approach_region;
mod grounding;
mod navigation_symbol;

pub use approach_region::{ApproachRegion, ApproachRegionError};
pub use grounding::ground;
pub use navigation_symbol::{BasePoseClassifier, NavigationSymbol};

pub use factotum_task_planning::operator::Provenance;
