//! How well the end of a lidar ray fits a map, as a smooth function of the place.
//!
//! Likelihood field (Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005, section 6.4):
//! `L(p) = exp(-d(p)² / 2σ²)` with `d` the distance to the nearest occupied cell. Unlike a beam model it
//! is smooth, so that it can be searched and climbed.
//!
//! For the search, level `h` of a pyramid holds at each cell the maximum of `L` over the `2^h x 2^h`
//! cells up and right of it, an upper bound for all shifts within (Hess, Kohler, Rapp & Andor, "Real-time
//! loop closure in 2D LIDAR SLAM", ICRA 2016, section V).

use factotum_geometry::Pose2;
use factotum_geometry::grid::{DistanceField, OccupancyGrid, UnknownCells};
use nalgebra::{Point2, Vector2};

/// The likelihood field of a map and its pyramid of upper bounds.
#[derive(Debug, Clone)]
pub(crate) struct LikelihoodField {
    distances: DistanceField,
    map_from_grid: Pose2,
    resolution_m: f64,
    sigma_m: f64,
    /// `levels[h]` is padded by `2^h - 1` cells below and left of the grid.
    levels: Vec<Level>,
}

#[derive(Debug, Clone)]
struct Level {
    width: usize,
    height: usize,
    pad: i32,
    values: Vec<f32>,
}

impl Level {
    fn at(&self, column: i32, row: i32) -> f32 {
        let (column, row) = (column + self.pad, row + self.pad);
        if column < 0 || row < 0 || column as usize >= self.width || row as usize >= self.height {
            return 0.0;
        }
        self.values[row as usize * self.width + column as usize]
    }
}

impl LikelihoodField {
    /// Field of a map, with upper bounds for blocks of up to `2^n_levels_up` cells.
    pub(crate) fn new(map: &OccupancyGrid, sigma_m: f64, n_levels_up: usize) -> Self {
        let distances = DistanceField::of(map, UnknownCells::Passable);
        let values = distances
            .distances_m()
            .iter()
            .map(|&d| (-0.5 * (f64::from(d) / sigma_m).powi(2)).exp() as f32)
            .collect();
        let mut levels = vec![Level {
            width: map.width(),
            height: map.height(),
            pad: 0,
            values,
        }];
        for up in 0..n_levels_up {
            let next = doubled(&levels[up], 1 << up);
            levels.push(next);
        }
        Self {
            distances,
            map_from_grid: *map.world_from_grid(),
            resolution_m: map.resolution_m(),
            sigma_m,
            levels,
        }
    }

    pub(crate) fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    pub(crate) fn map_from_grid(&self) -> &Pose2 {
        &self.map_from_grid
    }

    /// Columns and rows of the map.
    pub(crate) fn size(&self) -> (usize, usize) {
        (self.levels[0].width, self.levels[0].height)
    }

    /// Highest level of the pyramid.
    pub(crate) fn level_max(&self) -> usize {
        self.levels.len() - 1
    }

    /// Mean likelihood of points given in cells of the grid, shifted by (column, row); at level `h` an upper
    /// bound of all shifts by up to `2^h - 1` cells more.
    pub(crate) fn mean_at_level(&self, points: &[[i32; 2]], shift: [i32; 2], level: usize) -> f64 {
        let level = &self.levels[level];
        let sum: f32 = points
            .iter()
            .map(|p| level.at(p[0] + shift[0], p[1] + shift[1]))
            .sum();
        f64::from(sum) / points.len().max(1) as f64
    }

    /// Likelihood at a point of the map frame and its gradient (1/m); zero off the map.
    pub(crate) fn at(&self, point_in_map: &Point2<f64>) -> (f64, Vector2<f64>) {
        match self.distances.interpolate(point_in_map) {
            Some((d, gradient)) => {
                let value = (-0.5 * (d / self.sigma_m).powi(2)).exp();
                (
                    value,
                    gradient * (-value * d / (self.sigma_m * self.sigma_m)),
                )
            }
            None => (0.0, Vector2::zeros()),
        }
    }

    /// Mean likelihood of base-frame points with the base at a pose.
    pub(crate) fn mean(&self, points_in_base: &[Point2<f64>], map_from_base: &Pose2) -> f64 {
        let sum: f64 = points_in_base
            .iter()
            .map(|p| self.at(&(map_from_base * p)).0)
            .sum();
        sum / points_in_base.len().max(1) as f64
    }
}

/// The level above: each value the maximum of four values `reach` cells apart.
fn doubled(below: &Level, reach: usize) -> Level {
    // In padded places, value i of the level above covers values i - reach and i of the one below. Zeros
    // outside are the least likelihood, so they need not be looked at.
    let (width, height) = (below.width + reach, below.height + reach);
    let mut values = vec![0.0; width * height];
    let raise = |into: &mut [f32], from: &[f32]| {
        into.iter_mut()
            .zip(from)
            .for_each(|(value, other)| *value = value.max(*other));
    };
    for (row, line) in below.values.chunks_exact(below.width.max(1)).enumerate() {
        for above in [row, row + reach] {
            let start = above * width;
            raise(&mut values[start..start + below.width], line);
            raise(&mut values[start + reach..start + width], line);
        }
    }
    Level {
        width,
        height,
        pad: below.pad + reach as i32,
        values,
    }
}
