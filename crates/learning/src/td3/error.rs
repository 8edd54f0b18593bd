//! What stops a learner.

use crate::mlp::NetworkError;

use super::ParamsError;

/// Why a learner could not be made, told something, or go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Td3Error {
    /// A parameter out of its range.
    #[error(transparent)]
    Params(#[from] ParamsError),
    /// A size of zero.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A vector of another size.
    #[error("{what} has {found} components, expected {wanted}")]
    Size {
        /// Which vector.
        what: &'static str,
        /// Its components.
        found: usize,
        /// Components wanted.
        wanted: usize,
    },
    /// A NaN or an infinity.
    #[error("{what} is not finite at step {at}")]
    NotFinite {
        /// Which number.
        what: &'static str,
        /// The update, or for what was observed the step of the environment, counted from one.
        at: u64,
    },
    /// An observation to act on that says nothing.
    #[error("component {index} of the observation is {found}, expected a finite number")]
    Observation {
        /// Which component.
        index: usize,
        /// What it is.
        found: f32,
    },
    /// A ring that is too large.
    #[error("`replay_capacity` is {capacity}, expected no more transitions than fit into memory")]
    Memory {
        /// Transitions it was to hold.
        capacity: usize,
    },
    /// An update before the first transition.
    #[error("there are 0 transitions to learn from, expected at least 1")]
    NothingRecorded,
}

pub(super) fn check_size(what: &'static str, found: usize, wanted: usize) -> Result<(), Td3Error> {
    if found == wanted {
        return Ok(());
    }
    Err(Td3Error::Size {
        what,
        found,
        wanted,
    })
}

pub(super) fn check_finite(what: &'static str, values: &[f32], at: u64) -> Result<(), Td3Error> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(Td3Error::NotFinite { what, at })
}

/// Refuses to act on a NaN or an infinity, which a network may turn into a number that looks good.
pub(super) fn check_observation(observation: &[f32]) -> Result<(), Td3Error> {
    let bad = observation.iter().position(|value| !value.is_finite());
    match bad {
        Some(index) => Err(Td3Error::Observation {
            index,
            found: observation[index],
        }),
        None => Ok(()),
    }
}
