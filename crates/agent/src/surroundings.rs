//! What is around the arm, from what the camera has seen: points become boxes that a planning scene can hold.

use std::collections::BTreeMap;

use factotum_geometry::Pose;
use factotum_geometry::cloud::NearestPoints;
use factotum_geometry::grid::{OccupancyGrid, SignedCell};
use factotum_motion::{Obstacle, ObstacleShape};
use nalgebra::{Isometry3, Point2, Point3, Vector3};

/// Edge of a voxel, metres: fine enough for a hand between a table and a shelf, coarse enough for a few hundred boxes.
const VOXEL_M: f64 = 0.05;
/// Points lower than this are the floor, metres.
const FLOOR_M: f64 = 0.04;
/// Points farther than this from the base are out of the arm's reach, metres.
const REACH_M: f64 = 1.5;

/// Boxes that cover the points, in the base frame.
///
/// Voxels that follow each other upwards become columns, and equal columns that follow each other along x become one
/// box, so a table top is a few slabs rather than hundreds of cubes. A box is no larger than its points need.
pub(crate) fn obstacles_from_points(points_in_base: &[Point3<f64>]) -> Vec<Obstacle> {
    let mut voxels: BTreeMap<(i64, i64, i64), Bounds> = BTreeMap::new();
    for point in points_in_base {
        if point.z > FLOOR_M && point.xy().coords.norm() < REACH_M {
            let key = (index(point.y), index(point.x), index(point.z));
            voxels
                .entry(key)
                .or_insert_with(|| Bounds::of(point))
                .add(point);
        }
    }
    let mut boxes: Vec<Slab> = Vec::new();
    for run in columns(&voxels) {
        let extends =
            |slab: &&mut Slab| slab.y == run.y && slab.x_last + 1 == run.x_first && slab.z == run.z;
        match boxes.iter_mut().rev().take(64).find(extends) {
            Some(slab) => {
                slab.x_last = run.x_first;
                slab.bounds.join(&run.bounds);
            }
            None => boxes.push(run),
        }
    }
    boxes
        .iter()
        .enumerate()
        .map(|(number, slab)| slab.bounds.as_obstacle(number))
        .collect()
}

fn index(coordinate_m: f64) -> i64 {
    (coordinate_m / VOXEL_M).floor() as i64
}

/// The smallest box about some points.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bounds {
    lower: Vector3<f64>,
    upper: Vector3<f64>,
}

impl Bounds {
    fn of(point: &Point3<f64>) -> Self {
        Self {
            lower: point.coords,
            upper: point.coords,
        }
    }

    fn add(&mut self, point: &Point3<f64>) {
        self.join(&Self::of(point));
    }

    fn join(&mut self, other: &Self) {
        self.lower = self.lower.inf(&other.lower);
        self.upper = self.upper.sup(&other.upper);
    }

    /// The box, a little larger than its points: between them there is surface too.
    fn as_obstacle(&self, number: usize) -> Obstacle {
        const PAD_M: f64 = 0.008;
        let middle = (self.lower + self.upper) / 2.0;
        let half = (self.upper - self.lower) / 2.0 + Vector3::repeat(PAD_M);
        Obstacle {
            name: format!("seen_{number}"),
            shape: ObstacleShape::Box {
                half_extents_m: half.into(),
            },
            base_from_obstacle: Isometry3::translation(middle.x, middle.y, middle.z),
        }
    }
}

/// A box of voxels one voxel wide in y.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Slab {
    y: i64,
    x_first: i64,
    x_last: i64,
    z: (i64, i64),
    bounds: Bounds,
}

/// Runs of voxels that follow each other upwards, in the order of the voxels.
fn columns(voxels: &BTreeMap<(i64, i64, i64), Bounds>) -> Vec<Slab> {
    let mut runs: Vec<Slab> = Vec::new();
    for (&(y, x, z), bounds) in voxels {
        match runs.last_mut() {
            Some(run) if run.y == y && run.x_first == x && run.z.1 + 1 == z => {
                run.z.1 = z;
                run.bounds.join(bounds);
            }
            _ => runs.push(Slab {
                y,
                x_first: x,
                x_last: x,
                z: (z, z),
                bounds: *bounds,
            }),
        }
    }
    runs
}

/// Points of the walls about `place` that the camera has not had in view, in the map frame: where the lidar has found
/// something, it is taken to stand as high as an arm reaches, unless `seen` (map frame) shows where it ends.
///
/// Furniture is seen from above, so its top is known; of a wall the camera sees as much as its field of view holds.
pub(crate) fn walls_beyond_view(
    grid: &OccupancyGrid,
    place: &Point2<f64>,
    seen: &[Point3<f64>],
) -> Vec<Point3<f64>> {
    /// What ends below this has been seen from above, metres.
    const EYE_M: f64 = 1.1;
    /// No arm reaches higher, metres.
    const HIGH_M: f64 = 2.0;
    let resolution_m = grid.resolution_m();
    let mut tops: BTreeMap<(i64, i64), f64> = BTreeMap::new();
    for point in seen {
        let cell = grid.signed_cell_at(&point.xy());
        let top = tops.entry((cell.column, cell.row)).or_insert(point.z);
        *top = top.max(point.z);
    }
    // What is seen of a cell may lie beside it, by the errors of lidar and camera.
    let top_about = |cell: &SignedCell| {
        let about = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy)));
        about
            .filter_map(|(dx, dy)| tops.get(&(cell.column + dx, cell.row + dy)))
            .copied()
            .reduce(f64::max)
    };
    let reach = (REACH_M / resolution_m).ceil() as i64;
    let middle = grid.signed_cell_at(place);
    let mut points = Vec::new();
    for row in middle.row - reach..=middle.row + reach {
        for column in middle.column - reach..=middle.column + reach {
            let cell = SignedCell { column, row };
            let Some(index) = grid.index_of_signed(cell) else {
                continue;
            };
            let top_m = top_about(&cell);
            if !grid.cell(index).is_occupied() || top_m.is_some_and(|top_m| top_m < EYE_M) {
                continue;
            }
            let at = grid.center_of(index);
            let mut z = top_m.unwrap_or(0.0);
            while z < HIGH_M {
                points.push(Point3::new(at.x, at.y, z));
                z += 0.5 * VOXEL_M;
            }
        }
    }
    points
}

/// Drops the points on an object that is known to stand at `base_from_object`; what it stands on stays.
pub(crate) fn without_object(
    points: &mut Vec<Point3<f64>>,
    base_from_object: &Pose,
    surface: &NearestPoints,
    is_standing: bool,
) {
    /// Points this near to where the object's surface should be are the object, metres.
    const NEAR_M: f64 = 0.05;
    /// Points lower than this above Λ of a standing object belong to what it stands on, metres.
    const SUPPORT_M: f64 = 0.015;
    points.retain(|point| {
        let in_object = base_from_object.inverse_transform_point(point);
        let is_on_it = surface.nearest_within(&in_object, NEAR_M).is_some();
        !is_on_it || (is_standing && in_object.z < SUPPORT_M)
    });
}

#[cfg(test)]
mod tests {
    use factotum_geometry::Pose2;
    use factotum_geometry::grid::Cell;
    use nalgebra::Vector2;

    use super::*;

    #[test]
    fn a_flat_patch_becomes_few_slabs_that_cover_it() {
        let patch: Vec<Point3<f64>> = (0..40)
            .flat_map(|i| {
                (0..40).map(move |j| {
                    Point3::new(0.4 + 0.01 * f64::from(i), -0.2 + 0.01 * f64::from(j), 0.75)
                })
            })
            .collect();
        let boxes = obstacles_from_points(&patch);
        assert!(boxes.len() <= 12, "{} boxes for a 0.4 m patch", boxes.len());
        for point in &patch {
            let covered = boxes.iter().any(|obstacle| {
                let ObstacleShape::Box { half_extents_m } = &obstacle.shape else {
                    return false;
                };
                let local = obstacle.base_from_obstacle.inverse() * point;
                (0..3).all(|i| local[i].abs() <= half_extents_m[i] + 1e-9)
            });
            assert!(covered, "{point} is not covered");
        }
    }

    #[test]
    fn walls_are_as_high_as_an_arm_reaches_and_furniture_as_high_as_seen() {
        let corner = Pose2::new(Vector2::new(-1.0, -1.0), 0.0);
        let mut grid = OccupancyGrid::filled(40, 40, 0.05, corner, Cell::FREE).unwrap();
        let mut occupy = |x: f64, y: f64| {
            let index = grid.index_at(&Point2::new(x, y)).unwrap();
            grid.set_cell(index, Cell::OCCUPIED);
        };
        occupy(0.51, 0.01); // never seen by the camera
        occupy(0.01, 0.51); // seen up to where its view ends
        occupy(-0.49, 0.01); // a counter, seen from above
        let seen = [Point3::new(0.0, 0.5, 1.4), Point3::new(-0.5, 0.05, 0.9)];
        let points = walls_beyond_view(&grid, &Point2::origin(), &seen);
        let lowest = |x: f64, y: f64| {
            let near = |point: &&Point3<f64>| (point.xy() - Point2::new(x, y)).norm() < 0.1;
            let heights = points.iter().filter(near).map(|point| point.z);
            heights.reduce(f64::min)
        };
        assert_eq!(lowest(0.5, 0.0), Some(0.0));
        assert_eq!(lowest(0.0, 0.5), Some(1.4));
        assert_eq!(lowest(-0.5, 0.0), None);
        assert!(points.iter().any(|point| point.z > 1.9));
    }

    #[test]
    fn the_floor_and_the_far_wall_are_no_obstacles_of_the_arm() {
        assert!(
            obstacles_from_points(&[Point3::new(0.5, 0.0, 0.01), Point3::new(3.0, 0.0, 1.0)])
                .is_empty()
        );
    }
}
