//! A state, kept aside, to return to exactly.

use std::ffi::c_int;

use mujoco_rs::mujoco_c::{mj_stateSize, mjtState};

use crate::engine;
use crate::error::PhysicsError;
use crate::model::Model;
use crate::state::State;

/// All that a step depends on: time, positions, velocities, activations, controls, applied forces,
/// mocap poses, and the solver's warm start. Stepping from a restored state gives the same bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    model: String,
    values: Vec<f64>,
}

/// What tells models apart: the name, and MuJoCo's hash of the structure, which is the same whenever
/// the same files are compiled.
fn identity(model: &Model) -> String {
    format!("{} ({:016x})", model.name(), model.tables().signature)
}

impl Snapshot {
    /// The numbers, in MuJoCo's order (`mjSTATE_INTEGRATION`), to write to a file.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// A snapshot from numbers that [`values`](Self::values) gave.
    ///
    /// # Errors
    /// [`PhysicsError::Size`] when they are not as many as the model's state has.
    pub fn from_values(model: &Model, values: Vec<f64>) -> Result<Self, PhysicsError> {
        let expected = size(model);
        if values.len() != expected {
            return Err(PhysicsError::Size {
                what: "snapshot",
                found: values.len(),
                expected,
            });
        }
        Ok(Self {
            model: identity(model),
            values,
        })
    }

    /// Simulated time, s.
    pub fn time_secs(&self) -> f64 {
        self.values.first().copied().unwrap_or(0.0)
    }
}

fn signature() -> c_int {
    mjtState::mjSTATE_INTEGRATION as c_int
}

fn size(model: &Model) -> usize {
    // SAFETY: a live model; the signature is one of MuJoCo's own, so it cannot fail.
    let n = unsafe { mj_stateSize(model.as_ptr(), signature()) };
    usize::try_from(n).unwrap_or(0)
}

impl State {
    /// Keeps the state aside.
    pub fn snapshot(&self) -> Snapshot {
        let mut values = vec![0.0; size(self.model())];
        // SAFETY: a live model and state, and room for as many values as mj_stateSize says.
        let rc = unsafe {
            engine::fct_get_state(
                self.model().as_ptr(),
                self.as_ptr(),
                values.as_mut_ptr(),
                signature(),
            )
        };
        if self.check(rc, "mj_getState").is_err() {
            values.fill(f64::NAN);
        }
        Snapshot {
            model: identity(self.model()),
            values,
        }
    }

    /// Returns to a snapshot. What follows from the state (poses, contacts, forces) is as before until
    /// the next computation.
    ///
    /// # Errors
    /// [`PhysicsError::SnapshotModel`] or [`PhysicsError::Size`] for another model's snapshot,
    /// [`PhysicsError::Discarded`].
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), PhysicsError> {
        self.usable()?;
        let own = identity(self.model());
        if snapshot.model != own {
            return Err(PhysicsError::SnapshotModel {
                found: snapshot.model.clone(),
                expected: own,
            });
        }
        let expected = size(self.model());
        if snapshot.values.len() != expected {
            return Err(PhysicsError::Size {
                what: "snapshot",
                found: snapshot.values.len(),
                expected,
            });
        }
        // SAFETY: a live model and state, and as many values as mj_stateSize says.
        let rc = unsafe {
            engine::fct_set_state(
                self.model().as_ptr(),
                self.as_ptr(),
                snapshot.values.as_ptr(),
                signature(),
            )
        };
        self.check(rc, "mj_setState")
    }
}
