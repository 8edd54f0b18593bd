//! Paths of the base on an inflated occupancy grid.

mod grid;
mod search;
mod smooth;

pub use grid::{InflatedGrid, InflationOptions};

use std::f64::consts::PI;

use factotum_geometry::frames::wrap_angle;
use nalgebra::{Point2, Vector2};

use crate::Pose2;

/// Where the base looks while it drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Heading {
    /// Turns evenly from the start's yaw to the goal's: for a base that drives in any direction.
    #[default]
    Even,
    /// Along the path, except at both ends.
    AlongPath,
}

/// How a base path is searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BasePathOptions {
    /// A start in the inflated zone may first leave it, over at most this distance (m).
    pub start_escape_m: f64,
    /// A goal in the inflated zone is replaced by the nearest free place within this distance (m).
    pub goal_slack_m: f64,
    /// Distance of the path's poses, metres.
    pub spacing_m: f64,
    /// Where the base looks.
    pub heading: Heading,
    /// Cap: cells expanded.
    pub n_expansions_max: usize,
}

impl Default for BasePathOptions {
    fn default() -> Self {
        Self {
            start_escape_m: 0.5,
            goal_slack_m: 0.0,
            spacing_m: 0.1,
            heading: Heading::Even,
            n_expansions_max: 20_000_000,
        }
    }
}

/// What came of a base path search.
#[derive(Debug, Clone, PartialEq)]
pub enum BaseOutcome {
    /// There is a path.
    Solved {
        /// Poses in the map from the start to the goal.
        path: Vec<Pose2>,
        /// Length, metres.
        length_m: f64,
        /// Smallest distance from an obstacle on it, metres.
        clearance_m: f64,
    },
    /// The start is off the map, or too deep in an obstacle's inflated zone.
    StartBlocked,
    /// The goal is off the map or in the inflated zone.
    GoalBlocked,
    /// Start and goal are not connected.
    Unreachable,
    /// The cap on expanded cells ended the search.
    LimitReached,
}

/// Plans a path of the base between two poses in the map.
pub fn plan_base(
    grid: &InflatedGrid,
    map_from_start: &Pose2,
    map_from_goal: &Pose2,
    options: &BasePathOptions,
) -> BaseOutcome {
    let start = Point2::from(map_from_start.translation.vector);
    let goal = Point2::from(map_from_goal.translation.vector);
    let Some(start_cell) = grid.nearest_free(&start, options.start_escape_m) else {
        return BaseOutcome::StartBlocked;
    };
    let Some(goal_cell) = grid.nearest_free(&goal, options.goal_slack_m) else {
        return BaseOutcome::GoalBlocked;
    };
    let cells = match search::search(grid, start_cell, goal_cell, options.n_expansions_max) {
        search::CellPath::Found(cells) => cells,
        search::CellPath::Unreachable => return BaseOutcome::Unreachable,
        search::CellPath::LimitReached => return BaseOutcome::LimitReached,
    };
    let mut corners: Vec<Point2<f64>> = smooth::smooth(grid, &cells);
    // The path runs between the true points, not the cell centres, where these are free.
    let last = corners.len() - 1;
    if grid.is_free_at(&goal) {
        corners[last] = goal;
    }
    if grid.is_free_at(&start) && last > 0 {
        corners[0] = start;
    } else if !grid.is_free_at(&start) {
        corners.insert(0, start);
    }
    if corners.len() == 1 {
        corners.insert(0, start);
    }
    let length_m = corners
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).norm())
        .sum();
    let points = resample(&corners, options.spacing_m);
    let clearance_m = points
        .iter()
        .map(|point| grid.clearance_m(point))
        .fold(f64::INFINITY, f64::min);
    let yaws = [
        map_from_start.rotation.angle(),
        map_from_goal.rotation.angle(),
    ];
    let path = with_headings(&points, yaws, options.heading);
    BaseOutcome::Solved {
        path,
        length_m,
        clearance_m,
    }
}

/// Points at most `spacing_m` apart along the polyline, its corners included.
fn resample(corners: &[Point2<f64>], spacing_m: f64) -> Vec<Point2<f64>> {
    const SPACING_MIN_M: f64 = 1e-3;
    let spacing_m = spacing_m.max(SPACING_MIN_M);
    let mut points = vec![corners[0]];
    for pair in corners.windows(2) {
        let step = pair[1] - pair[0];
        let n_steps = ((step.norm() / spacing_m).ceil() as usize).max(1);
        points.extend((1..n_steps).map(|i| pair[0] + step * (i as f64 / n_steps as f64)));
        points.push(pair[1]);
    }
    points
}

fn with_headings(points: &[Point2<f64>], yaws: [f64; 2], heading: Heading) -> Vec<Pose2> {
    let n = points.len();
    let mut lengths = vec![0.0];
    for pair in points.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let total = lengths[n - 1];
    let turn = wrap_angle(yaws[1] - yaws[0]);
    (0..n)
        .map(|i| {
            let t = if total > 0.0 {
                lengths[i] / total
            } else {
                i as f64 / (n - 1).max(1) as f64
            };
            let yaw = match heading {
                _ if i == 0 => yaws[0],
                _ if i + 1 == n => yaws[1],
                Heading::Even => yaws[0] + t * turn,
                Heading::AlongPath => {
                    let ahead: Vector2<f64> = points[i + 1] - points[i - 1];
                    ahead.y.atan2(ahead.x)
                }
            };
            debug_assert!(yaw.abs() <= 2.0 * PI + 1e-9);
            Pose2::new(points[i].coords, yaw)
        })
        .collect()
}

#[cfg(test)]
mod tests;
