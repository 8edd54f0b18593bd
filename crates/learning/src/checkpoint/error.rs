//! Why a checkpoint was not written or cannot be used.

use std::path::PathBuf;

use crate::td3::Td3Error;

/// Why a checkpoint was not written or cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The disk or the system.
    #[error("cannot {act} checkpoint `{}`: {source}", path.display())]
    Io {
        /// `read` or `write`.
        act: &'static str,
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not a checkpoint, or one that lost bytes or had them changed.
    #[error("checkpoint `{}` is damaged: {found}, expected a whole safetensors file of Factotum", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        found: String,
    },
    /// A whole checkpoint, of something else.
    #[error("checkpoint `{}` has {what} {found}, expected {wanted}", path.display())]
    Other {
        /// Which file.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// What it has.
        found: String,
        /// What was wanted.
        wanted: String,
    },
    /// Parameters that make no learner.
    #[error(transparent)]
    Learner(#[from] Td3Error),
}
