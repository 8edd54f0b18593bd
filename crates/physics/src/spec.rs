//! An editable model (`mjSpec`) before it is compiled.

use std::ffi::{c_char, c_int};
use std::path::Path;
use std::ptr::NonNull;

use mujoco_rs::mujoco_c::{mjSpec, mjtObj};

use crate::Pose;
use crate::axes::wxyz_from_quat;
use crate::engine::{self, c_string};
use crate::error::PhysicsError;
use crate::model::Model;
use crate::tables::copied_text;

/// An owned `mjSpec` and where it came from.
#[derive(Debug)]
pub(crate) struct Spec {
    raw: NonNull<mjSpec>,
    origin: String,
}

// SAFETY: a spec is used by one thread at a time and MuJoCo keeps no thread-local data for it.
unsafe impl Send for Spec {}

impl Drop for Spec {
    fn drop(&mut self) {
        // SAFETY: owned here alone; attached parts were copied deeply.
        unsafe { engine::fct_spec_delete(self.raw.as_ptr()) };
    }
}

/// What a new actuator does with its control value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Servo {
    /// Control value is torque (N m) or force (N).
    Motor,
    /// Control value is a position (rad or m): force = kp (ctrl − q) − kv q̇.
    Position {
        /// Stiffness, N m/rad or N/m.
        kp: f64,
        /// Damping, N m s/rad or N s/m.
        kv: f64,
    },
    /// Control value is a velocity (rad/s or m/s): force = kv (ctrl − q̇).
    Velocity {
        /// Gain, N m s/rad or N s/m.
        kv: f64,
    },
}

/// An actuator to add to a part that has none on this joint.
#[derive(Debug, Clone, PartialEq)]
pub struct NewActuator {
    /// Its name, before the part's prefix.
    pub name: String,
    /// The joint it drives, before the part's prefix.
    pub joint: String,
    /// What its control value means.
    pub servo: Servo,
    /// Limits of the control value; `None` for none.
    pub ctrl_range: Option<[f64; 2]>,
    /// Limits of the force, N or N m; `None` for none.
    pub force_range: Option<[f64; 2]>,
}

impl Spec {
    pub(crate) fn from_file(path: &Path) -> Result<Self, PhysicsError> {
        engine::install()?;
        // MuJoCo's own message for a missing file is good, but does not say why.
        if let Err(error) = std::fs::metadata(path) {
            return Err(PhysicsError::File {
                path: path.to_owned(),
                message: error.to_string(),
            });
        }
        let origin = path.display().to_string();
        let Some(text) = path.to_str() else {
            return Err(PhysicsError::File {
                path: path.to_owned(),
                message: "its path is not UTF-8, which MuJoCo needs".to_owned(),
            });
        };
        let c_path = c_string("model path", text)?;
        let mut raw = std::ptr::null_mut();
        // SAFETY: a NUL-terminated path and a place for the result.
        let rc = unsafe { engine::fct_spec_parse_file(c_path.as_ptr(), &raw mut raw) };
        Self::parsed(rc, raw, origin)
    }

    pub(crate) fn from_text(origin: &str, xml: &str) -> Result<Self, PhysicsError> {
        engine::install()?;
        let c_xml = c_string("model text", xml)?;
        let mut raw = std::ptr::null_mut();
        // SAFETY: a NUL-terminated text and a place for the result.
        let rc = unsafe { engine::fct_spec_parse_text(c_xml.as_ptr(), &raw mut raw) };
        Self::parsed(rc, raw, origin.to_owned())
    }

    fn parsed(rc: c_int, raw: *mut mjSpec, origin: String) -> Result<Self, PhysicsError> {
        match (rc, NonNull::new(raw)) {
            (engine::OK, Some(raw)) => Ok(Self { raw, origin }),
            _ => Err(PhysicsError::Parse {
                origin,
                message: in_words(&engine::message()),
            }),
        }
    }

    pub(crate) fn compile(&mut self) -> Result<Model, PhysicsError> {
        let mut raw = std::ptr::null_mut();
        // SAFETY: a live spec and a place for the result.
        let rc = unsafe { engine::fct_spec_compile(self.raw.as_ptr(), &raw mut raw) };
        match (rc, NonNull::new(raw)) {
            (engine::OK, Some(raw)) => {
                for warning in self.warnings() {
                    tracing::debug!(model = %self.origin, %warning, "MuJoCo compiler warning");
                }
                Model::from_raw(raw)
            }
            _ => Err(PhysicsError::Compile {
                origin: self.origin.clone(),
                message: engine::message(),
            }),
        }
    }

    pub(crate) fn warnings(&self) -> Vec<String> {
        // SAFETY: a live spec.
        let n = unsafe { engine::fct_spec_n_warnings(self.raw.as_ptr()) };
        (0..n)
            .filter_map(|i| {
                // SAFETY: a live spec and an index below its count.
                copied_text(unsafe { engine::fct_spec_warning(self.raw.as_ptr(), i) })
            })
            .collect()
    }

    /// The spec as MJCF.
    pub(crate) fn to_xml(&self) -> Result<String, PhysicsError> {
        // MuJoCo does not say how much it needs: grow until it fits.
        let mut capacity: usize = 1 << 20;
        loop {
            let mut text = vec![0_u8; capacity];
            // SAFETY: a live spec, and a buffer of the stated capacity.
            let rc = unsafe {
                engine::fct_spec_save(
                    self.raw.as_ptr(),
                    text.as_mut_ptr().cast::<c_char>(),
                    c_int::try_from(capacity).unwrap_or(c_int::MAX),
                )
            };
            if rc == engine::OK {
                text.truncate(
                    text.iter()
                        .position(|&byte| byte == 0)
                        .unwrap_or(text.len()),
                );
                return String::from_utf8(text).map_err(|error| PhysicsError::Compile {
                    origin: self.origin.clone(),
                    message: error.to_string(),
                });
            }
            let message = engine::message();
            if capacity > 1 << 28 || !message.contains("buffer") {
                return Err(PhysicsError::Compile {
                    origin: self.origin.clone(),
                    message,
                });
            }
            capacity *= 4;
        }
    }

    pub(crate) fn has(&self, kind: mjtObj, name: &str) -> bool {
        let Ok(name) = c_string("name", name) else {
            return false;
        };
        // SAFETY: a live spec and a NUL-terminated name.
        unsafe { engine::fct_spec_has(self.raw.as_ptr(), kind as c_int, name.as_ptr()) != 0 }
    }

    pub(crate) fn names(&self, kind: mjtObj) -> Vec<String> {
        (0..)
            .map_while(|i| {
                // SAFETY: a live spec; NULL past the last element.
                copied_text(unsafe { engine::fct_spec_name(self.raw.as_ptr(), kind as c_int, i) })
            })
            .filter(|name| !name.is_empty())
            .collect()
    }

    /// Attaches all of `child`, moved by `offset`, to a site or else a body of that name (`None`: the world). `child`
    /// is spent.
    pub(crate) fn attach(
        &mut self,
        to: Option<&str>,
        child: Self,
        offset: &Pose,
        prefix: &str,
    ) -> Result<(), PhysicsError> {
        if let Some(name) = to
            && !self.has(mjtObj::mjOBJ_BODY, name)
        {
            self.require(mjtObj::mjOBJ_SITE, "site or body", name)?;
        }
        let c_to = to.map(|name| c_string("site name", name)).transpose()?;
        let c_prefix = c_string("prefix", prefix)?;
        let pos: [f64; 3] = offset.translation.vector.into();
        let quat = wxyz_from_quat(&offset.rotation);
        // SAFETY: two live specs, NUL-terminated texts, arrays of 3 and 4 values.
        let rc = unsafe {
            engine::fct_spec_attach(
                self.raw.as_ptr(),
                c_to.as_ref().map_or(std::ptr::null(), |name| name.as_ptr()),
                child.raw.as_ptr(),
                pos.as_ptr(),
                quat.as_ptr(),
                c_prefix.as_ptr(),
            )
        };
        if rc == engine::OK {
            return Ok(());
        }
        Err(PhysicsError::Attach {
            part: child.origin.clone(),
            target: to.map_or_else(|| "the world".to_owned(), |name| format!("`{name}`")),
            message: engine::message(),
        })
    }

    fn require(&self, kind: mjtObj, word: &'static str, name: &str) -> Result<(), PhysicsError> {
        if self.has(kind, name) {
            return Ok(());
        }
        Err(PhysicsError::UnknownName {
            kind: word,
            name: name.to_owned(),
            model: self.origin.clone(),
            available: self.names(kind),
        })
    }

    fn checked(&self, rc: c_int) -> Result<(), PhysicsError> {
        if rc == engine::OK {
            return Ok(());
        }
        Err(PhysicsError::Compile {
            origin: self.origin.clone(),
            message: engine::message(),
        })
    }

    pub(crate) fn free_roots(&mut self) -> Result<(), PhysicsError> {
        // SAFETY: a live spec.
        let rc = unsafe { engine::fct_spec_free_roots(self.raw.as_ptr()) };
        self.checked(rc)
    }

    pub(crate) fn add_actuator(&mut self, new: &NewActuator) -> Result<(), PhysicsError> {
        self.require(mjtObj::mjOBJ_JOINT, "joint", &new.joint)?;
        let name = c_string("actuator name", &new.name)?;
        let joint = c_string("joint name", &new.joint)?;
        let (servo, kp, kv) = match new.servo {
            Servo::Motor => (0, 0.0, 0.0),
            Servo::Position { kp, kv } => (1, kp, kv),
            Servo::Velocity { kv } => (2, 0.0, kv),
        };
        let range = |range: &Option<[f64; 2]>| {
            range
                .as_ref()
                .map_or(std::ptr::null(), |range| range.as_ptr())
        };
        // SAFETY: a live spec, NUL-terminated names, ranges of 2 values or NULL.
        let rc = unsafe {
            engine::fct_spec_add_actuator(
                self.raw.as_ptr(),
                name.as_ptr(),
                joint.as_ptr(),
                servo,
                kp,
                kv,
                range(&new.ctrl_range),
                range(&new.force_range),
            )
        };
        self.checked(rc)
    }

    pub(crate) fn add_site(
        &mut self,
        body: &str,
        name: &str,
        body_from_site: &Pose,
    ) -> Result<(), PhysicsError> {
        self.require(mjtObj::mjOBJ_BODY, "body", body)?;
        let body = c_string("body name", body)?;
        let name = c_string("site name", name)?;
        let pos: [f64; 3] = body_from_site.translation.vector.into();
        let quat = wxyz_from_quat(&body_from_site.rotation);
        // SAFETY: a live spec, NUL-terminated names, arrays of 3 and 4 values.
        let rc = unsafe {
            engine::fct_spec_add_site(
                self.raw.as_ptr(),
                body.as_ptr(),
                name.as_ptr(),
                pos.as_ptr(),
                quat.as_ptr(),
            )
        };
        self.checked(rc)
    }

    /// Sets the file that a mesh is read from.
    pub(crate) fn set_mesh_file(&mut self, mesh: &str, file: &Path) -> Result<(), PhysicsError> {
        let mesh = c_string("mesh name", mesh)?;
        let file = c_string("mesh file", &file.display().to_string())?;
        // SAFETY: a live spec and NUL-terminated texts, which are copied.
        let rc = unsafe {
            engine::fct_spec_set_mesh_file(self.raw.as_ptr(), mesh.as_ptr(), file.as_ptr())
        };
        self.checked(rc)
    }

    pub(crate) fn add_exclude(&mut self, a: &str, b: &str) -> Result<(), PhysicsError> {
        self.require(mjtObj::mjOBJ_BODY, "body", a)?;
        self.require(mjtObj::mjOBJ_BODY, "body", b)?;
        let a = c_string("body name", a)?;
        let b = c_string("body name", b)?;
        // SAFETY: a live spec and NUL-terminated names.
        let rc = unsafe { engine::fct_spec_add_exclude(self.raw.as_ptr(), a.as_ptr(), b.as_ptr()) };
        self.checked(rc)
    }
}

/// The XML reader's report, such as `Error=XML_ERROR_PARSING_COMMENT ErrorID=10 (0xa) Line number=2`, in words; any other
/// message as it is.
fn in_words(message: &str) -> String {
    let word_after = |key: &str| {
        let (_, rest) = message.split_once(key)?;
        rest.split([' ', ':', '\n']).next()
    };
    match (word_after("Error=XML_ERROR_"), word_after("Line number=")) {
        (Some(kind), Some(line)) => {
            let kind = kind.to_lowercase().replace('_', " ");
            format!("line {line} is not well-formed XML ({kind})")
        }
        _ => message.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn the_xml_reader_is_put_into_words() {
        let report = "XML parse error 7:\nError=XML_ERROR_PARSING_ATTRIBUTE ErrorID=7 (0x7) Line number=19: XMLElement name=geom";
        assert_eq!(
            in_words(report),
            "line 19 is not well-formed XML (parsing attribute)"
        );
        let schema =
            "XML Error: Schema violation: unrecognized attribute: 'foo'\nElement 'geom', line 19";
        assert_eq!(in_words(schema), schema);
    }
}
