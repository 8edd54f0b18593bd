//! Robots and objects as checked data.
//!
//! A person writes `robot.toml` and `class.toml`; this room reads them, refuses what makes no sense and hands the
//! rest of the house plain values. Nothing here moves, plans or simulates.
//!
//! Reading is parsing, not validating after the fact: a private raw form is deserialised with unknown keys refused
//! (the error names the nearest known key), then turned into the public type, whose fields always make sense together.
//! Names of joints and sites are checked against the model where the model is loaded, in `physics` and `motion`.
//!
//! Units are SI and radians. Poses are read as `xyz` (m) and `rpy` (rad, fixed axes X, Y, Z as in REP-103).

mod error;
mod form;
mod object;
mod placement;
mod provenance;
mod recorded_motion;
mod robot;
mod task;
mod taught;
mod toml_file;
mod trajectory;

pub use error::DescriptionError;
pub use form::{Form, FormError, SIZE_MAX_M, SIZE_MIN_M};
pub use object::{
    ActionKind, ActionSpec, Approach, Contact, Demonstration, Grasp, JointKind, ObjectClass,
    ObjectJoint, StateInterval,
};
pub use placement::Placement;
pub use provenance::Provenance;
pub use recorded_motion::{
    MotionFileError, MotionHead, MotionProblem, MotionSample, RecordedMotion,
};
pub use robot::{
    Arm, Base, Camera, Gripper, Lidar, Lift, RobotDescription, RobotPart, Sensors, TcpFrame,
};
pub use task::{EpisodeSpec, MotorPolicy, MotorSpec, PlacementRange, TaskSpec};
pub use toml_file::{nearest_name, parse_toml, read_toml};
pub use trajectory::{JointTrajectory, TrajectoryError, TrajectoryPoint};
