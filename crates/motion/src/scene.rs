//! A planning scene: the robot among obstacles that the caller believes in.
//!
//! Checked are contacts between what the chain moves and obstacles, and between parts of the robot that the chain
//! moves against each other (see `robot/groups.rs`). What does not depend on the configuration is not checked:
//! neither the base against obstacles nor obstacles against each other.

mod compile;

use std::collections::BTreeSet;
use std::path::PathBuf;

use factotum_physics::{GeomId, JointId, State};
use nalgebra::Matrix6xX;

use crate::Pose;
use crate::error::MotionError;
use crate::manipulability;
use crate::robot::RobotModel;

/// Shape of an obstacle, in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub enum ObstacleShape {
    /// A box about the origin.
    Box {
        /// Half its edges, metres.
        half_extents_m: [f64; 3],
    },
    /// A cylinder about the origin, along z.
    Cylinder {
        /// Radius, metres.
        radius_m: f64,
        /// Half its length, metres.
        half_length_m: f64,
    },
    /// A sphere about the origin.
    Sphere {
        /// Radius, metres.
        radius_m: f64,
    },
    /// The kinematic model τ of an object class.
    Model {
        /// MJCF or URDF file.
        file: PathBuf,
        /// Positions of its joints, by name (rad, m); others are as the model has them.
        joint_positions: Vec<(String, f64)>,
    },
}

/// Something the arm must not touch.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Name, unique in the scene.
    pub name: String,
    /// Its shape.
    pub shape: ObstacleShape,
    /// Where it is.
    pub base_from_obstacle: Pose,
}

/// An object in the gripper.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldObject {
    /// Its shape.
    pub shape: ObstacleShape,
    /// Where it is in the tool frame.
    pub tcp_from_object: Pose,
}

/// The robot among obstacles. Queries change an internal state, hence `&mut`.
#[derive(Debug)]
pub struct PlanningScene {
    robot: RobotModel,
    state: State,
    joints: Vec<JointId>,
    gripper: Vec<GripperJoint>,
    /// What each geom is, for messages and for [`PlanningScene::allow_contact`].
    owners: Vec<Owner>,
    margin_m: f64,
    allowed: BTreeSet<String>,
}

/// What a geom belongs to.
#[derive(Debug, Clone, PartialEq)]
enum Owner {
    Robot { body: String, is_tool: bool },
    Held,
    Obstacle { name: String },
}

/// Distance beyond the margin (m) up to which [`PlanningScene::clearance_m`] sees.
pub const CLEARANCE_SEEN_M: f64 = 0.005;

/// First name of the pair that is given for a configuration that could not be checked.
pub const UNCHECKED: &str = "unchecked configuration";

/// Name by which the held object appears in collisions.
pub const HELD_OBJECT: &str = "held object";

impl Owner {
    fn label(&self) -> &str {
        match self {
            Self::Robot { body, .. } => body,
            Self::Held => HELD_OBJECT,
            Self::Obstacle { name } => name,
        }
    }

    fn is_tool(&self) -> bool {
        matches!(self, Self::Held | Self::Robot { is_tool: true, .. })
    }
}

/// A finger joint with its positions in the closed and in the open gripper.
#[derive(Debug)]
struct GripperJoint {
    joint: JointId,
    closed: f64,
    open: f64,
}

impl PlanningScene {
    /// Compiles a scene; things collide when they overlap. The gripper is open.
    ///
    /// # Errors
    /// [`MotionError`] if a model does not load or two obstacles have one name.
    pub fn new(
        robot: &RobotModel,
        obstacles: &[Obstacle],
        held: Option<&HeldObject>,
    ) -> Result<Self, MotionError> {
        Self::with_margin(robot, obstacles, held, 0.0)
    }

    /// Compiles a scene in which things collide when they are nearer than `margin_m`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_margin(
        robot: &RobotModel,
        obstacles: &[Obstacle],
        held: Option<&HeldObject>,
        margin_m: f64,
    ) -> Result<Self, MotionError> {
        compile::compile(robot, obstacles, held, margin_m)
    }

    /// The robot.
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// Pose of the tool.
    ///
    /// # Panics
    /// When `q` does not have one value per chain joint.
    pub fn base_from_tcp(&self, q: &[f64]) -> Pose {
        self.robot.chain().base_from_tcp(q)
    }

    /// Jacobian at the tool, base frame, linear above angular.
    ///
    /// # Panics
    /// When `q` does not have one value per chain joint.
    pub fn jacobian(&self, q: &[f64]) -> Matrix6xX<f64> {
        self.robot.chain().jacobian(q)
    }

    /// Manipulability value (thesis Eq. 3.2).
    ///
    /// # Panics
    /// When `q` does not have one value per chain joint.
    pub fn manipulability(&self, q: &[f64]) -> f64 {
        manipulability::manipulability(&self.robot.chain().jacobian(q), self.robot.limits(), q)
    }

    /// Names of the first colliding pair, or nothing if the configuration is free.
    ///
    /// A configuration that cannot be checked (wrong length, not finite, or the engine fails) counts as colliding:
    /// the pair is then [`UNCHECKED`] and the reason.
    pub fn collision(&mut self, q: &[f64]) -> Option<(String, String)> {
        let (a, b) = match self.first_contact(q, 0.0) {
            Ok(contact) => contact?,
            Err(error) => return Some((UNCHECKED.to_owned(), error.to_string())),
        };
        let label = |geom: GeomId| self.owners[geom.index()].label().to_owned();
        Some((label(a), label(b)))
    }

    /// Whether nothing collides.
    pub fn is_free(&mut self, q: &[f64]) -> bool {
        self.is_free_by(q, 0.0)
    }

    /// The tool (gripper and held object) may touch this obstacle; a name that the scene lacks changes nothing.
    pub fn allow_contact(&mut self, obstacle: &str) {
        self.allowed.insert(obstacle.to_owned());
    }

    /// The tool may no longer touch this obstacle.
    pub fn forbid_contact(&mut self, obstacle: &str) {
        self.allowed.remove(obstacle);
    }

    /// Sets the opening of the gripper for collision checks: 0 closed, 1 open.
    pub fn set_gripper(&mut self, opening: f64) {
        let opening = if opening.is_finite() {
            opening.clamp(0.0, 1.0)
        } else {
            1.0
        };
        for finger in &self.gripper {
            let position = finger.closed + opening * (finger.open - finger.closed);
            self.state.set_joint_position(finger.joint, position);
        }
    }

    /// Distance to the nearest thing that the chain could collide with, beyond the scene's margin: negative in
    /// collision, at most [`CLEARANCE_SEEN_M`], and not a number where `q` cannot be checked.
    pub fn clearance_m(&mut self, q: &[f64]) -> f64 {
        if self.detect(q).is_err() {
            return f64::NAN;
        }
        let distances = self
            .state
            .contacts()
            .filter(|contact| !self.may_touch(contact.geom_a, contact.geom_b))
            .map(|contact| contact.distance_m - self.margin_m);
        distances.fold(CLEARANCE_SEEN_M, f64::min)
    }

    /// Distance from the tool (gripper and held object) to an obstacle, beyond the scene's margin; else as
    /// [`Self::clearance_m`].
    pub fn tool_clearance_m(&mut self, q: &[f64], obstacle: &str) -> f64 {
        if self.detect(q).is_err() {
            return f64::NAN;
        }
        let is_obstacle =
            |owner: &Owner| matches!(owner, Owner::Obstacle { name } if name == obstacle);
        let distances = self.state.contacts().filter_map(|contact| {
            let [a, b] = [contact.geom_a, contact.geom_b].map(|geom| &self.owners[geom.index()]);
            let of_pair = (is_obstacle(a) && b.is_tool()) || (is_obstacle(b) && a.is_tool());
            of_pair.then_some(contact.distance_m - self.margin_m)
        });
        distances.fold(CLEARANCE_SEEN_M, f64::min)
    }

    /// Whether nothing is nearer than `clearance_m` beyond the scene's margin; [`CLEARANCE_SEEN_M`] is the most
    /// that can be told.
    pub fn is_free_by(&mut self, q: &[f64], clearance_m: f64) -> bool {
        matches!(self.first_contact(q, clearance_m), Ok(None))
    }

    fn first_contact(
        &mut self,
        q: &[f64],
        clearance_m: f64,
    ) -> Result<Option<(GeomId, GeomId)>, MotionError> {
        self.detect(q)?;
        let nearest_allowed = self.margin_m + clearance_m;
        let contact = self.state.contacts().find(|contact| {
            contact.distance_m < nearest_allowed && !self.may_touch(contact.geom_a, contact.geom_b)
        });
        Ok(contact.map(|contact| (contact.geom_a, contact.geom_b)))
    }

    /// Moves the state to `q` and finds its contacts.
    fn detect(&mut self, q: &[f64]) -> Result<(), MotionError> {
        if q.len() != self.joints.len() {
            return Err(MotionError::Width {
                what: "configuration",
                found: q.len(),
                wanted: self.joints.len(),
            });
        }
        for (&joint, &q) in self.joints.iter().zip(q) {
            if !q.is_finite() {
                return Err(MotionError::NotFinite {
                    what: "joint position",
                    found: q,
                });
            }
            self.state.set_joint_position(joint, q);
        }
        Ok(self.state.detect_collisions()?)
    }

    /// Whether a contact found by physics is no collision. (Pairs that never matter are not found.)
    fn may_touch(&self, a: GeomId, b: GeomId) -> bool {
        let (a, b) = (&self.owners[a.index()], &self.owners[b.index()]);
        match (a, b) {
            (Owner::Obstacle { .. }, Owner::Obstacle { .. }) => true,
            (Owner::Obstacle { name }, other) | (other, Owner::Obstacle { name }) => {
                other.is_tool() && self.allowed.contains(name)
            }
            (Owner::Robot { body: a, .. }, Owner::Robot { body: b, .. }) => {
                self.robot.always_touch(a, b)
            }
            (Owner::Held, _) | (_, Owner::Held) => false,
        }
    }
}

#[cfg(test)]
mod tests;
