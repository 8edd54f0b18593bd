//! The simulation state of one model, and the calls that move it on.

use std::cell::{Cell, RefCell};
use std::ffi::c_int;
use std::ptr::NonNull;

use mujoco_rs::mujoco_c::{mj_deleteData, mjData, mjModel, mjtWarning};

use crate::engine;
use crate::error::PhysicsError;
use crate::ids::KeyframeId;
use crate::model::Model;

/// Mutable state of a [`Model`] (`mjData`): positions, velocities, controls and what follows from
/// them. It may move between threads, and is used by one at a time.
#[derive(Debug)]
pub struct State {
    model: Model,
    data: NonNull<mjData>,
    /// The failure that made the state unusable, if any.
    discarded: RefCell<Option<PhysicsError>>,
    /// Rows of a Jacobian or a mass matrix on their way from MuJoCo.
    scratch: RefCell<Vec<f64>>,
    n_rays_cast: Cell<u64>,
}

// SAFETY: mjData is owned here alone; MuJoCo keeps no thread-local data for it. Not Sync: some
// queries by `&State` use its scratch memory.
unsafe impl Send for State {}

impl Drop for State {
    fn drop(&mut self) {
        // SAFETY: made by mj_makeData, owned here alone; the model lives until after this.
        unsafe { mj_deleteData(self.data.as_ptr()) };
    }
}

/// A guarded call that checks numbers: model, data, kind and index of the warning.
type CheckedCall =
    unsafe extern "C" fn(*const mjModel, *mut mjData, *mut c_int, *mut c_int) -> c_int;

/// A view of an array of mjData; `$n` is the number of values, as `mjdata.h` states it.
macro_rules! view {
    ($state:expr, $field:ident, $n:expr) => {{
        let n: usize = $n;
        let pointer = $state.raw().$field;
        if n == 0 || pointer.is_null() {
            &[][..]
        } else {
            // SAFETY: mjdata.h states the length of each array beside its field; `$n` repeats it
            // from the same model; the array lives and stays in place as long as the state.
            unsafe { std::slice::from_raw_parts(pointer.cast_const(), n) }
        }
    }};
}
pub(crate) use view;

/// A mutable view, as [`view`].
macro_rules! view_mut {
    ($state:expr, $field:ident, $n:expr) => {{
        let n: usize = $n;
        let pointer = $state.raw_mut().$field;
        if n == 0 || pointer.is_null() {
            &mut [][..]
        } else {
            // SAFETY: as in `view`, and the state is borrowed mutably.
            unsafe { std::slice::from_raw_parts_mut(pointer, n) }
        }
    }};
}
pub(crate) use view_mut;

impl State {
    /// The reference state of a model.
    ///
    /// # Errors
    /// [`PhysicsError::Engine`] when MuJoCo cannot allocate or initialise it.
    pub fn new(model: &Model) -> Result<Self, PhysicsError> {
        let mut raw = std::ptr::null_mut();
        // SAFETY: a live model and a place for the result.
        let rc = unsafe { engine::fct_make_data(model.as_ptr(), &raw mut raw) };
        match (rc, NonNull::new(raw)) {
            (engine::OK, Some(data)) => Ok(Self {
                model: model.clone(),
                data,
                discarded: RefCell::new(None),
                scratch: RefCell::new(Vec::new()),
                n_rays_cast: Cell::new(0),
            }),
            _ => Err(engine::fatal("mj_makeData")),
        }
    }

    /// A copy that goes its own way, with everything computed so far.
    ///
    /// # Errors
    /// [`PhysicsError::Engine`] when MuJoCo cannot allocate it, [`PhysicsError::Discarded`].
    pub fn try_clone(&self) -> Result<Self, PhysicsError> {
        self.usable()?;
        let copy = Self::new(&self.model)?;
        // SAFETY: two live states of one model.
        let rc = unsafe {
            engine::fct_copy_data(self.model.as_ptr(), copy.data.as_ptr(), self.data.as_ptr())
        };
        if rc == engine::OK {
            Ok(copy)
        } else {
            Err(engine::fatal("mj_copyData"))
        }
    }

    pub(crate) fn raw(&self) -> &mjData {
        // SAFETY: alive as long as the state; no reference to it is kept across a MuJoCo call.
        unsafe { self.data.as_ref() }
    }

    pub(crate) fn raw_mut(&mut self) -> &mut mjData {
        // SAFETY: alive as long as the state, and borrowed mutably.
        unsafe { self.data.as_mut() }
    }

    pub(crate) fn as_ptr(&self) -> *mut mjData {
        self.data.as_ptr()
    }

    pub(crate) fn scratch(&self) -> std::cell::RefMut<'_, Vec<f64>> {
        self.scratch.borrow_mut()
    }

    pub(crate) fn count_rays(&self, n: u64) {
        self.n_rays_cast.set(self.n_rays_cast.get() + n);
    }

    /// How many rays were cast in this state, for accounting.
    pub fn n_rays_cast(&self) -> u64 {
        self.n_rays_cast.get()
    }

    /// The model this is a state of.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Whether an earlier failure made the state unusable.
    ///
    /// # Errors
    /// [`PhysicsError::Discarded`] with the cause.
    pub fn usable(&self) -> Result<(), PhysicsError> {
        match self.discarded.borrow().as_ref() {
            None => Ok(()),
            Some(cause) => Err(PhysicsError::Discarded {
                cause: Box::new(cause.clone()),
            }),
        }
    }

    /// Turns the return code of a guarded call on this state into a result; a fatal error discards
    /// the state.
    pub(crate) fn check(&self, rc: c_int, call: &'static str) -> Result<(), PhysicsError> {
        if rc == engine::OK {
            return Ok(());
        }
        let error = engine::fatal(call);
        *self.discarded.borrow_mut() = Some(error.clone());
        // SAFETY: a live state; only its counts are written.
        unsafe { engine::fct_abandon(self.data.as_ptr()) };
        Err(error)
    }

    fn run(&mut self, call: CheckedCall, name: &'static str) -> Result<(), PhysicsError> {
        if self.discarded.get_mut().is_some() {
            return self.usable();
        }
        let (mut kind, mut info) = (0, 0);
        // SAFETY: a live model and a live state of it, and places for the results.
        let rc = unsafe {
            call(
                self.model.as_ptr(),
                self.data.as_ptr(),
                &raw mut kind,
                &raw mut info,
            )
        };
        match rc {
            engine::OK => Ok(()),
            engine::WARNING => Err(self.warning(kind, info)),
            _ => self.check(rc, name),
        }
    }

    fn warning(&self, kind: c_int, info: c_int) -> PhysicsError {
        let time_secs = self.time_secs();
        let at = usize::try_from(info).unwrap_or(0);
        let is = |warning: mjtWarning| kind == warning as c_int;
        let diverged = |quantity, owner| PhysicsError::Diverged {
            quantity,
            owner,
            time_secs,
        };
        if is(mjtWarning::mjWARN_BADQPOS) {
            diverged("qpos", self.model.qpos_owner(at))
        } else if is(mjtWarning::mjWARN_BADQVEL) {
            diverged("qvel", self.model.dof_owner(at))
        } else if is(mjtWarning::mjWARN_BADQACC) {
            diverged("qacc", self.model.dof_owner(at))
        } else if is(mjtWarning::mjWARN_BADCTRL) {
            let named = self
                .model
                .actuators()
                .find(|&id| self.model.ctrl_adr(id) == at);
            let owner = named.map_or_else(
                || format!("control {at}"),
                |id| format!("actuator `{}`", self.model.actuator_name(id)),
            );
            diverged("ctrl", owner)
        } else if is(mjtWarning::mjWARN_INERTIA) {
            PhysicsError::SingularInertia {
                owner: self.model.dof_owner(at),
                time_secs,
            }
        } else {
            let contacts = is(mjtWarning::mjWARN_CONTACTFULL);
            PhysicsError::Full {
                what: if contacts { "contacts" } else { "constraints" },
                found: at,
                time_secs,
            }
        }
    }

    /// Returns to the reference state.
    ///
    /// # Errors
    /// [`PhysicsError::Discarded`] after a fatal error, [`PhysicsError::Engine`] on a new one.
    pub fn reset(&mut self) -> Result<(), PhysicsError> {
        self.usable()?;
        // SAFETY: a live model and a live state of it.
        let rc = unsafe { engine::fct_reset_data(self.model.as_ptr(), self.data.as_ptr()) };
        self.check(rc, "mj_resetData")
    }

    /// Returns to a keyframe of the model.
    ///
    /// # Errors
    /// As [`reset`](Self::reset).
    pub fn reset_to_keyframe(&mut self, keyframe: KeyframeId) -> Result<(), PhysicsError> {
        self.usable()?;
        // SAFETY: a live model and a live state of it; MuJoCo checks the index.
        let rc = unsafe {
            engine::fct_reset_keyframe(
                self.model.as_ptr(),
                self.data.as_ptr(),
                c_int::try_from(keyframe.0).unwrap_or(0),
            )
        };
        self.check(rc, "mj_resetDataKeyframe")
    }

    /// Moves on by one time step.
    ///
    /// # Errors
    /// [`PhysicsError::Diverged`], [`PhysicsError::Full`] or [`PhysicsError::SingularInertia`] when
    /// physics broke down (auto-reset is off, so nothing is hidden); [`PhysicsError::Engine`] when
    /// MuJoCo failed, after which the state is [`PhysicsError::Discarded`]. What is found before the
    /// step (bad positions or velocities) leaves the state as it was; what is found in it (bad
    /// accelerations or controls, dropped contacts) leaves a state to restore, not to go on from.
    pub fn step(&mut self) -> Result<(), PhysicsError> {
        self.run(engine::fct_step, "mj_step")
    }

    /// First half of a step, up to velocities: set controls after it, then call [`step2`](Self::step2).
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn step1(&mut self) -> Result<(), PhysicsError> {
        self.run(engine::fct_step1, "mj_step1")
    }

    /// Second half of a step. Not for the RK4 integrator.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn step2(&mut self) -> Result<(), PhysicsError> {
        self.run(engine::fct_step2, "mj_step2")
    }

    /// Computes everything that follows from the state, without moving on.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn forward(&mut self) -> Result<(), PhysicsError> {
        self.run(engine::fct_forward, "mj_forward")
    }

    /// Computes the forces that give the accelerations in [`qacc`](Self::qacc); read them with
    /// [`qfrc_inverse`](Self::qfrc_inverse).
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn inverse(&mut self) -> Result<(), PhysicsError> {
        self.run(engine::fct_inverse, "mj_inverse")
    }

    /// Computes poses and what Jacobians need, from positions alone.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn forward_kinematics(&mut self) -> Result<(), PhysicsError> {
        self.run(engine::fct_kinematics, "mj_kinematics")
    }

    /// Computes poses of bodies, geoms and sites and their contacts, from positions alone: no
    /// Jacobians, no forces. The cheapest way to check a configuration.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn detect_collisions(&mut self) -> Result<(), PhysicsError> {
        self.run(engine::fct_collision, "mj_collision")
    }

    /// Computes poses, the mass matrix and the bias forces, from positions and velocities: no
    /// actuation, contacts or constraints.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn dynamics(&mut self) -> Result<(), PhysicsError> {
        self.run(engine::fct_dynamics, "mj_rne")
    }
}
