//! Maps as ROS map_server keeps them: a YAML file of metadata beside an image in PGM.
//!
//! Follows Nav2's map_server (`nav2_map_server/src/map_io.cpp`): image row 0 is the highest y; a pixel's
//! occupancy is `p = 1 - value / maxval` (`value / maxval` when negated). *trinary*: occupied where
//! `p >= occupied_thresh`, free where `p <= free_thresh`, else unknown; *scale*: the same, but between the
//! thresholds `p` is stretched over 0..=100; *raw*: the value itself where it is 0..=100, else unknown.
//!
//! [`StoredMap`] keeps metadata and pixels as they were read, so that a map that is imported and
//! exported again is unchanged, and a changed grid changes only the pixels whose cells it changed.

mod metadata;
mod pgm;

pub use metadata::{MapMetadata, MapMode, MetadataError};
pub use pgm::{GrayImage, PgmEncoding, PgmError};

use super::{Cell, CellState, GridError, OccupancyGrid};
use crate::Pose2;
use std::path::{Path, PathBuf};

/// A map that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapFileError {
    /// The file system refused.
    #[error("cannot {action} map file `{}`: {source}", path.display())]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The YAML file is wrong.
    #[error("map metadata `{}`: {source}", path.display())]
    Metadata {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: MetadataError,
    },
    /// The image is wrong.
    #[error("map image `{}`: {source}", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: PgmError,
    },
    /// The image and metadata make no grid.
    #[error("map `{}`: {source}", path.display())]
    Grid {
        /// The YAML file.
        path: PathBuf,
        /// What is wrong.
        source: GridError,
    },
}

/// A grid that does not belong to a stored map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapUpdateError {
    /// Another number of cells.
    #[error("grid of {width} x {height} cells for a stored map of {map_width} x {map_height}")]
    Size {
        /// Columns of the grid.
        width: usize,
        /// Rows of the grid.
        height: usize,
        /// Columns of the map.
        map_width: usize,
        /// Rows of the map.
        map_height: usize,
    },
}

/// A map as it is on disk: metadata and pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredMap {
    /// What the YAML file says.
    pub metadata: MapMetadata,
    /// What the image holds.
    pub image: GrayImage,
}

impl StoredMap {
    /// Reads the YAML file at `path` and the image it names (relative to the YAML file's folder).
    ///
    /// # Errors
    /// [`MapFileError`] when a file is missing or malformed, or the two make no grid.
    pub fn read(path: &Path) -> Result<Self, MapFileError> {
        let bytes = read_file(path)?;
        let metadata = MapMetadata::parse(&String::from_utf8_lossy(&bytes)).map_err(|source| {
            MapFileError::Metadata {
                path: path.to_owned(),
                source,
            }
        })?;
        let image_path = path.parent().unwrap_or(Path::new("")).join(&metadata.image);
        let image = GrayImage::parse_pgm(&read_file(&image_path)?).map_err(|source| {
            MapFileError::Image {
                path: image_path,
                source,
            }
        })?;
        let map = Self { metadata, image };
        map.checked_grid().map_err(|source| MapFileError::Grid {
            path: path.to_owned(),
            source,
        })?;
        Ok(map)
    }

    /// Writes the YAML file at `path` and the image beside it, under the file name the metadata give
    /// it (a folder in that name is dropped, so that a map never writes outside its own folder).
    ///
    /// # Errors
    /// [`MapFileError::Io`] naming the file that could not be written.
    pub fn write(&self, path: &Path) -> Result<(), MapFileError> {
        let name = self
            .metadata
            .image
            .file_name()
            .map_or_else(
                || path.with_extension("pgm").file_name().map(PathBuf::from),
                |name| Some(PathBuf::from(name)),
            )
            .unwrap_or_else(|| PathBuf::from("map.pgm"));
        let image_path = path.with_file_name(&name);
        write_file(&image_path, &self.image.to_pgm())?;
        let metadata = MapMetadata {
            image: name,
            ..self.metadata.clone()
        };
        write_file(path, metadata.to_yaml().as_bytes())
    }

    /// A map of a grid in trinary mode with map_saver's pixel values: 254 free, 0 occupied, 205 unknown.
    #[must_use]
    pub fn from_grid(grid: &OccupancyGrid, image: impl Into<PathBuf>) -> Self {
        Self::from_grid_in_mode(grid, image, MapMode::Trinary)
    }

    /// A map of a grid; `Raw` keeps every cell's value, `Scale` all but those outside the thresholds.
    #[must_use]
    pub fn from_grid_in_mode(
        grid: &OccupancyGrid,
        image: impl Into<PathBuf>,
        mode: MapMode,
    ) -> Self {
        let metadata = MapMetadata {
            image: image.into(),
            resolution_m: grid.resolution_m(),
            origin: metadata::origin_of(grid.world_from_grid()),
            negate: false,
            occupied_thresh: 0.65,
            free_thresh: 0.196,
            mode,
            has_mode_key: mode != MapMode::Trinary,
        };
        let image = GrayImage::from_rows(grid.width(), grid.height(), |column, image_row| {
            let row = grid.height() - 1 - image_row;
            pixel_of(&metadata, 255, grid.cell(super::CellIndex { column, row }))
        });
        Self { metadata, image }
    }

    /// The grid the map describes.
    ///
    /// # Errors
    /// [`GridError`] when metadata edited by hand make no grid; never for a map that was read.
    pub fn checked_grid(&self) -> Result<OccupancyGrid, GridError> {
        let (width, height) = (self.image.width(), self.image.height());
        let cells = (0..height)
            .rev()
            .flat_map(|image_row| (0..width).map(move |column| (column, image_row)))
            .map(|(column, image_row)| self.cell_of(self.image.pixel(column, image_row)))
            .collect();
        let [x, y, yaw] = self.metadata.origin;
        let world_from_grid = Pose2::new(nalgebra::Vector2::new(x, y), yaw);
        OccupancyGrid::new(
            width,
            height,
            self.metadata.resolution_m,
            world_from_grid,
            cells,
        )
    }

    /// Takes over a changed grid: only pixels whose cell no longer has the state they stand for are
    /// rewritten, all others keep their exact value.
    ///
    /// # Errors
    /// [`MapUpdateError::Size`] when the grid has another size.
    pub fn update(&mut self, grid: &OccupancyGrid) -> Result<(), MapUpdateError> {
        let (map_width, map_height) = (self.image.width(), self.image.height());
        if (grid.width(), grid.height()) != (map_width, map_height) {
            let (width, height) = (grid.width(), grid.height());
            return Err(MapUpdateError::Size {
                width,
                height,
                map_width,
                map_height,
            });
        }
        for index in grid.indices() {
            let image_row = map_height - 1 - index.row;
            let stored = self.cell_of(self.image.pixel(index.column, image_row));
            let wanted = grid.cell(index);
            let is_kept = match self.metadata.mode {
                MapMode::Trinary => stored.state() == wanted.state(),
                MapMode::Scale | MapMode::Raw => stored == wanted,
            };
            if !is_kept {
                let pixel = pixel_of(&self.metadata, self.image.maxval(), wanted);
                self.image.set_pixel(index.column, image_row, pixel);
            }
        }
        self.metadata.resolution_m = grid.resolution_m();
        let origin = metadata::origin_of(grid.world_from_grid());
        // An origin that is the same pose keeps its digits.
        let [x, y, yaw] = self.metadata.origin;
        if Pose2::new(nalgebra::Vector2::new(x, y), yaw) != *grid.world_from_grid() {
            self.metadata.origin = origin;
        }
        Ok(())
    }

    fn cell_of(&self, pixel: u16) -> Cell {
        let metadata = &self.metadata;
        if metadata.mode == MapMode::Raw {
            return i8::try_from(pixel)
                .ok()
                .and_then(Cell::from_ros)
                .unwrap_or(Cell::UNKNOWN);
        }
        let shade = f64::from(pixel) / f64::from(self.image.maxval());
        let p = if metadata.negate { shade } else { 1.0 - shade };
        if p >= metadata.occupied_thresh {
            Cell::OCCUPIED
        } else if p <= metadata.free_thresh {
            Cell::FREE
        } else if metadata.mode == MapMode::Scale {
            let span = metadata.occupied_thresh - metadata.free_thresh;
            Cell::from_percent(((p - metadata.free_thresh) / span * 100.0).round() as i8)
        } else {
            Cell::UNKNOWN
        }
    }
}

/// The pixel that reads back as a cell (as its state, in trinary mode).
fn pixel_of(metadata: &MapMetadata, maxval: u16, cell: Cell) -> u16 {
    let top = f64::from(maxval);
    let shade_of = |p: f64| if metadata.negate { p } else { 1.0 - p };
    let pixel = |p: f64| (shade_of(p) * top).round().clamp(0.0, top) as u16;
    match metadata.mode {
        // 255 is map_saver's value for unknown.
        MapMode::Raw => cell
            .percent()
            .map_or(maxval.min(255), |percent| percent as u16),
        // Scale has no pixel for unknown without an alpha channel: the middle says least.
        MapMode::Scale => pixel(cell.percent().map_or(
            f64::midpoint(metadata.free_thresh, metadata.occupied_thresh),
            |percent| match percent {
                0 => 0.0,
                100 => 1.0,
                percent => {
                    let span = metadata.occupied_thresh - metadata.free_thresh;
                    metadata.free_thresh + f64::from(percent) / 100.0 * span
                }
            },
        )),
        MapMode::Trinary => match cell.state() {
            CellState::Occupied => pixel(1.0),
            // map_saver's 254 of 255 rather than white.
            CellState::Free => pixel((1.0_f64 / 255.0).min(metadata.free_thresh)),
            CellState::Unknown => unknown_pixel(metadata, maxval),
        },
    }
}

/// map_saver's 205 of 255 where it reads back as unknown, else the middle between the thresholds.
fn unknown_pixel(metadata: &MapMetadata, maxval: u16) -> u16 {
    let top = f64::from(maxval);
    let saver_p = 50.0 / 255.0;
    let is_between = |p: f64| p > metadata.free_thresh && p < metadata.occupied_thresh;
    let p = if is_between(saver_p) {
        saver_p
    } else {
        f64::midpoint(metadata.free_thresh, metadata.occupied_thresh)
    };
    let shade = if metadata.negate { p } else { 1.0 - p };
    (shade * top).round() as u16
}

fn read_file(path: &Path) -> Result<Vec<u8>, MapFileError> {
    std::fs::read(path).map_err(|source| MapFileError::Io {
        action: "read",
        path: path.to_owned(),
        source,
    })
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<(), MapFileError> {
    std::fs::write(path, bytes).map_err(|source| MapFileError::Io {
        action: "write",
        path: path.to_owned(),
        source,
    })
}

#[cfg(test)]
mod tests;
