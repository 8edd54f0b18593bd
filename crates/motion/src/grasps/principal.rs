//! Grasps by the principal axes of what lies about a point of a cloud.
//!
//! Method: the heuristic of ten Pas, Gualtieri, Saenko & Platt, "Grasp Pose Detection in Point Clouds", IJRR 2017, as
//! Abbatematteo's composable interaction primitives use it (thesis Chapter 3): about a random point the hand approaches
//! along the axis of least variance, against the normals, and closes along the axis of middle variance, so across the
//! longer side of a handle. The tool point goes a centimetre below the surface.
//!
//! Differs from the released code in what is kept: only grasps whose width fits the open hand (`aperture_max_m`; `None`
//! keeps all), and none about points whose neighbours lie on a line. With `centred` the tool point also moves midway
//! between the fingers' contacts, which the released code does not do: there the hand is off the handle's middle by as
//! much as the point was.

use std::f64::consts::FRAC_PI_6;

use factotum_geometry::cloud::PointCloud;
use nalgebra::{Matrix3, Translation3, Vector3};
use rand::{Rng, RngExt as _};

use super::CloudGrasp;
use super::surface::{Gap, Hand, Surface};
use crate::Pose;

/// What the generator looks for. The defaults are those of the thesis' experiments.
#[derive(Debug, Clone, PartialEq)]
pub struct PrincipalOptions {
    /// Grasps wanted.
    pub n_grasps: usize,
    /// Cap: surface points tried.
    pub n_samples: usize,
    /// Radius of the neighbourhood whose axes orient the hand, metres.
    pub radius_m: f64,
    /// Cap: nearest points taken of the neighbourhood.
    pub n_neighbours_max: usize,
    /// How far the tool point goes below the surface point, along the approach, metres.
    pub depth_m: f64,
    /// Turns about the approach at each point, radians.
    pub turns_rad: Vec<f64>,
    /// Largest width between the fingers, metres; `None` keeps whatever is wider.
    pub aperture_max_m: Option<f64>,
    /// Whether the tool point moves along the closing direction, midway between the contacts.
    pub centred: bool,
    /// Half the width of a finger across closing and approach direction, and how far its pad reaches beyond the tool
    /// point, metres.
    pub finger_half_width_m: f64,
}

impl Default for PrincipalOptions {
    fn default() -> Self {
        Self {
            n_grasps: 50,
            n_samples: 1_000,
            radius_m: 0.03,
            n_neighbours_max: 250,
            depth_m: 0.01,
            turns_rad: vec![0.0],
            aperture_max_m: Some(0.08),
            centred: false,
            finger_half_width_m: 0.01,
        }
    }
}

impl PrincipalOptions {
    /// The six turns of the heuristic as published, from -60 to 90 degrees.
    pub fn six_turns_rad() -> Vec<f64> {
        (-2..=3).map(|i| f64::from(i) * FRAC_PI_6).collect()
    }
}

/// Grasps at random points of the cloud, in the order drawn; none if the cloud has no normals.
pub fn principal_grasps(
    cloud: &PointCloud,
    options: &PrincipalOptions,
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
        let Some(hand) = surface.principal_hand(idx, options) else {
            continue;
        };
        for turn_rad in &options.turns_rad {
            grasps.extend(surface.grasp(idx, &hand.turned(*turn_rad), options));
        }
    }
    grasps.truncate(options.n_grasps);
    grasps
}

impl Hand {
    /// The hand turned about its approach direction.
    fn turned(&self, turn_rad: f64) -> Self {
        let (sin, cos) = turn_rad.sin_cos();
        Self::new(self.closing * cos + self.across * sin, self.approach)
    }
}

impl Surface<'_> {
    /// The hand along the axes of the neighbourhood of a point; none where that does not span a plane.
    pub(super) fn principal_hand(&self, idx: usize, options: &PrincipalOptions) -> Option<Hand> {
        let point = &self.points[idx];
        let near: Vec<Vector3<f64>> = self
            .nearest
            .nearest_k(point, options.n_neighbours_max)
            .into_iter()
            .map(|near| self.points[near] - point)
            .take_while(|offset| offset.norm() <= options.radius_m)
            .collect();
        let n = near.len() as f64;
        let mean = near.iter().sum::<Vector3<f64>>() / n;
        let mut covariance = Matrix3::zeros();
        for offset in &near {
            let off = offset - mean;
            covariance += off * off.transpose() / n;
        }
        let eigen = covariance.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let [least, middle, most] = order;
        /// Ratio of middle to largest variance below which points lie on a line; one point is none.
        const LINE_RATIO: f64 = 1e-9;
        let spans_plane = eigen.eigenvalues[middle] > LINE_RATIO * eigen.eigenvalues[most];
        if !spans_plane {
            return None;
        }
        let axis = |i: usize| eigen.eigenvectors.column(i).into_owned();
        let inwards = -self.normals[idx].into_inner();
        let approach = axis(least) * axis(least).dot(&inwards).signum();
        Some(Hand::new(axis(middle), approach))
    }

    /// The grasp at a point with a hand, if it fits.
    fn grasp(&self, idx: usize, hand: &Hand, options: &PrincipalOptions) -> Option<CloudGrasp> {
        let point = &self.points[idx];
        let aperture_m = options.aperture_max_m.unwrap_or(2.0 * options.radius_m);
        let gap = Gap {
            reach_m: aperture_m.hypot(options.depth_m),
            depth_m: options.depth_m + options.finger_half_width_m,
            finger_half_width_m: options.finger_half_width_m,
        };
        let contacts = self.contacts(point, hand, &gap)?;
        let width_m = contacts.width_m();
        if options.aperture_max_m.is_some_and(|most| width_m > most) {
            return None;
        }
        let sideways = if options.centred {
            0.5 * (contacts.along_m[0] + contacts.along_m[1])
        } else {
            0.0
        };
        let position = point.coords + hand.approach * options.depth_m + hand.closing * sideways;
        Some(CloudGrasp {
            cloud_from_tcp: Pose::from_parts(Translation3::from(position), hand.rotation()),
            width_m,
            score: contacts.score,
        })
    }
}
