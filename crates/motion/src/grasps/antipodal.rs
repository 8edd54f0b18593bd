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

use factotum_geometry::cloud::{NearestPoints, PointCloud};
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use rand::{Rng, RngExt as _};

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

/// A grasp found in a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloudGrasp {
    /// Tool pose in the cloud's frame: the tool point lies midway between the contacts.
    pub cloud_from_tcp: Pose,
    /// Width between the contacts, metres.
    pub width_m: f64,
    /// Cosine of the worse angle between closing direction and contact normal: 1 is best.
    pub score: f64,
}

/// Grasps at random points of the cloud, best first; none if the cloud has no normals.
pub fn antipodal_grasps(
    cloud: &PointCloud,
    options: &AntipodalOptions,
    rng: &mut impl Rng,
) -> Vec<CloudGrasp> {
    let Some(normals) = cloud.normals().filter(|_| !cloud.is_empty()) else {
        return Vec::new();
    };
    let surface = Surface {
        points: cloud.points(),
        normals,
        nearest: NearestPoints::new(cloud.points()),
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

struct Surface<'a> {
    points: &'a [Point3<f64>],
    normals: &'a [Unit<Vector3<f64>>],
    nearest: NearestPoints,
}

/// Directions of a hand: closing, across and approach are the axes of the tool frame.
struct Hand {
    closing: Vector3<f64>,
    across: Vector3<f64>,
    approach: Vector3<f64>,
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
        Some(Hand {
            closing,
            across: approach.cross(&closing),
            approach,
        })
    }

    /// Closes the fingers about a surface point, and says where they meet the surface.
    fn close(
        &self,
        point: &Point3<f64>,
        hand: &Hand,
        options: &AntipodalOptions,
    ) -> Option<CloudGrasp> {
        // 1. What lies between the fingers, as coordinates in the hand.
        let reach = options.aperture_max_m.hypot(options.depth_m);
        let mut ends: [Option<(f64, usize)>; 2] = [None, None];
        for idx in self.nearest.within(point, reach) {
            let offset = self.points[idx] - point;
            let along = offset.dot(&hand.approach);
            let is_between = offset.dot(&hand.across).abs() <= options.finger_half_width_m
                && (-0.5 * options.depth_m..=options.depth_m).contains(&along);
            if !is_between {
                continue;
            }
            let x = offset.dot(&hand.closing);
            if ends[0].is_none_or(|(low, _)| x < low) {
                ends[0] = Some((x, idx));
            }
            if ends[1].is_none_or(|(high, _)| x > high) {
                ends[1] = Some((x, idx));
            }
        }
        // 2. The fingers meet the outermost points: these must fit and face away from each other.
        let [Some((low, low_idx)), Some((high, high_idx))] = ends else {
            return None;
        };
        let width_m = high - low;
        let facing_low = -self.normals[low_idx].dot(&hand.closing);
        let facing_high = self.normals[high_idx].dot(&hand.closing);
        let score = facing_low.min(facing_high);
        const WIDTH_MIN_M: f64 = 0.002;
        let fits = (WIDTH_MIN_M..=options.aperture_max_m).contains(&width_m);
        if !fits || score < options.friction_angle_rad.cos() {
            return None;
        }
        // 3. The tool point midway between the contacts.
        let middle = point.coords + hand.closing * (0.5 * (low + high));
        let depth = {
            let contact = |idx: usize| (self.points[idx] - point).dot(&hand.approach);
            0.5 * (contact(low_idx) + contact(high_idx))
        };
        let axes = Matrix3::from_columns(&[hand.closing, hand.across, hand.approach]);
        let rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let position = Translation3::from(middle + hand.approach * depth);
        Some(CloudGrasp {
            cloud_from_tcp: Pose::from_parts(position, rotation),
            width_m,
            score,
        })
    }
}
