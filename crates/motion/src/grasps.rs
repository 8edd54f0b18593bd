//! Tool poses to grasp with: from the grasps of an object class, and from a point cloud.
//!
//! The tool frame has z along the approach direction, out of the gripper, and x along the closing direction.

mod antipodal;
mod fit;
mod principal;
mod surface;

pub use antipodal::{AntipodalOptions, antipodal_grasps};
pub use fit::fit_grasp;
pub use principal::{PrincipalOptions, principal_grasps};

use std::f64::consts::TAU;

use factotum_descriptions::Grasp;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::Pose;

/// A tool pose to grasp with.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspCandidate {
    /// Name of the class grasp it comes from.
    pub name: String,
    /// Tool pose in the object's frame Λ.
    pub object_from_tcp: Pose,
    /// Opening of the gripper before it closes, metres.
    pub aperture_m: f64,
    /// Turn about Λ's z axis from the grasp as given, radians.
    pub yaw_rad: f64,
}

/// A grasp found in a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloudGrasp {
    /// Tool pose in the cloud's frame: the tool point lies between the contacts.
    pub cloud_from_tcp: Pose,
    /// Width between the contacts, metres.
    pub width_m: f64,
    /// Cosine of the worse angle between closing direction and contact normal: 1 is best.
    pub score: f64,
}

impl GraspCandidate {
    /// Tool pose in the frame in which the object stands at `base_from_object`.
    pub fn base_from_tcp(&self, base_from_object: &Pose) -> Pose {
        base_from_object * self.object_from_tcp
    }
}

/// Candidates of a class grasp: itself, and if it may be turned about Λ's z axis, `n_yaws` evenly spread turns of it.
pub fn expand_grasp(grasp: &Grasp, n_yaws: usize) -> Vec<GraspCandidate> {
    let n_yaws = if grasp.yaw_symmetric {
        n_yaws.max(1)
    } else {
        1
    };
    (0..n_yaws)
        .map(|i| {
            let yaw_rad = TAU * i as f64 / n_yaws as f64;
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
            GraspCandidate {
                name: grasp.name.clone(),
                object_from_tcp: turn * grasp.object_from_tcp(),
                aperture_m: grasp.aperture_m,
                yaw_rad,
            }
        })
        .collect()
}

/// The tool pose `distance_m` before a grasp: back along the approach direction.
pub fn pregrasp(base_from_tcp: &Pose, distance_m: f64) -> Pose {
    base_from_tcp * Translation3::new(0.0, 0.0, -distance_m)
}

/// The tool pose to retreat to with a held object: back along the approach direction, then up.
pub fn retreat(base_from_tcp: &Pose, back_m: f64, up_m: f64) -> Pose {
    Translation3::new(0.0, 0.0, up_m) * pregrasp(base_from_tcp, back_m)
}

/// The same grasp of a two-finger gripper with the fingers swapped: half a turn about the approach direction.
pub fn with_fingers_swapped(base_from_tcp: &Pose) -> Pose {
    let half_turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI);
    base_from_tcp * half_turn
}

#[cfg(test)]
mod principal_tests;
#[cfg(test)]
mod tests;
