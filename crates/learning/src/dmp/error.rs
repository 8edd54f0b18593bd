//! What makes a demonstration or a motion unusable.

use crate::lwr::LwrError;

/// Why a primitive could not be learned or run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DmpError {
    /// Too few samples to tell the kernels apart and to take differences.
    #[error("the demonstration has {found} samples, expected at least {wanted}")]
    TooFewSamples {
        /// Samples given.
        found: usize,
        /// Fewest that do.
        wanted: usize,
    },
    /// A vector or matrix of another size.
    #[error("{what} has {found} entries, expected {wanted}")]
    Size {
        /// What was given.
        what: &'static str,
        /// Its number of entries.
        found: usize,
        /// Entries wanted.
        wanted: usize,
    },
    /// A NaN or an infinity.
    #[error("{what} has a component that is not finite")]
    NotFinite {
        /// What was given.
        what: &'static str,
    },
    /// A number outside its range.
    #[error("{name} is {found}, expected {wanted}")]
    OutOfRange {
        /// The quantity.
        name: &'static str,
        /// Its value.
        found: f64,
        /// The range in words.
        wanted: &'static str,
    },
    /// Forces that cannot be regressed.
    #[error("the forces of the demonstration cannot be learned: {source}")]
    Forces {
        /// What the regression says.
        source: LwrError,
    },
}

/// Refuses values that are not finite.
pub(super) fn check_finite<'a>(
    what: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
) -> Result<(), DmpError> {
    if values.into_iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(DmpError::NotFinite { what })
    }
}

/// Refuses numbers that are not positive and finite.
pub(super) fn check_positive(name: &'static str, found: f64) -> Result<(), DmpError> {
    if found.is_finite() && found > 0.0 {
        return Ok(());
    }
    let wanted = "a positive finite number";
    Err(DmpError::OutOfRange {
        name,
        found,
        wanted,
    })
}

/// Refuses another number of entries.
pub(super) fn check_size(what: &'static str, found: usize, wanted: usize) -> Result<(), DmpError> {
    if found == wanted {
        Ok(())
    } else {
        Err(DmpError::Size {
            what,
            found,
            wanted,
        })
    }
}
