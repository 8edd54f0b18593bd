//! Poses as they travel: xyzw quaternions, metres, radians.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

/// A pose in space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Position, in metres.
    pub position: [f64; 3],
    /// Orientation as a unit quaternion `[x, y, z, w]`.
    pub orientation_xyzw: [f64; 4],
}

impl Pose {
    /// The pose of a frame in itself.
    pub const IDENTITY: Self = Self {
        position: [0.0; 3],
        orientation_xyzw: [0.0, 0.0, 0.0, 1.0],
    };

    /// A pose turned by `yaw` radians about z.
    #[must_use]
    pub fn from_position_yaw(position: [f64; 3], yaw: f64) -> Self {
        let (sin_half, cos_half) = (0.5 * yaw).sin_cos();
        Self {
            position,
            orientation_xyzw: [0.0, 0.0, sin_half, cos_half],
        }
    }

    /// Whether every component is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.position
            .iter()
            .chain(&self.orientation_xyzw)
            .all(|component| component.is_finite())
    }
}

/// A pose on the floor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct PosePlanar {
    /// Position along x, in metres.
    pub x: f64,
    /// Position along y, in metres.
    pub y: f64,
    /// Heading about z, in radians; 0 looks along x.
    pub yaw: f64,
}

impl PosePlanar {
    /// Whether every component is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.yaw.is_finite()
    }
}
