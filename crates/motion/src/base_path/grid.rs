//! The grid on which the base plans as a point.

use factotum_geometry::Pose2;
use factotum_geometry::grid::{DistanceField, OccupancyGrid, UnknownCells};
use nalgebra::Point2;

/// How obstacles grow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InflationOptions {
    /// Radius of the base, metres: nearer to an obstacle it does not go.
    pub radius_m: f64,
    /// Distance beyond the radius that it prefers to keep, metres.
    pub preferred_m: f64,
    /// What a metre just outside the radius costs more than one in the open (0: only length counts).
    pub clearance_weight: f64,
    /// Whether it may drive where the map knows nothing.
    pub unknown: UnknownCells,
}

impl InflationOptions {
    /// Inflation by the radius of a base, with a preference for some more distance.
    pub fn for_radius(radius_m: f64) -> Self {
        Self {
            radius_m,
            preferred_m: 0.4,
            clearance_weight: 3.0,
            unknown: UnknownCells::Blocking,
        }
    }
}

/// Index of a cell in row-major order.
pub(super) type CellIdx = u32;

/// An occupancy grid inflated by the radius of the base: which cells its centre may be in, and how dear they are.
#[derive(Debug, Clone)]
pub struct InflatedGrid {
    field: DistanceField,
    resolution_m: f64,
    world_from_grid: Pose2,
    options: InflationOptions,
    /// Cost of a cell's edge length: [`BLOCKED`] or [`UNIT`] and more.
    costs: Vec<u16>,
}

/// Cost of a cell that the base may not enter.
pub(super) const BLOCKED: u16 = u16::MAX;
/// Cost of crossing a cell in the open.
pub(super) const UNIT: u16 = 128;

impl InflatedGrid {
    /// Inflates a grid.
    pub fn new(grid: &OccupancyGrid, options: &InflationOptions) -> Self {
        let field = DistanceField::of(grid, options.unknown);
        let mut costs: Vec<u16> = field
            .distances_m()
            .iter()
            .map(|&d| cost_at(f64::from(d), options))
            .collect();
        // The outermost cells are never entered, so that every free cell has eight neighbours.
        let (width, height) = (field.width(), field.height());
        for (idx, cost) in costs.iter_mut().enumerate() {
            let (column, row) = (idx % width, idx / width);
            if column == 0 || row == 0 || column + 1 == width || row + 1 == height {
                *cost = BLOCKED;
            }
        }
        Self {
            resolution_m: grid.resolution_m(),
            world_from_grid: *grid.world_from_grid(),
            options: *options,
            field,
            costs,
        }
    }

    /// How obstacles were grown.
    pub fn options(&self) -> &InflationOptions {
        &self.options
    }

    /// Whether the centre of the base may be at a point of the map.
    pub fn is_free_at(&self, point_in_map: &Point2<f64>) -> bool {
        self.cell_at(point_in_map)
            .is_some_and(|cell| self.is_free(cell))
    }

    /// Distance of a point from the nearest obstacle, metres; 0 off the map.
    pub fn clearance_m(&self, point_in_map: &Point2<f64>) -> f64 {
        self.field.distance_at(point_in_map).unwrap_or(0.0)
    }

    /// The free cell nearest to a point, within a distance; the cell of the point itself if that is free.
    pub(super) fn nearest_free(&self, point: &Point2<f64>, within_m: f64) -> Option<CellIdx> {
        let own = self.cell_at(point)?;
        if self.is_free(own) {
            return Some(own);
        }
        let (column, row) = self.column_row(own);
        let reach = (within_m / self.resolution_m).floor() as usize;
        let rows = row.saturating_sub(reach)..=row.saturating_add(reach).min(self.height() - 1);
        rows.flat_map(|row| {
            let columns =
                column.saturating_sub(reach)..=column.saturating_add(reach).min(self.width() - 1);
            columns.map(move |column| (column, row))
        })
        .map(|(column, row)| (row * self.width() + column) as CellIdx)
        .filter(|&cell| self.is_free(cell))
        .map(|cell| ((self.center(cell) - point).norm(), cell))
        .filter(|&(distance, _)| distance <= within_m)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, cell)| cell)
    }

    pub(super) fn width(&self) -> usize {
        self.field.width()
    }

    pub(super) fn height(&self) -> usize {
        self.field.height()
    }

    pub(super) fn costs(&self) -> &[u16] {
        &self.costs
    }

    pub(super) fn is_free(&self, cell: CellIdx) -> bool {
        self.costs[cell as usize] != BLOCKED
    }

    pub(super) fn column_row(&self, cell: CellIdx) -> (usize, usize) {
        (cell as usize % self.width(), cell as usize / self.width())
    }

    pub(super) fn center(&self, cell: CellIdx) -> Point2<f64> {
        let (column, row) = self.column_row(cell);
        let center = Point2::new(column as f64 + 0.5, row as f64 + 0.5) * self.resolution_m;
        self.world_from_grid * center
    }

    pub(super) fn cell_at(&self, point: &Point2<f64>) -> Option<CellIdx> {
        let p = self.world_from_grid.inverse_transform_point(point) / self.resolution_m;
        let is_inside =
            p.x >= 0.0 && p.y >= 0.0 && p.x < self.width() as f64 && p.y < self.height() as f64;
        is_inside.then(|| (p.y as usize * self.width() + p.x as usize) as CellIdx)
    }

    /// A point in units of cells from the grid's origin.
    pub(super) fn lattice_point(&self, point: &Point2<f64>) -> Point2<f64> {
        self.world_from_grid.inverse_transform_point(point) / self.resolution_m
    }
}

/// Cost of a cell at a distance from the nearest obstacle: falls quadratically until the preferred distance.
fn cost_at(distance_m: f64, options: &InflationOptions) -> u16 {
    if distance_m <= options.radius_m {
        return BLOCKED;
    }
    let lacking = if options.preferred_m > 0.0 {
        (1.0 - (distance_m - options.radius_m) / options.preferred_m).max(0.0)
    } else {
        0.0
    };
    let factor = 1.0 + options.clearance_weight.max(0.0) * lacking * lacking;
    (f64::from(UNIT) * factor).min(f64::from(BLOCKED - 1)) as u16
}
