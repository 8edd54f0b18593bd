//! Many rays from one point, as a depth camera or a lidar casts them.
//!
//! The geoms are looked up once and kept nearest first, so that a ray is done when the next geom lies farther than what
//! it has met. Boxes, of which homes are made, are met here (slabs: Kay & Kajiya, SIGGRAPH 1986); other primitives are
//! left to MuJoCo. The hits are those of [`State::ray`], but for rounding.

use std::ffi::c_int;

use mujoco_rs::mujoco_c::mju_rayGeom;
use nalgebra::{Matrix3, Point3, Vector3};

use crate::geom_shape::GeomShape;
use crate::ids::{BodyId, GeomId};
use crate::state::State;

/// What rays from one point can meet.
pub(crate) struct RayFan {
    origin: Point3<f64>,
    targets: Vec<Target>,
}

/// A geom as seen from the origin.
pub(crate) struct Target {
    geom: GeomId,
    /// None of its points is nearer than this, m.
    near_m: f64,
    shape: TargetShape,
    world_from_geom: Matrix3<f64>,
    center: Point3<f64>,
    origin_in_geom: Vector3<f64>,
    /// Half extents of the box that holds it, in its own frame.
    half: Vector3<f64>,
}

enum TargetShape {
    Box,
    /// MuJoCo's type and sizes of another primitive.
    Other(c_int, [f64; 3]),
}

impl RayFan {
    /// The geoms within `range_m` that are seen from `origin`, but for those of the bodies `exclude`; nothing when some
    /// geom is not a primitive with an end, which [`State::rays`] can do.
    pub(crate) fn new(
        state: &State,
        origin: Point3<f64>,
        exclude: &[BodyId],
        range_m: f64,
    ) -> Option<Self> {
        let model = state.model();
        let mut targets = Vec::with_capacity(model.n_geoms());
        for geom in model.geoms() {
            if model.geom_rgba(geom)[3] <= 0.0 || exclude.contains(&model.geom_body(geom)) {
                continue;
            }
            let target = Target::new(state, geom, &origin)?;
            if target.near_m <= range_m {
                targets.push(target);
            }
        }
        // Stable: of geoms that are equally near the first comes first.
        targets.sort_by(|a, b| a.near_m.total_cmp(&b.near_m));
        Some(Self { origin, targets })
    }

    /// What there is to meet, nearest first.
    pub(crate) fn targets(&self) -> &[Target] {
        &self.targets
    }

    /// The first of some targets, given nearest first, that a ray meets within `range_m`: distance and geom.
    pub(crate) fn first<'a>(
        &self,
        targets: impl Iterator<Item = &'a Target>,
        dir_unit: &Vector3<f64>,
        range_m: f64,
    ) -> Option<(f64, GeomId)> {
        let mut best: Option<(f64, GeomId)> = None;
        for target in targets {
            let reach_m = best.map_or(range_m, |(distance_m, _)| distance_m);
            if target.near_m > reach_m {
                break;
            }
            let Some(distance_m) = target.distance_m(&self.origin, dir_unit) else {
                continue;
            };
            // Of surfaces that coincide the first geom is seen, as by MuJoCo.
            let is_first = best.is_none_or(|(best_m, geom)| {
                distance_m < best_m || (distance_m == best_m && target.geom < geom)
            });
            if distance_m <= reach_m && is_first {
                best = Some((distance_m, target.geom));
            }
        }
        best
    }
}

impl Target {
    fn new(state: &State, geom: GeomId, origin: &Point3<f64>) -> Option<Self> {
        use mujoco_rs::mujoco_c::mjtGeom;
        let kind = |kind: mjtGeom, size| TargetShape::Other(kind as c_int, size);
        let (shape, half) = match *state.model().geom_shape_ref(geom) {
            GeomShape::Box { half } => (TargetShape::Box, half),
            GeomShape::Sphere { r } => (kind(mjtGeom::mjGEOM_SPHERE, [r, 0.0, 0.0]), [r, r, r]),
            GeomShape::Capsule { r, half } => (
                kind(mjtGeom::mjGEOM_CAPSULE, [r, half, 0.0]),
                [r, r, half + r],
            ),
            GeomShape::Cylinder { r, half } => {
                (kind(mjtGeom::mjGEOM_CYLINDER, [r, half, 0.0]), [r, r, half])
            }
            GeomShape::Ellipsoid { radii } => (kind(mjtGeom::mjGEOM_ELLIPSOID, radii), radii),
            // Drawn planes may end; MuJoCo knows where.
            GeomShape::Plane | GeomShape::Mesh { .. } | GeomShape::HeightField => return None,
        };
        let pose = state.world_from_geom(geom);
        let origin_in_geom = pose.inverse_transform_point(origin).coords;
        let half = Vector3::from(half);
        Some(Self {
            geom,
            near_m: (origin_in_geom.abs() - half).sup(&Vector3::zeros()).norm(),
            shape,
            world_from_geom: pose.rotation.to_rotation_matrix().into_inner(),
            center: Point3::from(pose.translation.vector),
            origin_in_geom,
            half,
        })
    }

    /// Corners of the box that holds it, in the world; corner `i` is on the upper side of axis `k` if bit `k` is set.
    pub(crate) fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|corner| {
            let sign = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
            let in_geom = self
                .half
                .component_mul(&Vector3::new(sign(0), sign(1), sign(2)));
            self.center + self.world_from_geom * in_geom
        })
    }

    fn distance_m(&self, origin: &Point3<f64>, dir_unit: &Vector3<f64>) -> Option<f64> {
        match &self.shape {
            TargetShape::Box => {
                let dir_in_geom = self.world_from_geom.tr_mul(dir_unit);
                distance_to_box(&self.half, &self.origin_in_geom, &dir_in_geom)
            }
            TargetShape::Other(kind, size) => {
                let row_major: [f64; 9] = self
                    .world_from_geom
                    .transpose()
                    .data
                    .0
                    .as_flattened()
                    .try_into()
                    .ok()?;
                let (center, point): ([f64; 3], [f64; 3]) = (self.center.into(), (*origin).into());
                let dir: [f64; 3] = (*dir_unit).into();
                // SAFETY: reads arrays of the lengths it states; it fails only for geoms that are no primitives, of which
                // none is made a target. A normal is not asked for.
                let distance_m = unsafe {
                    mju_rayGeom(
                        &raw const center,
                        &raw const row_major,
                        &raw const *size,
                        &raw const point,
                        &raw const dir,
                        *kind,
                        std::ptr::null_mut(),
                    )
                };
                (distance_m >= 0.0).then_some(distance_m)
            }
        }
    }
}

/// Distance along a ray to the first face of a box about zero that lies ahead: from inside, the one it leaves by.
fn distance_to_box(half: &Vector3<f64>, origin: &Vector3<f64>, dir: &Vector3<f64>) -> Option<f64> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let inverse = dir[axis].recip();
        let a = (-half[axis] - origin[axis]) * inverse;
        let b = (half[axis] - origin[axis]) * inverse;
        // A ray within a face gives 0 times infinity here, which `min` and `max` pass over.
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    let distance_m = if enter >= 0.0 { enter } else { leave };
    (enter <= leave && distance_m >= 0.0).then_some(distance_m)
}
