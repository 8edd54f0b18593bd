//! What is around the arm, from what the camera has seen: points become boxes that a planning scene can hold.

use std::collections::BTreeSet;

use factotum_geometry::Pose;
use factotum_motion::{Obstacle, ObstacleShape};
use nalgebra::{Isometry3, Point3, Vector3};

/// Edge of a voxel, metres: fine enough for a hand between a table and a shelf, coarse enough for a few hundred boxes.
const VOXEL_M: f64 = 0.04;
/// Points lower than this are the floor, metres.
const FLOOR_M: f64 = 0.04;
/// Points farther than this from the base are out of the arm's reach, metres.
const REACH_M: f64 = 1.5;

/// Boxes that cover the points, in the base frame.
///
/// Voxels that follow each other upwards become columns, and equal columns that follow each other along x become one
/// box, so a table top is a few slabs rather than hundreds of cubes.
pub(crate) fn obstacles_from_points(points_in_base: &[Point3<f64>]) -> Vec<Obstacle> {
    let voxels: BTreeSet<(i64, i64, i64)> = points_in_base
        .iter()
        .filter(|point| point.z > FLOOR_M && point.xy().coords.norm() < REACH_M)
        .map(|point| (index(point.y), index(point.x), index(point.z)))
        .collect();
    let mut boxes: Vec<Slab> = Vec::new();
    for run in columns(&voxels) {
        let extends = |slab: &&mut Slab| slab.y == run.y && slab.x_last + 1 == run.x_first && slab.z == run.z;
        match boxes.iter_mut().rev().take(64).find(extends) {
            Some(slab) => slab.x_last = run.x_first,
            None => boxes.push(run),
        }
    }
    boxes.iter().enumerate().map(|(number, slab)| slab.as_obstacle(number)).collect()
}

fn index(coordinate_m: f64) -> i64 {
    (coordinate_m / VOXEL_M).floor() as i64
}

/// A box of voxels one voxel wide in y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Slab {
    y: i64,
    x_first: i64,
    x_last: i64,
    z: (i64, i64),
}

impl Slab {
    fn as_obstacle(&self, number: usize) -> Obstacle {
        let lower = Vector3::new(self.x_first as f64, self.y as f64, self.z.0 as f64) * VOXEL_M;
        let upper = Vector3::new((self.x_last + 1) as f64, (self.y + 1) as f64, (self.z.1 + 1) as f64) * VOXEL_M;
        let middle = (lower + upper) / 2.0;
        Obstacle {
            name: format!("seen_{number}"),
            shape: ObstacleShape::Box { half_extents_m: ((upper - lower) / 2.0).into() },
            base_from_obstacle: Isometry3::translation(middle.x, middle.y, middle.z),
        }
    }
}

/// Runs of voxels that follow each other upwards, in the order of the voxels.
fn columns(voxels: &BTreeSet<(i64, i64, i64)>) -> Vec<Slab> {
    let mut runs: Vec<Slab> = Vec::new();
    for &(y, x, z) in voxels {
        match runs.last_mut() {
            Some(run) if run.y == y && run.x_first == x && run.z.1 + 1 == z => run.z.1 = z,
            _ => runs.push(Slab { y, x_first: x, x_last: x, z: (z, z) }),
        }
    }
    runs
}

/// Drops the points of an object that is known to stand at `base_from_object`; what it stands on stays.
pub(crate) fn without_object(
    points: &mut Vec<Point3<f64>>,
    base_from_object: &Pose,
    radius_m: f64,
    is_standing: bool,
) {
    /// Points lower than this above Λ of a standing object belong to what it stands on, metres.
    const SUPPORT_M: f64 = 0.02;
    let at = base_from_object.translation.vector;
    points.retain(|point| {
        let from = point.coords - at;
        if is_standing { from.xy().norm() > radius_m || from.z < SUPPORT_M } else { from.norm() > radius_m }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_patch_becomes_few_slabs_that_cover_it() {
        let patch: Vec<Point3<f64>> = (0..40)
            .flat_map(|i| (0..40).map(move |j| Point3::new(0.4 + 0.01 * f64::from(i), -0.2 + 0.01 * f64::from(j), 0.75)))
            .collect();
        let boxes = obstacles_from_points(&patch);
        assert!(boxes.len() <= 12, "{} boxes for a 0.4 m patch", boxes.len());
        for point in &patch {
            let covered = boxes.iter().any(|obstacle| {
                let ObstacleShape::Box { half_extents_m } = &obstacle.shape else { return false };
                let local = obstacle.base_from_obstacle.inverse() * point;
                (0..3).all(|i| local[i].abs() <= half_extents_m[i] + 1e-9)
            });
            assert!(covered, "{point} is not covered");
        }
    }

    #[test]
    fn the_floor_and_the_far_wall_are_no_obstacles_of_the_arm() {
        assert!(obstacles_from_points(&[Point3::new(0.5, 0.0, 0.01), Point3::new(3.0, 0.0, 1.0)]).is_empty());
    }
}
