//! A learned primitive, whole: head, policy and tail on any robot (thesis 3.2 and 3.4.1).
//!
//! I: some grasp of I_c, the most promising first, has a configuration (Eq. 3.2, or as the setting chooses) that is clear
//! of limits and obstacles, and a straight way from a pregrasp in free space.
//! h: to the pregrasp, from wherever the skill before has left the arm, then along that way, and the fingers close.
//! π: π_c at its control frequency within σ, until β_c or B.
//! t: the fingers open and the tool backs off into free space, where the next head begins.
//!
//! The policy sees what it saw in training, but for two things that a robot at home cannot feel: the object stands where
//! it is believed to stand, and its joint is where the motion of the tool says ([`JointFromTool`]).

use std::path::Path;

use factotum_control::{Command, GripperGoal, Robot, RobotState, ToolGoal};
use factotum_descriptions::{ActionKind, ActionSpec, ObjectClass, ObjectJoint, TaskSpec};
use factotum_geometry::Pose;
use factotum_learning::action::ActionError;
use factotum_learning::td3::Policy;
use factotum_motion::{PlanningScene, RobotModel};
use nalgebra::{Point3, Translation3};
use rand_chacha::ChaCha8Rng;

use super::action::{CLOSING_STEPS, CLOSING_STROKE, HOLD, N_ACTION, opening_around};
use super::configuration::configurations;
use super::ending::{FailureClassifier, FailureKind, FailureMemory, SuccessIndicator};
use super::guide::Guide;
use super::hand_motion::HandMotion;
use super::initiation::GraspInitiation;
use super::joint_from_tool::JointFromTool;
use super::observation::observe_into;
use super::rig::{Anatomy, Reading, RigCommand};
use super::setting::CipSetting;
use crate::arm::{ArmMotion, Stop, ToolPathNeeds, tool_line};
use crate::way::WaySkill;
use crate::{Failure, Outcome, Situation};

/// Grasps that are tried from where the robot stands.
const GRASPS_TRIED: usize = 8;

/// Configurations that are tried for each.
const CONFIGURATIONS_TRIED: usize = 4;

/// How far before the grasp the pregrasp is, and how far the tail backs off, metres.
const STANDOFF_M: f64 = 0.08;

/// β_c is asked for this share of the way beyond the goal, or half the way to the end of the joint if that is less: the grip
/// slips a little, which is taken for motion. With 0.03 a door was left 5 % short in half of all runs.
const BEYOND: f64 = 0.15;

/// Force on a pad that counts as touching, N.
const TOUCH_N: f64 = 0.2;

/// Why a primitive cannot be put together.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrimitiveError {
    /// It was learned without a head, so it does not know how to begin.
    #[error(
        "the skill of task `{task}` was learned without grasps, so it cannot begin anywhere but in its training; train it \
         with another setting than `unstructured`"
    )]
    NoHead {
        /// The task.
        task: String,
    },
    /// The setting's guide.
    #[error(transparent)]
    Guide(#[from] ActionError),
}

/// C = (π_c, σ, β_c, I_c, h, t, B), learned.
#[derive(Debug, Clone)]
pub struct Primitive {
    task: TaskSpec,
    anatomy: Anatomy,
    /// Middle of the grasp region in Λ, with the joint where it starts.
    object_from_region: Point3<f64>,
    setting: CipSetting,
    policy: Policy,
    motion: HandMotion,
    guide: Option<Guide>,
    initiation: GraspInitiation,
    success: SuccessIndicator,
    failure: FailureClassifier,
}

/// How the head goes.
#[derive(Debug, Clone)]
pub(crate) struct Head {
    object_from_tcp: Pose,
    pregrasp: Vec<f64>,
    opening: f64,
}

impl Primitive {
    /// A primitive from what was learned: `object_from_region` is the middle of what may be grasped in Λ, with the joint
    /// where it starts.
    ///
    /// # Errors
    /// [`PrimitiveError::NoHead`] without grasps.
    pub fn new(
        task: TaskSpec,
        anatomy: Anatomy,
        object_from_region: Point3<f64>,
        setting: CipSetting,
        policy: Policy,
        initiation: Option<GraspInitiation>,
    ) -> Result<Self, PrimitiveError> {
        let Some(initiation) = initiation else {
            return Err(PrimitiveError::NoHead { task: task.name });
        };
        let motion = HandMotion::of(&anatomy.object_joint, &task);
        let guide = setting.guide_along(&motion, &task)?;
        let success = SuccessIndicator::of(&task);
        Ok(Self {
            success: SuccessIndicator {
                goal: beyond(&success, &anatomy.object_joint),
                ..success
            },
            failure: setting.failure_classifier(&task),
            task,
            anatomy,
            object_from_region,
            setting,
            policy,
            motion,
            guide,
            initiation,
        })
    }

    /// The task that it was learned on.
    pub fn task(&self) -> &TaskSpec {
        &self.task
    }

    /// The robot that it was learned with.
    pub fn robot(&self) -> &RobotModel {
        &self.anatomy.robot
    }

    /// Whether it moves a joint of objects of a class: those with the model that it was learned on.
    pub fn is_for(&self, class: &ObjectClass) -> bool {
        let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
        whole(&class.model) == whole(&self.task.model) && class.joint(&self.task.joint).is_some()
    }

    /// Whether it does an action of a class: its joint, and the task's goal lies in the state that the action brings about.
    pub fn does(&self, class: &ObjectClass, action: &ActionSpec) -> bool {
        let effect = action.effect.as_ref().and_then(|name| class.state(name));
        self.is_for(class)
            && action.kind == ActionKind::Articulate
            && action.joint.as_ref() == Some(&self.task.joint)
            && effect
                .is_some_and(|state| (state.range[0]..=state.range[1]).contains(&self.task.goal))
    }

    /// Whether a joint position is beyond the task's goal.
    pub fn is_done_at(&self, joint_position: f64) -> bool {
        self.task.progress(joint_position) >= 1.0
    }

    fn check(&self, situation: &Situation) -> Result<(), Failure> {
        let class = &situation.object.class;
        let missing = |what: String| Failure::NotDescribed {
            class: class.name.clone(),
            what,
        };
        if class.joint(&self.task.joint).is_none() {
            return Err(missing(format!("joint `{}`", self.task.joint)));
        }
        let (found, wanted) = (
            &situation.robot.description().name,
            &self.robot().description().name,
        );
        if found != wanted {
            return Err(missing(format!(
                "skill `{}` for robot `{found}`; it was learned with `{wanted}`",
                self.task.name
            )));
        }
        Ok(())
    }
}

/// The goal, and a little more where the joint can go on.
fn beyond(success: &SuccessIndicator, joint: &ObjectJoint) -> f64 {
    let SuccessIndicator { start, goal } = *success;
    let end = if goal > start {
        joint.range[1]
    } else {
        joint.range[0]
    };
    let room = 0.5 * (end - goal).abs();
    goal + (goal - start).signum() * (BEYOND * (goal - start).abs()).min(room)
}

impl WaySkill for Primitive {
    type Way = Head;

    fn name(&self) -> &str {
        &self.task.name
    }

    fn find_way(
        &self,
        situation: &Situation,
        _from: &[f64],
        rng: &mut ChaCha8Rng,
    ) -> Result<Head, Stop> {
        self.check(situation)?;
        let object = &situation.object;
        let (mut free, mut near) = situation.scenes(1.0)?;
        let mut detail = "no grasp has a posture".to_owned();
        for grasp in self.initiation.ranked().into_iter().take(GRASPS_TRIED) {
            let object_from_tcp = *self.initiation.object_from_tcp(grasp);
            let base_from_tcp = object.base_from_object * object_from_tcp;
            let width_m = self.initiation.width_m(grasp);
            let opening = opening_around(width_m, self.anatomy.aperture_max_m);
            free.set_gripper(opening);
            near.set_gripper(opening);
            let motion =
                self.success
                    .tool_motion(&self.motion, &object.base_from_object, &base_from_tcp);
            let choice = self.setting.configuration;
            let found = configurations(&mut near, &motion, choice, rng);
            for q in found.into_iter().take(CONFIGURATIONS_TRIED) {
                match pregrasp_of(&mut free, &mut near, &q, &base_from_tcp, &object.name) {
                    Ok(pregrasp) => {
                        return Ok(Head {
                            object_from_tcp,
                            pregrasp,
                            opening,
                        });
                    }
                    Err(reason) => detail = reason,
                }
            }
        }
        Err(Failure::OutOfReach {
            object: object.name.clone(),
            detail,
        }
        .into())
    }

    fn go(
        &self,
        head: Head,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, Stop> {
        let object = &situation.object;
        let joint = self.task.joint.clone();
        let (mut free, mut near) = situation.scenes(head.opening)?;
        let mut arm = ArmMotion::new(robot, &situation.robot, rng);
        arm.grip(head.opening)?;
        arm.go(
            &mut free,
            std::slice::from_ref(&head.pregrasp),
            &object.name,
        )?;
        let q = arm.configuration()?;
        let grasp = object.base_from_object * head.object_from_tcp;
        let approach = tool_line(&mut near, &q, &[grasp], &object.name)?;
        arm.follow_near(&approach, &format!("approach {}", object.name))?;

        let mut contact = Contact::new(self, situation, head.opening);
        let acted = contact.act(robot);
        let position = contact.reading.object_joint;

        // The tail, whatever came of the policy: a skill ends in free space.
        let mut arm = ArmMotion::new(robot, &situation.robot, rng);
        arm.grip(1.0)?;
        let q = arm.configuration()?;
        let here = self.robot().chain().base_from_tcp(&q);
        let clear = here * Translation3::new(0.0, 0.0, -STANDOFF_M);
        let backed_off = arm.tool(
            &[here, clear],
            &ToolPathNeeds::gentle(STANDOFF_M),
            &format!("back off from {}", object.name),
        );
        match acted? {
            None => {
                backed_off?;
                Ok(Outcome::Done {
                    tcp_from_held: None,
                    joints: [(joint, position)].into(),
                })
            }
            Some(kind) => Err(Failure::Stopped {
                doing: format!("move {joint} of {}", object.name),
                reason: kind.in_words().to_owned(),
            }
            .into()),
        }
    }
}

/// The posture before a grasp that is taken with `q`, with a straight way there, or why there is none.
fn pregrasp_of(
    free: &mut PlanningScene,
    near: &mut PlanningScene,
    q: &[f64],
    base_from_tcp: &Pose,
    object: &str,
) -> Result<Vec<f64>, String> {
    if let Some((a, b)) = near.collision(q) {
        return Err(format!("`{a}` would touch `{b}`"));
    }
    let before = base_from_tcp * Translation3::new(0.0, 0.0, -STANDOFF_M);
    let way = tool_line(near, q, &[before], object).map_err(|failure| failure.to_string())?;
    let pregrasp = way.last().cloned().unwrap_or_default();
    match free.collision(&pregrasp) {
        Some((a, b)) => Err(format!("before the grasp, `{a}` would touch `{b}`")),
        None => Ok(pregrasp),
    }
}

/// The fingers at the object, from when they begin to close until β_c or B.
struct Contact<'a> {
    primitive: &'a Primitive,
    robot_model: &'a RobotModel,
    reading: Reading,
    joint: JointFromTool,
    opening: f64,
    memory: FailureMemory,
}

impl<'a> Contact<'a> {
    fn new(primitive: &'a Primitive, situation: &'a Situation, opening: f64) -> Self {
        let anatomy = &primitive.anatomy;
        let base_from_object = situation.object.base_from_object;
        Self {
            primitive,
            robot_model: &situation.robot,
            reading: Reading {
                arm_positions: Vec::new(),
                arm_velocities: Vec::new(),
                base_from_tcp: Pose::identity(),
                finger_positions: Vec::new(),
                finger_velocities: Vec::new(),
                pad_forces_in_tcp: Vec::new(),
                base_from_object,
                region: base_from_object * primitive.object_from_region,
                object_joint: primitive.success.start,
                touching: false,
                peak_force_n: 0.0,
                limit_distance_rad: f64::INFINITY,
            },
            joint: JointFromTool::new(anatomy.object_joint.clone(), 0.0, Pose::identity()),
            opening,
            memory: FailureMemory::default(),
        }
    }

    /// Closes the fingers and lets the policy act; the answer is what B said, or nothing where β_c holds.
    fn act(&mut self, robot: &mut dyn Robot) -> Result<Option<FailureKind>, Stop> {
        let Primitive {
            setting,
            success,
            failure,
            guide,
            ..
        } = self.primitive;
        self.read(&robot.state()?);
        for _ in 0..CLOSING_STEPS {
            let opening = (self.opening - CLOSING_STROKE).max(0.0);
            self.step(robot, &HOLD, Some(opening))?;
        }
        // From here on the tool tells where the joint is.
        self.joint = JointFromTool::new(
            self.primitive.anatomy.object_joint.clone(),
            success.start,
            self.reading.base_from_object.inverse() * self.reading.base_from_tcp,
        );
        let mut policy = self.primitive.policy.clone();
        let mut observation = vec![0.0; policy.n_observation()];
        let mut said = vec![0.0; policy.n_action()];
        loop {
            self.estimate();
            observe_into(&self.reading, &mut observation);
            policy.act_into(&observation, &mut said).map_err(nonsense)?;
            let action = match guide {
                Some(guide) => guide
                    .corrected(&self.reading, &setting.ranges, &said)
                    .map_err(nonsense)?,
                None => std::array::from_fn(|i| said.get(i).copied().unwrap_or(0.0)),
            };
            self.step(robot, &action, None)?;
            self.estimate();
            let progress = success.progress(&self.reading);
            let failed = failure.judge(&mut self.memory, &self.reading, progress);
            if failed == Some(FailureKind::JointLimit) {
                return Ok(failed);
            }
            if success.holds(&self.reading) {
                self.come_to_rest(robot)?;
                return Ok(None);
            }
            if failed.is_some() {
                return Ok(failed);
            }
        }
    }

    /// Holds on until tool and object stand still: a door without friction that is let go on its way swings on.
    fn come_to_rest(&mut self, robot: &mut dyn Robot) -> Result<(), Stop> {
        const STEPS_MAX: u32 = 20;
        const SLOW_RAD_PER_S: f64 = 0.02;
        for _ in 0..STEPS_MAX {
            self.step(robot, &HOLD, None)?;
            let speeds = self.reading.arm_velocities.iter();
            if speeds.fold(0.0, |most, speed| speed.abs().max(most)) < SLOW_RAD_PER_S {
                break;
            }
        }
        self.estimate();
        Ok(())
    }

    /// One control period.
    fn step(
        &mut self,
        robot: &mut dyn Robot,
        action: &[f32; N_ACTION],
        opening: Option<f64>,
    ) -> Result<(), Stop> {
        /// A policy that falls silent for this many periods has its arm stopped.
        const VALID_PERIODS: f64 = 2.5;
        let Primitive {
            setting, anatomy, ..
        } = self.primitive;
        let period_secs = 1.0 / anatomy.episode.control_hz;
        let RigCommand {
            base_from_tcp,
            impedance,
            opening: wished,
        } = setting.ranges.command(
            action,
            &self.reading.base_from_tcp,
            self.opening,
            period_secs,
        );
        self.opening = opening.unwrap_or(wished);
        robot.send(Command::ToolGoal(ToolGoal {
            base_from_tcp,
            impedance,
            guard: setting.guard_spec(),
            valid_secs: VALID_PERIODS * period_secs,
        }))?;
        robot.send(Command::Gripper(GripperGoal {
            opening: self.opening,
            force_n: anatomy.episode.grip_force_n,
        }))?;
        robot.wait(period_secs)?;
        self.read(&robot.state()?);
        Ok(())
    }

    /// What the robot feels of itself.
    fn read(&mut self, state: &RobotState) {
        let q = self
            .robot_model
            .q_from_state(state.lift_m, &state.arm_positions);
        let limits = self.primitive.anatomy.arm_limits.iter();
        let reading = &mut self.reading;
        reading.base_from_tcp = self.robot_model.chain().base_from_tcp(&q);
        reading.limit_distance_rad = limits
            .zip(&state.arm_positions)
            .filter_map(|(limit, q)| limit.map(|[lower, upper]| (q - lower).min(upper - q)))
            .fold(f64::INFINITY, f64::min);
        let forces = state.pad_forces_in_tcp.iter().map(|force| force.norm());
        reading.peak_force_n = forces.fold(0.0, f64::max);
        reading.touching = reading.peak_force_n > TOUCH_N;
        reading.arm_positions.clone_from(&state.arm_positions);
        reading.arm_velocities.clone_from(&state.arm_velocities);
        reading.finger_positions.clone_from(&state.finger_positions);
        reading
            .finger_velocities
            .clone_from(&state.finger_velocities);
        reading
            .pad_forces_in_tcp
            .clone_from(&state.pad_forces_in_tcp);
    }

    /// Where the object's joint is, and with it what is held.
    fn estimate(&mut self) {
        let Self {
            primitive, reading, ..
        } = self;
        let base_from_object = reading.base_from_object;
        let object_from_tcp = base_from_object.inverse() * reading.base_from_tcp;
        reading.object_joint = self.joint.position(&object_from_tcp);
        let joint = &primitive.anatomy.object_joint;
        let moved = joint.motion(primitive.task.start, reading.object_joint);
        reading.region = base_from_object * (moved * primitive.object_from_region);
    }
}

/// A policy that is given, or says, what is no number.
fn nonsense(error: impl std::fmt::Display) -> Stop {
    Failure::Stopped {
        doing: "act by a learned policy".to_owned(),
        reason: error.to_string(),
    }
    .into()
}
