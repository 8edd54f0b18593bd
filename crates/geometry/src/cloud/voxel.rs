//! Thinning a cloud to one point a voxel.

use super::PointCloud;
use nalgebra::{Point3, Unit, Vector3};
use std::collections::BTreeMap;

#[derive(Default)]
struct Voxel {
    n_points: f64,
    point_sum: Vector3<f64>,
    normal_sum: Vector3<f64>,
    first_normal: Option<Unit<Vector3<f64>>>,
}

impl PointCloud {
    /// The mean point (and mean normal) of each occupied voxel, in order of the voxels' (x, y, z) places.
    ///
    /// Points that are not finite are dropped. The result does not depend on the order of the points but
    /// for rounding. An edge that is not positive returns the cloud as it is.
    #[must_use]
    pub fn voxel_downsampled(&self, edge_m: f64) -> Self {
        if !(edge_m.is_finite() && edge_m > 0.0) {
            return self.clone();
        }
        let mut voxels: BTreeMap<[i64; 3], Voxel> = BTreeMap::new();
        for (i, point) in self.points.iter().enumerate() {
            if !point.iter().all(|v| v.is_finite()) {
                continue;
            }
            let voxel = voxels.entry(voxel_key(point, edge_m)).or_default();
            voxel.n_points += 1.0;
            voxel.point_sum += point.coords;
            if let Some(normal) = self.normals.as_ref().map(|normals| normals[i]) {
                voxel.normal_sum += normal.into_inner();
                voxel.first_normal.get_or_insert(normal);
            }
        }
        let points = voxels
            .values()
            .map(|voxel| Point3::from(voxel.point_sum / voxel.n_points))
            .collect();
        let normals = self.normals.as_ref().map(|_| {
            // Opposite normals (two sides of a thin sheet) may cancel: keep the first one then.
            voxels
                .values()
                .filter_map(|voxel| Unit::try_new(voxel.normal_sum, 1e-6).or(voxel.first_normal))
                .collect()
        });
        Self { points, normals }
    }
}

/// Place of the voxel of edge `edge_m` that holds a finite point.
fn voxel_key(point: &Point3<f64>, edge_m: f64) -> [i64; 3] {
    [point.x, point.y, point.z].map(|v| (v / edge_m).floor() as i64)
}
