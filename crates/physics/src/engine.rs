//! The C boundary: the shim's functions and what their return codes mean.
//!
//! MuJoCo reports a fatal error to a log handler and ends the process when the handler returns.
//! `shim/guard.h` leaves the handler by `longjmp` instead, inside C. Every MuJoCo function that can
//! raise such an error is called through the shim; no other is called unless it cannot fail.

use std::ffi::{CStr, CString, c_char, c_int};
use std::sync::OnceLock;

use mujoco_rs::mujoco_c::{mjData, mjModel, mjSpec};

use crate::error::PhysicsError;

unsafe extern "C" {
    fn fct_install_handler();
    fn fct_message() -> *const c_char;

    pub(crate) fn fct_step(
        m: *const mjModel,
        d: *mut mjData,
        kind: *mut c_int,
        info: *mut c_int,
    ) -> c_int;
    pub(crate) fn fct_step1(
        m: *const mjModel,
        d: *mut mjData,
        kind: *mut c_int,
        info: *mut c_int,
    ) -> c_int;
    pub(crate) fn fct_step2(
        m: *const mjModel,
        d: *mut mjData,
        kind: *mut c_int,
        info: *mut c_int,
    ) -> c_int;
    pub(crate) fn fct_forward(
        m: *const mjModel,
        d: *mut mjData,
        kind: *mut c_int,
        info: *mut c_int,
    ) -> c_int;
    pub(crate) fn fct_inverse(
        m: *const mjModel,
        d: *mut mjData,
        kind: *mut c_int,
        info: *mut c_int,
    ) -> c_int;
    pub(crate) fn fct_kinematics(
        m: *const mjModel,
        d: *mut mjData,
        kind: *mut c_int,
        info: *mut c_int,
    ) -> c_int;
    pub(crate) fn fct_collision(
        m: *const mjModel,
        d: *mut mjData,
        kind: *mut c_int,
        info: *mut c_int,
    ) -> c_int;
    pub(crate) fn fct_dynamics(
        m: *const mjModel,
        d: *mut mjData,
        kind: *mut c_int,
        info: *mut c_int,
    ) -> c_int;
    pub(crate) fn fct_gravity(
        m: *const mjModel,
        d: *mut mjData,
        qvel_scratch: *mut f64,
        out: *mut f64,
    ) -> c_int;
    pub(crate) fn fct_ray(
        m: *const mjModel,
        d: *const mjData,
        point: *const f64,
        direction: *const f64,
        groups: *const u8,
        include_static: bool,
        body_excluded: c_int,
        geom: *mut c_int,
        normal: *mut f64,
        distance: *mut f64,
    ) -> c_int;
    pub(crate) fn fct_multi_ray(
        m: *const mjModel,
        d: *mut mjData,
        point: *const f64,
        directions: *const f64,
        groups: *const u8,
        include_static: bool,
        body_excluded: c_int,
        geoms: *mut c_int,
        distances: *mut f64,
        n_rays: c_int,
        cutoff: f64,
    ) -> c_int;
    pub(crate) fn fct_geom_distance(
        m: *const mjModel,
        d: *mut mjData,
        geom_a: c_int,
        geom_b: c_int,
        distance_max: f64,
        segment: *mut f64,
        distance: *mut f64,
    ) -> c_int;
    pub(crate) fn fct_make_data(m: *const mjModel, out: *mut *mut mjData) -> c_int;
    pub(crate) fn fct_reset_data(m: *const mjModel, d: *mut mjData) -> c_int;
    pub(crate) fn fct_reset_keyframe(m: *const mjModel, d: *mut mjData, key: c_int) -> c_int;
    pub(crate) fn fct_copy_data(
        m: *const mjModel,
        destination: *mut mjData,
        source: *const mjData,
    ) -> c_int;
    pub(crate) fn fct_copy_model(m: *const mjModel, out: *mut *mut mjModel) -> c_int;
    pub(crate) fn fct_set_state(
        m: *const mjModel,
        d: *mut mjData,
        state: *const f64,
        signature: c_int,
    ) -> c_int;
    pub(crate) fn fct_get_state(
        m: *const mjModel,
        d: *const mjData,
        state: *mut f64,
        signature: c_int,
    ) -> c_int;
    pub(crate) fn fct_jacobian(
        m: *const mjModel,
        d: *const mjData,
        linear: *mut f64,
        angular: *mut f64,
        point: *const f64,
        body: c_int,
    ) -> c_int;
    pub(crate) fn fct_full_mass_matrix(m: *const mjModel, d: *const mjData, out: *mut f64)
    -> c_int;
    pub(crate) fn fct_contact_force(
        m: *const mjModel,
        d: *const mjData,
        contact: c_int,
        out: *mut f64,
    ) -> c_int;
    pub(crate) fn fct_object_velocity(
        m: *const mjModel,
        d: *const mjData,
        object_type: c_int,
        id: c_int,
        out: *mut f64,
    ) -> c_int;
    pub(crate) fn fct_differentiate_pos(
        m: *const mjModel,
        velocity: *mut f64,
        dt: f64,
        from: *const f64,
        to: *const f64,
    ) -> c_int;
    pub(crate) fn fct_integrate_pos(
        m: *const mjModel,
        qpos: *mut f64,
        velocity: *const f64,
        dt: f64,
    ) -> c_int;
    pub(crate) fn fct_abandon(d: *mut mjData);

    pub(crate) fn fct_spec_parse_file(path: *const c_char, out: *mut *mut mjSpec) -> c_int;
    pub(crate) fn fct_spec_parse_text(xml: *const c_char, out: *mut *mut mjSpec) -> c_int;
    pub(crate) fn fct_spec_delete(spec: *mut mjSpec);
    pub(crate) fn fct_spec_compile(spec: *mut mjSpec, out: *mut *mut mjModel) -> c_int;
    pub(crate) fn fct_spec_n_warnings(spec: *const mjSpec) -> c_int;
    pub(crate) fn fct_spec_warning(spec: *const mjSpec, index: c_int) -> *const c_char;
    pub(crate) fn fct_spec_save(spec: *const mjSpec, text: *mut c_char, capacity: c_int) -> c_int;
    pub(crate) fn fct_spec_attach(
        parent: *mut mjSpec,
        to: *const c_char,
        child: *mut mjSpec,
        pos: *const f64,
        quat: *const f64,
        prefix: *const c_char,
    ) -> c_int;
    pub(crate) fn fct_spec_has(spec: *const mjSpec, kind: c_int, name: *const c_char) -> c_int;
    pub(crate) fn fct_spec_name(spec: *const mjSpec, kind: c_int, index: c_int) -> *const c_char;
    pub(crate) fn fct_spec_free_roots(spec: *mut mjSpec) -> c_int;
    pub(crate) fn fct_spec_add_actuator(
        spec: *mut mjSpec,
        name: *const c_char,
        joint: *const c_char,
        servo: c_int,
        kp: f64,
        kv: f64,
        ctrl_range: *const f64,
        force_range: *const f64,
    ) -> c_int;
    pub(crate) fn fct_spec_add_site(
        spec: *mut mjSpec,
        body: *const c_char,
        name: *const c_char,
        pos: *const f64,
        quat: *const f64,
    ) -> c_int;
    pub(crate) fn fct_spec_set_mesh_file(
        spec: *mut mjSpec,
        mesh: *const c_char,
        file: *const c_char,
    ) -> c_int;
    pub(crate) fn fct_spec_add_exclude(
        spec: *mut mjSpec,
        body_a: *const c_char,
        body_b: *const c_char,
    ) -> c_int;
}

/// Codes of `shim/guard.h`.
pub(crate) const OK: c_int = 0;
pub(crate) const WARNING: c_int = 2;

/// Version of the bindings, in the form of `mj_version`.
const VERSION: c_int = mujoco_rs::mujoco_c::mjVERSION_HEADER as c_int;

/// Version that was found when the handler was installed.
static INSTALLED: OnceLock<c_int> = OnceLock::new();

/// Installs the log handler, once per process; every path to a MuJoCo object begins here.
pub(crate) fn install() -> Result<(), PhysicsError> {
    let found = *INSTALLED.get_or_init(|| {
        // SAFETY: the lock runs this before any other MuJoCo call of this crate, the only one that
        // calls MuJoCo; the handler is a static C function.
        unsafe { fct_install_handler() };
        // SAFETY: mj_version takes nothing and reads a constant.
        unsafe { mujoco_rs::mujoco_c::mj_version() }
    });
    if found == VERSION {
        return Ok(());
    }
    // The layouts of mjModel and mjData change between versions: nothing may be read.
    Err(PhysicsError::Version {
        found: dotted(found),
        expected: dotted(VERSION),
    })
}

/// `3017000` as `3.17.0`.
fn dotted(version: c_int) -> String {
    format!(
        "{}.{}.{}",
        version / 1_000_000,
        version / 1_000 % 1_000,
        version % 1_000
    )
}

/// Version of the MuJoCo library that is linked, as `3.17.0`.
pub fn engine_version() -> String {
    // SAFETY: mj_version takes nothing and reads a constant.
    dotted(unsafe { mujoco_rs::mujoco_c::mj_version() })
}

/// The text of the last error on this thread, in one line.
pub(crate) fn message() -> String {
    // SAFETY: takes nothing; returns a NUL-terminated buffer of this thread.
    let text = unsafe { fct_message() };
    // SAFETY: as above; the buffer lives as long as the thread, and is copied at once.
    let text = unsafe { CStr::from_ptr(text) }.to_string_lossy();
    let lines: Vec<&str> = text
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect();
    lines.join("; ").trim_start_matches("Error: ").to_owned()
}

/// The fatal error that `call` left behind.
pub(crate) fn fatal(call: &'static str) -> PhysicsError {
    PhysicsError::Engine {
        call,
        message: message(),
    }
}

/// A C string; names and texts with a NUL byte are refused.
pub(crate) fn c_string(what: &'static str, text: &str) -> Result<CString, PhysicsError> {
    CString::new(text).map_err(|error| PhysicsError::Argument {
        what,
        found: format!("a text with a NUL byte at {}", error.nul_position()),
        expected: "a text without NUL bytes",
    })
}
