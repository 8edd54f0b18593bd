//! Simulated robots in simulated homes, and the judge that reads physics to say what was really achieved.
//!
//! [`SimRobot`] composes a described robot with a [`HomeScene`] in one physics model and implements
//! [`factotum_control::Robot`]: commands become goals of controllers that run at each physics step and write nothing but
//! actuator controls. The controllers know the robot from its own model, not from the simulation. Its senses err as
//! [`Noise`] says; [`Fault`]s disturb it from outside.
//!
//! Whoever decides what to do gets the `Robot` and nothing else. [`Judge`], [`SimRobot::true_grid`] and the poses in
//! [`WorldView`] are for those who watch and measure.
//!
//! The same configuration and the same commands give the same bytes: all randomness comes from one seed, in streams
//! by purpose.
//!
//! Frames: the world frame of the scene (x east, y north, z up), the odometry frame (identity where the robot starts),
//! the base frame (x forward, y left, z up). SI and radians.

pub mod action_map;
mod assembly;
mod error;
mod faults;
mod ground_truth;
mod judge;
pub mod kitchen;
mod noise;
mod odometry;
mod random;
mod scene;
mod sensing;
mod sim_robot;
mod snapshot;
mod task_rig;
mod visual;

pub use error::WorldError;
pub use faults::{Fault, FaultSwitch, UnknownFault};
pub use judge::{Judge, Verdict};
pub use noise::Noise;
pub use scene::{
    Bounds, Chore, Criterion, HomeScene, Place, Placed, PlacedObject, SceneObject, StartRegion,
};
pub use sim_robot::{SimRobot, WorldConfig};
pub use snapshot::WorldSnapshot;
pub use task_rig::{RigError, TaskRig};
pub use visual::{BodyGroup, VisualBody, VisualShape, WorldView};
