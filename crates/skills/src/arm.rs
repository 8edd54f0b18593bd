//! Moving the arm: plan, time, send, wait, and say why not.

use factotum_control::{
    Command, GripperGoal, Impedance, MotionStatus, Robot, RobotError, RobotState, ToolPath,
    send_and_wait,
};
use factotum_geometry::Pose;
use factotum_motion::{
    CartesianFailure, CartesianFailureReason, JointPathPlan, MotionError, PathOutcome, PlanLimits,
    PlanningScene, RobotModel, ToolLineOptions, back_out, plan_joints, plan_tool_line, time_path,
};
use rand_chacha::ChaCha8Rng;

use crate::{Failure, SkillError};

/// Fraction of the joint speed limits used in free space, and near things.
const SPEED_FREE: f64 = 0.6;
const SPEED_NEAR: f64 = 0.25;

/// How long a motion may take beyond its own duration before it counts as stuck, seconds.
const PATIENCE_SECS: f64 = 5.0;

/// Openings of the gripper at which something may be between its fingers, as fractions: neither closed nor wide open.
const HOLDING_OPENINGS: std::ops::Range<f64> = 0.06..0.95;

/// Whether a gripper that was to close, and is this far open (as a fraction), may hold something.
#[must_use]
pub fn is_holding(gripper_opening: f64) -> bool {
    HOLDING_OPENINGS.contains(&gripper_opening)
}

/// Either the attempt failed, or the machine did.
#[derive(Debug)]
pub(crate) enum Stop {
    Failed(Failure),
    Error(SkillError),
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure)
    }
}

impl From<RobotError> for Stop {
    fn from(error: RobotError) -> Self {
        Self::Error(error.into())
    }
}

impl From<SkillError> for Stop {
    fn from(error: SkillError) -> Self {
        Self::Error(error)
    }
}

impl From<MotionError> for Stop {
    fn from(error: MotionError) -> Self {
        Self::Error(error.into())
    }
}

/// What a compliant tool motion needs beside its poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPathNeeds {
    /// Tool speed, m/s.
    pub speed_m_per_s: f64,
    /// Stiffness and damping.
    pub impedance: Impedance,
    /// External force at which the motion ends early, N.
    pub stop_force_n: Option<f64>,
    /// How near the last pose counts as there, metres.
    pub tolerance_m: f64,
}

impl ToolPathNeeds {
    /// Slow and soft, for a tool that holds something or leaves it, with this tolerance (metres).
    pub(crate) fn gentle(tolerance_m: f64) -> Self {
        Self {
            speed_m_per_s: 0.06,
            impedance: Impedance::uniform(200.0, 100.0),
            stop_force_n: None,
            tolerance_m,
        }
    }
}

/// The arm of a robot, for the length of one skill.
pub struct ArmMotion<'a> {
    robot: &'a mut dyn Robot,
    model: &'a RobotModel,
    rng: &'a mut ChaCha8Rng,
}

impl std::fmt::Debug for ArmMotion<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ArmMotion")
            .field("robot", &self.model.description().name)
            .finish_non_exhaustive()
    }
}

impl<'a> ArmMotion<'a> {
    /// Takes hold of the robot's arm.
    pub fn new(robot: &'a mut dyn Robot, model: &'a RobotModel, rng: &'a mut ChaCha8Rng) -> Self {
        Self { robot, model, rng }
    }

    pub(crate) fn state(&mut self) -> Result<RobotState, Stop> {
        Ok(self.robot.state()?)
    }

    /// Lift and arm positions now.
    pub(crate) fn configuration(&mut self) -> Result<Vec<f64>, Stop> {
        let state = self.robot.state()?;
        Ok(self.model.q_from_state(state.lift_m, &state.arm_positions))
    }

    /// Plans around obstacles to the first of `goals` that a path is found to, goes there, and says which it is.
    pub(crate) fn go(
        &mut self,
        scene: &mut PlanningScene,
        goals: &[Vec<f64>],
        object: &str,
    ) -> Result<usize, Stop> {
        let start = self.start_of_plan(scene, object)?;
        let outcome = plan_joints(scene, &start, goals, &PlanLimits::default(), self.rng);
        let plan = solved(outcome).map_err(|detail| Failure::NoWay {
            object: object.to_owned(),
            detail,
        })?;
        self.follow(&plan.path, SPEED_FREE, &format!("move to {object}"))?;
        Ok(plan.goal_idx)
    }

    /// Where the arm is, after it has backed out of what it may touch.
    fn start_of_plan(&mut self, scene: &mut PlanningScene, object: &str) -> Result<Vec<f64>, Stop> {
        let here = self.configuration()?;
        if scene.is_free(&here) {
            return Ok(here);
        }
        // Without a way out the plan says what is touched.
        let Some(way_out) = back_out(scene, &here, self.rng) else {
            return Ok(here);
        };
        self.follow_near(&way_out, &format!("back out on the way to {object}"))?;
        self.configuration()
    }

    /// Plans around obstacles to a named posture and goes there.
    ///
    /// # Errors
    /// [`SkillError`] for faults of the machine; a plan that cannot be found or ends early is an `Ok(Err(failure))`.
    pub fn go_to_posture(
        &mut self,
        scene: &mut PlanningScene,
        posture: &[f64],
        name: &str,
    ) -> Result<Result<(), Failure>, SkillError> {
        match self.go(scene, &[posture.to_vec()], name) {
            Ok(_) => Ok(Ok(())),
            Err(Stop::Failed(failure)) => Ok(Err(failure)),
            Err(Stop::Error(error)) => Err(error),
        }
    }

    /// Follows a joint path that was planned near things, slowly.
    pub(crate) fn follow_near(&mut self, path: &[Vec<f64>], doing: &str) -> Result<(), Stop> {
        self.follow(path, SPEED_NEAR, doing)
    }

    fn follow(&mut self, path: &[Vec<f64>], speed: f64, doing: &str) -> Result<(), Stop> {
        if path.len() < 2 {
            return Ok(());
        }
        let trajectory = time_path(self.model, path, speed)?;
        let timeout_secs = trajectory.duration_secs() + PATIENCE_SECS;
        self.send(Command::Joints(trajectory), timeout_secs, doing)
            .map(|_| ())
    }

    /// Moves the tool compliantly through poses in the base frame.
    pub(crate) fn tool(
        &mut self,
        poses: &[Pose],
        needs: &ToolPathNeeds,
        doing: &str,
    ) -> Result<MotionStatus, Stop> {
        /// A turn of one radian takes as long as this many metres.
        const METRES_PER_RADIAN: f64 = 0.15;
        let mut time_secs = 0.0;
        let mut timed: Vec<(f64, Pose)> = Vec::with_capacity(poses.len());
        for pose in poses {
            if let Some((_, before)) = timed.last() {
                let way = (pose.translation.vector - before.translation.vector).norm()
                    + METRES_PER_RADIAN * before.rotation.angle_to(&pose.rotation);
                time_secs += way / needs.speed_m_per_s;
            }
            timed.push((time_secs, *pose));
        }
        let path = ToolPath {
            base_from_tcp: timed,
            impedance: needs.impedance,
            stop_force_n: needs.stop_force_n,
            tolerance_m: needs.tolerance_m,
        };
        self.send(Command::Tool(path), time_secs + PATIENCE_SECS, doing)
    }

    /// Opens or closes the gripper with all its force and returns how far open it ended.
    pub(crate) fn grip(&mut self, opening: f64) -> Result<f64, Stop> {
        const TIMEOUT_SECS: f64 = 4.0;
        if let Some(gripper) = &self.model.description().gripper {
            let goal = GripperGoal {
                opening,
                force_n: gripper.force_max_n,
            };
            send_and_wait(
                self.robot,
                Command::Gripper(goal),
                TIMEOUT_SECS,
                &mut |_| Ok(true),
            )?;
        }
        Ok(self.robot.state()?.gripper_opening)
    }

    fn send(
        &mut self,
        command: Command,
        timeout_secs: f64,
        doing: &str,
    ) -> Result<MotionStatus, Stop> {
        let status = send_and_wait(self.robot, command, timeout_secs, &mut |_| Ok(true))?;
        match status {
            MotionStatus::Done | MotionStatus::Guarded => Ok(status),
            MotionStatus::Preempted | MotionStatus::Active => Err(Failure::OnRequest.into()),
            MotionStatus::Aborted(reason) => Err(Failure::Stopped {
                doing: doing.to_owned(),
                reason,
            }
            .into()),
        }
    }
}

/// The plan, or in words why there is none.
pub(crate) fn solved(outcome: PathOutcome) -> Result<JointPathPlan, String> {
    Err(match outcome {
        PathOutcome::Solved(plan) => return Ok(plan),
        PathOutcome::StartInCollision((a, b)) => format!("`{a}` touches `{b}` already"),
        PathOutcome::GoalInCollision((a, b)) => format!("there, `{a}` would touch `{b}`"),
        PathOutcome::GoalOutsideLimits { joint, .. } => {
            format!("joint `{joint}` would be beyond its limit")
        }
        PathOutcome::NoGoal => "no posture to go to".to_owned(),
        PathOutcome::LimitReached { .. } => "the search reached its limit".to_owned(),
    })
}

/// The joint path of the tool along straight lines through `poses`, or why there is none.
pub(crate) fn tool_line(
    scene: &mut PlanningScene,
    q: &[f64],
    poses: &[Pose],
    object: &str,
) -> Result<Vec<Vec<f64>>, Failure> {
    plan_tool_line(scene, q, poses, &ToolLineOptions::default()).map_err(|failure| Failure::NoWay {
        object: object.to_owned(),
        detail: in_words(&failure),
    })
}

pub(crate) fn in_words(failure: &CartesianFailure) -> String {
    let reason = match &failure.reason {
        CartesianFailureReason::Unreachable {
            joint_at_limit: Some(joint),
            ..
        } => {
            format!("joint `{joint}` is at its limit")
        }
        CartesianFailureReason::Unreachable {
            position_error_m, ..
        } => {
            format!("the arm falls {position_error_m:.2} m short")
        }
        CartesianFailureReason::Jump { joint, .. } => format!("joint `{joint}` would have to jump"),
        CartesianFailureReason::Collision((a, b)) => format!("`{a}` would touch `{b}`"),
        CartesianFailureReason::BadStart => "the arm's state makes no sense".to_owned(),
    };
    format!(
        "{:.0} % of a straight way: {reason}",
        100.0 * failure.fraction_done
    )
}
