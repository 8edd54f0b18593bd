//! What makes samples or fields unusable.

/// Why a regression could not be fitted or asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LwrError {
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
    /// A width of a field that is none.
    #[error(
        "width of field {field} in dimension {dim} is {found}, expected a number of at least 0"
    )]
    Width {
        /// Which field.
        field: usize,
        /// Which dimension of the input.
        dim: usize,
        /// The width.
        found: f64,
    },
    /// Nothing to blend.
    #[error("there are 0 {what}, expected at least 1")]
    Empty {
        /// What is missing.
        what: &'static str,
    },
}

pub(super) fn check_finite<'a>(
    what: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
) -> Result<(), LwrError> {
    if values.into_iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(LwrError::NotFinite { what })
    }
}

pub(super) fn check_size(what: &'static str, found: usize, wanted: usize) -> Result<(), LwrError> {
    if found == wanted {
        return Ok(());
    }
    Err(LwrError::Size {
        what,
        found,
        wanted,
    })
}
