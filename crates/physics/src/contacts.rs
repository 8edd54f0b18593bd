//! Contacts found by the last computation, and the forces they carry.

use std::ffi::c_int;

use mujoco_rs::mujoco_c::mjContact;
use nalgebra::{Matrix3, Point3, Vector3};

use crate::engine;
use crate::ids::GeomId;
use crate::state::State;

/// Two geoms that touch, or are nearer than their margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Place in the list, for [`State::contact_wrench`].
    pub idx: usize,
    /// First geom.
    pub geom_a: GeomId,
    /// Second geom.
    pub geom_b: GeomId,
    /// Midpoint between the surfaces, in the world.
    pub point: Point3<f64>,
    /// Unit normal in the world, from the first geom to the second.
    pub normal: Vector3<f64>,
    /// Distance between the surfaces, m; negative where they overlap.
    pub distance_m: f64,
}

/// What the first geom of a contact does to the second, in world axes, at the contact point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactWrench {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Torque, N m.
    pub torque: Vector3<f64>,
}

impl State {
    fn raw_contacts(&self) -> &[mjContact] {
        let n = usize::try_from(self.raw().ncon).unwrap_or(0);
        let pointer = self.raw().contact;
        if n == 0 || pointer.is_null() {
            return &[];
        }
        // SAFETY: mjdata.h: `contact` holds ncon contacts; they stay until the next computation,
        // which needs the state mutably.
        unsafe { std::slice::from_raw_parts(pointer.cast_const(), n) }
    }

    /// Contacts between geoms, of the last computation that looked for them.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        self.raw_contacts()
            .iter()
            .enumerate()
            .filter_map(|(idx, raw)| {
                // Negative for a flexible body, which has no geom.
                let geom_a = GeomId(usize::try_from(raw.geom[0]).ok()?);
                let geom_b = GeomId(usize::try_from(raw.geom[1]).ok()?);
                Some(Contact {
                    idx,
                    geom_a,
                    geom_b,
                    point: Point3::from(raw.pos),
                    normal: Vector3::new(raw.frame[0], raw.frame[1], raw.frame[2]),
                    distance_m: raw.dist,
                })
            })
    }

    /// Number of contacts, flexible bodies' included.
    pub fn n_contacts(&self) -> usize {
        self.raw_contacts().len()
    }

    /// What the first geom of contact `idx` does to the second; `None` when there is no such contact.
    /// Needs [`forward`](State::forward) or [`step`](State::step); after the latter it is the force
    /// that acted during the step. Zero where no constraint was made, as after
    /// [`detect_collisions`](State::detect_collisions).
    pub fn contact_wrench(&self, idx: usize) -> Option<ContactWrench> {
        let raw = self.raw_contacts().get(idx)?;
        if raw.efc_address < 0 {
            return Some(ContactWrench {
                force: Vector3::zeros(),
                torque: Vector3::zeros(),
            });
        }
        let mut wrench = [0.0; 6];
        // SAFETY: a live model and state, a contact of it, room for 6 values.
        let rc = unsafe {
            engine::fct_contact_force(
                self.model().as_ptr(),
                self.as_ptr(),
                c_int::try_from(idx).ok()?,
                wrench.as_mut_ptr(),
            )
        };
        self.check(rc, "mj_contactForce").ok()?;
        // Rows of the frame are its axes in the world, the normal first.
        let world_from_contact = Matrix3::from_row_slice(&raw.frame).transpose();
        let [fx, fy, fz, tx, ty, tz] = wrench;
        Some(ContactWrench {
            force: world_from_contact * Vector3::new(fx, fy, fz),
            torque: world_from_contact * Vector3::new(tx, ty, tz),
        })
    }

    /// Force, N in the world, that geoms `a` together do to geoms `b`.
    pub fn contact_force_between(&self, a: &[GeomId], b: &[GeomId]) -> Vector3<f64> {
        self.contacts().fold(Vector3::zeros(), |sum, contact| {
            let sign = if a.contains(&contact.geom_a) && b.contains(&contact.geom_b) {
                1.0
            } else if a.contains(&contact.geom_b) && b.contains(&contact.geom_a) {
                -1.0
            } else {
                return sum;
            };
            self.contact_wrench(contact.idx)
                .map_or(sum, |wrench| sum + sign * wrench.force)
        })
    }

    /// Force, N in the world, that everything else does to these geoms: a fingertip's load.
    pub fn contact_force_on(&self, geoms: &[GeomId]) -> Vector3<f64> {
        self.contacts().fold(Vector3::zeros(), |sum, contact| {
            let sign = match (
                geoms.contains(&contact.geom_a),
                geoms.contains(&contact.geom_b),
            ) {
                (false, true) => 1.0,
                (true, false) => -1.0,
                // Between two of them, or between two others.
                _ => return sum,
            };
            self.contact_wrench(contact.idx)
                .map_or(sum, |wrench| sum + sign * wrench.force)
        })
    }

    /// Whether any of geoms `a` touches any of geoms `b`.
    pub fn are_touching(&self, a: &[GeomId], b: &[GeomId]) -> bool {
        self.contacts().any(|contact| {
            contact.distance_m <= 0.0
                && (a.contains(&contact.geom_a) && b.contains(&contact.geom_b)
                    || a.contains(&contact.geom_b) && b.contains(&contact.geom_a))
        })
    }

    /// Shortest distance between two geoms, m, up to `distance_max_m`; negative where they overlap.
    /// Needs [`forward_kinematics`](State::forward_kinematics).
    ///
    /// # Errors
    /// [`PhysicsError::Engine`](crate::PhysicsError::Engine),
    /// [`PhysicsError::Discarded`](crate::PhysicsError::Discarded).
    pub fn geom_distance_m(
        &self,
        a: GeomId,
        b: GeomId,
        distance_max_m: f64,
    ) -> Result<f64, crate::PhysicsError> {
        self.usable()?;
        let mut segment = [0.0; 6];
        let mut distance = 0.0;
        // SAFETY: a live model and state, two geoms of it, room for 6 values and 1. The state's
        // scratch memory is written; no reference to it is held.
        let rc = unsafe {
            engine::fct_geom_distance(
                self.model().as_ptr(),
                self.as_ptr(),
                c_int::try_from(a.0).unwrap_or(0),
                c_int::try_from(b.0).unwrap_or(0),
                distance_max_m,
                segment.as_mut_ptr(),
                &raw mut distance,
            )
        };
        self.check(rc, "mj_geomDistance")?;
        Ok(distance)
    }
}
