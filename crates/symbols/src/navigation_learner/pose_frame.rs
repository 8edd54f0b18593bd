//! How a navigation symbol sees the pose of the base.

use factotum_geometry::Pose2;
use factotum_geometry::frames::wrap_angle;

/// The variables of a base pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PoseFrame {
    /// (x, y, yaw) in the map.
    Global,
    /// (x, y, yaw) in the object's frame.
    Object,
    /// (d, cos b, sin b, e): how far from the object, in which direction b of its frame, and how far turned away from it,
    /// from −π to π.
    Polar,
}

impl PoseFrame {
    /// How many variables.
    pub fn n_variables(self) -> usize {
        match self {
            Self::Global | Self::Object => 3,
            Self::Polar => 4,
        }
    }

    /// The variables, in metres and radians.
    pub fn variables(self, world_from_object: &Pose2, world_from_base: &Pose2) -> Vec<f64> {
        let object_from_base = world_from_object.inv_mul(world_from_base);
        match self {
            Self::Global => cartesian(world_from_base),
            Self::Object => cartesian(&object_from_base),
            Self::Polar => {
                let place = object_from_base.translation.vector;
                let distance = place.norm();
                let bearing = place.y.atan2(place.x);
                let facing = (-place.y).atan2(-place.x);
                let error = wrap_angle(facing - object_from_base.rotation.angle());
                vec![distance, bearing.cos(), bearing.sin(), error]
            }
        }
    }
}

fn cartesian(pose: &Pose2) -> Vec<f64> {
    let place = pose.translation.vector;
    vec![place.x, place.y, pose.rotation.angle()]
}
