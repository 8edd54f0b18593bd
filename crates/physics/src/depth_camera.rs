//! A pinhole depth camera with segmentation, by ray casting: it needs no display or GPU, and costs
//! a fraction of a microsecond a ray.

use nalgebra::{Point3, Vector3};

use crate::Pose;
use crate::error::PhysicsError;
use crate::ids::{BodyId, GeomId};
use crate::ray_fan::{RayFan, Target};
use crate::rays::RayFilter;
use crate::state::State;

/// A pinhole camera without distortion, in pixels. Pixel (0, 0) is the upper left; its centre is at
/// (0, 0), so the principal point of a symmetric camera is at ((width − 1) / 2, (height − 1) / 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinholeCamera {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Focal length along x.
    pub fx: f64,
    /// Focal length along y.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

impl PinholeCamera {
    /// A symmetric camera with square pixels.
    ///
    /// # Errors
    /// [`PhysicsError::Argument`] when it has no pixels or the angle is not in (0, π).
    pub fn from_fovy(width: usize, height: usize, fovy_rad: f64) -> Result<Self, PhysicsError> {
        if width == 0 || height == 0 {
            return Err(PhysicsError::Argument {
                what: "image size",
                found: format!("{width} x {height}"),
                expected: "at least 1 x 1",
            });
        }
        if !(fovy_rad > 0.0 && fovy_rad < std::f64::consts::PI) {
            return Err(PhysicsError::Argument {
                what: "vertical field of view",
                found: fovy_rad.to_string(),
                expected: "radians in (0, pi)",
            });
        }
        let focal = height as f64 / (2.0 * (fovy_rad / 2.0).tan());
        Ok(Self {
            width,
            height,
            fx: focal,
            fy: focal,
            cx: (width as f64 - 1.0) / 2.0,
            cy: (height as f64 - 1.0) / 2.0,
        })
    }

    /// Direction through a pixel in the optical frame, with z = 1.
    pub fn ray_in_optical(&self, column: f64, row: f64) -> Vector3<f64> {
        Vector3::new((column - self.cx) / self.fx, (row - self.cy) / self.fy, 1.0)
    }

    /// Column and row of a point in the optical frame; `None` when it is not in front.
    pub fn pixel(&self, point_in_optical: &Point3<f64>) -> Option<(f64, f64)> {
        let p = point_in_optical;
        (p.z > 0.0).then(|| (p.x / p.z * self.fx + self.cx, p.y / p.z * self.fy + self.cy))
    }
}

/// A depth image with the geom behind each pixel, row by row from the upper left.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthImage {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Depth along the optical axis (z, not range), m; 0 where there is no return.
    pub depth_m: Vec<f32>,
    /// Geom seen; `None` where there is no return.
    pub geom: Vec<Option<GeomId>>,
}

impl DepthImage {
    /// Points in the optical frame of every pixel with a return, with its index.
    pub fn points_in_optical(
        &self,
        camera: &PinholeCamera,
    ) -> impl Iterator<Item = (usize, Point3<f64>)> + use<'_> {
        let camera = *camera;
        self.depth_m
            .iter()
            .enumerate()
            .filter(|(_, depth)| **depth > 0.0)
            .map(move |(i, &depth)| {
                let ray = camera.ray_in_optical((i % self.width) as f64, (i / self.width) as f64);
                (i, Point3::from(ray * f64::from(depth)))
            })
    }
}

/// What a depth camera sees from `world_from_optical` (z forward, x right, y down). Depths outside
/// `range_m` give no return; the bodies in `exclude` are not seen. Poses are those of the last
/// computation of `state`.
///
/// # Errors
/// As [`State::rays`].
pub fn depth_image(
    state: &State,
    camera: &PinholeCamera,
    world_from_optical: &Pose,
    range_m: [f64; 2],
    exclude: &[BodyId],
) -> Result<DepthImage, PhysicsError> {
    state.usable()?;
    let n = camera.width * camera.height;
    // Ray lengths with z = 1: depth = range / length.
    let mut lengths = Vec::with_capacity(n);
    let mut directions = Vec::with_capacity(n);
    for row in 0..camera.height {
        for column in 0..camera.width {
            let ray = camera.ray_in_optical(column as f64, row as f64);
            let length = ray.norm(); // at least 1
            lengths.push(length);
            directions.push(world_from_optical.rotation * (ray / length));
        }
    }
    let length_max = lengths.iter().copied().fold(1.0, f64::max);
    let reach_m = range_m[1] * length_max;
    let origin = Point3::from(world_from_optical.translation.vector);
    let hits = match RayFan::new(state, origin, exclude, reach_m) {
        Some(fan) => {
            state.count_rays(n as u64);
            let tiles = Tiles::new(&fan, camera, world_from_optical);
            let ray = |(i, dir)| fan.first(tiles.targets(&fan, i), dir, reach_m);
            directions.iter().enumerate().map(ray).collect()
        }
        None => state.rays(origin, &directions, &RayFilter::excluding(exclude), reach_m)?,
    };
    let mut image = DepthImage {
        width: camera.width,
        height: camera.height,
        depth_m: vec![0.0; n],
        geom: vec![None; n],
    };
    for (i, (hit, length)) in hits.into_iter().zip(lengths).enumerate() {
        if let Some((range, geom)) = hit {
            let depth = range / length;
            if depth >= range_m[0] && depth <= range_m[1] {
                image.depth_m[i] = depth as f32;
                image.geom[i] = Some(geom);
            }
        }
    }
    Ok(image)
}

/// Which geoms a part of the image can show: squares of pixels, each with its targets, nearest first.
struct Tiles {
    image_columns: usize,
    n_columns: usize,
    targets: Vec<Vec<u32>>,
}

impl Tiles {
    /// Edge of a tile, pixels.
    const EDGE: usize = 8;

    fn new(fan: &RayFan, camera: &PinholeCamera, world_from_optical: &Pose) -> Self {
        let n_columns = camera.width.div_ceil(Self::EDGE);
        let n_rows = camera.height.div_ceil(Self::EDGE);
        let mut targets = vec![Vec::new(); n_columns * n_rows];
        let optical_from_world = world_from_optical.inverse();
        for (number, target) in (0..).zip(fan.targets()) {
            let corners = target.corners().map(|corner| optical_from_world * corner);
            let Some([first, last]) = pixel_bounds(camera, &corners) else {
                continue;
            };
            for row in first[1] / Self::EDGE..=last[1] / Self::EDGE {
                for column in first[0] / Self::EDGE..=last[0] / Self::EDGE {
                    targets[row * n_columns + column].push(number);
                }
            }
        }
        Self {
            image_columns: camera.width,
            n_columns,
            targets,
        }
    }

    /// The targets that pixel `i` can show.
    fn targets<'a>(&'a self, fan: &'a RayFan, i: usize) -> impl Iterator<Item = &'a Target> {
        let (row, column) = (i / self.image_columns, i % self.image_columns);
        self.targets[row / Self::EDGE * self.n_columns + column / Self::EDGE]
            .iter()
            .map(|number| &fan.targets()[*number as usize])
    }
}

/// First and last (column, row) that a box given by its corners can cover; nothing when it is not in view. Corners whose
/// numbers differ in one bit share an edge.
fn pixel_bounds(camera: &PinholeCamera, corners: &[Point3<f64>; 8]) -> Option<[[usize; 2]; 2]> {
    /// What is nearer to the camera's plane than this is taken to be there, metres.
    const NEAR_M: f64 = 1e-6;
    let mut bounds: Option<[(f64, f64); 2]> = None;
    let mut add = |point: &Point3<f64>| {
        if let Some((column, row)) = camera.pixel(point) {
            let [low, high] = bounds.get_or_insert([(column, row); 2]);
            *low = (low.0.min(column), low.1.min(row));
            *high = (high.0.max(column), high.1.max(row));
        }
    };
    for (i, corner) in corners.iter().enumerate() {
        if corner.z >= NEAR_M {
            add(corner);
        }
        for other in [1, 2, 4].map(|bit| corners[i ^ bit]) {
            if corner.z < NEAR_M && other.z >= NEAR_M {
                let share = (NEAR_M - corner.z) / (other.z - corner.z);
                let mut cut = corner + (other - corner) * share;
                cut.z = NEAR_M;
                add(&cut);
            }
        }
    }
    let [low, high] = bounds?;
    // A pixel more to each side, for rounding.
    let clamped = |low: f64, high: f64, n: usize| {
        let last = (n - 1) as f64;
        (high >= -1.0 && low <= last + 1.0).then(|| {
            let first = (low.floor() - 1.0).clamp(0.0, last);
            [
                first as usize,
                (high.ceil() + 1.0).clamp(0.0, last) as usize,
            ]
        })
    };
    let [first_column, last_column] = clamped(low.0, high.0, camera.width)?;
    let [first_row, last_row] = clamped(low.1, high.1, camera.height)?;
    Some([[first_column, first_row], [last_column, last_row]])
}
