//! Control laws, and the [`Robot`] trait through which the rest of the house commands a machine.
//!
//! The laws are pure: arm terms and targets in, torques or velocities out, with the time step as an argument. Whoever
//! owns a robot's clock (the simulated robot in `worlds`, a driver for a real one) calls them once per control step.
//!
//! | module | holds |
//! |---|---|
//! | [`robot`] | the `Robot` trait, its commands, states and errors |
//! | [`arm_state`] | mass matrix, bias forces, Jacobian and tool pose of an arm at one instant |
//! | [`arm_dynamics`] | the robot's own model, from which an arm state is computed |
//! | [`model_arm`] | where the numbers of an arm lie in a physics model |
//! | [`composition`] | putting a described robot together in a physics scene |
//! | [`impedance`] | variable-impedance operational-space control (thesis Eq. 3.1) and null-space posture |
//! | [`joint_tracking`] | computed-torque tracking of joint targets |
//! | [`torque_limit`] | torque and torque rate limits |
//! | [`safety`] | the safety envelope σ of the thesis, section 3.2.1 |
//! | [`barrier`] | a hard guard of the joint limits, our own option beside σ |
//! | [`tool_servo`] | tool target to motor torques: impedance, guard, limits |
//! | [`tool_path`] | where the tool should be at a time |
//! | [`base_tracking`] | following a path with an omnidirectional base |
//! | [`gripper`] | finger targets under a force limit, and when a grip is done |
//! | [`wrench_estimate`] | external wrench on the tool without a force sensor |
//!
//! Frames and units: SI and radians; poses, Jacobians and wrenches of the tool are expressed in the base frame
//! (x forward, y left, z up, REP-103); linear rows come before angular ones.

pub mod arm_dynamics;
pub mod arm_state;
pub mod barrier;
pub mod base_tracking;
pub mod composition;
mod error;
pub mod gripper;
pub mod impedance;
pub mod joint_tracking;
pub mod model_arm;
pub mod robot;
pub mod safety;
pub mod tool_path;
pub mod tool_servo;
pub mod torque_limit;
pub mod wrench_estimate;

pub use arm_dynamics::ArmDynamics;
pub use arm_state::ArmState;
pub use error::ControlError;
pub use model_arm::ModelArm;
pub use robot::*;
