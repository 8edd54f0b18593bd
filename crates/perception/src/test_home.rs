//! A made-up home of straight walls, its lidar and its odometry, for tests.

use crate::sensing::LaserScan;
use factotum_geometry::Pose2;
use factotum_geometry::grid::{Cell, OccupancyGrid, cells_on_segment};
use nalgebra::{Point2, Vector2};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use std::f64::consts::TAU;

pub(crate) struct Home {
    walls: Vec<(Point2<f64>, Point2<f64>)>,
    /// A place on the floor from which all free floor can be reached.
    inside: Point2<f64>,
    size_m: Vector2<f64>,
}

pub(crate) fn pose2(x: f64, y: f64, yaw: f64) -> Pose2 {
    Pose2::new(Vector2::new(x, y), yaw)
}

/// Distance (m) and angle (rad) between two poses.
pub(crate) fn errors(found: &Pose2, truth: &Pose2) -> (f64, f64) {
    let error = found.inverse() * truth;
    (
        error.translation.vector.norm(),
        error.rotation.angle().abs(),
    )
}

impl Home {
    fn new(size_m: [f64; 2], inside: [f64; 2]) -> Self {
        let mut home = Self {
            walls: Vec::new(),
            inside: inside.into(),
            size_m: size_m.into(),
        };
        home.add_box(0.0, 0.0, size_m[0], size_m[1]);
        home
    }

    fn add_wall(&mut self, x0: f64, y0: f64, x1: f64, y1: f64) {
        self.walls.push((Point2::new(x0, y0), Point2::new(x1, y1)));
    }

    fn add_box(&mut self, x0: f64, y0: f64, x1: f64, y1: f64) {
        self.add_wall(x0, y0, x1, y0);
        self.add_wall(x1, y0, x1, y1);
        self.add_wall(x1, y1, x0, y1);
        self.add_wall(x0, y1, x0, y0);
    }

    /// Three rooms on 8 x 6 m, with furniture.
    pub(crate) fn household() -> Self {
        let mut home = Self::new([8.0, 6.0], [1.0, 1.0]);
        home.add_box(4.42, 0.0, 4.54, 2.2);
        home.add_box(4.42, 3.2, 4.54, 6.0);
        home.add_box(0.0, 3.37, 1.6, 3.49);
        home.add_box(2.7, 3.37, 4.42, 3.49);
        home.add_box(2.9, 0.0, 4.42, 0.63); // counter
        home.add_box(6.1, 2.1, 7.3, 2.9); // table
        home.add_box(7.1, 4.3, 8.0, 6.0); // bed
        home.add_box(0.0, 5.1, 0.85, 6.0); // cupboard
        home.add_box(0.3, 2.6, 0.72, 3.02); // chair
        home
    }

    /// Another home of about the same size.
    pub(crate) fn elsewhere() -> Self {
        let mut home = Self::new([7.3, 7.1], [1.0, 1.0]);
        home.add_box(0.0, 2.6, 5.2, 2.75);
        home.add_box(2.2, 4.4, 7.3, 4.55);
        home.add_box(5.9, 0.4, 6.6, 1.9);
        home.add_box(3.1, 5.6, 4.0, 6.2);
        home
    }

    /// A corridor, 30 m long, bare.
    pub(crate) fn corridor() -> Self {
        Self::new([30.0, 1.6], [15.0, 0.8])
    }

    /// Two rooms alike but for a box, joined by a door.
    pub(crate) fn twin_rooms() -> Self {
        let mut home = Self::new([8.0, 4.0], [1.0, 1.0]);
        home.add_wall(4.0, 0.0, 4.0, 3.0);
        home.add_wall(4.0, 3.0, 4.0, 3.2);
        home.add_box(1.5, 0.0, 2.5, 0.5);
        home.add_box(5.5, 0.0, 6.5, 0.5);
        home.add_wall(0.0, 2.2, 0.4, 2.2);
        home.add_wall(4.0, 2.2, 4.4, 2.2);
        home
    }

    /// A bare rectangle, which looks the same after half a turn.
    pub(crate) fn bare_room() -> Self {
        Self::new([5.0, 3.0], [1.0, 1.0])
    }

    /// Distance along a direction to the first wall (m).
    fn range(&self, from: &Point2<f64>, direction: &Vector2<f64>) -> f64 {
        let cross = |a: &Vector2<f64>, b: &Vector2<f64>| a.x * b.y - a.y * b.x;
        self.walls
            .iter()
            .filter_map(|(a, b)| {
                let along = b - a;
                let denominator = cross(direction, &along);
                let to_wall = a - from;
                let t = cross(&to_wall, &along) / denominator;
                let s = cross(&to_wall, direction) / denominator;
                (denominator.abs() > 1e-12 && t > 0.0 && (0.0..=1.0).contains(&s)).then_some(t)
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// A sweep of 360 rays with noise, half a percent of them lost.
    pub(crate) fn scan(
        &self,
        world_from_base: &Pose2,
        sigma_m: f64,
        rng: &mut ChaCha8Rng,
    ) -> LaserScan {
        let n_rays = 360;
        let (angle_min_rad, angle_step_rad) = (-TAU / 2.0, TAU / f64::from(n_rays));
        let (range_min_m, range_max_m) = (0.05, 10.0);
        let base_from_lidar = pose2(0.15, 0.0, 0.0);
        let lidar = world_from_base * base_from_lidar;
        let noise = Normal::new(0.0, sigma_m).unwrap();
        let ranges_m = (0..n_rays)
            .map(|i| {
                let angle = angle_min_rad + f64::from(i) * angle_step_rad;
                let direction = lidar.rotation * Vector2::new(angle.cos(), angle.sin());
                let range = self.range(&lidar.translation.vector.into(), &direction);
                let is_lost = rng.random_bool(0.005);
                if range > range_max_m || is_lost {
                    f64::INFINITY
                } else {
                    range + noise.sample(rng)
                }
            })
            .collect();
        LaserScan {
            angle_min_rad,
            angle_step_rad,
            ranges_m,
            range_min_m,
            range_max_m,
            base_from_lidar,
        }
    }

    /// The true map: walls that face the floor occupied, floor that can be reached free, all else unknown.
    pub(crate) fn grid(&self) -> OccupancyGrid {
        let resolution_m = 0.05;
        let cells = |m: f64| (m / resolution_m).ceil() as usize + 4;
        // The outer walls run through the middle of cells.
        let corner = pose2(-0.125, -0.125, 0.0);
        let mut grid = OccupancyGrid::filled(
            cells(self.size_m.x),
            cells(self.size_m.y),
            resolution_m,
            corner,
            Cell::UNKNOWN,
        )
        .unwrap();
        for (a, b) in &self.walls {
            let on_wall: Vec<_> =
                cells_on_segment(&grid.lattice_point(a), &grid.lattice_point(b)).collect();
            for place in on_wall {
                grid.set_cell(grid.index_of_signed(place).unwrap(), Cell::OCCUPIED);
            }
        }
        let mut open = vec![grid.index_at(&self.inside).unwrap()];
        while let Some(index) = open.pop() {
            if grid.cell(index) == Cell::UNKNOWN {
                grid.set_cell(index, Cell::FREE);
                open.extend(grid.edge_neighbours(index));
            }
        }
        for index in grid.indices() {
            let faces_floor = grid.all_neighbours(index).any(|n| grid.cell(n).is_free());
            if grid.cell(index).is_occupied() && !faces_floor {
                grid.set_cell(index, Cell::UNKNOWN);
            }
        }
        grid
    }

    /// A random pose on free floor, `clearance_m` from walls.
    pub(crate) fn free_pose(&self, clearance_m: f64, rng: &mut ChaCha8Rng) -> Pose2 {
        let grid = self.grid().inflate(clearance_m);
        loop {
            let pose = pose2(
                rng.random_range(0.0..self.size_m.x),
                rng.random_range(0.0..self.size_m.y),
                rng.random_range(-3.1..3.1),
            );
            if grid.cell_at(&pose.translation.vector.into()).is_free() {
                return pose;
            }
        }
    }
}

/// Poses every few centimetres along a path that turns towards each next place, as a robot drives.
pub(crate) fn drive(places: &[[f64; 2]]) -> Vec<Pose2> {
    let mut poses = vec![pose2(places[0][0], places[0][1], 0.0)];
    for place in &places[1..] {
        loop {
            let here = poses[poses.len() - 1];
            let ahead = here.inverse_transform_point(&Point2::from(*place));
            if ahead.coords.norm() < 0.08 {
                break;
            }
            let turn = ahead.y.atan2(ahead.x).clamp(-0.15, 0.15);
            let way = if turn.abs() < 0.05 {
                ahead.coords.norm().min(0.04)
            } else {
                0.0
            };
            poses.push(here * pose2(way, 0.0, turn));
        }
    }
    poses
}

/// Odometry along true poses: scale errors of `scale`, and a random walk of as much per step.
pub(crate) fn odometry(poses: &[Pose2], scale: f64, seed: u64) -> Vec<Pose2> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let unit = Normal::new(0.0, 1.0).unwrap();
    let (way_scale, turn_scale) = (
        1.0 + scale * unit.sample(&mut rng),
        1.0 + scale * unit.sample(&mut rng),
    );
    let mut odom = Pose2::identity();
    let mut all = vec![odom];
    for pair in poses.windows(2) {
        let motion = pair[0].inverse() * pair[1];
        let (t, turn) = (motion.translation.vector, motion.rotation.angle());
        let size = t.norm() + 0.3 * turn.abs();
        let mut walk = || 2.0 * scale * size * unit.sample(&mut rng);
        odom *= pose2(
            way_scale * t.x + walk(),
            way_scale * t.y + walk(),
            turn_scale * turn + walk(),
        );
        all.push(odom);
    }
    all
}

/// A round through all rooms of [`Home::household`].
pub(crate) fn household_round() -> Vec<Pose2> {
    drive(&[
        [1.0, 1.0],
        [2.2, 1.6],
        [2.1, 4.4],
        [3.6, 4.9],
        [1.5, 4.4],
        [2.1, 2.8],
        [3.8, 2.7],
        [5.3, 2.7],
        [5.4, 0.8],
        [7.4, 1.1],
        [5.4, 1.2],
        [5.3, 4.6],
        [6.5, 5.0],
        [5.3, 2.8],
        [3.8, 2.7],
        [1.0, 1.0],
    ])
}
