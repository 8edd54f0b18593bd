//! Composable Interaction Primitives: contact skills that are learned safely and in few trials (thesis Chapter 3).
//!
//! ```text
//! C = (π_c, σ, β_c, I_c, h, t, B)
//! ```
//!
//! | part | what it is | here |
//! |---|---|---|
//! | π_c | policy from what is felt to tool motion, stiffness and gripper (Eq. 3.1) | [`observation`], [`action`], `learning::td3` |
//! | σ | safety envelope of the robot's joints, not of the task | `control::safety`, `control::barrier`, [`setting`] |
//! | β_c | success indicator of the task | [`ending::SuccessIndicator`] |
//! | I_c | grasps, and the probability of success from each | [`initiation`], [`grasp_search`] |
//! | h, t | free-space motion to a grasp and away from it | [`configuration`], [`Primitive`] |
//! | B | failure classifier, the same for all tasks | [`ending::FailureClassifier`] |
//!
//! [`setting`] says which of them are there: the ablations of thesis 3.3. [`training`] learns π_c and I_c on a
//! [`rig::Rig`], which is a simulated robot at an object, or a real one. What was learned is a [`Primitive`], a
//! [`Skill`](crate::Skill) like those that were taught.

pub mod action;
pub mod configuration;
pub mod ending;
pub mod environment;
pub mod grasp_search;
pub mod guide;
pub mod hand_motion;
pub mod initiation;
pub mod joint_from_tool;
pub mod observation;
pub mod perturbation;
mod primitive;
pub mod reward;
pub mod rig;
pub mod setting;
pub mod training;

pub use primitive::{Primitive, PrimitiveError};
