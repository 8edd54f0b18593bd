//! Who may do what.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

/// What a page may do. Each role may do what those before it may.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Look at everything, and stop the robot.
    View,
    /// Change the home too.
    Teach,
    /// Command the robot too.
    Execute,
}

impl Role {
    /// All of them, the least first.
    pub const ALL: [Self; 3] = [Self::View, Self::Teach, Self::Execute];

    /// Its name on the wire.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::View => "view",
            Self::Teach => "teach",
            Self::Execute => "execute",
        }
    }
}

/// Whose commands the robot follows.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Control {
    /// [`Hello::client`](crate::Hello::client) of the page that has the robot; none when it is free. The first that
    /// commands it has it until it leaves, or until another commands after it has long said nothing.
    pub owner: Option<String>,
}
