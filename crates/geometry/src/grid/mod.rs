//! Occupancy grids: what is known about the floor of a home, cell by cell.
//!
//! A grid covers a rectangle whose lower left corner is the origin of the *grid frame*; cell
//! (column, row) covers `[column, column + 1) x [row, row + 1)` cells along that frame's x and y.
//! [`OccupancyGrid::world_from_grid`] places the frame in the world and may be turned (ROS allows a
//! yawed origin). Cells are row-major from the origin, as in ROS `nav_msgs/OccupancyGrid`.

mod distance_field;
mod frontier;
pub mod map_server;
mod mapper;
mod overlap;
mod ray;

pub use distance_field::{DistanceField, UnknownCells};
pub use frontier::{Frontier, frontiers};
pub use mapper::{GridMapper, GridMapperParams};
pub use overlap::{MapOverlap, map_overlap};
pub use ray::{SignedCell, cells_on_segment};

use crate::Pose2;
use nalgebra::Point2;

/// What is known about one cell: unknown, or an occupancy of 0 (free) to 100 (occupied) percent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell(i8);

/// A cell by its thresholded state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CellState {
    /// Never seen, or undecided between the thresholds.
    Unknown,
    /// Can be driven over.
    Free,
    /// Holds an obstacle.
    Occupied,
}

/// Occupancies (percent) that separate free, unknown and occupied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellThresholds {
    /// At most this is free.
    pub free_max_percent: i8,
    /// At least this is occupied.
    pub occupied_min_percent: i8,
}

impl Default for CellThresholds {
    /// The thresholds of ROS map_server's map_saver, 25 and 65.
    fn default() -> Self {
        Self {
            free_max_percent: 25,
            occupied_min_percent: 65,
        }
    }
}

impl CellThresholds {
    /// State of a cell under these thresholds.
    #[must_use]
    pub fn state(self, cell: Cell) -> CellState {
        match cell.percent() {
            Some(p) if p <= self.free_max_percent => CellState::Free,
            Some(p) if p >= self.occupied_min_percent => CellState::Occupied,
            _ => CellState::Unknown,
        }
    }
}

impl Cell {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self(-1);
    /// Certainly free.
    pub const FREE: Self = Self(0);
    /// Certainly occupied.
    pub const OCCUPIED: Self = Self(100);

    /// Cell of an occupancy in percent, clamped to 0..=100.
    #[must_use]
    pub fn from_percent(percent: i8) -> Self {
        Self(percent.clamp(0, 100))
    }

    /// Cell from the ROS value, -1 or 0..=100; nothing for other values.
    #[must_use]
    pub fn from_ros(value: i8) -> Option<Self> {
        (-1..=100).contains(&value).then_some(Self(value))
    }

    /// The ROS value, -1 for unknown or 0..=100.
    #[must_use]
    pub fn to_ros(self) -> i8 {
        self.0
    }

    /// Occupancy in percent, or nothing when unknown.
    #[must_use]
    pub fn percent(self) -> Option<i8> {
        (self.0 >= 0).then_some(self.0)
    }

    /// State under the default thresholds.
    #[must_use]
    pub fn state(self) -> CellState {
        CellThresholds::default().state(self)
    }

    /// Whether the cell is free under the default thresholds.
    #[must_use]
    pub fn is_free(self) -> bool {
        self.state() == CellState::Free
    }

    /// Whether the cell is occupied under the default thresholds.
    #[must_use]
    pub fn is_occupied(self) -> bool {
        self.state() == CellState::Occupied
    }

    /// Whether the cell is neither free nor occupied under the default thresholds.
    #[must_use]
    pub fn is_unknown(self) -> bool {
        self.state() == CellState::Unknown
    }
}

/// Place of a cell in a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellIndex {
    /// Cells from the origin along the grid frame's x.
    pub column: usize,
    /// Cells from the origin along the grid frame's y.
    pub row: usize,
}

/// A grid that cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// The number of cells does not fit the size.
    #[error("grid of {width} x {height} has {found} cells, expected {}", width * height)]
    CellCount {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Cells given.
        found: usize,
    },
    /// The edge of a cell has no length.
    #[error("grid resolution is {resolution_m} m, expected a positive finite number")]
    Resolution {
        /// The resolution given.
        resolution_m: f64,
    },
    /// The origin is not a pose.
    #[error("grid origin has a component that is not finite")]
    Origin,
    /// More cells than memory should hold.
    #[error(
        "grid of {width} x {height} cells is larger than the {} allowed",
        OccupancyGrid::CELLS_MAX
    )]
    TooLarge {
        /// Columns asked for.
        width: usize,
        /// Rows asked for.
        height: usize,
    },
}

/// A rectangle of floor cut into square cells.
#[derive(Debug, Clone, PartialEq)]
pub struct OccupancyGrid {
    width: usize,
    height: usize,
    resolution_m: f64,
    world_from_grid: Pose2,
    cells: Vec<Cell>,
}

impl OccupancyGrid {
    /// Most cells a grid may have: 8192 x 8192, a 400 m square at 5 cm.
    pub const CELLS_MAX: usize = 1 << 26;

    /// Grid from cells, row-major from the origin.
    ///
    /// # Errors
    /// [`GridError`] when the cells do not fill `width x height`, or resolution or origin are not finite.
    pub fn new(
        width: usize,
        height: usize,
        resolution_m: f64,
        world_from_grid: Pose2,
        cells: Vec<Cell>,
    ) -> Result<Self, GridError> {
        let n_cells = width
            .checked_mul(height)
            .filter(|&n| n <= Self::CELLS_MAX)
            .ok_or(GridError::TooLarge { width, height })?;
        if cells.len() != n_cells {
            return Err(GridError::CellCount {
                width,
                height,
                found: cells.len(),
            });
        }
        if !(resolution_m.is_finite() && resolution_m > 0.0) {
            return Err(GridError::Resolution { resolution_m });
        }
        let t = world_from_grid.translation.vector;
        if !(t.x.is_finite() && t.y.is_finite() && world_from_grid.rotation.re.is_finite()) {
            return Err(GridError::Origin);
        }
        Ok(Self {
            width,
            height,
            resolution_m,
            world_from_grid,
            cells,
        })
    }

    /// Grid of cells that are all the same.
    ///
    /// # Errors
    /// As [`OccupancyGrid::new`].
    pub fn filled(
        width: usize,
        height: usize,
        resolution_m: f64,
        world_from_grid: Pose2,
        cell: Cell,
    ) -> Result<Self, GridError> {
        if width
            .checked_mul(height)
            .is_none_or(|n| n > Self::CELLS_MAX)
        {
            return Err(GridError::TooLarge { width, height });
        }
        Self::new(
            width,
            height,
            resolution_m,
            world_from_grid,
            vec![cell; width * height],
        )
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Edge of a cell (m).
    #[must_use]
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Pose of the grid frame: its origin is the outer corner of cell (0, 0).
    #[must_use]
    pub fn world_from_grid(&self) -> &Pose2 {
        &self.world_from_grid
    }

    /// The cells, row-major from the origin.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The cell at an index.
    ///
    /// # Panics
    /// When the index is outside the grid.
    #[must_use]
    pub fn cell(&self, index: CellIndex) -> Cell {
        self.cells[self.flat(index)]
    }

    /// Replaces the cell at an index.
    ///
    /// # Panics
    /// When the index is outside the grid.
    pub fn set_cell(&mut self, index: CellIndex, cell: Cell) {
        let flat = self.flat(index);
        self.cells[flat] = cell;
    }

    /// The cell at a signed place, or nothing outside the grid.
    #[must_use]
    pub fn cell_at_signed(&self, place: SignedCell) -> Option<Cell> {
        self.index_of_signed(place).map(|index| self.cell(index))
    }

    /// The index of the cell that holds a point, or nothing outside the grid.
    #[must_use]
    pub fn index_at(&self, point_in_world: &Point2<f64>) -> Option<CellIndex> {
        self.index_of_signed(self.signed_cell_at(point_in_world))
    }

    /// The cell that holds a point; outside the grid nothing is known.
    #[must_use]
    pub fn cell_at(&self, point_in_world: &Point2<f64>) -> Cell {
        self.index_at(point_in_world)
            .map_or(Cell::UNKNOWN, |index| self.cell(index))
    }

    /// Centre of a cell in the world.
    #[must_use]
    pub fn center_of(&self, index: CellIndex) -> Point2<f64> {
        self.world_from_grid
            * Point2::new(
                (index.column as f64 + 0.5) * self.resolution_m,
                (index.row as f64 + 0.5) * self.resolution_m,
            )
    }

    /// The place of a point in the grid's lattice, also where the grid has no cell.
    #[must_use]
    pub fn signed_cell_at(&self, point_in_world: &Point2<f64>) -> SignedCell {
        SignedCell::containing(&self.lattice_point(point_in_world))
    }

    /// A point in units of cells from the origin: cell (c, r) covers `[c, c+1) x [r, r+1)`.
    #[must_use]
    pub fn lattice_point(&self, point_in_world: &Point2<f64>) -> Point2<f64> {
        let p = self.world_from_grid.inverse_transform_point(point_in_world);
        p / self.resolution_m
    }

    /// The index of a signed place, or nothing outside the grid.
    #[must_use]
    pub fn index_of_signed(&self, place: SignedCell) -> Option<CellIndex> {
        let column = usize::try_from(place.column)
            .ok()
            .filter(|&c| c < self.width)?;
        let row = usize::try_from(place.row)
            .ok()
            .filter(|&r| r < self.height)?;
        Some(CellIndex { column, row })
    }

    /// All indices, row by row.
    pub fn indices(&self) -> impl Iterator<Item = CellIndex> + use<> {
        let (width, height) = (self.width, self.height);
        (0..height).flat_map(move |row| (0..width).map(move |column| CellIndex { column, row }))
    }

    /// The up to four cells that share an edge with this one.
    pub fn edge_neighbours(&self, index: CellIndex) -> impl Iterator<Item = CellIndex> + use<> {
        const EDGES: [(i64, i64); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];
        self.neighbours(index, &EDGES)
    }

    /// The up to eight cells that share an edge or a corner with this one.
    pub fn all_neighbours(&self, index: CellIndex) -> impl Iterator<Item = CellIndex> + use<> {
        const ALL: [(i64, i64); 8] = [
            (1, 0),
            (1, 1),
            (0, 1),
            (-1, 1),
            (-1, 0),
            (-1, -1),
            (0, -1),
            (1, -1),
        ];
        self.neighbours(index, &ALL)
    }

    /// The same grid in which every cell whose centre is within `radius_m` of an occupied cell's centre is occupied.
    ///
    /// A robot of that radius then plans as a point. Other cells keep what is known of them.
    #[must_use]
    pub fn inflate(&self, radius_m: f64) -> Self {
        let field = DistanceField::of(self, UnknownCells::Passable);
        let mut inflated = self.clone();
        for (cell, &distance_m) in inflated.cells.iter_mut().zip(field.distances_m()) {
            if f64::from(distance_m) <= radius_m {
                *cell = Cell::OCCUPIED;
            }
        }
        inflated
    }

    /// Whether every cell on the segment is free; outside the grid nothing is.
    #[must_use]
    pub fn is_line_free(&self, from_in_world: &Point2<f64>, to_in_world: &Point2<f64>) -> bool {
        cells_on_segment(
            &self.lattice_point(from_in_world),
            &self.lattice_point(to_in_world),
        )
        .all(|place| self.cell_at_signed(place).is_some_and(Cell::is_free))
    }

    /// Whether nothing occupied lies on the segment: one can look from one point to the other.
    #[must_use]
    pub fn has_line_of_sight(
        &self,
        from_in_world: &Point2<f64>,
        to_in_world: &Point2<f64>,
    ) -> bool {
        cells_on_segment(
            &self.lattice_point(from_in_world),
            &self.lattice_point(to_in_world),
        )
        .all(|place| !self.cell_at_signed(place).is_some_and(Cell::is_occupied))
    }

    /// How many cells are free, occupied and unknown, in this order.
    #[must_use]
    pub fn count_states(&self) -> [usize; 3] {
        let mut counts = [0; 3];
        for cell in &self.cells {
            let slot = match cell.state() {
                CellState::Free => 0,
                CellState::Occupied => 1,
                CellState::Unknown => 2,
            };
            counts[slot] += 1;
        }
        counts
    }

    fn neighbours(
        &self,
        index: CellIndex,
        offsets: &'static [(i64, i64)],
    ) -> impl Iterator<Item = CellIndex> + use<> {
        let (width, height) = (self.width, self.height);
        offsets.iter().filter_map(move |&(d_column, d_row)| {
            let column = index.column.checked_add_signed(d_column as isize)?;
            let row = index.row.checked_add_signed(d_row as isize)?;
            (column < width && row < height).then_some(CellIndex { column, row })
        })
    }

    fn flat(&self, index: CellIndex) -> usize {
        assert!(
            index.column < self.width && index.row < self.height,
            "cell {index:?} is outside the grid of {} x {}",
            self.width,
            self.height
        );
        index.row * self.width + index.column
    }
}

#[cfg(test)]
mod tests;
