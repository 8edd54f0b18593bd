//! Physics: MuJoCo's models, states, contacts, rays and sensors behind a safe interface.
//!
//! A [`Model`] is compiled from MJCF or URDF, or put together by a [`SceneBuilder`]; it never changes.
//! A [`State`] is a state of one model that steps, answers questions and can fail, but never ends the
//! process: MuJoCo's fatal errors come back as [`PhysicsError::Engine`] and discard that state alone,
//! and a state that diverges is reported, not silently reset.
//!
//! ```
//! use factotum_physics::{Model, State};
//!
//! let model = Model::from_mjcf_str(
//!     r#"<mujoco><worldbody><body name="ball" pos="0 0 1">
//!          <freejoint/><geom size="0.1"/></body></worldbody></mujoco>"#,
//! )?;
//! let mut state = State::new(&model)?;
//! while state.time_secs() < 0.1 {
//!     state.step()?;
//! }
//! let ball = model.body("ball")?;
//! state.forward_kinematics()?;
//! assert!(state.world_from_body(ball).translation.z < 1.0);
//! # Ok::<(), factotum_physics::PhysicsError>(())
//! ```
//!
//! # Units and frames
//! MuJoCo has no units of its own; we fix metres, kilograms, seconds and radians. The world is z up.
//! Poses read `world_from_body`; vectors are in world axes unless their name says otherwise.
//!
//! # MuJoCo's traps, once
//! - `n_q` ≠ `n_v` as soon as there is a free or ball joint: address positions by
//!   [`Model::qpos_adr`] and everything else by [`Model::dof_adr`].
//! - The velocity of a free joint is linear in the **world** and angular in the **body** frame.
//! - Quaternions in `qpos` are (w, x, y, z); [`axes`] converts, and nothing outside this crate sees it.
//! - `cvel` and other spatial vectors of MuJoCo put the rotation first; [`State::site_velocity`] and
//!   the Jacobians here put the translation first.
//! - MJCF angles are in degrees unless `<compiler angle="radian"/>`; a compiled model is in radians,
//!   but for the cameras' field of view, which this crate converts.
//! - Cameras of MuJoCo look along −z; [`State::world_from_camera`] is the optical frame (z forward).
//! - Results follow the last computation, not the last write: after changing `qpos`, call
//!   [`State::forward_kinematics`], [`State::dynamics`], [`State::detect_collisions`] or
//!   [`State::forward`], whichever is enough. After [`State::step`] poses are those *before* the
//!   integration, one step behind `qpos`.
//! - A joint without limits has a range in the file all the same; [`Model::joint_range`] is `None`.
//! - Geoms of a body and its parent never touch unless the model says so, and geoms of bodies fixed
//!   to the world never touch each other.
//! - A mesh collides as its convex hull, while rays meet its triangles.
#![expect(unsafe_code, reason = "the one crate that calls MuJoCo's C interface")]

pub mod axes;
mod contacts;
mod depth_camera;
mod dynamics;
mod engine;
mod error;
mod geom_shape;
mod ids;
mod joint_kind;
mod kinematics;
mod model;
mod model_edit;
mod picture;
mod planar_lidar;
mod ray_fan;
mod rays;
pub mod scene;
mod self_collision;
mod site_chain;
mod snapshot;
mod spec;
mod state;
mod state_arrays;
mod tables;
mod urdf;

pub use contacts::{Contact, ContactWrench};
pub use depth_camera::{DepthImage, PinholeCamera, depth_image};
pub use engine::engine_version;
pub use error::PhysicsError;
pub use geom_shape::GeomShape;
pub use ids::{ActuatorId, BodyId, CameraId, GeomId, JointId, KeyframeId, SensorId, SiteId};
pub use joint_kind::JointKind;
pub use model::Model;
pub use model_edit::ModelEdit;
pub use picture::{Picture, picture};
pub use planar_lidar::planar_scan;
pub use rays::{RayFilter, RayHit};
pub use scene::{
    AttachOptions, AttachPoint, Integrator, Motion, NewSite, Part, PartNames, Primitive,
    SceneBuilder, SceneOptions, Shape,
};
pub use self_collision::{BodyPair, PairKind, self_collision_pairs};
pub use site_chain::SiteChain;
pub use snapshot::Snapshot;
pub use spec::{NewActuator, Servo};
pub use state::State;
pub use urdf::{UrdfOptions, urdf_to_mjcf};

pub use factotum_geometry::Pose;
