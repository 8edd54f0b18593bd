//! Grasps from a point cloud with normals.
//!
//! Method: after ten Pas & Platt, "Using Geometry to Detect Grasp Poses in 3D Point Clouds", ISRR 2015: at a random
//! surface point the hand approaches against the mean normal of the neighbourhood and closes along the direction in
//! which the surface bends most; a grasp is kept when the fingers meet surfaces that face each other (antipodal:
//! both normals within the friction cone of the closing direction) and that fit between the fingers.
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | a | approach: minus the mean normal | - |
//! | c | closing direction: across a, along the largest variation of the normals | - |

use factotum_geometry::cloud::PointCloud;
use nalgebra::{Matrix3, Point3, Translation3, Vector3};
use rand::{Rng, RngExt as _};

use super::CloudGrasp;
use super::surface::{Gap, Hand, Surface};
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
    /// How far the fingers reach behind the surface point, metres.
    pub depth_m: f64,
    /// Half the width of a finger across closing and approach direction, metres.
    pub finger_half_width_m: f64,
}

impl Default for AntipodalOptions {
    fn default() -> Self {
        Self {
            n_grasps: 50,
            n_samples: 1_000,
            radius_m: 0.03,
            aperture_max_m: 0.08,
            friction_angle_rad: 20_f64.to_radians(),
            depth_m: 0.04,
            finger_half_width_m: 0.01,
        }
    }
}

/// Grasps at random points of the cloud, best first; none if the cloud has no normals.
pub fn antipodal_grasps(
    cloud: &PointCloud,
    options: &AntipodalOptions,
    rng: &mut impl Rng,
) -> Vec<CloudGrasp> {
    let Some(surface) = Surface::new(cloud) else {
        return Vec::new();
    };
    let mut grasps = Vec::new();
    for _ in 0..options.n_samples {
        if grasps.len() >= options.n_grasps {
            break;
        }
        let idx = rng.random_range(0..surface.points.len());
        let grasp = surface
            .hand_at(&surface.points[idx], options.radius_m)
            .and_then(|hand| surface.close(&surface.points[idx], &hand, options));
        grasps.extend(grasp);
    }
    grasps.sort_by(|a, b| b.score.total_cmp(&a.score));
    grasps
}

impl Surface<'_> {
    /// The hand that fits the shape of the surface about a point; none where the surface does not bend.
    fn hand_at(&self, point: &Point3<f64>, radius_m: f64) -> Option<Hand> {
        const NEIGHBOURS_MIN: usize = 8;
        let near = self.nearest.within(point, radius_m);
        if near.len() < NEIGHBOURS_MIN {
            return None;
        }
        let centre = self
            .nearest
            .nearest(point)
            .map(|(idx, _)| self.normals[idx])?;
        // Only what faces the same side: the far wall of a thin handle is no neighbour.
        let facing: Vec<Vector3<f64>> = near
            .iter()
            .map(|&idx| self.normals[idx].into_inner())
            .filter(|normal| normal.dot(&centre) > 0.0)
            .collect();
        let mean = facing.iter().sum::<Vector3<f64>>().try_normalize(1e-9)?;
        let mut spread = Matrix3::zeros();
        for normal in &facing {
            let off = normal - mean * normal.dot(&mean);
            spread += off * off.transpose();
        }
        let eigen = spread.symmetric_eigen();
        let largest = eigen.eigenvalues.imax();
        let bend = eigen.eigenvectors.column(largest).into_owned();
        let approach = -mean;
        let closing = (bend - approach * bend.dot(&approach)).try_normalize(1e-9)?;
        Some(Hand::new(closing, approach))
    }

    /// Closes the fingers about a surface point, and says where they meet the surface.
    fn close(
        &self,
        point: &Point3<f64>,
        hand: &Hand,
        options: &AntipodalOptions,
    ) -> Option<CloudGrasp> {
        // 1. The fingers meet the outermost points: these must fit and face away from each other.
        let gap = Gap {
            reach_m: options.aperture_max_m.hypot(options.depth_m),
            depth_m: options.depth_m,
            finger_half_width_m: options.finger_half_width_m,
        };
        let contacts = self.contacts(point, hand, &gap)?;
        let width_m = contacts.width_m();
        const WIDTH_MIN_M: f64 = 0.002;
        let fits = (WIDTH_MIN_M..=options.aperture_max_m).contains(&width_m);
        if !fits || contacts.score < options.friction_angle_rad.cos() {
            return None;
        }
        // 2. The tool point midway between the contacts.
        let [low, high] = contacts.along_m;
        let middle = point.coords + hand.closing * (0.5 * (low + high));
        let depths = contacts
            .idx
            .map(|idx| (self.points[idx] - point).dot(&hand.approach));
        let depth = 0.5 * (depths[0] + depths[1]);
        let position = Translation3::from(middle + hand.approach * depth);
        Some(CloudGrasp {
            cloud_from_tcp: Pose::from_parts(position, hand.rotation()),
            width_m,
            score: contacts.score,
        })
    }
}
