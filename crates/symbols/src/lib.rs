//! Symbols: what a robot plans with, learned from what it did.
//!
//! Two kinds stand side by side.
//!
//! *From transitions to operators* (dissertation 2.1.3 and 5.4): [`transitions`] are divided into subgoal
//! options ([`partition`]), whose [`precondition`]s are support vector classifiers and whose effects are kernel
//! densities over [`factors`]; these densities are the symbols of a [`vocabulary`], and a choice of symbols that a
//! precondition holds for is an operator ([`operators`]). [`model`] is the whole way, up to PPDDL.
//!
//! With [`spatial`] independence, where the base must be is learned apart from the rest.
//!
//! *Navigation symbols* σ^o (dissertation 5.3): a probabilistic classifier over the robot's base pose relative to
//! the object an option acts on. Because it lives in the object's frame, it moves with the object and to other homes.
//!
//! Frames: `object_from_base` is the pose of the robot's base in the object's frame, seen from above;
//! x forward, y left; metres and radians.

mod approach_region;
pub mod clustering;
pub mod density;
pub mod factors;
pub mod gaussian_process;
mod grounding;
pub mod model;
pub mod navigation_learner;
mod navigation_symbol;
pub mod operators;
pub mod partition;
pub mod precondition;
mod samples;
pub mod spatial;
pub mod subgoal;
pub mod support_vector;
pub mod transitions;
pub mod vocabulary;

pub use approach_region::{ApproachRegion, ApproachRegionError};
pub use grounding::ground;
pub use navigation_symbol::{BasePoseClassifier, NavigationSymbol};
pub use samples::{Bounds, Distinct, Samples};

pub use factotum_task_planning::operator::Provenance;
