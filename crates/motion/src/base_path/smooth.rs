//! From a path of cells to a polyline with few corners.
//!
//! A straight line replaces cells when it is free and costs no more than they do, clearance included, so
//! smoothing does not pull the path back to the walls.

use factotum_geometry::grid::cells_on_segment;
use nalgebra::Point2;

use super::grid::{BLOCKED, CellIdx, InflatedGrid};
use super::search::step_cost;

/// A line may cost this much more than the cells it replaces: rounding of the integer costs.
const TOLERANCE: f64 = 1.01;

/// Corners of the polyline, from the first cell's centre to the last one's.
pub(super) fn smooth(grid: &InflatedGrid, cells: &[CellIdx]) -> Vec<Point2<f64>> {
    let costs = cumulative_costs(grid, cells);
    let mut corners = vec![grid.center(cells[0])];
    let mut anchor = 0;
    let mut reached = 1;
    while reached < cells.len() {
        let next = reached + 1;
        let extends = next < cells.len()
            && line_cost(grid, &grid.center(cells[anchor]), &grid.center(cells[next]))
                .is_some_and(|cost| cost <= TOLERANCE * (costs[next] - costs[anchor]));
        if !extends {
            corners.push(grid.center(cells[reached]));
            anchor = reached;
        }
        reached = next;
    }
    corners
}

fn cumulative_costs(grid: &InflatedGrid, cells: &[CellIdx]) -> Vec<f64> {
    let mut costs = vec![0.0];
    let mut total = 0.0;
    for pair in cells.windows(2) {
        let is_diagonal = {
            let difference = pair[0].abs_diff(pair[1]) as usize;
            difference != 1 && difference != grid.width()
        };
        let cost = |cell: CellIdx| grid.costs()[cell as usize];
        total += f64::from(step_cost(cost(pair[0]), cost(pair[1]), is_diagonal));
        costs.push(total);
    }
    costs
}

/// Cost of a straight line, or nothing if it is blocked.
pub(super) fn line_cost(grid: &InflatedGrid, from: &Point2<f64>, to: &Point2<f64>) -> Option<f64> {
    let (from, to) = (grid.lattice_point(from), grid.lattice_point(to));
    let mut sum = 0.0;
    let mut n = 0;
    for place in cells_on_segment(&from, &to) {
        let column = usize::try_from(place.column)
            .ok()
            .filter(|&column| column < grid.width())?;
        let row = usize::try_from(place.row)
            .ok()
            .filter(|&row| row < grid.height())?;
        let cost = grid.costs()[row * grid.width() + column];
        if cost == BLOCKED {
            return None;
        }
        sum += f64::from(cost);
        n += 1;
    }
    Some((to - from).norm() * sum / f64::from(n))
}
