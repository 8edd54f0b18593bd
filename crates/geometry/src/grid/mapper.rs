//! Building an occupancy grid from lidar scans at known poses.
//!
//! Method: log-odds occupancy mapping (Moravec & Elfes, ICRA 1985; Thrun, Burgard & Fox, *Probabilistic
//! Robotics*, 2005, table 9.1) with clamping (Yguel et al. 2007), so that a moved chair is unlearned.
//! As in Cartographer (Hess et al., ICRA 2016, section IV), a scan updates each cell at most once and a
//! hit outweighs a pass, so grazing rays do not erode walls.
//!
//! Beside its log-odds a cell keeps the mean of the ray ends that fell into it, as GMapping's does (Grisetti, Stachniss &
//! Burgard, IEEE T-RO 2007): where in the cell the wall is, far finer than the cell.

use super::{Cell, CellIndex, GridError, OccupancyGrid, SignedCell, cells_on_segment};
use crate::Pose2;
use crate::sensing::LaserScan;
use nalgebra::Point2;

/// Settings of a [`GridMapper`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridMapperParams {
    /// Edge of a cell (m).
    pub resolution_m: f64,
    /// Log-odds added to a cell in which a ray ends; 1.5 is p = 0.82, so one hit makes it occupied.
    pub hit_log_odds: f64,
    /// Log-odds added (negative) to a cell that a ray passes; -1.15 is p = 0.24, so that floor seen once is
    /// free under the default thresholds and no longer a frontier.
    pub miss_log_odds: f64,
    /// Bound of |log-odds|; 4 is p = 0.98. Larger values remember longer.
    pub log_odds_max: f64,
    /// Whether rays without a return free the cells up to the lidar's range. Off by default: a ray that a
    /// dark or glass surface swallowed would open the wall it hit and clear what lies behind.
    pub clear_without_return: bool,
}

impl Default for GridMapperParams {
    fn default() -> Self {
        Self {
            resolution_m: 0.05,
            hit_log_odds: 1.5,
            miss_log_odds: -1.15,
            log_odds_max: 4.0,
            clear_without_return: false,
        }
    }
}

/// An occupancy grid in the making; it grows to hold what the scans see.
#[derive(Debug, Clone)]
pub struct GridMapper {
    params: GridMapperParams,
    /// Lattice place of column 0, row 0: the world origin is the corner of place (0, 0).
    first: SignedCell,
    width: usize,
    height: usize,
    /// Log-odds per cell; NaN where nothing was ever seen.
    log_odds: Vec<f32>,
    /// Scan number that last touched a cell.
    touched: Vec<u32>,
    /// Ends of rays per cell.
    hits: Vec<Hits>,
    n_scans: u32,
}

/// The mean of the ray ends in a cell.
#[derive(Debug, Clone, Copy)]
struct Hits {
    n: u32,
    /// From the cell's lower left corner, cells; the centre where nothing ended.
    mean: [f32; 2],
}

impl Hits {
    const NONE: Self = Self {
        n: 0,
        mean: [0.5, 0.5],
    };

    fn add(&mut self, in_cell: [f64; 2]) {
        /// So many ends are remembered: what was moved within its cell is learned anew.
        const N_MAX: u32 = 50;
        self.n = (self.n + 1).min(N_MAX);
        for (mean, value) in self.mean.iter_mut().zip(in_cell) {
            *mean += (value as f32 - *mean) / self.n as f32;
        }
    }
}

impl GridMapper {
    /// Cells added beyond what is needed when the grid grows, so that it rarely does.
    const GROWTH_MARGIN: i64 = 32;

    /// An empty map.
    ///
    /// # Errors
    /// [`GridError::Resolution`] when the resolution is not a positive number.
    pub fn new(params: GridMapperParams) -> Result<Self, GridError> {
        let resolution_m = params.resolution_m;
        if !(resolution_m.is_finite() && resolution_m > 0.0) {
            return Err(GridError::Resolution { resolution_m });
        }
        Ok(Self {
            params,
            first: SignedCell { column: 0, row: 0 },
            width: 0,
            height: 0,
            log_odds: Vec::new(),
            touched: Vec::new(),
            hits: Vec::new(),
            n_scans: 0,
        })
    }

    /// A map to go on with: known cells start at their occupancy, within the bound of the log-odds.
    ///
    /// The grid's lattice is kept when it is aligned with the world and on the same resolution;
    /// otherwise cells are looked up at their centres.
    ///
    /// # Errors
    /// As [`GridMapper::new`].
    pub fn from_grid(grid: &OccupancyGrid, params: GridMapperParams) -> Result<Self, GridError> {
        let mut mapper = Self::new(params)?;
        let (width_m, height_m) = (
            grid.width() as f64 * grid.resolution_m(),
            grid.height() as f64 * grid.resolution_m(),
        );
        let corners = [
            (0.0, 0.0),
            (width_m, 0.0),
            (0.0, height_m),
            (width_m, height_m),
        ]
        .map(|(x, y)| mapper.place_of(&(grid.world_from_grid() * Point2::new(x, y))));
        mapper.grow_to_hold(&corners)?;
        for flat in 0..mapper.log_odds.len() {
            let index = CellIndex {
                column: flat % mapper.width,
                row: flat / mapper.width,
            };
            if let Some(percent) = grid.cell_at(&mapper.center_of(index)).percent() {
                let p = f64::from(percent) / 100.0;
                let bound = params.log_odds_max;
                mapper.log_odds[flat] = (p / (1.0 - p)).ln().clamp(-bound, bound) as f32;
            }
        }
        Ok(mapper)
    }

    /// The settings.
    #[must_use]
    pub fn params(&self) -> &GridMapperParams {
        &self.params
    }

    /// How many scans are in the map.
    #[must_use]
    pub fn n_scans(&self) -> u32 {
        self.n_scans
    }

    /// Adds a scan taken at `world_from_base`.
    ///
    /// # Errors
    /// [`GridError::TooLarge`] when the scan reaches too far from the rest, [`GridError::Origin`] when the
    /// pose is not finite; the map is unchanged then.
    pub fn integrate(
        &mut self,
        world_from_base: &Pose2,
        scan: &LaserScan,
    ) -> Result<(), GridError> {
        let lidar = world_from_base * scan.origin_in_base();
        let rays: Vec<(Point2<f64>, bool)> = scan
            .rays()
            .filter(|ray| ray.is_hit || self.params.clear_without_return)
            .map(|ray| (world_from_base * ray.end_in_base, ray.is_hit))
            .collect();
        let is_finite = |p: &Point2<f64>| p.x.is_finite() && p.y.is_finite();
        if !is_finite(&lidar) || !rays.iter().all(|(end, _)| is_finite(end)) {
            return Err(GridError::Origin);
        }
        let mut places: Vec<SignedCell> = rays.iter().map(|(end, _)| self.place_of(end)).collect();
        places.push(self.place_of(&lidar));
        self.grow_to_hold(&places)?;

        self.n_scans += 1;
        for (end, _) in rays.iter().filter(|(_, is_hit)| *is_hit) {
            self.touch(self.place_of(end), self.params.hit_log_odds);
            self.add_end(end);
        }
        let scale = 1.0 / self.params.resolution_m;
        for (end, is_hit) in &rays {
            let last = self.place_of(end);
            for place in cells_on_segment(&(lidar * scale), &(end * scale)) {
                // The end of a ray without return is as free as the rest of it.
                if place != last || !is_hit {
                    self.touch(place, self.params.miss_log_odds);
                }
            }
        }
        Ok(())
    }

    /// Where in each cell of [`Self::grid`] rays have ended on average, from the cell's lower left corner in cells; the
    /// centre where none has.
    #[must_use]
    pub fn places_in_cells(&self) -> Vec<[f32; 2]> {
        self.hits.iter().map(|hits| hits.mean).collect()
    }

    /// The map so far, axis-aligned with the world; nothing when no scan has been added.
    #[must_use]
    pub fn grid(&self) -> Option<OccupancyGrid> {
        let cells = self
            .log_odds
            .iter()
            .map(|&log_odds| {
                if log_odds.is_nan() {
                    return Cell::UNKNOWN;
                }
                let p = 1.0 / (1.0 + (-f64::from(log_odds)).exp());
                Cell::from_percent((p * 100.0).round() as i8)
            })
            .collect();
        let resolution_m = self.params.resolution_m;
        let corner = nalgebra::Vector2::new(
            self.first.column as f64 * resolution_m,
            self.first.row as f64 * resolution_m,
        );
        if self.width == 0 {
            return None;
        }
        OccupancyGrid::new(
            self.width,
            self.height,
            resolution_m,
            Pose2::new(corner, 0.0),
            cells,
        )
        .ok()
    }

    fn place_of(&self, point_in_world: &Point2<f64>) -> SignedCell {
        SignedCell::containing(&(point_in_world / self.params.resolution_m))
    }

    fn center_of(&self, index: CellIndex) -> Point2<f64> {
        let resolution_m = self.params.resolution_m;
        Point2::new(
            (self.first.column as f64 + index.column as f64 + 0.5) * resolution_m,
            (self.first.row as f64 + index.row as f64 + 0.5) * resolution_m,
        )
    }

    fn flat(&self, place: SignedCell) -> usize {
        let column = (place.column - self.first.column) as usize;
        let row = (place.row - self.first.row) as usize;
        row * self.width + column
    }

    /// Takes the end of a ray into the mean of its cell.
    fn add_end(&mut self, end: &Point2<f64>) {
        let at = end / self.params.resolution_m;
        let flat = self.flat(SignedCell::containing(&at));
        self.hits[flat].add([at.x - at.x.floor(), at.y - at.y.floor()]);
    }

    /// Adds to one cell unless this scan already did.
    fn touch(&mut self, place: SignedCell, log_odds: f64) {
        let flat = self.flat(place);
        if self.touched[flat] == self.n_scans {
            return;
        }
        self.touched[flat] = self.n_scans;
        let before = if self.log_odds[flat].is_nan() {
            0.0
        } else {
            f64::from(self.log_odds[flat])
        };
        let bound = self.params.log_odds_max;
        self.log_odds[flat] = (before + log_odds).clamp(-bound, bound) as f32;
    }

    fn grow_to_hold(&mut self, places: &[SignedCell]) -> Result<(), GridError> {
        let columns = places.iter().map(|place| place.column);
        let rows = places.iter().map(|place| place.row);
        let (Some(column_min), Some(column_max), Some(row_min), Some(row_max)) = (
            columns.clone().min(),
            columns.max(),
            rows.clone().min(),
            rows.max(),
        ) else {
            return Ok(());
        };
        let (columns, rows) = (
            grown(self.first.column, self.width, column_min, column_max),
            grown(self.first.row, self.height, row_min, row_max),
        );
        if columns == (self.first.column, self.width) && rows == (self.first.row, self.height) {
            return Ok(());
        }
        let ((first_column, width), (first_row, height)) = (columns, rows);
        let n_cells = width
            .checked_mul(height)
            .filter(|&n| n <= OccupancyGrid::CELLS_MAX)
            .ok_or(GridError::TooLarge { width, height })?;
        let mut log_odds = vec![f32::NAN; n_cells];
        let mut touched = vec![0; n_cells];
        let mut hits = vec![Hits::NONE; n_cells];
        for row in 0..self.height {
            let from = row * self.width;
            let to = (row + (self.first.row - first_row) as usize) * width
                + (self.first.column - first_column) as usize;
            log_odds[to..to + self.width].copy_from_slice(&self.log_odds[from..from + self.width]);
            touched[to..to + self.width].copy_from_slice(&self.touched[from..from + self.width]);
            hits[to..to + self.width].copy_from_slice(&self.hits[from..from + self.width]);
        }
        self.first = SignedCell {
            column: first_column,
            row: first_row,
        };
        (self.width, self.height) = (width, height);
        (self.log_odds, self.touched, self.hits) = (log_odds, touched, hits);
        Ok(())
    }
}

/// First place and length of an axis that must also hold `min..=max`.
fn grown(first: i64, length: usize, min: i64, max: i64) -> (i64, usize) {
    let margin = GridMapper::GROWTH_MARGIN;
    if length == 0 {
        return (min - margin, (max - min + 1 + 2 * margin) as usize);
    }
    let end = first + length as i64;
    let new_first = if min < first { min - margin } else { first };
    let new_end = if max >= end { max + 1 + margin } else { end };
    (new_first, (new_end - new_first) as usize)
}
