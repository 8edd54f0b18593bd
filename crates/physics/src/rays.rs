//! Rays: the nearest visible geom along a direction. A geom with alpha 0 is not seen.

use std::ffi::c_int;

use nalgebra::{Point3, Vector3};

use crate::engine;
use crate::error::PhysicsError;
use crate::ids::{BodyId, GeomId};
use crate::state::State;

/// How far behind an ignored surface a ray goes on, m.
const SKIP_M: f64 = 1e-6;
/// How many ignored surfaces a ray goes through before it gives up.
const N_SKIPS_MAX: usize = 256;

/// What a ray sees.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RayFilter {
    /// Which geom groups are seen; all of them by default.
    pub groups: [bool; 6],
    /// Whether geoms fixed to the world are seen; they are by default.
    pub sees_static: bool,
    /// Bodies whose own geoms are passed through.
    pub excluded: Vec<BodyId>,
}

impl Default for RayFilter {
    fn default() -> Self {
        Self {
            groups: [true; 6],
            sees_static: true,
            excluded: Vec::new(),
        }
    }
}

impl RayFilter {
    /// Sees all but these bodies.
    pub fn excluding(bodies: &[BodyId]) -> Self {
        Self {
            excluded: bodies.to_vec(),
            ..Self::default()
        }
    }

    fn group_bytes(&self) -> [u8; 6] {
        self.groups.map(u8::from)
    }

    /// The one body MuJoCo itself can exclude.
    fn first_excluded(&self) -> c_int {
        self.excluded
            .first()
            .map_or(-1, |body| c_int::try_from(body.0).unwrap_or(-1))
    }
}

/// What a ray met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// Distance from the origin along the direction, m.
    pub distance_m: f64,
    /// The geom.
    pub geom: GeomId,
    /// Outward unit normal of its surface, in the world.
    pub normal: Vector3<f64>,
}

impl State {
    /// The nearest geom along a ray in the world; `None` when there is none. Poses are those of the
    /// last computation. After a failure inside MuJoCo it is `None` and the state is discarded, see
    /// [`usable`](Self::usable).
    pub fn ray(
        &self,
        origin: Point3<f64>,
        dir_unit: Vector3<f64>,
        filter: &RayFilter,
    ) -> Option<RayHit> {
        self.ray_from(origin, dir_unit, filter, 0.0)
    }

    /// As [`ray`](Self::ray), starting `start_m` along it.
    fn ray_from(
        &self,
        origin: Point3<f64>,
        dir_unit: Vector3<f64>,
        filter: &RayFilter,
        start_m: f64,
    ) -> Option<RayHit> {
        self.usable().ok()?;
        let groups = filter.group_bytes();
        let direction: [f64; 3] = dir_unit.into();
        let mut start_m = start_m;
        for _ in 0..N_SKIPS_MAX {
            let point: [f64; 3] = (origin + dir_unit * start_m).coords.into();
            let mut geom = -1;
            let mut normal = [0.0; 3];
            let mut distance = -1.0;
            // SAFETY: a live model and state; a point, a direction and a normal of 3 values, six
            // groups, and places for the results.
            let rc = unsafe {
                engine::fct_ray(
                    self.model().as_ptr(),
                    self.as_ptr(),
                    point.as_ptr(),
                    direction.as_ptr(),
                    groups.as_ptr(),
                    filter.sees_static,
                    filter.first_excluded(),
                    &raw mut geom,
                    normal.as_mut_ptr(),
                    &raw mut distance,
                )
            };
            self.count_rays(1);
            self.check(rc, "mj_ray").ok()?;
            let geom = GeomId(usize::try_from(geom).ok()?);
            if !filter.excluded.contains(&self.model().geom_body(geom)) {
                return Some(RayHit {
                    distance_m: start_m + distance,
                    geom,
                    normal: Vector3::from(normal),
                });
            }
            start_m += distance + SKIP_M;
        }
        None
    }

    /// The nearest geom along many rays from one point, within `cutoff_m`; a few times faster than
    /// [`ray`](Self::ray) for each. The result has no normals: distance and geom, or `None`.
    ///
    /// # Errors
    /// [`PhysicsError::Engine`] when the state has too little memory, [`PhysicsError::Discarded`].
    pub fn rays(
        &self,
        origin: Point3<f64>,
        dirs_unit: &[Vector3<f64>],
        filter: &RayFilter,
        cutoff_m: f64,
    ) -> Result<Vec<Option<(f64, GeomId)>>, PhysicsError> {
        self.usable()?;
        let n = dirs_unit.len();
        if n == 0 {
            return Ok(Vec::new());
        }
        let point: [f64; 3] = origin.coords.into();
        let directions: Vec<f64> = dirs_unit
            .iter()
            .flat_map(|dir| [dir.x, dir.y, dir.z])
            .collect();
        let groups = filter.group_bytes();
        let mut geoms: Vec<c_int> = vec![-1; n];
        let mut distances = vec![-1.0; n];
        // SAFETY: a live model and state; n directions, room for n geoms and n distances. The
        // state's scratch memory is written; no reference to it is held.
        let rc = unsafe {
            engine::fct_multi_ray(
                self.model().as_ptr(),
                self.as_ptr(),
                point.as_ptr(),
                directions.as_ptr(),
                groups.as_ptr(),
                filter.sees_static,
                filter.first_excluded(),
                geoms.as_mut_ptr(),
                distances.as_mut_ptr(),
                c_int::try_from(n).unwrap_or(c_int::MAX),
                cutoff_m,
            )
        };
        self.count_rays(u64::try_from(n).unwrap_or(u64::MAX));
        self.check(rc, "mj_multiRay")?;
        let hits = geoms.iter().zip(&distances).zip(dirs_unit);
        let result = hits
            .map(|((&geom, &distance), dir)| {
                let geom = GeomId(usize::try_from(geom).ok()?);
                let (distance, geom) = if filter.excluded.contains(&self.model().geom_body(geom)) {
                    let hit = self.ray_from(origin, *dir, filter, distance + SKIP_M)?;
                    (hit.distance_m, hit.geom)
                } else {
                    (distance, geom)
                };
                (distance <= cutoff_m).then_some((distance, geom))
            })
            .collect();
        self.usable()?;
        Ok(result)
    }
}
