//! Mass matrix and gravity, as of the last [`State::dynamics`] or [`State::forward`]:
//! M(q) q̈ + c(q, q̇) = τ, where c is [`State::bias_forces`].

use nalgebra::{DMatrix, DVector};

use crate::engine;
use crate::error::PhysicsError;
use crate::state::State;

impl State {
    /// Mass matrix, `n_v` × `n_v`, armature included. `mass` is resized when it is of another size.
    pub fn mass_matrix_into(&self, mass: &mut DMatrix<f64>) {
        let n_v = self.model().n_v();
        if mass.shape() != (n_v, n_v) {
            *mass = DMatrix::zeros(n_v, n_v);
        }
        if n_v == 0 {
            return;
        }
        // Symmetric, so row-major and column-major are one.
        // SAFETY: a live model and state, room for nv x nv values.
        let rc = unsafe {
            engine::fct_full_mass_matrix(
                self.model().as_ptr(),
                self.as_ptr(),
                mass.as_mut_slice().as_mut_ptr(),
            )
        };
        if self.check(rc, "mj_fullM").is_err() {
            mass.fill(f64::NAN);
        }
    }

    /// Gravity alone, length `n_v`: the force that holds the arm still. `forces` is resized when it is
    /// of another size. Needs [`dynamics`](Self::dynamics) or [`forward`](Self::forward) before.
    ///
    /// # Errors
    /// [`PhysicsError::Discarded`], [`PhysicsError::Engine`].
    pub fn gravity_forces_into(&mut self, forces: &mut DVector<f64>) -> Result<(), PhysicsError> {
        self.usable()?;
        let n_v = self.model().n_v();
        if forces.len() != n_v {
            *forces = DVector::zeros(n_v);
        }
        let rc = {
            let mut velocity = self.scratch();
            velocity.clear();
            velocity.resize(n_v, 0.0);
            // SAFETY: a live model and state, two arrays of nv values.
            unsafe {
                engine::fct_gravity(
                    self.model().as_ptr(),
                    self.as_ptr(),
                    velocity.as_mut_ptr(),
                    forces.as_mut_slice().as_mut_ptr(),
                )
            }
        };
        self.check(rc, "mj_rne")
    }

    /// Gravity alone, as [`gravity_forces_into`](Self::gravity_forces_into), in a new vector.
    ///
    /// # Errors
    /// As [`gravity_forces_into`](Self::gravity_forces_into).
    pub fn gravity_forces(&mut self) -> Result<DVector<f64>, PhysicsError> {
        let mut forces = DVector::zeros(self.model().n_v());
        self.gravity_forces_into(&mut forces)?;
        Ok(forces)
    }
}
