//! Which bodies of a robot can meet when the chain moves.
//!
//! Bodies between two successive chain joints move as one: they are a group. Group 0 stands with the base, group
//! i follows the i-th joint, and the last group is the hand with what it holds. Two bodies of one group never
//! move against each other, and neighbouring groups are housings around one joint: neither is checked.

use factotum_physics::{BodyId, JointId, Model};

use crate::error::MotionError;

/// Contact bits of obstacles; the bits below are the groups'.
const OBSTACLE_BIT: i32 = 1 << 30;

/// The group of every body of a model.
#[derive(Debug, Clone)]
pub(crate) struct Groups {
    of_body: Vec<usize>,
    n_joints: usize,
}

impl Groups {
    /// Longest chain: each group has a bit of its own.
    const N_JOINTS_MAX: usize = 29;

    /// Groups by the chain's joints, base first.
    pub(crate) fn of(model: &Model, joints: &[JointId]) -> Result<Self, MotionError> {
        if joints.len() > Self::N_JOINTS_MAX {
            return Err(MotionError::Value {
                what: "number of chain joints",
                found: joints.len().to_string(),
                wanted: "at most 29",
            });
        }
        let mut of_body = vec![0; model.n_bodies()];
        // Parents come before their children.
        for body in model.bodies() {
            let inherited = model
                .body_parent(body)
                .map_or(0, |parent| of_body[parent.index()]);
            let own = joints
                .iter()
                .rposition(|&joint| model.joint_body(joint) == body);
            of_body[body.index()] = own.map_or(inherited, |idx| idx + 1);
        }
        Ok(Self {
            of_body,
            n_joints: joints.len(),
        })
    }

    pub(crate) fn of_body(&self, body: BodyId) -> usize {
        self.of_body[body.index()]
    }

    /// Whether the body is part of the hand, or held.
    pub(crate) fn is_tool(&self, body: BodyId) -> bool {
        self.of_body(body) == self.n_joints
    }

    /// Whether two bodies of the robot can meet in some configurations and not in others.
    pub(crate) fn may_meet(&self, a: BodyId, b: BodyId) -> bool {
        self.of_body(a).abs_diff(self.of_body(b)) >= 2
    }

    /// Contact type and affinity of a body of the robot: it meets groups further than the neighbouring ones
    /// towards the base, and obstacles if the chain moves it.
    pub(crate) fn contact_bits(&self, body: BodyId) -> (i32, i32) {
        let group = self.of_body(body);
        let nearer_to_base = if group >= 2 {
            (1 << (group - 1)) - 1
        } else {
            0
        };
        let obstacles = if group >= 1 { OBSTACLE_BIT } else { 0 };
        (1 << group, nearer_to_base | obstacles)
    }

    /// Contact type and affinity of an obstacle.
    pub(crate) const OBSTACLE_BITS: (i32, i32) = (OBSTACLE_BIT, 0);
}
