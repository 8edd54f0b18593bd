//! Driving by hand.

use serde::de::{Error as _, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};
use ts_rs::TS;

/// A velocity of the base, as shares of the robot's limits: each in `[-1, 1]`. Any other number is refused when it is
/// read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Ahead; backwards when negative.
    #[serde(deserialize_with = "share")]
    pub forward: f64,
    /// Sideways to the left; to the right when negative.
    #[serde(deserialize_with = "share")]
    pub left: f64,
    /// Turning counterclockwise; clockwise when negative.
    #[serde(deserialize_with = "share")]
    pub turn: f64,
}

fn share<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let share = f64::deserialize(deserializer)?;
    if (-1.0..=1.0).contains(&share) {
        Ok(share)
    } else {
        Err(D::Error::invalid_value(
            Unexpected::Float(share),
            &"a share of the limit in [-1, 1]",
        ))
    }
}
