//! What a planar lidar and a depth camera deliver, whoever makes them.

use crate::cloud::PointCloud;
use crate::{Pose, Pose2};
use nalgebra::{Point2, Point3};

/// One sweep of a planar lidar.
///
/// Ray `i` points at `angle_min_rad + i * angle_step_rad` in the lidar's frame (counter-clockwise, 0 = x axis).
#[derive(Debug, Clone, PartialEq)]
pub struct LaserScan {
    /// Direction of the first ray (rad).
    pub angle_min_rad: f64,
    /// Angle from one ray to the next (rad).
    pub angle_step_rad: f64,
    /// Distance to the first surface along each ray (m); infinite where nothing returned within the range.
    pub ranges_m: Vec<f64>,
    /// Shortest distance the lidar can measure (m); shorter readings are dropped.
    pub range_min_m: f64,
    /// Longest distance the lidar can measure (m).
    pub range_max_m: f64,
    /// Where the lidar sits on the robot, in the plane.
    pub base_from_lidar: Pose2,
}

/// One valid ray of a [`LaserScan`], in the robot's base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanRay {
    /// End of the ray: the surface, or the end of the range where nothing returned (m).
    pub end_in_base: Point2<f64>,
    /// Whether a surface is there.
    pub is_hit: bool,
}

impl LaserScan {
    /// Position of the lidar in the base frame.
    #[must_use]
    pub fn origin_in_base(&self) -> Point2<f64> {
        Point2::from(self.base_from_lidar.translation.vector)
    }

    /// The usable rays, in order: NaN, negative and too short readings are dropped, readings at or beyond
    /// `range_max_m` become rays without a hit.
    pub fn rays(&self) -> impl Iterator<Item = ScanRay> + '_ {
        self.ranges_m
            .iter()
            .enumerate()
            .filter_map(|(i, &range_m)| {
                if range_m.is_nan() || range_m < self.range_min_m {
                    return None;
                }
                let is_hit = range_m < self.range_max_m;
                let length_m = range_m.min(self.range_max_m);
                let (sin, cos) = (self.angle_min_rad + i as f64 * self.angle_step_rad).sin_cos();
                let end_in_base =
                    self.base_from_lidar * Point2::new(length_m * cos, length_m * sin);
                Some(ScanRay {
                    end_in_base,
                    is_hit,
                })
            })
    }

    /// The surfaces seen, in the base frame (m).
    #[must_use]
    pub fn hits_in_base(&self) -> Vec<Point2<f64>> {
        self.rays()
            .filter(|ray| ray.is_hit)
            .map(|ray| ray.end_in_base)
            .collect()
    }
}

/// One image of a depth camera with an instance segmenter behind it. Images are row-major, row 0 on top.
///
/// Pinhole: pixel (u, v) at depth d is the point `((u - cx) d / fx, (v - cy) d / fy, d)` of the optical
/// frame (z forward, x right, y down).
#[derive(Debug, Clone, PartialEq)]
pub struct DepthFrame {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Focal length along columns (pixels).
    pub fx: f64,
    /// Focal length along rows (pixels).
    pub fy: f64,
    /// Column of the optical axis (pixels; pixel centres are whole numbers).
    pub cx: f64,
    /// Row of the optical axis (pixels).
    pub cy: f64,
    /// Depth along the optical axis per pixel (m); 0, negative, NaN or infinite where nothing was measured.
    pub depth_m: Vec<f32>,
    /// Instance label per pixel, 0 for none; empty when there is no segmenter.
    pub labels: Vec<u16>,
    /// Class name of label `i + 1`. Two instances of one class have two labels.
    pub label_classes: Vec<String>,
    /// Where the camera sits on the robot, as an optical frame.
    pub base_from_optical: Pose,
}

/// A [`DepthFrame`] whose parts contradict each other.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthFrameError {
    /// An image has the wrong number of pixels.
    #[error("depth frame `{image}` has {found} pixels, expected {width} x {height} = {wanted}")]
    PixelCount {
        /// `depth_m` or `labels`.
        image: &'static str,
        /// Pixels there are.
        found: usize,
        /// Pixels there should be.
        wanted: usize,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// The focal length cannot project.
    #[error("depth frame has focal lengths ({fx}, {fy}), expected both positive and finite")]
    FocalLength {
        /// Along columns.
        fx: f64,
        /// Along rows.
        fy: f64,
    },
    /// A label has no class.
    #[error("depth frame has label {label} at pixel {pixel}, but names {n_classes} classes")]
    LabelWithoutClass {
        /// The label.
        label: u16,
        /// Where it was first seen (row-major index).
        pixel: usize,
        /// How many classes are named.
        n_classes: usize,
    },
}

impl DepthFrame {
    /// Checks that images, labels and camera agree.
    ///
    /// # Errors
    /// The first contradiction found.
    pub fn check(&self) -> Result<(), DepthFrameError> {
        let wanted = self.width * self.height;
        let images = [
            ("depth_m", self.depth_m.len(), false),
            ("labels", self.labels.len(), self.labels.is_empty()),
        ];
        for (image, found, absent) in images {
            if found != wanted && !absent {
                let (width, height) = (self.width, self.height);
                return Err(DepthFrameError::PixelCount {
                    image,
                    found,
                    wanted,
                    width,
                    height,
                });
            }
        }
        let focal_ok = |f: f64| f.is_finite() && f > 0.0;
        if !(focal_ok(self.fx) && focal_ok(self.fy)) {
            return Err(DepthFrameError::FocalLength {
                fx: self.fx,
                fy: self.fy,
            });
        }
        let n_classes = self.label_classes.len();
        match self
            .labels
            .iter()
            .position(|&label| usize::from(label) > n_classes)
        {
            Some(pixel) => Err(DepthFrameError::LabelWithoutClass {
                label: self.labels[pixel],
                pixel,
                n_classes,
            }),
            None => Ok(()),
        }
    }

    /// The point seen at a pixel in the optical frame, or nothing where no depth was measured.
    #[must_use]
    pub fn point_in_optical(&self, column: usize, row: usize) -> Option<Point3<f64>> {
        if column >= self.width {
            return None;
        }
        let depth_m = f64::from(*self.depth_m.get(row * self.width + column)?);
        if !depth_m.is_finite() || depth_m <= 0.0 {
            return None;
        }
        Some(Point3::new(
            (column as f64 - self.cx) * depth_m / self.fx,
            (row as f64 - self.cy) * depth_m / self.fy,
            depth_m,
        ))
    }

    /// Everything seen, as a cloud in the base frame; pixels where `keep(label)` is false are left out.
    #[must_use]
    pub fn cloud_in_base(&self, keep: impl Fn(u16) -> bool) -> PointCloud {
        let mut points = Vec::new();
        for row in 0..self.height {
            for column in 0..self.width {
                let label = self
                    .labels
                    .get(row * self.width + column)
                    .copied()
                    .unwrap_or(0);
                if !keep(label) {
                    continue;
                }
                if let Some(point) = self.point_in_optical(column, row) {
                    points.push(self.base_from_optical * point);
                }
            }
        }
        PointCloud::new(points)
    }
}

#[cfg(test)]
mod tests;
