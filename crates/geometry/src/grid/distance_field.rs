//! Distance of every cell to the nearest occupied one.
//!
//! Method: Felzenszwalb & Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing
//! 8 (2012), section 2: the exact squared Euclidean transform as lower envelopes of parabolas, first
//! along columns, then along rows. Where we differ: along columns the envelope of a yes-or-no grid is
//! found by two sweeps, which read memory in order. Time and memory are linear in the number of cells.

use super::{CellState, OccupancyGrid};
use crate::Pose2;
use nalgebra::{Point2, Vector2};

/// Whether cells of unknown state count as obstacles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnknownCells {
    /// Only occupied cells are obstacles.
    Passable,
    /// Unknown cells are obstacles too: the robot stays where it has seen the floor.
    Blocking,
}

/// Distances to the nearest obstacle, cell by cell, on the lattice of the grid they come from.
#[derive(Debug, Clone, PartialEq)]
pub struct DistanceField {
    width: usize,
    height: usize,
    resolution_m: f64,
    world_from_grid: Pose2,
    distances_m: Vec<f32>,
}

impl DistanceField {
    /// Exact distances between cell centres: 0 in obstacles, infinite when there is none at all.
    #[must_use]
    pub fn of(grid: &OccupancyGrid, unknown: UnknownCells) -> Self {
        Self::from_obstacles(grid, |flat| match grid.cells()[flat].state() {
            CellState::Occupied => true,
            CellState::Unknown => unknown == UnknownCells::Blocking,
            CellState::Free => false,
        })
    }

    /// Exact distances to the cells (row-major indices on the lattice of `grid`) for which `is_obstacle` holds.
    #[must_use]
    pub fn from_obstacles(grid: &OccupancyGrid, is_obstacle: impl Fn(usize) -> bool) -> Self {
        let (width, height) = (grid.width(), grid.height());
        let mut squared = squared_along_columns(width, height, is_obstacle);
        let mut scratch = Envelope::with_capacity(width);
        for row in squared.chunks_exact_mut(width.max(1)) {
            scratch.transform(row);
        }
        let resolution_m = grid.resolution_m();
        Self {
            width,
            height,
            resolution_m,
            world_from_grid: *grid.world_from_grid(),
            distances_m: squared
                .iter()
                .map(|d| (d.sqrt() * resolution_m) as f32)
                .collect(),
        }
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

    /// Distances (m), row-major from the origin.
    #[must_use]
    pub fn distances_m(&self) -> &[f32] {
        &self.distances_m
    }

    /// Distance (m) at the cell that holds a point, or nothing outside the grid.
    #[must_use]
    pub fn distance_at(&self, point_in_world: &Point2<f64>) -> Option<f64> {
        let p = self.world_from_grid.inverse_transform_point(point_in_world) / self.resolution_m;
        let inside =
            p.x >= 0.0 && p.y >= 0.0 && p.x < self.width as f64 && p.y < self.height as f64;
        inside.then(|| self.at(p.x as usize, p.y as usize))
    }

    /// Distance (m) between cell centres by bilinear interpolation, with its gradient in the world frame.
    ///
    /// Nothing where one of the four cells around the point is missing or has no finite distance.
    #[must_use]
    pub fn interpolate(&self, point_in_world: &Point2<f64>) -> Option<(f64, Vector2<f64>)> {
        let p = self.world_from_grid.inverse_transform_point(point_in_world) / self.resolution_m;
        let (x, y) = (p.x - 0.5, p.y - 0.5);
        if !(x >= 0.0 && y >= 0.0) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        if column + 1 >= self.width || row + 1 >= self.height {
            return None;
        }
        let (fx, fy) = (x - column as f64, y - row as f64);
        let (d00, d10) = (self.at(column, row), self.at(column + 1, row));
        let (d01, d11) = (self.at(column, row + 1), self.at(column + 1, row + 1));
        if !(d00 + d10 + d01 + d11).is_finite() {
            return None;
        }
        let (low, high) = (d00 + fx * (d10 - d00), d01 + fx * (d11 - d01));
        let gradient_in_grid =
            Vector2::new((1.0 - fy) * (d10 - d00) + fy * (d11 - d01), high - low)
                / self.resolution_m;
        Some((
            low + fy * (high - low),
            self.world_from_grid.rotation * gradient_in_grid,
        ))
    }

    fn at(&self, column: usize, row: usize) -> f64 {
        f64::from(self.distances_m[row * self.width + column])
    }
}

/// Squared distance (cells) of every cell to the nearest obstacle in its own column, row-major.
///
/// A column holds only obstacles and infinities, so that its lower envelope is the distance to the nearer of the
/// obstacles above and below: two sweeps over whole rows, in the order in which they lie in memory.
fn squared_along_columns(
    width: usize,
    height: usize,
    is_obstacle: impl Fn(usize) -> bool,
) -> Vec<f64> {
    let mut squared = vec![f64::INFINITY; width * height];
    // Rows since the last obstacle of each column, upwards and then downwards.
    let mut n_rows_since = vec![f64::INFINITY; width];
    for (row, line) in squared.chunks_exact_mut(width.max(1)).enumerate() {
        for (column, (out, since)) in line.iter_mut().zip(&mut n_rows_since).enumerate() {
            *since = if is_obstacle(row * width + column) {
                0.0
            } else {
                *since + 1.0
            };
            *out = *since * *since;
        }
    }
    n_rows_since.fill(f64::INFINITY);
    for line in squared.chunks_exact_mut(width.max(1)).rev() {
        for (out, since) in line.iter_mut().zip(&mut n_rows_since) {
            *since = if *out == 0.0 { 0.0 } else { *since + 1.0 };
            *out = out.min(*since * *since);
        }
    }
    squared
}

/// Lower envelope of parabolas rooted at the samples of one line; buffers are kept between lines.
struct Envelope {
    values: Vec<f64>,
    vertices: Vec<usize>,
    starts: Vec<f64>,
}

impl Envelope {
    fn with_capacity(n: usize) -> Self {
        Self {
            values: Vec::with_capacity(n),
            vertices: Vec::with_capacity(n),
            starts: Vec::with_capacity(n),
        }
    }

    /// Replaces each `f(p)` by `min over q of (p - q)^2 + f(q)`.
    fn transform(&mut self, line: &mut [f64]) {
        self.values.clear();
        self.values.extend_from_slice(line);
        self.vertices.clear();
        self.starts.clear();
        for (q, &value) in self.values.iter().enumerate() {
            // Samples at infinity have no parabola; leaving them out avoids inf - inf below.
            if value.is_infinite() {
                continue;
            }
            let mut start = f64::NEG_INFINITY;
            while let Some(&v) = self.vertices.last() {
                let (qf, vf) = (q as f64, v as f64);
                start = ((value + qf * qf) - (self.values[v] + vf * vf)) / (2.0 * (qf - vf));
                if self.starts.last().is_some_and(|&s| start > s) {
                    break;
                }
                self.vertices.pop();
                self.starts.pop();
                start = f64::NEG_INFINITY;
            }
            self.vertices.push(q);
            self.starts.push(start);
        }
        if self.vertices.is_empty() {
            return;
        }
        let mut k = 0;
        for (p, out) in line.iter_mut().enumerate() {
            while self.starts.get(k + 1).is_some_and(|&s| s < p as f64) {
                k += 1;
            }
            let v = self.vertices[k];
            let d = p as f64 - v as f64;
            *out = d * d + self.values[v];
        }
    }
}
