//! What stops a policy from being made, cloned or improved.

use crate::mlp::NetworkError;

/// Why a policy could not be made, told something, or improved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PolicyGradientError {
    /// A size of zero.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A list of another length.
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
    #[error("entry {index} of {what} is {found}, expected a finite number")]
    NotFinite {
        /// What was given.
        what: &'static str,
        /// Which entry.
        index: usize,
        /// What it is.
        found: f32,
    },
    /// Nothing to learn from.
    #[error("there are 0 {what}, expected at least 1")]
    Empty {
        /// What is missing.
        what: &'static str,
    },
    /// A parameter out of its range.
    #[error("`{field}` is {found}, expected {wanted}")]
    OutOfRange {
        /// Which parameter.
        field: &'static str,
        /// Its value.
        found: f64,
        /// Its range in words.
        wanted: &'static str,
    },
    /// An update that led out of all numbers; the policy is what it was.
    #[error("the update leads to parameters that are not finite, expected finite numbers")]
    Diverged,
}

pub(super) fn check_size(
    what: &'static str,
    found: usize,
    wanted: usize,
) -> Result<(), PolicyGradientError> {
    if found == wanted {
        return Ok(());
    }
    Err(PolicyGradientError::Size {
        what,
        found,
        wanted,
    })
}

pub(super) fn check_finite(what: &'static str, values: &[f32]) -> Result<(), PolicyGradientError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(PolicyGradientError::NotFinite {
            what,
            index,
            found: values[index],
        }),
    }
}

pub(super) fn check_range(
    field: &'static str,
    found: f64,
    good: bool,
    wanted: &'static str,
) -> Result<(), PolicyGradientError> {
    if good && found.is_finite() {
        return Ok(());
    }
    Err(PolicyGradientError::OutOfRange {
        field,
        found,
        wanted,
    })
}
