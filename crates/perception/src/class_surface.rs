//! What a class looks like, from its model τ: its surfaces sampled evenly, in Λ.
//!
//! Primitive shapes are sampled on a lattice of the given spacing, triangles on a barycentric one; samples inside
//! another shape of the same object are left out, since no camera sees them. Deterministic.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use factotum_descriptions::ObjectClass;
use factotum_geometry::cloud::PointCloud;
use factotum_physics::{BodyId, GeomShape, Model, PhysicsError, State};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};

use crate::articulation::ArticulatedModel;
use crate::detect::ClassModel;

/// Distance between samples, metres: finer than the detector's voxels it thins them to is waste.
const SPACING_M: f64 = 0.01;

/// A sample: a point of the surface and the outward normal there.
type Sample = (Point3<f64>, UnitVector3<f64>);

/// A class as the detector and the joint estimators need it.
#[derive(Debug)]
pub struct ClassAppearance {
    /// The whole object.
    pub model: ClassModel,
    /// One for each joint whose link has a surface, by joint name.
    pub joints: BTreeMap<String, ArticulatedModel>,
}

/// A class whose model cannot be sampled.
#[derive(Debug, Clone, thiserror::Error)]
#[error("appearance of class `{class}`: {source}")]
pub struct AppearanceError {
    /// The class.
    pub class: String,
    /// What the physics engine says.
    pub source: PhysicsError,
}

impl ClassAppearance {
    /// Samples a class.
    ///
    /// # Errors
    /// [`AppearanceError`] if the model does not load or lacks a joint or link that the class names.
    pub fn load(class: &ObjectClass) -> Result<Self, AppearanceError> {
        Self::sample(class).map_err(|source| AppearanceError {
            class: class.name.clone(),
            source,
        })
    }

    fn sample(class: &ObjectClass) -> Result<Self, PhysicsError> {
        let physics = Model::from_mjcf_file(&class.model)?;
        let whole = surface(&physics, &usual_joints(class), |_| true)?;
        let mut joints = BTreeMap::new();
        for joint in &class.joints {
            let moving = physics.bodies_of_subtree(physics.body(&joint.link)?);
            let at_zero = BTreeMap::new();
            let fixed_part = surface(&physics, &at_zero, |body| !moving.contains(&body))?;
            let moving_part = surface(&physics, &at_zero, |body| moving.contains(&body))?;
            if let Ok(model) = ArticulatedModel::new(joint.clone(), &fixed_part, &moving_part) {
                joints.insert(joint.name.clone(), model);
            }
        }
        Ok(Self {
            model: ClassModel {
                name: class.name.clone(),
                surface: whole,
                is_yaw_symmetric: class.yaw_symmetric,
                is_upright: true,
                is_fixed: !class.movable,
                is_on_floor: class.on_floor,
            },
            joints,
        })
    }
}

/// Where the joints of an object are usually found: where the first action on them begins.
fn usual_joints(class: &ObjectClass) -> BTreeMap<String, f64> {
    let mut usual = BTreeMap::new();
    for action in &class.actions {
        if let (Some(joint), Some(initiation)) = (&action.joint, action.initiation) {
            usual.entry(joint.clone()).or_insert(initiation);
        }
    }
    usual
}

/// Surface samples of the bodies wanted, in the frame of the model's root body.
fn surface(
    physics: &Model,
    joints: &BTreeMap<String, f64>,
    is_wanted: impl Fn(BodyId) -> bool,
) -> Result<PointCloud, PhysicsError> {
    let mut state = State::new(physics)?;
    for (name, position) in joints {
        state.set_joint_position(physics.joint(name)?, *position);
    }
    state.forward_kinematics()?;
    let root = physics
        .bodies()
        .find(|body| physics.body_parent(*body).is_some());
    let object_from_world = root.map_or_else(factotum_geometry::Pose::identity, |root| {
        state.world_from_body(root).inverse()
    });
    let shapes: Vec<_> = physics
        .geoms()
        .map(|geom| {
            let object_from_geom = object_from_world * state.world_from_geom(geom);
            (
                physics.geom_body(geom),
                physics.geom_shape(geom),
                object_from_geom,
            )
        })
        .collect();
    let mut points = Vec::new();
    let mut normals = Vec::new();
    for (index, (body, shape, object_from_geom)) in shapes.iter().enumerate() {
        if !is_wanted(*body) {
            continue;
        }
        for (point, normal) in samples(shape) {
            let point = object_from_geom * point;
            let is_inside_another =
                shapes
                    .iter()
                    .enumerate()
                    .any(|(other, (_, shape, object_from_other))| {
                        other != index
                            && contains(shape, &object_from_other.inverse_transform_point(&point))
                    });
            if !is_inside_another {
                points.push(point);
                normals.push(object_from_geom.rotation * normal);
            }
        }
    }
    // Each point has its normal, so the two always match.
    Ok(PointCloud::with_normals(points.clone(), normals)
        .unwrap_or_else(|_| PointCloud::new(points)))
}

/// Samples of a shape in its own frame.
fn samples(shape: &GeomShape) -> Vec<Sample> {
    match shape {
        GeomShape::Box { half } => box_samples(half),
        GeomShape::Sphere { r } => ellipsoid_samples([*r; 3]),
        GeomShape::Ellipsoid { radii } => ellipsoid_samples(*radii),
        GeomShape::Cylinder { r, half } => {
            let mut samples = side_samples(*r, *half);
            samples.extend(disc_samples(*r, *half));
            samples
        }
        GeomShape::Capsule { r, half } => {
            let mut samples = side_samples(*r, *half);
            for (point, normal) in ellipsoid_samples([*r; 3]) {
                samples.push((point + Vector3::z() * half.copysign(point.z), normal));
            }
            samples
        }
        GeomShape::Mesh { vertices, faces } => mesh_samples(vertices, faces),
        GeomShape::Plane | GeomShape::HeightField => Vec::new(),
    }
}

fn n_steps(length_m: f64) -> usize {
    ((length_m / SPACING_M).round() as usize).max(1)
}

/// Middles of `n` equal parts of `[-half, half]`.
fn middles(half: f64) -> impl Iterator<Item = f64> + Clone {
    let n = n_steps(2.0 * half);
    (0..n).map(move |i| half * ((2 * i + 1) as f64 / n as f64 - 1.0))
}

fn box_samples(half: &[f64; 3]) -> Vec<Sample> {
    let mut samples = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for sign in [-1.0, 1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            for a in middles(half[u]) {
                for b in middles(half[v]) {
                    let mut point = Point3::origin();
                    point[axis] = sign * half[axis];
                    point[u] = a;
                    point[v] = b;
                    samples.push((point, Unit::new_unchecked(normal)));
                }
            }
        }
    }
    samples
}

fn side_samples(r: f64, half: f64) -> Vec<Sample> {
    let n_around = n_steps(TAU * r).max(8);
    middles(half)
        .flat_map(|z| {
            (0..n_around).map(move |i| {
                let (sin, cos) = (TAU * i as f64 / n_around as f64).sin_cos();
                (
                    Point3::new(r * cos, r * sin, z),
                    Unit::new_unchecked(Vector3::new(cos, sin, 0.0)),
                )
            })
        })
        .collect()
}

fn disc_samples(r: f64, half: f64) -> Vec<Sample> {
    let n_rings = n_steps(r);
    let mut samples = Vec::new();
    for ring in 0..n_rings {
        let radius = r * (ring as f64 + 0.5) / n_rings as f64;
        let n_around = n_steps(TAU * radius).max(4);
        for i in 0..n_around {
            let (sin, cos) = (TAU * i as f64 / n_around as f64).sin_cos();
            for sign in [-1.0, 1.0] {
                let point = Point3::new(radius * cos, radius * sin, sign * half);
                samples.push((point, Unit::new_unchecked(Vector3::z() * sign)));
            }
        }
    }
    samples
}

/// A Fibonacci lattice on the unit sphere, stretched.
fn ellipsoid_samples(radii: [f64; 3]) -> Vec<Sample> {
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let n = ((4.0 * PI * (largest / SPACING_M).powi(2)) as usize).clamp(16, 4096);
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..n)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / n as f64;
            let (sin, cos) = (golden * i as f64).sin_cos();
            let ring = (1.0 - z * z).max(0.0).sqrt();
            let on_unit = Vector3::new(ring * cos, ring * sin, z);
            let point = Point3::from(on_unit.component_mul(&Vector3::from(radii)));
            (
                point,
                Unit::new_normalize(on_unit.component_div(&Vector3::from(radii))),
            )
        })
        .collect()
}

fn mesh_samples(vertices: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<Sample> {
    let vertex = |index: u32| {
        vertices
            .get(index as usize)
            .map(|v| Point3::from(v.map(f64::from)))
    };
    let mut samples = Vec::new();
    for [a, b, c] in faces {
        let (Some(a), Some(b), Some(c)) = (vertex(*a), vertex(*b), vertex(*c)) else {
            continue;
        };
        let Some(normal) = Unit::try_new((b - a).cross(&(c - a)), 1e-12) else {
            continue;
        };
        let n = n_steps((b - a).norm().max((c - a).norm()));
        for i in 0..n {
            for j in 0..n - i {
                // The centre of each upright small triangle of an n-fold subdivision.
                let (u, v) = (
                    (i as f64 + 1.0 / 3.0) / n as f64,
                    (j as f64 + 1.0 / 3.0) / n as f64,
                );
                samples.push((a + (b - a) * u + (c - a) * v, normal));
            }
        }
    }
    samples
}

/// Whether a point in the shape's frame lies inside it, well clear of its surface.
fn contains(shape: &GeomShape, point: &Point3<f64>) -> bool {
    /// Shapes that only touch do not hide each other's surfaces, metres.
    const CLEAR_M: f64 = 1e-4;
    let inside = |value: f64, bound: f64| value < bound - CLEAR_M;
    match shape {
        GeomShape::Box { half } => (0..3).all(|axis| inside(point[axis].abs(), half[axis])),
        GeomShape::Sphere { r } => inside(point.coords.norm(), *r),
        GeomShape::Cylinder { r, half } => {
            inside(point.xy().coords.norm(), *r) && inside(point.z.abs(), *half)
        }
        GeomShape::Capsule { r, half } => {
            let on_axis = Point3::new(0.0, 0.0, point.z.clamp(-*half, *half));
            inside((point - on_axis).norm(), *r)
        }
        GeomShape::Ellipsoid { radii } => {
            point.coords.component_div(&Vector3::from(*radii)).norm() < 1.0 - 1e-3
        }
        GeomShape::Plane | GeomShape::Mesh { .. } | GeomShape::HeightField => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn samples_lie_on_their_shape_and_face_outwards() {
        let shapes = [
            GeomShape::Box {
                half: [0.05, 0.02, 0.1],
            },
            GeomShape::Sphere { r: 0.04 },
            GeomShape::Capsule {
                r: 0.02,
                half: 0.05,
            },
            GeomShape::Cylinder { r: 0.03, half: 0.1 },
            GeomShape::Ellipsoid {
                radii: [0.03, 0.05, 0.04],
            },
        ];
        for shape in shapes {
            let samples = samples(&shape);
            assert!(samples.len() > 50, "{shape:?}: {} samples", samples.len());
            for (point, normal) in samples {
                let (within, beyond) = (
                    point - normal.into_inner() * 2e-3,
                    point + normal.into_inner() * 2e-3,
                );
                assert!(contains(&shape, &within), "{shape:?} at {point}");
                assert!(!contains(&shape, &beyond), "{shape:?} at {point}");
            }
        }
    }

    #[test]
    fn shipped_classes_have_a_surface_and_their_joints() {
        let objects = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/objects");
        for (name, n_joints) in [
            ("bottle", 0),
            ("light_switch", 1),
            ("faucet", 1),
            ("bin", 0),
        ] {
            let class = ObjectClass::load(&objects.join(name)).unwrap();
            let appearance = ClassAppearance::load(&class).unwrap();
            assert!(
                appearance.model.surface.len() > 100,
                "{name}: {}",
                appearance.model.surface.len()
            );
            assert_eq!(appearance.joints.len(), n_joints, "{name}");
        }
    }
}
