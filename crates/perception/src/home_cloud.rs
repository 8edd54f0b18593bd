//! The home's point cloud in the map frame, one mean point a voxel, built from depth images.
//!
//! What a later image sees through is there no more, or never was: things are moved, depth is noisy from afar, and
//! the robot's own pose was known less well then.

use crate::detect::depth_at;
use crate::sensing::DepthFrame;
use factotum_geometry::Pose;
use factotum_geometry::cloud::PointCloud;
use nalgebra::{Point2, Point3, Vector3};
use std::collections::BTreeMap;

/// A cloud in the making.
#[derive(Debug, Clone)]
pub struct HomeCloud {
    voxel_m: f64,
    distance_max_m: f64,
    n_voxels_max: usize,
    voxels: BTreeMap<[i32; 3], Voxel>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Voxel {
    n_points: u32,
    mean: Vector3<f64>,
}

impl HomeCloud {
    /// Most voxels kept: a home of 200 m² at 3 cm has about a million.
    pub const N_VOXELS_MAX: usize = 2_000_000;

    /// An empty cloud with voxels of edge `voxel_m` (at least a millimetre); points farther than
    /// `distance_max_m` from the camera are not used, since depth is poor there.
    #[must_use]
    pub fn new(voxel_m: f64, distance_max_m: f64) -> Self {
        Self {
            voxel_m: voxel_m.max(1e-3),
            distance_max_m,
            n_voxels_max: Self::N_VOXELS_MAX,
            voxels: BTreeMap::new(),
        }
    }

    /// A cloud that goes on from a stored one, each of whose points counts as seen once.
    #[must_use]
    pub fn from_cloud(voxel_m: f64, distance_max_m: f64, stored: &PointCloud) -> Self {
        let mut cloud = Self::new(voxel_m, distance_max_m);
        for point in stored.points() {
            cloud.add_point(point);
        }
        cloud
    }

    /// Adds an image taken at `map_from_base`, and removes what it sees through; `keep(label)` chooses what belongs to
    /// the home.
    ///
    /// Returns how many points were added. Once the most voxels are in use, known ones are still refined.
    pub fn add(
        &mut self,
        map_from_base: &Pose,
        frame: &DepthFrame,
        keep: impl Fn(u16) -> bool,
    ) -> usize {
        self.remove_seen_through(map_from_base, frame);
        let camera = Point3::from(frame.base_from_optical.translation.vector);
        let mut n_added = 0;
        for point in frame.cloud_in_base(keep).points() {
            if (point - camera).norm() > self.distance_max_m {
                continue;
            }
            n_added += usize::from(self.add_point(&(map_from_base * point)));
        }
        n_added
    }

    fn remove_seen_through(&mut self, map_from_base: &Pose, frame: &DepthFrame) {
        /// Surfaces are known no better than this, metres, and metres per metre of distance.
        const MARGIN: (f64, f64) = (0.03, 0.01);
        let map_from_optical = map_from_base * frame.base_from_optical;
        let optical_from_map = map_from_optical.inverse();
        let place = Point2::from(map_from_optical.translation.vector.xy());
        let is_seen_through = |voxel: &Voxel| {
            let point = optical_from_map * Point3::from(voxel.mean);
            let margin_m = MARGIN.0 + MARGIN.1 * point.z;
            point.z < self.distance_max_m
                && surroundings(frame, &point)
                    .is_some_and(|nearest_m| nearest_m > point.z + margin_m)
        };
        let gone: Vec<[i32; 3]> = self
            .voxels_near(&place, self.distance_max_m)
            .filter(|(_, voxel)| is_seen_through(voxel))
            .map(|(key, _)| *key)
            .collect();
        for key in gone {
            self.voxels.remove(&key);
        }
    }

    /// Adds a point of the map, if there is room for it.
    fn add_point(&mut self, point: &Point3<f64>) -> bool {
        if !point.iter().all(|v| v.is_finite()) {
            return false;
        }
        let key = [point.x, point.y, point.z].map(|v| (v / self.voxel_m).floor() as i32);
        if self.voxels.len() >= self.n_voxels_max && !self.voxels.contains_key(&key) {
            return false;
        }
        let voxel = self.voxels.entry(key).or_default();
        voxel.n_points = voxel.n_points.saturating_add(1);
        voxel.mean += (point.coords - voxel.mean) / f64::from(voxel.n_points);
        true
    }

    /// The points of all voxels within about `radius_m` of a place, seen from above, in order of their places: none that
    /// is nearer is left out.
    pub fn near(
        &self,
        place: &Point2<f64>,
        radius_m: f64,
    ) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.voxels_near(place, radius_m)
            .map(|(_, voxel)| Point3::from(voxel.mean))
    }

    fn voxels_near(
        &self,
        place: &Point2<f64>,
        radius_m: f64,
    ) -> impl Iterator<Item = (&[i32; 3], &Voxel)> + '_ {
        let index = |coordinate_m: f64| (coordinate_m / self.voxel_m).floor() as i32;
        let [first, last] =
            [-radius_m, radius_m].map(|reach_m| [place.x, place.y].map(|v| index(v + reach_m)));
        self.voxels
            .range([first[0], i32::MIN, i32::MIN]..=[last[0], i32::MAX, i32::MAX])
            .filter(move |(key, _)| (first[1]..=last[1]).contains(&key[1]))
    }

    /// Number of voxels with points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.voxels.len()
    }

    /// Whether there is no point yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.voxels.is_empty()
    }

    /// The cloud: voxels seen by at least `n_points_min` points, in order of their places.
    #[must_use]
    pub fn to_cloud(&self, n_points_min: u32) -> PointCloud {
        let kept = self
            .voxels
            .values()
            .filter(|voxel| voxel.n_points >= n_points_min);
        PointCloud::new(kept.map(|voxel| Point3::from(voxel.mean)).collect())
    }
}

/// The least depth measured at a point of the optical frame and right around it (m): thin things fill no pixel. Nothing
/// if the point is out of the image, or one of these pixels measured nothing.
fn surroundings(frame: &DepthFrame, point_in_optical: &Point3<f64>) -> Option<f64> {
    let pixel = [1.0 / frame.fx, 1.0 / frame.fy].map(|angle| angle * point_in_optical.z);
    let mut least_m = f64::INFINITY;
    for right in [-1.0, 0.0, 1.0] {
        for down in [-1.0, 0.0, 1.0] {
            let offset = Vector3::new(right * pixel[0], down * pixel[1], 0.0);
            least_m = least_m.min(depth_at(frame, &(point_in_optical + offset))?);
        }
    }
    Some(least_m)
}

#[cfg(test)]
mod tests;
