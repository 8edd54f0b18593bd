//! What can be wrong with a description.

use std::path::PathBuf;

/// Why a description could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// The file could not be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// The file is not TOML of the wanted form.
    #[error("`{}`: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, column, what was found and what was wanted.
        message: String,
    },
    /// The file holds a key that nobody knows.
    #[error("`{}`{}: unknown key `{key}`{}", path.display(), at_line(*line), did_you_mean(nearest.as_deref()))]
    UnknownKey {
        /// The file.
        path: PathBuf,
        /// One-based line, where known.
        line: Option<usize>,
        /// The key as written.
        key: String,
        /// The known key most like it.
        nearest: Option<String>,
    },
    /// A value is out of its range, or two values contradict each other.
    #[error("`{}`: `{field}` is {found}, expected {wanted}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Dotted path of the field.
        field: String,
        /// What the file says.
        found: String,
        /// What would be right.
        wanted: String,
    },
}

fn at_line(line: Option<usize>) -> String {
    line.map(|line| format!(":{line}")).unwrap_or_default()
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest
        .map(|nearest| format!("; did you mean `{nearest}`?"))
        .unwrap_or_default()
}
