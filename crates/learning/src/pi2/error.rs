//! What makes a search impossible.

/// Why a search could not begin, be told, or be read back.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Pi2Error {
    /// Nothing to search for.
    #[error("there are 0 {what}, expected at least 1")]
    Empty {
        /// What is missing.
        what: &'static str,
    },
    /// Nothing to compare.
    #[error("there are {found} samples, expected at least 2")]
    TooFewSamples {
        /// Samples given.
        found: usize,
    },
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
        found: f64,
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
}

pub(super) fn check_finite(what: &'static str, values: &[f64]) -> Result<(), Pi2Error> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Pi2Error::NotFinite {
            what,
            index,
            found: values[index],
        }),
    }
}

pub(super) fn check_size(what: &'static str, found: usize, wanted: usize) -> Result<(), Pi2Error> {
    if found == wanted {
        return Ok(());
    }
    Err(Pi2Error::Size {
        what,
        found,
        wanted,
    })
}
