//! Made-up objects of boxes and cylinders, their surfaces and depth images, for tests.

use crate::detect::ClassModel;
use crate::sensing::DepthFrame;
use factotum_geometry::Pose;
use factotum_geometry::cloud::PointCloud;
use factotum_geometry::frames::{body_from_optical, pose_from_xyz_rpy};
use nalgebra::{Point3, Unit, Vector3};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};

#[derive(Clone, Copy)]
pub(crate) enum Shape {
    /// Half edges (m).
    Box([f64; 3]),
    /// Radius and half height along z (m).
    Cylinder(f64, f64),
}

/// A rigid object of shapes placed in its frame Λ.
#[derive(Clone)]
pub(crate) struct Solid(pub(crate) Vec<(Pose, Shape)>);

pub(crate) fn at(xyz: [f64; 3], rpy: [f64; 3]) -> Pose {
    pose_from_xyz_rpy(xyz, rpy)
}

/// A bottle 24 cm high, Λ at the middle of its foot.
pub(crate) fn bottle() -> Solid {
    Solid(vec![
        (at([0.0, 0.0, 0.08], [0.0; 3]), Shape::Cylinder(0.035, 0.08)),
        (at([0.0, 0.0, 0.20], [0.0; 3]), Shape::Cylinder(0.014, 0.04)),
    ])
}

/// A microwave with a handle on its front (+x) right side.
pub(crate) fn microwave() -> Solid {
    Solid(vec![
        (
            at([0.0, 0.0, 0.13], [0.0; 3]),
            Shape::Box([0.16, 0.23, 0.13]),
        ),
        (
            at([0.18, -0.16, 0.13], [0.0; 3]),
            Shape::Box([0.03, 0.015, 0.09]),
        ),
    ])
}

/// A thing without any symmetry: a plate with a block on one corner and a stick on another.
pub(crate) fn toy() -> Solid {
    Solid(vec![
        (
            at([0.0, 0.0, 0.01], [0.0; 3]),
            Shape::Box([0.1, 0.07, 0.01]),
        ),
        (
            at([0.06, 0.03, 0.05], [0.0; 3]),
            Shape::Box([0.03, 0.02, 0.03]),
        ),
        (
            at([-0.07, -0.04, 0.045], [0.0; 3]),
            Shape::Cylinder(0.012, 0.035),
        ),
    ])
}

impl Shape {
    fn contains(self, p: &Point3<f64>) -> bool {
        match self {
            Self::Box(half) => (0..3).all(|i| p[i].abs() < half[i] - 1e-9),
            Self::Cylinder(radius, half) => {
                p.x.hypot(p.y) < radius - 1e-9 && p.z.abs() < half - 1e-9
            }
        }
    }

    /// Distance along a ray to the surface from outside.
    fn hit(self, from: &Point3<f64>, direction: &Vector3<f64>) -> Option<f64> {
        let slab = |i: usize, half: f64| {
            let (a, b) = (
                (-half - from[i]) / direction[i],
                (half - from[i]) / direction[i],
            );
            (a.min(b), a.max(b))
        };
        let spans = match self {
            Self::Box(half) => vec![slab(0, half[0]), slab(1, half[1]), slab(2, half[2])],
            Self::Cylinder(radius, half) => {
                let a = direction.xy().norm_squared();
                let b = from.coords.xy().dot(&direction.xy());
                let root = b * b - a * (from.coords.xy().norm_squared() - radius * radius);
                if root < 0.0 {
                    return None;
                }
                vec![
                    ((-b - root.sqrt()) / a, (-b + root.sqrt()) / a),
                    slab(2, half),
                ]
            }
        };
        let enter = spans.iter().map(|s| s.0).fold(f64::NEG_INFINITY, f64::max);
        let leave = spans.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
        (enter < leave && enter > 0.0).then_some(enter)
    }

    /// Points every `step_m` on the surface, with outward normals.
    fn samples(self, step_m: f64) -> Vec<(Point3<f64>, Vector3<f64>)> {
        let along = |half: f64| -> Vec<f64> {
            let n = (2.0 * half / step_m).ceil().max(1.0) as i32;
            (0..n)
                .map(|i| -half + 2.0 * half * (f64::from(i) + 0.5) / f64::from(n))
                .collect()
        };
        let mut samples = Vec::new();
        match self {
            Self::Box(half) => {
                for axis in 0..3 {
                    let (u_axis, v_axis) = ((axis + 1) % 3, (axis + 2) % 3);
                    for side in [-1.0, 1.0] {
                        for &u in &along(half[u_axis]) {
                            for &v in &along(half[v_axis]) {
                                let mut p = Point3::origin();
                                (p[axis], p[u_axis], p[v_axis]) = (side * half[axis], u, v);
                                let mut n = Vector3::zeros();
                                n[axis] = side;
                                samples.push((p, n));
                            }
                        }
                    }
                }
            }
            Self::Cylinder(radius, half) => {
                let n_turns = (std::f64::consts::TAU * radius / step_m).ceil() as i32;
                for i in 0..n_turns {
                    let (sin, cos) =
                        (f64::from(i) * std::f64::consts::TAU / f64::from(n_turns)).sin_cos();
                    for &z in &along(half) {
                        samples.push((
                            Point3::new(radius * cos, radius * sin, z),
                            Vector3::new(cos, sin, 0.0),
                        ));
                    }
                }
                for &x in &along(radius) {
                    for &y in &along(radius) {
                        if x.hypot(y) < radius {
                            samples.push((Point3::new(x, y, half), Vector3::z()));
                            samples.push((Point3::new(x, y, -half), -Vector3::z()));
                        }
                    }
                }
            }
        }
        samples
    }
}

impl Solid {
    /// The outer surface, sampled every `step_m`.
    pub(crate) fn surface(&self, step_m: f64) -> PointCloud {
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        for (i, (place, shape)) in self.0.iter().enumerate() {
            for (p, n) in shape.samples(step_m) {
                let p = place * p;
                let is_inside = self.0.iter().enumerate().any(|(j, (other, shape))| {
                    j != i && shape.contains(&other.inverse_transform_point(&p))
                });
                if !is_inside {
                    points.push(p);
                    normals.push(Unit::new_normalize(place * n));
                }
            }
        }
        PointCloud::with_normals(points, normals).unwrap()
    }

    pub(crate) fn class(&self, name: &str, is_yaw_symmetric: bool, is_upright: bool) -> ClassModel {
        ClassModel {
            name: name.to_owned(),
            surface: self.surface(0.008),
            is_yaw_symmetric,
            is_upright,
            is_fixed: false,
            is_on_floor: false,
        }
    }

    pub(crate) fn moved(&self, motion: &Pose) -> Self {
        Self(
            self.0
                .iter()
                .map(|(place, shape)| (motion * place, *shape))
                .collect(),
        )
    }
}

/// Things before a camera.
pub(crate) struct Scene {
    /// Solid, its pose in the base frame, its class ("" for unlabelled things).
    pub(crate) things: Vec<(Solid, Pose, &'static str)>,
    /// Depth noise at one metre (m), growing with the square of the depth.
    pub(crate) sigma_m: f64,
}

/// Camera 1.2 m above the floor, looking forward and `down_rad` down.
pub(crate) fn camera(down_rad: f64) -> Pose {
    at([0.1, 0.0, 1.2], [0.0, down_rad, 0.0]) * body_from_optical()
}

impl Scene {
    /// What a camera of 160 x 120 pixels sees, floor included.
    pub(crate) fn look(&self, base_from_optical: &Pose, seed: u64) -> DepthFrame {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let unit = Normal::new(0.0, 1.0).unwrap();
        let mut frame = DepthFrame {
            width: 160,
            height: 120,
            fx: 140.0,
            fy: 140.0,
            cx: 79.5,
            cy: 59.5,
            depth_m: Vec::new(),
            labels: Vec::new(),
            label_classes: Vec::new(),
            base_from_optical: *base_from_optical,
        };
        let mut labels = Vec::new();
        for (_, _, class) in &self.things {
            if !class.is_empty() {
                frame.label_classes.push((*class).to_owned());
            }
            labels.push(if class.is_empty() {
                0
            } else {
                frame.label_classes.len() as u16
            });
        }
        let floor = Shape::Box([20.0, 20.0, 0.5]);
        let from = Point3::from(base_from_optical.translation.vector);
        for row in 0..frame.height {
            for column in 0..frame.width {
                let in_optical = Vector3::new(
                    (column as f64 - frame.cx) / frame.fx,
                    (row as f64 - frame.cy) / frame.fy,
                    1.0,
                );
                // Depth is along the optical axis, so the direction is not normalised.
                let direction = base_from_optical * in_optical;
                let below = at([0.0, 0.0, -0.5], [0.0; 3]);
                let mut nearest = (hit(&floor, &below, &from, &direction), 0);
                for ((solid, pose, _), label) in self.things.iter().zip(&labels) {
                    for (place, shape) in &solid.0 {
                        let depth = hit(shape, &(pose * place), &from, &direction);
                        if depth < nearest.0 {
                            nearest = (depth, *label);
                        }
                    }
                }
                let (depth, label) = nearest;
                let noise = self.sigma_m * depth * depth * unit.sample(&mut rng);
                frame.depth_m.push(if depth.is_finite() {
                    (depth + noise) as f32
                } else {
                    0.0
                });
                frame.labels.push(label);
            }
        }
        frame
    }
}

fn hit(shape: &Shape, place: &Pose, from: &Point3<f64>, direction: &Vector3<f64>) -> f64 {
    let from = place.inverse_transform_point(from);
    shape
        .hit(&from, &place.inverse_transform_vector(direction))
        .unwrap_or(f64::INFINITY)
}
