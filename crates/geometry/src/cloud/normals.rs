//! Surface normals by principal components of the neighbourhood (Hoppe et al., "Surface Reconstruction
//! from Unorganized Points", SIGGRAPH 1992, section 3.1), turned towards the viewpoint that saw the surface.

use super::{NearestPoints, PointCloud};
use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// Neighbourhoods from which no plane can be fitted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NormalsError {
    /// A plane needs three points.
    #[error(
        "normals asked from {n_neighbours} neighbours of {n_points} points, expected at least 3 of each"
    )]
    TooFewPoints {
        /// Neighbours asked for.
        n_neighbours: usize,
        /// Points there are.
        n_points: usize,
    },
}

impl PointCloud {
    /// The same points with normals fitted to `n_neighbours` neighbours (the point included), each turned
    /// to the side of `viewpoint` (same frame as the points).
    ///
    /// Where the neighbours lie on one line or point, the normal is the direction to the viewpoint.
    ///
    /// # Errors
    /// [`NormalsError::TooFewPoints`] with fewer than three points or neighbours.
    pub fn with_estimated_normals(
        &self,
        n_neighbours: usize,
        viewpoint: &Point3<f64>,
    ) -> Result<Self, NormalsError> {
        let n_points = self.len();
        if n_neighbours < 3 || n_points < 3 {
            return Err(NormalsError::TooFewPoints {
                n_neighbours,
                n_points,
            });
        }
        let tree = NearestPoints::new(&self.points);
        let normals = self
            .points
            .iter()
            .map(|point| {
                let neighbours = tree.nearest_k(point, n_neighbours);
                let to_viewpoint = viewpoint - point;
                let normal = plane_normal(neighbours.iter().map(|&i| &self.points[i]))
                    .or_else(|| Unit::try_new(to_viewpoint, f64::EPSILON))
                    .unwrap_or_else(Vector3::z_axis);
                if normal.dot(&to_viewpoint) < 0.0 {
                    -normal
                } else {
                    normal
                }
            })
            .collect();
        Ok(Self {
            points: self.points.clone(),
            normals: Some(normals),
        })
    }
}

/// Ratio of middle to largest variance below which points lie on a line rather than in a plane.
const LINE_VARIANCE_RATIO: f64 = 1e-9;

/// Direction of least variance of the points, or nothing when they do not span a plane.
fn plane_normal<'a>(
    points: impl Iterator<Item = &'a Point3<f64>> + Clone,
) -> Option<Unit<Vector3<f64>>> {
    let n = points.clone().count() as f64;
    let mean = points
        .clone()
        .fold(Vector3::zeros(), |sum, p| sum + p.coords)
        / n;
    let covariance = points.fold(Matrix3::zeros(), |sum, p| {
        let d = p.coords - mean;
        sum + d * d.transpose()
    });
    let eigen = covariance.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let [least, middle, most] = order;
    let spans_plane = eigen.eigenvalues[middle] > LINE_VARIANCE_RATIO * eigen.eigenvalues[most];
    if !spans_plane {
        return None;
    }
    Unit::try_new(eigen.eigenvectors.column(least).into_owned(), f64::EPSILON)
}
