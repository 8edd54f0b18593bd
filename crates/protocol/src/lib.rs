//! Wire messages between the studio and its page, as plain data.
//!
//! The studio sends [`ServerMessage`]s and receives [`ClientMessage`]s, one JSON document per
//! WebSocket text frame, told apart by their `type` field. This crate holds data and nothing
//! else: inner types of the other rooms are converted to it by hand, so that what they look like
//! inside can change without changing the wire.
//!
//! # Frames and units
//!
//! Metres, radians and seconds of simulated time. Every pose is in the world frame (z up,
//! x forward, y left, REP-103), which is also the frame of the map, unless a field says otherwise.
//! Quaternions are `[x, y, z, w]`. Numbers are finite: a message with a NaN is a bug of its
//! sender, see [`State::is_finite`].
//!
//! # The page's types
//!
//! [`typescript::module`] renders all of this as TypeScript. The result is committed as
//! `web/src/protocol.ts`; a test compares the two, and
//! `cargo run -p factotum-protocol --example codegen` brings it up to date.

mod aosm;
mod drive;
mod job;
mod map;
mod message;
mod plan;
mod pose;
mod role;
mod scene;
mod state;
mod teaching;
mod training;
pub mod typescript;

pub use aosm::{Aosm, AosmEdge, AosmObject, NavigationRegion, ObjectClass, Provenance};
pub use drive::Drive;
pub use job::{Activity, Done, Event, EventLevel, Status};
pub use map::{CELL_OCCUPIED, CELL_UNKNOWN, MapError, OccupancyMap};
pub use message::{ClientMessage, Hello, ServerMessage};
pub use plan::{Plan, PlanStep, StepKind, StepState};
pub use pose::{Pose, PosePlanar};
pub use role::{Control, Role};
pub use scene::{Body, Geometry, Scene, SceneSource, Shape};
pub use state::{BasePath, BodyPose, JointPosition, State};
pub use teaching::{
    Action, ActionMotion, Approach, CatalogueClass, ClassJoint, ClassPart, ClassState, Contact,
    EDIT_ID_CHARS_MAX, Edit, EditAnswer, EditOutcome, EditRequest, Form, Grasp, HistoryEntry,
    JointKind, TaughtClass, TaughtObject, Teaching,
};
pub use training::{Evaluation, Training, Trainings};

/// Version of this protocol. A page and a studio that differ in it do not understand each other.
pub const VERSION: u32 = 3;
