//! How joints move, and how many numbers that takes.

use std::ffi::c_int;

use mujoco_rs::mujoco_c::mjtJoint;

use crate::error::PhysicsError;

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Six degrees of freedom; 7 positions (x, y, z, then quaternion w, x, y, z), 6 velocities
    /// (linear in the world, then angular in the body).
    Free,
    /// Three rotations; 4 positions (quaternion w, x, y, z), 3 velocities.
    Ball,
    /// One translation, m.
    Slide,
    /// One rotation, rad.
    Hinge,
}

impl JointKind {
    /// How many entries it has in `qpos`.
    pub fn n_q(self) -> usize {
        match self {
            Self::Free => 7,
            Self::Ball => 4,
            Self::Slide | Self::Hinge => 1,
        }
    }

    /// How many entries it has in `qvel`.
    pub fn n_v(self) -> usize {
        match self {
            Self::Free => 6,
            Self::Ball => 3,
            Self::Slide | Self::Hinge => 1,
        }
    }
}

impl TryFrom<c_int> for JointKind {
    type Error = PhysicsError;

    fn try_from(value: c_int) -> Result<Self, PhysicsError> {
        [
            (mjtJoint::mjJNT_FREE, Self::Free),
            (mjtJoint::mjJNT_BALL, Self::Ball),
            (mjtJoint::mjJNT_SLIDE, Self::Slide),
            (mjtJoint::mjJNT_HINGE, Self::Hinge),
        ]
        .into_iter()
        .find_map(|(raw, kind)| (raw as c_int == value).then_some(kind))
        .ok_or(PhysicsError::Argument {
            what: "joint type of the compiled model",
            found: value.to_string(),
            expected: "0 (free), 1 (ball), 2 (slide) or 3 (hinge)",
        })
    }
}
