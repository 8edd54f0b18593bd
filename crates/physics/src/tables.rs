//! A copy of what callers ask of a model, read once when it is loaded, so that queries are safe code.

use std::ffi::{CStr, c_char, c_int};

use mujoco_rs::mujoco_c::{mjModel, mjtGeom};
use nalgebra::{Point3, Vector3};

use crate::Pose;
use crate::axes::pose_from_mujoco;
use crate::error::PhysicsError;
use crate::geom_shape::GeomShape;
use crate::ids::{BodyId, GeomId};
use crate::joint_kind::JointKind;

#[derive(Debug)]
pub(crate) struct Body {
    pub(crate) name: String,
    pub(crate) parent: usize,
    pub(crate) mass: f64,
    pub(crate) com_in_body: Point3<f64>,
    pub(crate) geoms: std::ops::Range<usize>,
    pub(crate) joints: std::ops::Range<usize>,
    pub(crate) weld_root: usize,
    pub(crate) mocap: Option<usize>,
    /// Pose in the parent at the reference configuration.
    pub(crate) parent_from_body: Pose,
}

#[derive(Debug)]
pub(crate) struct Joint {
    pub(crate) name: String,
    pub(crate) kind: JointKind,
    pub(crate) body: usize,
    pub(crate) qpos_adr: usize,
    pub(crate) dof_adr: usize,
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) axis_in_body: Vector3<f64>,
}

#[derive(Debug)]
pub(crate) struct Geom {
    pub(crate) name: String,
    pub(crate) body: usize,
    pub(crate) shape: GeomShape,
    pub(crate) rgba: [f32; 4],
    pub(crate) group: usize,
    pub(crate) contact_bits: (i32, i32),
    pub(crate) friction: [f64; 3],
    pub(crate) body_from_geom: Pose,
    pub(crate) bounding_radius_m: f64,
}

#[derive(Debug)]
pub(crate) struct Site {
    pub(crate) name: String,
    pub(crate) body: usize,
}

#[derive(Debug)]
pub(crate) struct Actuator {
    pub(crate) name: String,
    pub(crate) ctrl_adr: usize,
    pub(crate) ctrl_range: Option<[f64; 2]>,
    pub(crate) force_range: Option<[f64; 2]>,
    /// Joint it drives, when its transmission is a joint.
    pub(crate) joint: Option<usize>,
}

#[derive(Debug)]
pub(crate) struct Camera {
    pub(crate) name: String,
    pub(crate) body: usize,
    pub(crate) fovy_rad: f64,
}

#[derive(Debug)]
pub(crate) struct Sensor {
    pub(crate) name: String,
    pub(crate) values: std::ops::Range<usize>,
}

#[derive(Debug)]
pub(crate) struct Tables {
    pub(crate) model_name: String,
    /// MuJoCo's hash of the structure.
    pub(crate) signature: u64,
    pub(crate) n_q: usize,
    pub(crate) n_v: usize,
    pub(crate) n_u: usize,
    pub(crate) n_mocap: usize,
    pub(crate) n_sensor_data: usize,
    pub(crate) timestep_secs: f64,
    pub(crate) gravity: Vector3<f64>,
    /// Where the row of each degree of freedom lies among the entries of the mass matrix, lower triangle, and the
    /// column of each entry.
    pub(crate) mass_rows: Vec<std::ops::Range<usize>>,
    pub(crate) mass_columns: Vec<usize>,
    pub(crate) qpos_reference: Vec<f64>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) geoms: Vec<Geom>,
    pub(crate) sites: Vec<Site>,
    pub(crate) actuators: Vec<Actuator>,
    pub(crate) cameras: Vec<Camera>,
    pub(crate) sensors: Vec<Sensor>,
    pub(crate) keyframes: Vec<String>,
}

/// Copies a column of the model; `$n` is the number of values, as `mjmodel.h` states it.
macro_rules! column {
    ($raw:ident . $field:ident, $n:expr) => {{
        let n: usize = $n;
        if n == 0 || $raw.$field.is_null() {
            Vec::new()
        } else {
            // SAFETY: mjmodel.h states the length of each array beside its field; `$n` repeats it
            // from the same model, which is alive and not written while it is borrowed.
            unsafe { std::slice::from_raw_parts($raw.$field, n) }.to_vec()
        }
    }};
}

/// Texts of the model, found by their offsets.
struct Names {
    text: Vec<c_char>,
}

impl Names {
    fn at(&self, adr: c_int) -> String {
        let bytes: Vec<u8> = self
            .text
            .iter()
            .skip(size(adr.into()))
            .take_while(|&&c| c != 0)
            .map(|&c| c.to_ne_bytes()[0])
            .collect();
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

/// A count or an address of MuJoCo, which are signed but never negative where this is used.
fn size(value: i64) -> usize {
    usize::try_from(value).unwrap_or(0)
}

fn range_at(adr: c_int, n: c_int) -> std::ops::Range<usize> {
    let start = size(adr.into());
    start..start + size(n.into())
}

fn triple<T: Copy>(values: &[T], row: usize) -> [T; 3] {
    [values[3 * row], values[3 * row + 1], values[3 * row + 2]]
}

fn quadruple<T: Copy>(values: &[T], row: usize) -> [T; 4] {
    [
        values[4 * row],
        values[4 * row + 1],
        values[4 * row + 2],
        values[4 * row + 3],
    ]
}

impl Tables {
    pub(crate) fn read(raw: &mjModel) -> Result<Self, PhysicsError> {
        let names = Names {
            text: column!(raw.names, size(raw.nnames)),
        };
        Ok(Self {
            model_name: names.at(0),
            signature: raw.signature,
            n_q: size(raw.nq),
            n_v: size(raw.nv),
            n_u: size(raw.nu),
            n_mocap: size(raw.nmocap),
            n_sensor_data: size(raw.nsensordata),
            timestep_secs: raw.opt.timestep,
            gravity: Vector3::from(raw.opt.gravity),
            mass_rows: column!(raw.M_rowadr, size(raw.nv))
                .into_iter()
                .zip(column!(raw.M_rownnz, size(raw.nv)))
                .map(|(adr, n)| range_at(adr, n))
                .collect(),
            mass_columns: column!(raw.M_colind, size(raw.nC))
                .into_iter()
                .map(|column| size(column.into()))
                .collect(),
            qpos_reference: column!(raw.qpos0, size(raw.nq)),
            bodies: bodies(raw, &names),
            joints: joints(raw, &names)?,
            geoms: geoms(raw, &names),
            sites: sites(raw, &names),
            actuators: actuators(raw, &names),
            cameras: cameras(raw, &names),
            sensors: sensors(raw, &names),
            keyframes: column!(raw.name_keyadr, size(raw.nkey))
                .into_iter()
                .map(|adr| names.at(adr))
                .collect(),
        })
    }
}

fn bodies(raw: &mjModel, names: &Names) -> Vec<Body> {
    let n = size(raw.nbody);
    let name = column!(raw.name_bodyadr, n);
    let parent = column!(raw.body_parentid, n);
    let mass = column!(raw.body_mass, n);
    let com = column!(raw.body_ipos, 3 * n);
    let geom_adr = column!(raw.body_geomadr, n);
    let geom_num = column!(raw.body_geomnum, n);
    let joint_adr = column!(raw.body_jntadr, n);
    let joint_num = column!(raw.body_jntnum, n);
    let weld = column!(raw.body_weldid, n);
    let mocap = column!(raw.body_mocapid, n);
    let pos = column!(raw.body_pos, 3 * n);
    let quat = column!(raw.body_quat, 4 * n);
    (0..n)
        .map(|i| Body {
            name: names.at(name[i]),
            parent: size(parent[i].into()),
            mass: mass[i],
            com_in_body: Point3::from(triple(&com, i)),
            geoms: range_at(geom_adr[i], geom_num[i]),
            joints: range_at(joint_adr[i], joint_num[i]),
            weld_root: size(weld[i].into()),
            mocap: usize::try_from(mocap[i]).ok(),
            parent_from_body: pose_from_mujoco(triple(&pos, i), quadruple(&quat, i)),
        })
        .collect()
}

fn joints(raw: &mjModel, names: &Names) -> Result<Vec<Joint>, PhysicsError> {
    let n = size(raw.njnt);
    let name = column!(raw.name_jntadr, n);
    let kind = column!(raw.jnt_type, n);
    let body = column!(raw.jnt_bodyid, n);
    let qpos_adr = column!(raw.jnt_qposadr, n);
    let dof_adr = column!(raw.jnt_dofadr, n);
    let limited = column!(raw.jnt_limited, n);
    let range = column!(raw.jnt_range, 2 * n);
    let axis = column!(raw.jnt_axis, 3 * n);
    (0..n)
        .map(|i| {
            Ok(Joint {
                name: names.at(name[i]),
                kind: JointKind::try_from(kind[i])?,
                body: size(body[i].into()),
                qpos_adr: size(qpos_adr[i].into()),
                dof_adr: size(dof_adr[i].into()),
                range: limited[i].then(|| [range[2 * i], range[2 * i + 1]]),
                axis_in_body: Vector3::from(triple(&axis, i)),
            })
        })
        .collect()
}

fn geoms(raw: &mjModel, names: &Names) -> Vec<Geom> {
    let n = size(raw.ngeom);
    let name = column!(raw.name_geomadr, n);
    let body = column!(raw.geom_bodyid, n);
    let kind = column!(raw.geom_type, n);
    let data = column!(raw.geom_dataid, n);
    let dimensions = column!(raw.geom_size, 3 * n);
    let material = column!(raw.geom_matid, n);
    let rgba = column!(raw.geom_rgba, 4 * n);
    let material_rgba = column!(raw.mat_rgba, 4 * size(raw.nmat));
    let group = column!(raw.geom_group, n);
    let contype = column!(raw.geom_contype, n);
    let conaffinity = column!(raw.geom_conaffinity, n);
    let friction = column!(raw.geom_friction, 3 * n);
    let pos = column!(raw.geom_pos, 3 * n);
    let quat = column!(raw.geom_quat, 4 * n);
    let bound = column!(raw.geom_rbound, n);
    let meshes = Meshes::read(raw);
    (0..n)
        .map(|i| Geom {
            name: names.at(name[i]),
            body: size(body[i].into()),
            shape: shape(kind[i], triple(&dimensions, i), data[i], &meshes),
            rgba: match usize::try_from(material[i]) {
                Ok(m) => quadruple(&material_rgba, m),
                Err(_) => quadruple(&rgba, i),
            },
            group: size(group[i].into()),
            contact_bits: (contype[i], conaffinity[i]),
            friction: triple(&friction, i),
            body_from_geom: pose_from_mujoco(triple(&pos, i), quadruple(&quat, i)),
            bounding_radius_m: bound[i],
        })
        .collect()
}

/// Mesh columns, shared by the geoms that use them.
struct Meshes {
    vertex_adr: Vec<c_int>,
    vertex_num: Vec<c_int>,
    face_adr: Vec<c_int>,
    face_num: Vec<c_int>,
    vertices: Vec<f32>,
    faces: Vec<c_int>,
}

impl Meshes {
    fn read(raw: &mjModel) -> Self {
        let n = size(raw.nmesh);
        Self {
            vertex_adr: column!(raw.mesh_vertadr, n),
            vertex_num: column!(raw.mesh_vertnum, n),
            face_adr: column!(raw.mesh_faceadr, n),
            face_num: column!(raw.mesh_facenum, n),
            vertices: column!(raw.mesh_vert, 3 * size(raw.nmeshvert)),
            faces: column!(raw.mesh_face, 3 * size(raw.nmeshface)),
        }
    }

    fn shape(&self, mesh: usize) -> GeomShape {
        let vertices = range_at(self.vertex_adr[mesh], self.vertex_num[mesh]);
        let faces = range_at(self.face_adr[mesh], self.face_num[mesh]);
        GeomShape::Mesh {
            vertices: vertices.map(|row| triple(&self.vertices, row)).collect(),
            faces: faces
                .map(|row| triple(&self.faces, row).map(|v| u32::try_from(v).unwrap_or(0)))
                .collect(),
        }
    }
}

fn shape(kind: c_int, size: [f64; 3], data: c_int, meshes: &Meshes) -> GeomShape {
    let is = |geom: mjtGeom| kind == geom as c_int;
    if is(mjtGeom::mjGEOM_BOX) {
        GeomShape::Box { half: size }
    } else if is(mjtGeom::mjGEOM_SPHERE) {
        GeomShape::Sphere { r: size[0] }
    } else if is(mjtGeom::mjGEOM_CAPSULE) {
        GeomShape::Capsule {
            r: size[0],
            half: size[1],
        }
    } else if is(mjtGeom::mjGEOM_CYLINDER) {
        GeomShape::Cylinder {
            r: size[0],
            half: size[1],
        }
    } else if is(mjtGeom::mjGEOM_ELLIPSOID) {
        GeomShape::Ellipsoid { radii: size }
    } else if is(mjtGeom::mjGEOM_PLANE) {
        GeomShape::Plane
    } else if is(mjtGeom::mjGEOM_HFIELD) {
        GeomShape::HeightField
    } else {
        // Mesh or SDF; the compiler gives both a mesh.
        match usize::try_from(data) {
            Ok(mesh) => meshes.shape(mesh),
            Err(_) => GeomShape::Mesh {
                vertices: Vec::new(),
                faces: Vec::new(),
            },
        }
    }
}

fn sites(raw: &mjModel, names: &Names) -> Vec<Site> {
    let n = size(raw.nsite);
    let name = column!(raw.name_siteadr, n);
    let body = column!(raw.site_bodyid, n);
    (0..n)
        .map(|i| Site {
            name: names.at(name[i]),
            body: size(body[i].into()),
        })
        .collect()
}

fn actuators(raw: &mjModel, names: &Names) -> Vec<Actuator> {
    let n = size(raw.nactuator);
    let n_u = size(raw.nu);
    let n_out = size(raw.nout);
    let name = column!(raw.name_actuatoradr, n);
    let ctrl_adr = column!(raw.actuator_ctrladr, n);
    let out_adr = column!(raw.actuator_outadr, n);
    let ctrl_limited = column!(raw.actuator_ctrllimited, n_u);
    let ctrl_range = column!(raw.actuator_ctrlrange, 2 * n_u);
    let force_limited = column!(raw.actuator_forcelimited, n_out);
    let force_range = column!(raw.actuator_forcerange, 2 * n_out);
    let transmission = column!(raw.actuator_trntype, n);
    let target = column!(raw.actuator_trnid, 2 * n);
    let joint_transmission = mujoco_rs::mujoco_c::mjtTrn::mjTRN_JOINT as c_int;
    (0..n)
        .map(|i| {
            let u = size(ctrl_adr[i].into());
            let out = size(out_adr[i].into());
            Actuator {
                name: names.at(name[i]),
                ctrl_adr: u,
                ctrl_range: (u < n_u && ctrl_limited[u])
                    .then(|| [ctrl_range[2 * u], ctrl_range[2 * u + 1]]),
                force_range: (out < n_out && force_limited[out])
                    .then(|| [force_range[2 * out], force_range[2 * out + 1]]),
                joint: (transmission[i] == joint_transmission).then(|| size(target[2 * i].into())),
            }
        })
        .collect()
}

fn cameras(raw: &mjModel, names: &Names) -> Vec<Camera> {
    let n = size(raw.ncam);
    let name = column!(raw.name_camadr, n);
    let body = column!(raw.cam_bodyid, n);
    let fovy = column!(raw.cam_fovy, n);
    (0..n)
        .map(|i| Camera {
            name: names.at(name[i]),
            body: size(body[i].into()),
            // The one angle that mjModel keeps in degrees.
            fovy_rad: fovy[i].to_radians(),
        })
        .collect()
}

fn sensors(raw: &mjModel, names: &Names) -> Vec<Sensor> {
    let n = size(raw.nsensor);
    let name = column!(raw.name_sensoradr, n);
    let adr = column!(raw.sensor_adr, n);
    let dim = column!(raw.sensor_dim, n);
    (0..n)
        .map(|i| Sensor {
            name: names.at(name[i]),
            values: range_at(adr[i], dim[i]),
        })
        .collect()
}

/// Copies a NUL-terminated C text that may be null.
pub(crate) fn copied_text(text: *const c_char) -> Option<String> {
    if text.is_null() {
        return None;
    }
    // SAFETY: callers pass texts that MuJoCo returned, NUL-terminated and alive until the next call
    // on the same object; it is copied before that.
    let text = unsafe { CStr::from_ptr(text) };
    Some(text.to_string_lossy().into_owned())
}

impl Tables {
    pub(crate) fn children(&self, body: BodyId) -> impl Iterator<Item = BodyId> + '_ {
        // Bodies are numbered parents first; the world is its own parent.
        (1..self.bodies.len())
            .filter(move |&i| self.bodies[i].parent == body.0)
            .map(BodyId)
    }

    pub(crate) fn geoms_of(&self, body: BodyId) -> impl Iterator<Item = GeomId> + '_ {
        self.bodies[body.0].geoms.clone().map(GeomId)
    }
}
