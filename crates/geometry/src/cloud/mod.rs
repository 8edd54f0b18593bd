//! Point clouds, with or without surface normals.

mod nearest;
mod normals;
pub mod ply;
mod voxel;

pub use nearest::NearestPoints;
pub use normals::NormalsError;

use crate::Pose;
use nalgebra::{Point3, Unit, Vector3};

/// Points in one frame (m), each with a unit normal or none of them with one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloud {
    points: Vec<Point3<f64>>,
    normals: Option<Vec<Unit<Vector3<f64>>>>,
}

/// Normals that do not belong to the points.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("cloud has {n_points} points but {n_normals} normals")]
pub struct NormalCountError {
    /// Points there are.
    pub n_points: usize,
    /// Normals given.
    pub n_normals: usize,
}

impl PointCloud {
    /// A cloud without normals.
    #[must_use]
    pub fn new(points: Vec<Point3<f64>>) -> Self {
        Self {
            points,
            normals: None,
        }
    }

    /// A cloud with a normal at each point.
    ///
    /// # Errors
    /// [`NormalCountError`] when there is not one normal a point.
    pub fn with_normals(
        points: Vec<Point3<f64>>,
        normals: Vec<Unit<Vector3<f64>>>,
    ) -> Result<Self, NormalCountError> {
        if points.len() == normals.len() {
            Ok(Self {
                points,
                normals: Some(normals),
            })
        } else {
            Err(NormalCountError {
                n_points: points.len(),
                n_normals: normals.len(),
            })
        }
    }

    /// The points (m).
    #[must_use]
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// The normals, one a point, if the cloud has any.
    #[must_use]
    pub fn normals(&self) -> Option<&[Unit<Vector3<f64>>]> {
        self.normals.as_deref()
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The same cloud seen from another frame: `target_from_source` applied to points and normals.
    #[must_use]
    pub fn transformed(&self, target_from_source: &Pose) -> Self {
        Self {
            points: self.points.iter().map(|p| target_from_source * p).collect(),
            normals: self.normals.as_ref().map(|normals| {
                normals
                    .iter()
                    .map(|n| target_from_source.rotation * n)
                    .collect()
            }),
        }
    }

    /// Mean of the points, or nothing when there is none.
    #[must_use]
    pub fn centroid(&self) -> Option<Point3<f64>> {
        if self.is_empty() {
            return None;
        }
        let sum = self
            .points
            .iter()
            .fold(Vector3::zeros(), |sum, p| sum + p.coords);
        Some(Point3::from(sum / self.len() as f64))
    }

    /// Lowest and highest corner of the axis-aligned box around the points, or nothing when there is none.
    #[must_use]
    pub fn bounds(&self) -> Option<(Point3<f64>, Point3<f64>)> {
        let first = *self.points.first()?;
        Some(
            self.points
                .iter()
                .fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))),
        )
    }

    /// The points (with their normals) at the given indices, in that order.
    ///
    /// # Panics
    /// When an index is past the end.
    #[must_use]
    pub fn select(&self, indices: &[usize]) -> Self {
        Self {
            points: indices.iter().map(|&i| self.points[i]).collect(),
            normals: self
                .normals
                .as_ref()
                .map(|normals| indices.iter().map(|&i| normals[i]).collect()),
        }
    }

    /// The points (with their normals) for which `keep` holds, in order.
    #[must_use]
    pub fn filtered(&self, mut keep: impl FnMut(&Point3<f64>) -> bool) -> Self {
        let indices: Vec<usize> = (0..self.len()).filter(|&i| keep(&self.points[i])).collect();
        self.select(&indices)
    }

    /// Both clouds one after the other; normals are kept only when both have them (an empty cloud always fits).
    #[must_use]
    pub fn merged(mut self, other: Self) -> Self {
        if self.is_empty() {
            return other;
        }
        if other.is_empty() {
            return self;
        }
        self.normals = match (self.normals.take(), other.normals) {
            (Some(mut mine), Some(theirs)) => {
                mine.extend(theirs);
                Some(mine)
            }
            _ => None,
        };
        self.points.extend(other.points);
        self
    }
}

#[cfg(test)]
mod tests;
