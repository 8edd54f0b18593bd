//! Spatial independence: what can be done is learned apart from where it can be done.
//!
//! Let S_b be the variables of the base's pose. The initiation set I_o of an option o has the *spatial independence
//! property* (dissertation Definition 5.3.1) if
//!
//! ```text
//! I_o = Proj(I_o, Factors(I_o) / S_b) ∩ Proj(I_o, S_b)
//! ```
//!
//! where Proj(X, v) frees the variables v. The first set says where the base must be, whatever the rest of the world is
//! like: the navigation symbol σ^o. The second says what the rest must be like, wherever the base is. So
//! symbols are learned with S_b projected out, σ^o from the places alone, and every operator of o gets σ^o as one more
//! precondition, which the path planner brings about (Theorem 1).
//!
//! The property is [tested](Independence) for every option. Where it fails, where the base must be depends on
//! the rest; then each operator gets a navigation symbol of its own, learned from the states in which its symbols hold.
//! With symbols fine enough that is a union of products, which any set is.
//!
//! With few samples a state is like no other. So "the same place" and "the same rest of the world" are those within
//! [`SpatialParams::epsilon`] of a state that the option ran from. A try that failed where the rest was such that
//! the option ran elsewhere tells about places; all other failures tell about the rest.

mod independence;
mod places;
#[cfg(test)]
mod tests;

pub use independence::{Gain, Independence, Verdict};
pub use places::Place;
pub(crate) use places::SpatialData;

/// How space is treated apart.
#[derive(Debug, Clone, PartialEq)]
pub struct SpatialParams {
    /// The variables of the base's pose, S_b, ascending.
    pub variables: Vec<usize>,
    /// Distance up to which two places, or two states of the rest, count as the same, in the units of the variables;
    /// default 0.05, as for start states ([`PartitionParams`](crate::partition::PartitionParams)).
    pub epsilon: f64,
    /// Folds in which states are held out to test independence; default 5.
    pub n_folds: usize,
    /// Most states of a test; default 400.
    pub n_samples_max: usize,
    /// Least states of each class for a test; default 10.
    pub n_samples_min: usize,
    /// Standard errors by which the joint classifier must be better for independence to fail; default 2.33, one test in a
    /// hundred by chance.
    pub n_errors: f64,
    /// Least gain of the joint classifier for independence to fail, nats a state; default 0.02.
    pub gain_min_nats: f64,
}

impl SpatialParams {
    /// The defaults for a base whose pose is in these variables.
    pub fn new(mut variables: Vec<usize>) -> Self {
        variables.sort_unstable();
        variables.dedup();
        Self {
            variables,
            epsilon: 0.05,
            n_folds: 5,
            n_samples_max: 400,
            n_samples_min: 10,
            n_errors: 2.33,
            gain_min_nats: 0.02,
        }
    }
}

/// What was learned about space.
#[derive(Debug, Clone, PartialEq)]
pub struct SpatialModel {
    /// The navigation symbols.
    pub places: Vec<Place>,
    /// For each option, or part of an option with places of its own, whether space is independent of the rest.
    pub independence: Vec<Independence>,
    /// Operators that were dropped: in the states in which their symbols hold, the option was never seen to be able to run.
    pub n_operators_without_place: usize,
}
