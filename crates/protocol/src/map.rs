//! The occupancy grid, run-length coded.

use serde::{Deserialize, Serialize};
use thiserror::Error;
use ts_rs::TS;

use crate::PosePlanar;

/// Value of a cell about which nothing is known.
pub const CELL_UNKNOWN: i8 = -1;
/// Value of a cell that is surely occupied; 0 is surely free, between them lies the probability.
pub const CELL_OCCUPIED: i8 = 100;

/// An occupancy grid with the cell values and order of ROS `nav_msgs/OccupancyGrid`.
///
/// Cells are ordered by rows along x, from the row at the origin upward in y. They travel as runs
/// `[value, count, value, count, ...]`, which makes a home's map some kilobytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct OccupancyMap {
    /// Cells along x.
    pub width: u32,
    /// Cells along y.
    pub height: u32,
    /// Edge of a cell, in metres.
    pub resolution_m: f64,
    /// World from the outer corner of the first cell.
    pub origin: PosePlanar,
    /// The cells, as runs of a value (-1 unknown, 0 free to 100 occupied) and a count.
    pub runs: Vec<i32>,
}

/// A map whose parts do not fit each other.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MapError {
    /// The number of cells is not width times height.
    #[error("map of {width} by {height} cells has {found} cells, expected {expected}")]
    CellCount {
        /// Cells along x.
        width: u32,
        /// Cells along y.
        height: u32,
        /// Cells found.
        found: u64,
        /// Cells wanted.
        expected: u64,
    },
    /// A cell has a value outside its range.
    #[error("map cell {index} is {found}, expected -1 (unknown) or 0 to 100")]
    CellValue {
        /// The cell, or the run when decoding.
        index: usize,
        /// Value found.
        found: i32,
    },
    /// A run without a count, or one that counts no cells.
    #[error("map run {index} has no count above 0")]
    RunCount {
        /// The run.
        index: usize,
    },
}

impl OccupancyMap {
    /// A map of `width` by `height` cells, in the order described at the type.
    ///
    /// # Errors
    ///
    /// When the number or a value of the cells is wrong.
    pub fn from_cells(
        width: u32,
        height: u32,
        resolution_m: f64,
        origin: PosePlanar,
        cells: &[i8],
    ) -> Result<Self, MapError> {
        check_count(width, height, cells.len() as u64)?;
        let mut runs: Vec<i32> = Vec::new();
        for (index, &cell) in cells.iter().enumerate() {
            let value = i32::from(cell);
            check_value(index, value)?;
            match runs.as_mut_slice() {
                // The upper bound keeps a run's count within its type.
                [.., last, count] if *last == value && *count < i32::MAX => *count += 1,
                _ => runs.extend([value, 1]),
            }
        }
        Ok(Self {
            width,
            height,
            resolution_m,
            origin,
            runs,
        })
    }

    /// The cells, in the order described at the type.
    ///
    /// # Errors
    ///
    /// When the runs are not well formed or do not fill the map exactly. Nothing larger than the
    /// map is ever allocated.
    pub fn cells(&self) -> Result<Vec<i8>, MapError> {
        let mut found = 0_u64;
        for (index, run) in self.runs.chunks(2).enumerate() {
            check_value(index, run[0])?;
            match run.get(1).map(|&count| u64::try_from(count)) {
                Some(Ok(count)) if count > 0 => found += count,
                _ => return Err(MapError::RunCount { index }),
            }
        }
        check_count(self.width, self.height, found)?;
        let runs = self.runs.chunks_exact(2);
        Ok(runs
            .flat_map(|run| std::iter::repeat_n(run[0] as i8, run[1] as usize))
            .collect())
    }
}

fn check_count(width: u32, height: u32, found: u64) -> Result<(), MapError> {
    let expected = u64::from(width) * u64::from(height);
    if found == expected {
        return Ok(());
    }
    Err(MapError::CellCount {
        width,
        height,
        found,
        expected,
    })
}

fn check_value(index: usize, found: i32) -> Result<(), MapError> {
    if (i32::from(CELL_UNKNOWN)..=i32::from(CELL_OCCUPIED)).contains(&found) {
        return Ok(());
    }
    Err(MapError::CellValue { index, found })
}
