//! The compiled model: what there is, and where its numbers are.

use std::ffi::c_int;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::Arc;

use mujoco_rs::mujoco_c::{mj_deleteModel, mjModel, mjtDisableBit};
use nalgebra::{Point3, Vector3};

use crate::Pose;
use crate::error::PhysicsError;
use crate::geom_shape::GeomShape;
use crate::ids::{ActuatorId, BodyId, CameraId, GeomId, JointId, KeyframeId, SensorId, SiteId};
use crate::joint_kind::JointKind;
use crate::spec::Spec;
use crate::tables::Tables;

/// A compiled, immutable model. Cloning shares it.
#[derive(Clone, Debug)]
pub struct Model {
    inner: Arc<ModelInner>,
}

#[derive(Debug)]
struct ModelInner {
    raw: NonNull<mjModel>,
    tables: Tables,
}

// SAFETY: the mjModel is written only before it is put here, and MuJoCo's functions take it const.
unsafe impl Send for ModelInner {}
// SAFETY: as above: concurrent reads only.
unsafe impl Sync for ModelInner {}

impl Drop for ModelInner {
    fn drop(&mut self) {
        // SAFETY: `raw` came from mj_compile or mj_copyModel, is owned here alone, and every State
        // that reads it holds a clone of the Arc.
        unsafe { mj_deleteModel(self.raw.as_ptr()) };
    }
}

macro_rules! lookups {
    ($($(#[$doc:meta])* $find:ident, $names:ident, $name_of:ident, $id:ident, $rows:ident, $kind:literal;)*) => {
        impl Model {
            $(
                #[doc = concat!("The ", $kind, " of this name.")]
                ///
                /// # Errors
                /// [`PhysicsError::UnknownName`], listing the names there are.
                pub fn $find(&self, name: &str) -> Result<$id, PhysicsError> {
                    self.tables()
                        .$rows
                        .iter()
                        .position(|row| !name.is_empty() && row.name == name)
                        .map($id)
                        .ok_or_else(|| PhysicsError::UnknownName {
                            kind: $kind,
                            name: name.to_owned(),
                            model: self.name().to_owned(),
                            available: self.$names().into_iter().filter(|n| !n.is_empty()).collect(),
                        })
                }

                #[doc = concat!("The names of every ", $kind, ", in order; empty where one has none.")]
                pub fn $names(&self) -> Vec<String> {
                    self.tables().$rows.iter().map(|row| row.name.clone()).collect()
                }

                #[doc = concat!("The name of a ", $kind, "; empty when it has none.")]
                pub fn $name_of(&self, id: $id) -> &str {
                    &self.tables().$rows[id.0].name
                }
            )*
        }
    };
}

lookups! {
    joint, joint_names, joint_name, JointId, joints, "joint";
    body, body_names, body_name, BodyId, bodies, "body";
    geom, geom_names, geom_name, GeomId, geoms, "geom";
    site, site_names, site_name, SiteId, sites, "site";
    actuator, actuator_names, actuator_name, ActuatorId, actuators, "actuator";
    camera, camera_names, camera_name, CameraId, cameras, "camera";
    sensor, sensor_names, sensor_name, SensorId, sensors, "sensor";
}

impl Model {
    /// Reads and compiles an MJCF file; relative asset paths count from the file.
    ///
    /// # Errors
    /// [`PhysicsError::File`], [`PhysicsError::Parse`] or [`PhysicsError::Compile`] with MuJoCo's words.
    pub fn from_mjcf_file(path: &Path) -> Result<Self, PhysicsError> {
        Spec::from_file(path)?.compile()
    }

    /// Reads and compiles an MJCF text; relative asset paths count from the working directory.
    ///
    /// # Errors
    /// [`PhysicsError::Parse`] or [`PhysicsError::Compile`] with MuJoCo's words.
    pub fn from_mjcf_str(xml: &str) -> Result<Self, PhysicsError> {
        Spec::from_text("(text)", xml)?.compile()
    }

    /// Takes over a model that MuJoCo compiled or copied.
    pub(crate) fn from_raw(mut raw: NonNull<mjModel>) -> Result<Self, PhysicsError> {
        // SAFETY: `raw` is a live model that nothing else holds yet.
        let model = unsafe { raw.as_mut() };
        // A bad state is an error to report, never a silent return to the start.
        model.opt.disableflags |= mjtDisableBit::mjDSBL_AUTORESET as c_int;
        match Tables::read(model) {
            Ok(tables) => Ok(Self {
                inner: Arc::new(ModelInner { raw, tables }),
            }),
            Err(error) => {
                // SAFETY: as above; it is not used again.
                unsafe { mj_deleteModel(raw.as_ptr()) };
                Err(error)
            }
        }
    }

    pub(crate) fn as_ptr(&self) -> *const mjModel {
        self.inner.raw.as_ptr()
    }

    pub(crate) fn tables(&self) -> &Tables {
        &self.inner.tables
    }

    /// Whether two handles share one compiled model.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.inner, &other.inner)
    }

    /// The model's name.
    pub fn name(&self) -> &str {
        &self.tables().model_name
    }

    /// Number of position coordinates.
    pub fn n_q(&self) -> usize {
        self.tables().n_q
    }

    /// Number of degrees of freedom; not [`n_q`](Self::n_q) where there is a free or ball joint.
    pub fn n_v(&self) -> usize {
        self.tables().n_v
    }

    /// Number of control values.
    pub fn n_u(&self) -> usize {
        self.tables().n_u
    }

    /// Number of bodies, the world included.
    pub fn n_bodies(&self) -> usize {
        self.tables().bodies.len()
    }

    /// Number of geoms.
    pub fn n_geoms(&self) -> usize {
        self.tables().geoms.len()
    }

    /// Number of joints.
    pub fn n_joints(&self) -> usize {
        self.tables().joints.len()
    }

    /// Number of sites.
    pub fn n_sites(&self) -> usize {
        self.tables().sites.len()
    }

    /// Number of actuators.
    pub fn n_actuators(&self) -> usize {
        self.tables().actuators.len()
    }

    /// Every body, the world first, parents before children.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> + use<> {
        (0..self.n_bodies()).map(BodyId)
    }

    /// Every geom.
    pub fn geoms(&self) -> impl Iterator<Item = GeomId> + use<> {
        (0..self.n_geoms()).map(GeomId)
    }

    /// Every joint.
    pub fn joints(&self) -> impl Iterator<Item = JointId> + use<> {
        (0..self.n_joints()).map(JointId)
    }

    /// Every site.
    pub fn sites(&self) -> impl Iterator<Item = SiteId> + use<> {
        (0..self.n_sites()).map(SiteId)
    }

    /// Every actuator.
    pub fn actuators(&self) -> impl Iterator<Item = ActuatorId> + use<> {
        (0..self.n_actuators()).map(ActuatorId)
    }

    /// Length of a step, s.
    pub fn timestep_secs(&self) -> f64 {
        self.tables().timestep_secs
    }

    /// Gravity in the world, m/s².
    pub fn gravity(&self) -> Vector3<f64> {
        self.tables().gravity
    }

    /// Positions of the reference configuration (`qpos0`).
    pub fn qpos_reference(&self) -> &[f64] {
        &self.tables().qpos_reference
    }

    /// Limits of a slide (m) or hinge (rad); `None` when it has none.
    pub fn joint_range(&self, joint: JointId) -> Option<[f64; 2]> {
        self.tables().joints[joint.0].range
    }

    /// How a joint moves.
    pub fn joint_kind(&self, joint: JointId) -> JointKind {
        self.tables().joints[joint.0].kind
    }

    /// Body that a joint moves.
    pub fn joint_body(&self, joint: JointId) -> BodyId {
        BodyId(self.tables().joints[joint.0].body)
    }

    /// Axis of a slide or hinge in the frame of its body.
    pub fn joint_axis_in_body(&self, joint: JointId) -> Vector3<f64> {
        self.tables().joints[joint.0].axis_in_body
    }

    /// First entry of a joint in `qpos`.
    pub fn qpos_adr(&self, joint: JointId) -> usize {
        self.tables().joints[joint.0].qpos_adr
    }

    /// First entry of a joint in `qvel` and the other arrays per degree of freedom.
    pub fn dof_adr(&self, joint: JointId) -> usize {
        self.tables().joints[joint.0].dof_adr
    }

    /// Joints of a body.
    pub fn joints_of_body(&self, body: BodyId) -> Vec<JointId> {
        self.tables().bodies[body.0]
            .joints
            .clone()
            .map(JointId)
            .collect()
    }

    /// Body that carries a geom.
    pub fn geom_body(&self, geom: GeomId) -> BodyId {
        BodyId(self.tables().geoms[geom.0].body)
    }

    /// Body that carries a site.
    pub fn site_body(&self, site: SiteId) -> BodyId {
        BodyId(self.tables().sites[site.0].body)
    }

    /// Body that carries a camera.
    pub fn camera_body(&self, camera: CameraId) -> BodyId {
        BodyId(self.tables().cameras[camera.0].body)
    }

    /// Vertical field of view of a camera, rad.
    pub fn camera_fovy_rad(&self, camera: CameraId) -> f64 {
        self.tables().cameras[camera.0].fovy_rad
    }

    /// Parent of a body; `None` for the world.
    pub fn body_parent(&self, body: BodyId) -> Option<BodyId> {
        (body != BodyId::WORLD).then(|| BodyId(self.tables().bodies[body.0].parent))
    }

    /// Mass of a body, kg, without its children.
    pub fn body_mass(&self, body: BodyId) -> f64 {
        self.tables().bodies[body.0].mass
    }

    /// Centre of mass of a body in its frame.
    pub fn body_com_in_body(&self, body: BodyId) -> Point3<f64> {
        self.tables().bodies[body.0].com_in_body
    }

    /// Pose of a body in its parent where its joints are at their reference.
    pub fn parent_from_body(&self, body: BodyId) -> Pose {
        self.tables().bodies[body.0].parent_from_body
    }

    /// First body up the tree that a body is fixed to: itself when it has joints, the world when
    /// nothing above it moves.
    pub fn body_weld_root(&self, body: BodyId) -> BodyId {
        BodyId(self.tables().bodies[body.0].weld_root)
    }

    /// Whether a body is moved by hand ([`State::set_mocap`](crate::State::set_mocap)).
    pub fn body_is_mocap(&self, body: BodyId) -> bool {
        self.tables().bodies[body.0].mocap.is_some()
    }

    /// Bodies directly under a body.
    pub fn body_children(&self, body: BodyId) -> Vec<BodyId> {
        self.tables().children(body).collect()
    }

    /// A body and all below it, in increasing order.
    pub fn bodies_of_subtree(&self, body: BodyId) -> Vec<BodyId> {
        let mut inside = vec![false; self.n_bodies()];
        inside[body.0] = true;
        for i in body.0 + 1..self.n_bodies() {
            inside[i] = inside[self.tables().bodies[i].parent];
        }
        (0..self.n_bodies())
            .filter(|&i| inside[i])
            .map(BodyId)
            .collect()
    }

    /// Geoms directly on a body.
    pub fn geoms_of_body(&self, body: BodyId) -> Vec<GeomId> {
        self.tables().geoms_of(body).collect()
    }

    /// Geoms of a body and of all below it.
    pub fn geoms_of_subtree(&self, body: BodyId) -> Vec<GeomId> {
        self.bodies_of_subtree(body)
            .into_iter()
            .flat_map(|inside| self.tables().geoms_of(inside))
            .collect()
    }

    /// Index of an actuator's value in `ctrl`.
    pub fn ctrl_adr(&self, actuator: ActuatorId) -> usize {
        self.tables().actuators[actuator.0].ctrl_adr
    }

    /// Limits of an actuator's control value; `None` when it has none.
    pub fn actuator_ctrl_range(&self, actuator: ActuatorId) -> Option<[f64; 2]> {
        self.tables().actuators[actuator.0].ctrl_range
    }

    /// Limits of an actuator's force, N or N m; `None` when it has none.
    pub fn actuator_force_range(&self, actuator: ActuatorId) -> Option<[f64; 2]> {
        self.tables().actuators[actuator.0].force_range
    }

    /// Joint that an actuator drives; `None` when it drives a tendon or a site.
    pub fn actuator_joint(&self, actuator: ActuatorId) -> Option<JointId> {
        self.tables().actuators[actuator.0].joint.map(JointId)
    }

    /// Shape of a geom, in its own frame.
    pub fn geom_shape(&self, geom: GeomId) -> GeomShape {
        self.geom_shape_ref(geom).clone()
    }

    /// The shape of a geom, in place.
    pub(crate) fn geom_shape_ref(&self, geom: GeomId) -> &GeomShape {
        &self.tables().geoms[geom.0].shape
    }

    /// Pose of a geom in its body. A mesh's frame is centred and turned by the compiler, so it is not
    /// the pose written in the file; use it with [`geom_shape`](Self::geom_shape).
    pub fn body_from_geom(&self, geom: GeomId) -> Pose {
        self.tables().geoms[geom.0].body_from_geom
    }

    /// Radius of the sphere about a geom's centre that holds it, m; 0 for a plane, which is endless.
    pub fn geom_bounding_radius_m(&self, geom: GeomId) -> f64 {
        self.tables().geoms[geom.0].bounding_radius_m
    }

    /// Colour of a geom (or of its material), each in 0..1.
    pub fn geom_rgba(&self, geom: GeomId) -> [f32; 4] {
        self.tables().geoms[geom.0].rgba
    }

    /// Display group of a geom, 0 to 5.
    pub fn geom_group(&self, geom: GeomId) -> usize {
        self.tables().geoms[geom.0].group
    }

    /// `contype` and `conaffinity`; two geoms may touch when one's type meets the other's affinity.
    pub fn geom_contact_bits(&self, geom: GeomId) -> (i32, i32) {
        self.tables().geoms[geom.0].contact_bits
    }

    /// Sliding, torsional and rolling friction of a geom.
    pub fn geom_friction(&self, geom: GeomId) -> [f64; 3] {
        self.tables().geoms[geom.0].friction
    }

    /// Whether a geom can touch anything.
    pub fn geom_collides(&self, geom: GeomId) -> bool {
        let (contype, conaffinity) = self.geom_contact_bits(geom);
        contype != 0 || conaffinity != 0
    }

    /// The keyframe of this name.
    ///
    /// # Errors
    /// [`PhysicsError::UnknownName`], listing the names there are.
    pub fn keyframe(&self, name: &str) -> Result<KeyframeId, PhysicsError> {
        let keyframes = &self.tables().keyframes;
        keyframes
            .iter()
            .position(|key| !name.is_empty() && key == name)
            .map(KeyframeId)
            .ok_or_else(|| PhysicsError::UnknownName {
                kind: "keyframe",
                name: name.to_owned(),
                model: self.name().to_owned(),
                available: keyframes.clone(),
            })
    }

    /// What a degree of freedom belongs to, for messages.
    pub(crate) fn dof_owner(&self, dof: usize) -> String {
        self.owner(
            |joint| (joint.dof_adr, joint.kind.n_v()),
            dof,
            "degree of freedom",
        )
    }

    /// What a position coordinate belongs to, for messages.
    pub(crate) fn qpos_owner(&self, adr: usize) -> String {
        self.owner(|joint| (joint.qpos_adr, joint.kind.n_q()), adr, "position")
    }

    fn owner(
        &self,
        place: impl Fn(&crate::tables::Joint) -> (usize, usize),
        at: usize,
        what: &str,
    ) -> String {
        let found = self.tables().joints.iter().find(|joint| {
            let (adr, n) = place(joint);
            (adr..adr + n).contains(&at)
        });
        match found {
            Some(joint) if !joint.name.is_empty() => format!("joint `{}`", joint.name),
            Some(joint) => {
                format!(
                    "an unnamed joint of body `{}`",
                    self.tables().bodies[joint.body].name
                )
            }
            None => format!("{what} {at}"),
        }
    }
}
