//! Copies of a model with some numbers changed: friction, gravity, the time step.

use std::ptr::NonNull;

use mujoco_rs::mujoco_c::{mj_deleteModel, mjModel};
use nalgebra::Vector3;

use crate::engine;
use crate::error::PhysicsError;
use crate::ids::{GeomId, JointId};
use crate::model::Model;
use crate::tables::Tables;

/// Numbers of a model that may be changed in a copy; see [`Model::edited`].
#[derive(Debug)]
pub struct ModelEdit<'a> {
    raw: &'a mut mjModel,
    tables: &'a Tables,
}

impl ModelEdit<'_> {
    /// Sets the length of a step, s.
    ///
    /// # Errors
    /// [`PhysicsError::Argument`] when it is not positive.
    pub fn set_timestep_secs(&mut self, timestep_secs: f64) -> Result<(), PhysicsError> {
        if !(timestep_secs.is_finite() && timestep_secs > 0.0) {
            return Err(PhysicsError::Argument {
                what: "timestep",
                found: timestep_secs.to_string(),
                expected: "a positive number of seconds",
            });
        }
        self.raw.opt.timestep = timestep_secs;
        Ok(())
    }

    /// Sets gravity in the world, m/s².
    pub fn set_gravity(&mut self, gravity: Vector3<f64>) {
        self.raw.opt.gravity = gravity.into();
    }

    /// Sets the sliding, torsional and rolling friction of a geom.
    pub fn set_geom_friction(&mut self, geom: GeomId, friction: [f64; 3]) {
        let n = self.tables.geoms.len();
        // SAFETY: geom_friction holds ngeom x 3 values; the copy is held by this edit alone.
        let values = unsafe { std::slice::from_raw_parts_mut(self.raw.geom_friction, 3 * n) };
        values[3 * geom.0..3 * geom.0 + 3].copy_from_slice(&friction);
    }

    /// Sets which geoms a geom collides with: a pair collides when the type of one shares a bit with
    /// the affinity of the other. Bodies fixed to each other and excluded pairs still do not.
    pub fn set_geom_contact_bits(&mut self, geom: GeomId, contype: i32, conaffinity: i32) {
        let n = self.tables.geoms.len();
        // SAFETY: geom_contype holds ngeom values; the copy is held by this edit alone.
        let types = unsafe { std::slice::from_raw_parts_mut(self.raw.geom_contype, n) };
        types[geom.0] = contype;
        // SAFETY: geom_conaffinity holds ngeom values; as above.
        let affinities = unsafe { std::slice::from_raw_parts_mut(self.raw.geom_conaffinity, n) };
        affinities[geom.0] = conaffinity;
        // MuJoCo's first filter looks at the union over each body's geoms.
        let body = self.tables.geoms[geom.0].body;
        let union = |bits: &[i32]| {
            let geoms = self.tables.geoms.iter().zip(bits);
            geoms
                .filter(|(geom, _)| geom.body == body)
                .fold(0, |union, (_, bits)| union | bits)
        };
        let n_bodies = self.tables.bodies.len();
        // SAFETY: body_contype holds nbody values; as above.
        let of_bodies = unsafe { std::slice::from_raw_parts_mut(self.raw.body_contype, n_bodies) };
        of_bodies[body] = union(types);
        // SAFETY: body_conaffinity holds nbody values; as above.
        let of_bodies =
            unsafe { std::slice::from_raw_parts_mut(self.raw.body_conaffinity, n_bodies) };
        of_bodies[body] = union(affinities);
    }

    /// Multiplies damping and dry friction of a hinge or slide, by factors of at least 0.
    ///
    /// # Errors
    /// [`PhysicsError::Argument`] for a factor that is negative or not finite.
    pub fn scale_joint_resistance(
        &mut self,
        joint: JointId,
        damping: f64,
        friction: f64,
    ) -> Result<(), PhysicsError> {
        for (what, factor) in [("damping factor", damping), ("friction factor", friction)] {
            if !(factor >= 0.0 && factor.is_finite()) {
                return Err(PhysicsError::Argument {
                    what,
                    found: factor.to_string(),
                    expected: "a finite number of at least 0",
                });
            }
        }
        let dof = self.tables.joints[joint.0].dof_adr;
        let n = self.tables.n_v;
        // SAFETY: dof_damping holds nv values; the copy is held by this edit alone.
        let dampings = unsafe { std::slice::from_raw_parts_mut(self.raw.dof_damping, n) };
        dampings[dof] *= damping;
        // SAFETY: dof_frictionloss holds nv values; as above.
        let frictions = unsafe { std::slice::from_raw_parts_mut(self.raw.dof_frictionloss, n) };
        frictions[dof] *= friction;
        Ok(())
    }

    /// Sets the distance (m) from which a geom's contacts are found.
    pub fn set_geom_margin(&mut self, geom: GeomId, margin_m: f64) {
        let n = self.tables.geoms.len();
        // SAFETY: geom_margin holds ngeom values; the copy is held by this edit alone.
        let margins = unsafe { std::slice::from_raw_parts_mut(self.raw.geom_margin, n) };
        margins[geom.0] = margin_m;
        let n_bodies = self.tables.bodies.len();
        // SAFETY: body_margin, the largest of a body's geoms, holds nbody values; as above.
        let of_bodies = unsafe { std::slice::from_raw_parts_mut(self.raw.body_margin, n_bodies) };
        let of_body = &mut of_bodies[self.tables.geoms[geom.0].body];
        *of_body = of_body.max(margin_m);
    }

    /// Takes a geom out of collision detection; it is still seen by rays.
    pub fn disable_geom_contacts(&mut self, geom: GeomId) {
        let n = self.tables.geoms.len();
        // SAFETY: geom_contype holds ngeom values; the copy is held by this edit alone.
        let types = unsafe { std::slice::from_raw_parts_mut(self.raw.geom_contype, n) };
        types[geom.0] = 0;
        // SAFETY: geom_conaffinity holds ngeom values; as above.
        let affinities = unsafe { std::slice::from_raw_parts_mut(self.raw.geom_conaffinity, n) };
        affinities[geom.0] = 0;
    }
}

impl Model {
    /// A copy of the model with some numbers changed.
    ///
    /// # Errors
    /// [`PhysicsError::Engine`] when there is no memory; [`PhysicsError::Argument`] from the edits.
    pub fn edited(
        &self,
        edit: impl FnOnce(&mut ModelEdit<'_>) -> Result<(), PhysicsError>,
    ) -> Result<Self, PhysicsError> {
        let mut copy = std::ptr::null_mut();
        // SAFETY: a live model and a place for the result; mj_copyModel allocates when given NULL.
        let rc = unsafe { engine::fct_copy_model(self.as_ptr(), &raw mut copy) };
        let mut raw = match (rc, NonNull::new(copy)) {
            (engine::OK, Some(raw)) => raw,
            _ => return Err(engine::fatal("mj_copyModel")),
        };
        // SAFETY: a live model that nothing else holds yet.
        let copied = unsafe { raw.as_mut() };
        let result = edit(&mut ModelEdit {
            raw: copied,
            tables: self.tables(),
        });
        if let Err(error) = result {
            // SAFETY: as above; it is not used again.
            unsafe { mj_deleteModel(raw.as_ptr()) };
            return Err(error);
        }
        Self::from_raw(raw)
    }
}
