//! A pose as people write it: position and fixed-axis roll, pitch, yaw.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// A pose in a text file: `xyz` in metres, `rpy` in radians about the fixed axes X, Y, Z (REP-103).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Placement {
    /// Position, metres.
    pub xyz: [f64; 3],
    /// Roll, pitch, yaw, radians.
    pub rpy: [f64; 3],
}

impl From<Placement> for Isometry3<f64> {
    fn from(placement: Placement) -> Self {
        let [x, y, z] = placement.xyz;
        let [roll, pitch, yaw] = placement.rpy;
        Self::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        )
    }
}

impl From<Isometry3<f64>> for Placement {
    fn from(pose: Isometry3<f64>) -> Self {
        let (roll, pitch, yaw) = pose.rotation.euler_angles();
        Self {
            xyz: pose.translation.vector.into(),
            rpy: [roll, pitch, yaw],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn round_trips_as_a_pose(xyz in prop::array::uniform3(-5.0..5.0), rpy in prop::array::uniform3(-3.0..3.0)) {
            let pose = Isometry3::from(Placement { xyz, rpy });
            let again = Isometry3::from(Placement::from(pose));
            prop_assert!((pose.inverse() * again).translation.vector.norm() < 1e-9);
            prop_assert!(pose.rotation.angle_to(&again.rotation) < 1e-6);
        }
    }
}
