//! Frontiers: where known free floor borders the unknown (Yamauchi, "A Frontier-Based Approach for
//! Autonomous Exploration", CIRA 1997).

use super::{CellIndex, OccupancyGrid};
use nalgebra::Point2;

/// A connected run of free cells that border unknown ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Frontier {
    /// Its cells, in order of discovery.
    pub cells: Vec<CellIndex>,
    /// Mean of the cell centres (m, world); may lie off the free floor when the frontier is bent.
    pub centroid_in_world: Point2<f64>,
    /// The frontier's own cell nearest to the centroid: known to be free.
    pub nearest_cell: CellIndex,
}

impl Frontier {
    /// Number of cells.
    #[must_use]
    pub fn n_cells(&self) -> usize {
        self.cells.len()
    }
}

/// The frontiers of a grid with at least `n_cells_min` cells, largest first (ties: lowest cell first).
///
/// A cell is on a frontier when it is free and shares an edge with an unknown cell; frontier cells that
/// share an edge or corner belong together. The border of the grid is not a frontier.
#[must_use]
pub fn frontiers(grid: &OccupancyGrid, n_cells_min: usize) -> Vec<Frontier> {
    let is_frontier: Vec<bool> = grid
        .indices()
        .map(|index| {
            grid.cell(index).is_free()
                && grid
                    .edge_neighbours(index)
                    .any(|n| grid.cell(n).is_unknown())
        })
        .collect();
    let flat = |index: CellIndex| index.row * grid.width() + index.column;
    let mut is_taken = vec![false; is_frontier.len()];
    let mut found = Vec::new();
    for seed in grid.indices() {
        if !is_frontier[flat(seed)] || is_taken[flat(seed)] {
            continue;
        }
        is_taken[flat(seed)] = true;
        let mut cells = vec![seed];
        let mut next = 0;
        while next < cells.len() {
            for neighbour in grid.all_neighbours(cells[next]) {
                if is_frontier[flat(neighbour)] && !is_taken[flat(neighbour)] {
                    is_taken[flat(neighbour)] = true;
                    cells.push(neighbour);
                }
            }
            next += 1;
        }
        if cells.len() >= n_cells_min.max(1) {
            found.push(summarise(grid, cells));
        }
    }
    // Stable: equal sizes stay in order of their first cell.
    found.sort_by_key(|frontier| std::cmp::Reverse(frontier.n_cells()));
    found
}

fn summarise(grid: &OccupancyGrid, cells: Vec<CellIndex>) -> Frontier {
    let sum = cells.iter().fold(nalgebra::Vector2::zeros(), |sum, &cell| {
        sum + grid.center_of(cell).coords
    });
    let centroid_in_world = Point2::from(sum / cells.len() as f64);
    let mut nearest_cell = cells[0];
    let mut nearest_m2 = f64::INFINITY;
    for &cell in &cells {
        let m2 = (grid.center_of(cell) - centroid_in_world).norm_squared();
        if m2 < nearest_m2 {
            (nearest_cell, nearest_m2) = (cell, m2);
        }
    }
    Frontier {
        cells,
        centroid_in_world,
        nearest_cell,
    }
}
