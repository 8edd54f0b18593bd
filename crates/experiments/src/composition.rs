//! Skills that were learned apart, done one after the other in a scene that none of them has seen (thesis 3.4.1).
//!
//! Nothing is learned here. The tail of one skill ends in free space, where the head of the next begins; after the last
//! the arm goes to its ready posture. Where the objects stand is known; where their joints are, the skills tell. Whether
//! it succeeded is read off physics: at the end every joint is beyond the goal of its skill's task.

use factotum_control::Robot as _;
use factotum_descriptions::{DescriptionError, RobotDescription};
use factotum_geometry::Pose;
use factotum_geometry::frames::pose_from_planar;
use factotum_motion::{MotionError, Obstacle, ObstacleShape, PlanningScene};
use factotum_skills::cip::Primitive;
use factotum_skills::{ArmMotion, ObjectView, Outcome, Situation, Skill as _, SkillError};
use factotum_worlds::{HomeScene, Noise, SimRobot, WorldConfig, WorldError};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Why skills could not be composed at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompositionError {
    /// The robot's description.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The world.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The robot's kinematics.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A skill broke down.
    #[error(transparent)]
    Skill(#[from] SkillError),
    /// The scene has nothing that a skill is for.
    #[error(
        "scene `{scene}` has no object for skill `{skill}`, which moves joint `{joint}` of `{model}`; it has {available}"
    )]
    NoObject {
        /// The scene.
        scene: String,
        /// The skill.
        skill: String,
        /// The joint of its task.
        joint: String,
        /// The model of its task.
        model: String,
        /// Objects and classes of the scene.
        available: String,
    },
    /// Skills of different robots.
    #[error("skill `{skill}` was learned with robot `{found}`, expected `{wanted}` as the first")]
    Robots {
        /// The skill.
        skill: String,
        /// Its robot.
        found: String,
        /// That of the first skill.
        wanted: String,
    },
    /// Nothing to do.
    #[error("no skill to run, expected at least one")]
    Empty,
}

/// What came of a skill.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SkillResult {
    /// Task of the skill.
    pub skill: String,
    /// What it was done to.
    pub object: String,
    /// Whether the skill ended in β_c, by its own word.
    pub done: bool,
    /// Why it did not.
    pub failure: Option<String>,
    /// Where the joint really was when the skill ended, rad or m.
    pub joint_after: f64,
    /// Where it was at the end of all.
    pub joint_at_end: f64,
    /// Beyond which it should be.
    pub goal: f64,
    /// Whether it was, at the end.
    pub success: bool,
    /// Time that the skill took, seconds of the robot's clock.
    pub robot_secs: f64,
}

/// What came of all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CompositionResult {
    /// Whether every joint is beyond its goal and the arm ended in free space.
    pub success: bool,
    /// Skill by skill.
    pub skills: Vec<SkillResult>,
    /// Why the arm did not get to its ready posture.
    pub not_ready: Option<String>,
    /// Time in all, seconds of the robot's clock.
    pub robot_secs: f64,
}

/// Skills to be done in this order.
#[derive(Debug)]
pub struct Composition<'a> {
    /// Where.
    pub scene: &'a HomeScene,
    /// What.
    pub skills: &'a [Primitive],
    /// Draws where the objects stand.
    pub seed: u64,
}

impl Composition<'_> {
    /// The world before anything is done.
    ///
    /// # Errors
    /// [`CompositionError`] if robot and scene do not fit the skills.
    pub fn world(&self) -> Result<SimRobot, CompositionError> {
        let Some(first) = self.skills.first() else {
            return Err(CompositionError::Empty);
        };
        let wanted = &first.robot().description().name;
        for skill in self.skills {
            let found = &skill.robot().description().name;
            if found != wanted {
                return Err(CompositionError::Robots {
                    skill: skill.task().name.clone(),
                    found: found.clone(),
                    wanted: wanted.clone(),
                });
            }
            self.object_of(skill)?;
        }
        Ok(SimRobot::new(WorldConfig {
            robot: RobotDescription::load(&first.task().robot)?,
            scene: self.scene.clone(),
            seed: self.seed,
            noise: Noise::default(),
            fault: None,
        })?)
    }

    /// Does the skills one after the other in a world of [`Self::world`]; a failed one ends it. `tell` hears of every
    /// skill when it begins.
    ///
    /// # Errors
    /// [`CompositionError`] for faults of the machine; a skill that fails is a result.
    pub fn run(
        &self,
        robot: &mut SimRobot,
        tell: &mut dyn FnMut(&Primitive, &str),
    ) -> Result<CompositionResult, CompositionError> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut views = self.views(robot)?;
        let mut skills = Vec::new();
        for skill in self.skills {
            let object = self.object_of(skill)?;
            tell(skill, object);
            let result = self.run_skill(skill, object, robot, &mut views, &mut rng)?;
            let done = result.done;
            skills.push(result);
            if !done {
                break;
            }
        }
        let not_ready = match self.skills.last() {
            Some(last) => {
                let obstacles = self.obstacles(robot, &views, None);
                let mut scene = PlanningScene::new(last.robot(), &obstacles, None)?;
                ArmMotion::new(robot, last.robot(), &mut rng)
                    .go_to_posture(&mut scene, &last.robot().q_ready(), "ready")?
                    .err()
            }
            None => None,
        };
        for (result, skill) in skills.iter_mut().zip(self.skills) {
            result.joint_at_end = robot.object_joint(&result.object, &skill.task().joint)?;
            result.success = result.done && skill.is_done_at(result.joint_at_end);
        }
        Ok(CompositionResult {
            success: not_ready.is_none()
                && skills.len() == self.skills.len()
                && skills.iter().all(|result| result.success),
            skills,
            not_ready: not_ready.map(|failure| failure.to_string()),
            robot_secs: robot.state().map_err(SkillError::from)?.time_secs,
        })
    }

    fn run_skill(
        &self,
        skill: &Primitive,
        object: &str,
        robot: &mut SimRobot,
        views: &mut [ObjectView],
        rng: &mut ChaCha8Rng,
    ) -> Result<SkillResult, CompositionError> {
        let situation = Situation {
            robot: skill.robot().clone(),
            obstacles: self.obstacles(robot, views, Some(object)),
            object: views
                .iter()
                .find(|view| view.name == object)
                .cloned()
                .ok_or_else(|| self.no_object(skill))?,
            target: None,
            held: None,
        };
        let began_secs = robot.state().map_err(SkillError::from)?.time_secs;
        let outcome = skill.run(robot, &situation, rng)?;
        let failure = match outcome {
            Outcome::Done { joints, .. } => {
                for view in views.iter_mut().filter(|view| view.name == object) {
                    view.joints.extend(joints.clone());
                }
                None
            }
            Outcome::Failed(failure) => Some(failure.to_string()),
        };
        let joint_after = robot.object_joint(object, &skill.task().joint)?;
        Ok(SkillResult {
            skill: skill.task().name.clone(),
            object: object.to_owned(),
            done: failure.is_none(),
            failure,
            joint_after,
            joint_at_end: joint_after,
            goal: skill.task().goal,
            success: false,
            robot_secs: robot.state().map_err(SkillError::from)?.time_secs - began_secs,
        })
    }

    /// The first object that a skill is for.
    fn object_of(&self, skill: &Primitive) -> Result<&str, CompositionError> {
        let mut objects = self.scene.objects().iter();
        objects
            .find(|object| skill.is_for(&self.scene.classes()[&object.class]))
            .map(|object| object.name.as_str())
            .ok_or_else(|| self.no_object(skill))
    }

    fn no_object(&self, skill: &Primitive) -> CompositionError {
        let objects = self.scene.objects().iter();
        let names = objects.map(|object| format!("`{}` ({})", object.name, object.class));
        CompositionError::NoObject {
            scene: self.scene.name().to_owned(),
            skill: skill.task().name.clone(),
            joint: skill.task().joint.clone(),
            model: skill.task().model.display().to_string(),
            available: names.collect::<Vec<_>>().join(", "),
        }
    }

    /// The objects as they stand at the beginning.
    fn views(&self, robot: &SimRobot) -> Result<Vec<ObjectView>, CompositionError> {
        let base_from_world = base_from_world(robot);
        let objects = self.scene.objects().iter();
        objects
            .map(|object| {
                let class = &self.scene.classes()[&object.class];
                let joints = class.joints.iter().map(|joint| {
                    let position = robot.object_joint(&object.name, &joint.name)?;
                    Ok((joint.name.clone(), position))
                });
                Ok(ObjectView {
                    name: object.name.clone(),
                    class: class.clone(),
                    base_from_object: base_from_world * robot.world_from_object(&object.name)?,
                    joints: joints.collect::<Result<_, WorldError>>()?,
                })
            })
            .collect()
    }

    /// All that the arm must not hit but for one object.
    fn obstacles(
        &self,
        robot: &SimRobot,
        views: &[ObjectView],
        without: Option<&str>,
    ) -> Vec<Obstacle> {
        let structure = Obstacle {
            name: "structure".to_owned(),
            shape: ObstacleShape::Model {
                file: self.scene.structure().to_owned(),
                joint_positions: Vec::new(),
            },
            base_from_obstacle: base_from_world(robot),
        };
        let others = views
            .iter()
            .filter(|view| Some(view.name.as_str()) != without);
        std::iter::once(structure)
            .chain(others.map(ObjectView::as_obstacle))
            .collect()
    }
}

fn base_from_world(robot: &SimRobot) -> Pose {
    pose_from_planar(&robot.world_from_base(), 0.0).inverse()
}
