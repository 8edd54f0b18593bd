//! What moves: sent many times a second, the latest wins.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

use crate::{Pose, PosePlanar};

/// The world at one instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Simulated time, in seconds.
    pub time_secs: f64,
    /// Seconds of simulated time that pass in a second; 0 when nothing moves.
    pub sim_speed: f64,
    /// World from base.
    pub base: PosePlanar,
    /// Every body that can move. A body not named stays where its scene put it, since a state
    /// may be skipped by a slow reader.
    pub body_poses: Vec<BodyPose>,
    /// The robot's joints.
    pub joints: Vec<JointPosition>,
}

impl State {
    /// Whether every number is finite, as the wire asks: JSON has no NaN.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.time_secs.is_finite()
            && self.sim_speed.is_finite()
            && self.base.is_finite()
            && self.body_poses.iter().all(|body| body.pose.is_finite())
            && self.joints.iter().all(|joint| joint.position.is_finite())
    }
}

/// Where a body is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct BodyPose {
    /// The body's name in its scene.
    pub name: String,
    /// World from body.
    pub pose: Pose,
}

/// Where a joint is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct JointPosition {
    /// The joint's name.
    pub name: String,
    /// Radians of a hinge, metres of a slide.
    pub position: f64,
}

/// The way the base is about to take; no points when it stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct BasePath {
    /// Points `[x, y]` in the world, in metres, in driving order.
    pub points: Vec<[f64; 2]>,
}
