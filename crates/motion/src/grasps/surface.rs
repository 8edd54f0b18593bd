//! A cloud with normals, as a hand that is about to close meets it.

use factotum_geometry::cloud::{NearestPoints, PointCloud};
use nalgebra::{Matrix3, Point3, Rotation3, Unit, UnitQuaternion, Vector3};

pub(super) struct Surface<'a> {
    pub(super) points: &'a [Point3<f64>],
    pub(super) normals: &'a [Unit<Vector3<f64>>],
    pub(super) nearest: NearestPoints,
}

/// Directions of a hand: closing, across and approach are the axes of the tool frame.
pub(super) struct Hand {
    pub(super) closing: Vector3<f64>,
    pub(super) across: Vector3<f64>,
    pub(super) approach: Vector3<f64>,
}

impl Hand {
    pub(super) fn new(closing: Vector3<f64>, approach: Vector3<f64>) -> Self {
        Self {
            closing,
            across: approach.cross(&closing),
            approach,
        }
    }

    pub(super) fn rotation(&self) -> UnitQuaternion<f64> {
        let axes = Matrix3::from_columns(&[self.closing, self.across, self.approach]);
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
    }
}

/// The room between the fingers about a point that they close on.
pub(super) struct Gap {
    /// How far from the point surfaces are looked for, metres.
    pub(super) reach_m: f64,
    /// How far the fingers reach behind the point, and half as far before it, metres.
    pub(super) depth_m: f64,
    /// Half the width of a finger across closing and approach direction, metres.
    pub(super) finger_half_width_m: f64,
}

/// The outermost points between the fingers.
pub(super) struct Contacts {
    /// Where they lie along the closing direction from the point, metres.
    pub(super) along_m: [f64; 2],
    pub(super) idx: [usize; 2],
    /// Cosine of the worse angle between closing direction and normal.
    pub(super) score: f64,
}

impl Contacts {
    pub(super) fn width_m(&self) -> f64 {
        self.along_m[1] - self.along_m[0]
    }
}

impl<'a> Surface<'a> {
    /// Nothing if the cloud is empty or has no normals.
    pub(super) fn new(cloud: &'a PointCloud) -> Option<Self> {
        let normals = cloud.normals().filter(|_| !cloud.is_empty())?;
        Some(Self {
            points: cloud.points(),
            normals,
            nearest: NearestPoints::new(cloud.points()),
        })
    }

    /// What the fingers meet when they close about a point; nothing if there is nothing between them.
    pub(super) fn contacts(&self, point: &Point3<f64>, hand: &Hand, gap: &Gap) -> Option<Contacts> {
        let mut ends: [Option<(f64, usize)>; 2] = [None, None];
        for idx in self.nearest.within(point, gap.reach_m) {
            let offset = self.points[idx] - point;
            let along = offset.dot(&hand.approach);
            let is_between = offset.dot(&hand.across).abs() <= gap.finger_half_width_m
                && (-0.5 * gap.depth_m..=gap.depth_m).contains(&along);
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
        let [Some((low, low_idx)), Some((high, high_idx))] = ends else {
            return None;
        };
        let facing_low = -self.normals[low_idx].dot(&hand.closing);
        let facing_high = self.normals[high_idx].dot(&hand.closing);
        Some(Contacts {
            along_m: [low, high],
            idx: [low_idx, high_idx],
            score: facing_low.min(facing_high),
        })
    }
}
