//! What can be wrong with recorded transitions.

/// Why a transition cannot be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransitionError {
    /// Another number of values than there are variables.
    #[error("{which} has {found} values, wanted {wanted}")]
    Length {
        /// Which state.
        which: &'static str,
        /// Values in it.
        found: usize,
        /// Variables there are.
        wanted: usize,
    },
    /// A value that is no finite number.
    #[error("variable `{variable}` of the {which} is {found}, wanted a finite number")]
    NotFinite {
        /// Which state.
        which: &'static str,
        /// The variable's name.
        variable: String,
        /// The value.
        found: f64,
    },
    /// An option that does not exist.
    #[error("option {found} does not exist; there are {n_options}, from 0")]
    Option {
        /// The index.
        found: usize,
        /// Options there are.
        n_options: usize,
    },
    /// Another number of flags than there are options.
    #[error("{found} flags say which options can run, wanted one for each of {wanted} options")]
    Executable {
        /// Flags given.
        found: usize,
        /// Options there are.
        wanted: usize,
    },
    /// A variable of the mask that does not exist.
    #[error("the mask names variable {found}; there are {n_variables}, from 0")]
    Mask {
        /// The index.
        found: usize,
        /// Variables there are.
        n_variables: usize,
    },
    /// A reward that is no finite number.
    #[error("the reward is {found}, wanted a finite number")]
    Reward {
        /// The value.
        found: f64,
    },
}

/// Why a table of transitions cannot be read. Rows count from 1, the header being row 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The bytes could not be read or unpacked.
    #[error("transitions cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// There is not even a header.
    #[error("transitions have no header row; wanted columns such as {wanted}")]
    Empty {
        /// Columns that must be there.
        wanted: &'static str,
    },
    /// A column that must be there is not.
    #[error("transitions have no column `{wanted}`; found {found}")]
    MissingColumn {
        /// The column.
        wanted: String,
        /// The columns there are.
        found: String,
    },
    /// A column given twice.
    #[error("column `{column}` of the transitions stands there twice")]
    DuplicateColumn {
        /// The column.
        column: String,
    },
    /// A column whose meaning is not known.
    #[error("column `{column}` of the transitions is not known{hint}")]
    UnknownColumn {
        /// The column.
        column: String,
        /// The nearest column that is known, as a question, or nothing.
        hint: String,
    },
    /// A row with more or fewer fields than the header.
    #[error("row {row} has {found} fields, wanted {wanted} as in the header")]
    Ragged {
        /// The row.
        row: usize,
        /// Fields in it.
        found: usize,
        /// Fields in the header.
        wanted: usize,
    },
    /// A field that is not what its column holds.
    #[error("row {row}, column `{column}`: found `{found}`, wanted {wanted}")]
    Field {
        /// The row.
        row: usize,
        /// The column.
        column: String,
        /// What stands there.
        found: String,
        /// What should.
        wanted: String,
    },
}
