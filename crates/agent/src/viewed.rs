//! Which parts of the home the camera has had in view, as squares of the map; and how to turn to see the rest.
//!
//! What is in view is found by rays over the grid, from the base outwards until something stands in the way. The camera
//! is taken to look where the base looks.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use factotum_descriptions::Camera;
use factotum_geometry::Pose2;
use factotum_geometry::grid::OccupancyGrid;
use nalgebra::{Point2, Rotation2, Vector2};

/// The camera recognises objects up to this distance, metres.
pub(crate) const LOOK_RANGE_M: f64 = 2.8;
/// Edge of a square, metres.
const SQUARE_M: f64 = 0.4;
/// Angle between rays: at the range they are half a square apart.
const RAY_RAD: f64 = 0.07;
/// Steps along a ray, metres.
const STEP_M: f64 = 0.05;
/// A direction is worth a look for this many squares not seen yet.
const N_SQUARES_MIN: usize = 2;

/// Squares of the map that the camera has had in view.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Viewed {
    squares: BTreeSet<[i32; 2]>,
}

impl Viewed {
    /// The squares in which these points lie.
    pub(crate) fn of_points(points: &[Point2<f64>]) -> Self {
        Self {
            squares: points.iter().map(square_at).collect(),
        }
    }

    /// The middles of the squares.
    pub(crate) fn middles(&self) -> Vec<Point2<f64>> {
        self.squares.iter().copied().map(middle_of).collect()
    }

    /// Forgets all looks.
    pub(crate) fn clear(&mut self) {
        self.squares.clear();
    }

    /// Whether the square in which a point lies has been in view.
    #[cfg(test)]
    fn holds(&self, point: &Point2<f64>) -> bool {
        self.squares.contains(&square_at(point))
    }

    /// Middles of the squares of free floor that have not been in view.
    pub(crate) fn missing(&self, grid: &OccupancyGrid) -> Vec<Point2<f64>> {
        let free = grid.indices().filter(|index| grid.cell(*index).is_free());
        let squares: BTreeSet<[i32; 2]> = free
            .map(|index| square_at(&grid.center_of(index)))
            .collect();
        squares
            .difference(&self.squares)
            .map(|square| middle_of(*square))
            .filter(|middle| grid.cell_at(middle).is_free())
            .collect()
    }

    /// Takes note of a look.
    pub(crate) fn add_look(
        &mut self,
        grid: &OccupancyGrid,
        map_from_base: &Pose2,
        half_view_rad: f64,
    ) {
        let from = Point2::from(map_from_base.translation.vector);
        let n_rays = (2.0 * half_view_rad / RAY_RAD).ceil() as usize;
        for i in 0..=n_rays {
            let turn = half_view_rad * (2.0 * i as f64 / n_rays.max(1) as f64 - 1.0);
            let bearing = map_from_base.rotation.angle() + turn;
            self.squares.extend(squares_along(grid, from, bearing));
        }
    }

    /// The turns, left and right in this order or the other, that bring all that is new from a place into view: angles
    /// to turn by one after the other, counterclockwise positive. Empty when nothing is new.
    pub(crate) fn turns_to_see(
        &self,
        grid: &OccupancyGrid,
        map_from_base: &Pose2,
        half_view_rad: f64,
    ) -> Vec<f64> {
        let from = Point2::from(map_from_base.translation.vector);
        let n_rays = (TAU / RAY_RAD).ceil() as usize;
        let turns: Vec<f64> = (0..n_rays)
            .map(|i| TAU * i as f64 / n_rays as f64)
            .filter(|turn| {
                let bearing = map_from_base.rotation.angle() + turn;
                let new: BTreeSet<[i32; 2]> = squares_along(grid, from, bearing)
                    .filter(|square| !self.squares.contains(square))
                    .collect();
                new.len() >= N_SQUARES_MIN
            })
            .collect();
        shortest_turns(&turns, half_view_rad)
    }
}

/// Half of what a camera sees from left to right, less a margin, radians.
pub(crate) fn half_view_rad(camera: Option<&Camera>) -> f64 {
    /// At the edge of the image objects are cut off, radians.
    const MARGIN_RAD: f64 = 0.1;
    camera.map_or(0.5, |camera| {
        let aspect = camera.width as f64 / camera.height.max(1) as f64;
        ((camera.fovy_rad / 2.0).tan() * aspect).atan() - MARGIN_RAD
    })
}

fn square_at(point: &Point2<f64>) -> [i32; 2] {
    [point.x, point.y].map(|v| (v / SQUARE_M).floor() as i32)
}

fn middle_of(square: [i32; 2]) -> Point2<f64> {
    Point2::from(square.map(|i| (f64::from(i) + 0.5) * SQUARE_M))
}

/// Squares that a ray passes, up to what it meets or the unknown.
fn squares_along(
    grid: &OccupancyGrid,
    from: Point2<f64>,
    bearing_rad: f64,
) -> impl Iterator<Item = [i32; 2]> {
    let ahead = Rotation2::new(bearing_rad) * Vector2::x();
    let n_steps = (LOOK_RANGE_M / STEP_M) as usize;
    let mut is_open = true;
    (0..n_steps)
        .map(move |i| from + ahead * (i as f64 * STEP_M))
        // What the ray ends at is seen as well.
        .take_while(move |point| std::mem::replace(&mut is_open, grid.cell_at(point).is_free()))
        .filter(|point| !grid.cell_at(point).is_unknown())
        .map(|point| square_at(&point))
}

/// The shortest turns after which each of some bearings (relative to the heading, in rising order, in `0..TAU`) has been
/// within `half_view_rad` of the heading: to one side, or to one side and back to the other.
fn shortest_turns(bearings: &[f64], half_view_rad: f64) -> Vec<f64> {
    if bearings.is_empty() {
        return Vec::new();
    }
    // The first `n_left` bearings are reached by turning left, the others by turning right.
    let sides = (0..=bearings.len()).map(|n_left| {
        let left = match n_left {
            0 => 0.0,
            n => (bearings[n - 1] - half_view_rad).max(0.0),
        };
        let right = match bearings.get(n_left) {
            None => 0.0,
            Some(first) => (TAU - first - half_view_rad).max(0.0),
        };
        (left, right)
    });
    let cost = |(left, right): &(f64, f64)| left + right + left.min(*right);
    let Some((left, right)) = sides.min_by(|a, b| cost(a).total_cmp(&cost(b))) else {
        return Vec::new();
    };
    let turns = if left <= right {
        [left, -(left + right)]
    } else {
        [-right, left + right]
    };
    // The way back over nothing is the whole turn to the other side.
    turns.into_iter().filter(|turn| *turn != 0.0).collect()
}

#[cfg(test)]
mod tests {
    use factotum_geometry::grid::Cell;

    use super::*;

    fn hall() -> OccupancyGrid {
        OccupancyGrid::filled(200, 200, 0.05, Pose2::identity(), Cell::FREE).unwrap()
    }

    #[test]
    fn a_look_takes_in_what_is_ahead_and_not_behind_a_wall() {
        let mut grid = hall();
        for row in 0..200 {
            let index = factotum_geometry::grid::CellIndex { column: 120, row };
            grid.set_cell(index, Cell::OCCUPIED);
        }
        let mut viewed = Viewed::default();
        viewed.add_look(&grid, &Pose2::new(Vector2::new(5.0, 5.0), 0.0), 0.5);
        assert!(viewed.holds(&Point2::new(5.8, 5.0)), "ahead");
        assert!(viewed.holds(&Point2::new(6.02, 5.0)), "the wall itself");
        assert!(!viewed.holds(&Point2::new(6.5, 5.0)), "behind the wall");
        assert!(!viewed.holds(&Point2::new(4.0, 5.0)), "behind the robot");
        assert_eq!(Viewed::of_points(&viewed.middles()), viewed);
    }

    #[test]
    fn after_the_turns_nothing_is_new() {
        let grid = hall();
        let place = Vector2::new(5.0, 5.0);
        let mut viewed = Viewed::default();
        viewed.add_look(&grid, &Pose2::new(Vector2::new(4.0, 5.5), 0.7), 0.5);
        let mut heading = 0.3;
        let turns = viewed.turns_to_see(&grid, &Pose2::new(place, heading), 0.5);
        assert!(!turns.is_empty());
        let mut total = 0.0;
        for turn in turns {
            for _ in 0..50 {
                heading += turn / 50.0;
                viewed.add_look(&grid, &Pose2::new(place, heading), 0.5);
            }
            total += f64::abs(turn);
        }
        assert!(total < TAU, "{total}");
        let left = viewed.turns_to_see(&grid, &Pose2::new(place, heading), 0.5);
        assert_eq!(left, Vec::<f64>::new());
    }

    #[test]
    fn the_shorter_side_comes_first() {
        assert_eq!(shortest_turns(&[], 0.5), Vec::<f64>::new());
        assert_eq!(shortest_turns(&[0.2, TAU - 0.2], 0.5), Vec::<f64>::new());
        assert_eq!(shortest_turns(&[1.5], 0.5), vec![1.0]);
        let back = shortest_turns(&[1.0, TAU - 1.5], 0.5);
        assert!(
            (back[0] - 0.5).abs() < 1e-9 && (back[1] + 1.5).abs() < 1e-9,
            "{back:?}"
        );
    }
}
