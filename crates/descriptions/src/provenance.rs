//! Where a description comes from.

use serde::{Deserialize, Serialize};

/// Where a class, or something that is known of it, comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Provenance {
    /// Shipped or written by hand.
    #[default]
    Given,
    /// Taught by a person.
    Taught,
    /// Learned by the robot.
    Learned,
}

impl Provenance {
    /// Whether it need not be said.
    pub(crate) fn is_given(&self) -> bool {
        *self == Self::Given
    }
}
