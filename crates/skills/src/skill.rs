//! The option (I, π, β) as a trait, and what it is told and reports.

use std::collections::BTreeMap;

use factotum_control::{Robot, RobotError, RobotState};
use factotum_descriptions::ObjectClass;
use factotum_geometry::Pose;
use factotum_learning::dmp::DmpError;
use factotum_motion::{HeldObject, MotionError, Obstacle, ObstacleShape, RobotModel};
use rand_chacha::ChaCha8Rng;

/// What is around the robot, as it believes, in the frame of its base.
#[derive(Debug, Clone)]
pub struct Situation {
    /// The robot's kinematics.
    pub robot: RobotModel,
    /// Everything that must not be hit, but for the object of the skill.
    pub obstacles: Vec<Obstacle>,
    /// The object of the skill.
    pub object: ObjectView,
    /// Where the object is to go, for skills that put it somewhere.
    pub target: Option<ObjectView>,
    /// What the gripper holds.
    pub held: Option<HeldView>,
}

/// An object as the robot believes it to be.
#[derive(Debug, Clone)]
pub struct ObjectView {
    /// Name in the home.
    pub name: String,
    /// Its class.
    pub class: ObjectClass,
    /// Pose of Λ in the base frame.
    pub base_from_object: Pose,
    /// Joint positions, rad or m.
    pub joints: BTreeMap<String, f64>,
}

impl ObjectView {
    /// The object as a thing to keep clear of.
    pub fn as_obstacle(&self) -> Obstacle {
        Obstacle {
            name: self.name.clone(),
            shape: self.shape(),
            base_from_obstacle: self.base_from_object,
        }
    }

    pub(crate) fn shape(&self) -> ObstacleShape {
        ObstacleShape::Model {
            file: self.class.model.clone(),
            joint_positions: self
                .joints
                .iter()
                .map(|(name, q)| (name.clone(), *q))
                .collect(),
        }
    }
}

/// What the gripper holds.
#[derive(Debug, Clone)]
pub struct HeldView {
    /// Name in the home.
    pub name: String,
    /// Its class.
    pub class: ObjectClass,
    /// Pose of Λ in the tool frame.
    pub tcp_from_object: Pose,
}

impl HeldView {
    /// The held object as part of the arm.
    pub fn as_held(&self) -> HeldObject {
        HeldObject {
            shape: ObstacleShape::Model {
                file: self.class.model.clone(),
                joint_positions: Vec::new(),
            },
            tcp_from_object: self.tcp_from_object,
        }
    }
}

/// Whether an option can start here: I, asked of one state.
#[derive(Debug, Clone, PartialEq)]
pub enum Initiation {
    /// It can, as far as kinematics and collisions tell.
    Possible,
    /// It cannot, and why.
    Impossible(Failure),
}

/// How an execution ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// β: the skill believes that it did what it is for.
    Done {
        /// Pose of the held object in the tool frame, if the skill ended holding one.
        tcp_from_held: Option<Pose>,
        /// Where the skill believes it left the object's joints.
        joints: BTreeMap<String, f64>,
    },
    /// It did not.
    Failed(Failure),
}

/// Why a skill could not start or did not succeed, in words for people.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// The class has no grasp, joint or pose that the skill needs.
    #[error("class `{class}` has no {what}")]
    NotDescribed {
        /// The class.
        class: String,
        /// What is missing.
        what: String,
    },
    /// No arm posture reaches.
    #[error("`{object}` is out of reach from here ({detail})")]
    OutOfReach {
        /// The object.
        object: String,
        /// How near the best try came, or what was in the way.
        detail: String,
    },
    /// No collision-free motion was found.
    #[error("no free way for the arm to `{object}` ({detail})")]
    NoWay {
        /// The object.
        object: String,
        /// Which search ended how.
        detail: String,
    },
    /// The gripper closed on nothing.
    #[error("the gripper closed without `{object}` in it")]
    Missed {
        /// The object.
        object: String,
    },
    /// The object was lost on the way.
    #[error("`{object}` slipped out of the gripper")]
    Slipped {
        /// The object.
        object: String,
    },
    /// The motion ended before its goal.
    #[error("the arm stopped short while it was to {doing}: {reason}")]
    Stopped {
        /// What it was doing.
        doing: String,
        /// Why it stopped.
        reason: String,
    },
    /// A person or the executive stopped it.
    #[error("stopped on request")]
    OnRequest,
}

/// Why a skill could not even be tried: a fault of the machine or of the data, not of the attempt.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SkillError {
    /// The robot does not answer or refused a command.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// A model could not be loaded, or a planner was misused.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// Nothing can be learned from what was shown.
    #[error("the demonstration of `{action}` for class `{class}` is of no use")]
    Demonstration {
        /// The class.
        class: String,
        /// Its action.
        action: String,
        /// Why.
        source: DmpError,
    },
}

/// An option: initiation set, policy and termination condition.
pub trait Skill {
    /// Name for people and reports.
    fn name(&self) -> &str;

    /// I: whether the skill could start from the state, by kinematics and collisions alone; moves nothing.
    ///
    /// # Errors
    /// [`SkillError::Motion`] if a model cannot be loaded.
    fn initiation(
        &self,
        situation: &Situation,
        state: &RobotState,
        rng: &mut ChaCha8Rng,
    ) -> Result<Initiation, SkillError>;

    /// Runs π until β and reports.
    ///
    /// # Errors
    /// [`SkillError`] for faults that trying again would not mend.
    fn run(
        &self,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, SkillError>;
}
