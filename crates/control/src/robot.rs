//! The robot as the rest of the house sees it: what it feels, what it can be told, and nothing of how it is made.
//!
//! [`Robot`] is implemented by the simulated robot in `worlds`, and by a real one later (ROS 2). It promises only what
//! a real machine can keep:
//!
//! - Commands are goals that take time. [`Robot::send`] returns at once; [`Robot::progress`] tells how it goes. One
//!   goal per subsystem (arm with lift, base, gripper) is active, and a new one preempts the old.
//! - What is read is already old when it arrives: every reading carries the robot's own time stamp.
//! - Base goals are given in the odometry frame, which is continuous but drifts (REP-105); whoever holds the map
//!   corrects for the drift.
//! - Time passes only in [`Robot::wait`]. A simulation steps its physics there; a real robot sleeps.
//! - A velocity command expires ([`BaseTwist::valid_secs`]), so a silent commander means a robot at rest.

use factotum_descriptions::{JointTrajectory, RobotDescription};
use factotum_geometry::sensing::{DepthFrame, LaserScan};
use factotum_geometry::{Pose, Pose2};
use nalgebra::{Vector3, Vector6};

/// What a robot feels of itself at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotState {
    /// The robot's clock, seconds.
    pub time_secs: f64,
    /// Base in the odometry frame; identity for a fixed base.
    pub odom_from_base: Pose2,
    /// Base velocity in the base frame: x, y (m/s), yaw (rad/s).
    pub base_velocity: Vector3<f64>,
    /// Lift height, metres; zero without a lift.
    pub lift_m: f64,
    /// Arm joint positions, rad.
    pub arm_positions: Vec<f64>,
    /// Arm joint velocities, rad/s.
    pub arm_velocities: Vec<f64>,
    /// Gripper opening, 0 closed to 1 open.
    pub gripper_opening: f64,
    /// Positions of the gripper's joints, m or rad, in the order of `robot.toml`.
    pub finger_positions: Vec<f64>,
    /// Their velocities.
    pub finger_velocities: Vec<f64>,
    /// Contact force on the finger of each gripper pad in the tool frame, N, in the order of `robot.toml`.
    pub pad_forces_in_tcp: Vec<Vector3<f64>>,
    /// Estimated external wrench on the tool in the base frame: force (N), then torque (N m).
    pub tool_wrench_in_base: Vector6<f64>,
}

/// A reading with the robot's time at which it was taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Stamped<T> {
    /// The robot's clock, seconds.
    pub time_secs: f64,
    /// Base in the odometry frame at that time.
    pub odom_from_base: Pose2,
    /// The reading.
    pub data: T,
}

/// A goal for one subsystem.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Follow a trajectory of arm joints, the lift, or both.
    Joints(JointTrajectory),
    /// Move the tool along timed poses, compliantly.
    Tool(ToolPath),
    /// Pull the tool to a pose for a short while, compliantly: what a policy says at each of its steps.
    ToolGoal(ToolGoal),
    /// Drive along a path.
    BasePath(BasePath),
    /// Drive at a velocity for a short while.
    BaseTwist(BaseTwist),
    /// Open or close the gripper.
    Gripper(GripperGoal),
}

/// Timed tool poses under variable impedance (thesis Eq. 3.1).
#[derive(Debug, Clone, PartialEq)]
pub struct ToolPath {
    /// Time from the start (s, never decreasing) and tool pose in the base frame.
    pub base_from_tcp: Vec<(f64, Pose)>,
    /// Stiffness and damping.
    pub impedance: Impedance,
    /// End early, as done, when the external force on the tool exceeds this (N).
    pub stop_force_n: Option<f64>,
    /// How near the tool must be to the last pose to count as arrived, metres; short of it the motion aborts.
    pub tolerance_m: f64,
}

/// A tool pose that the arm is pulled to until the command expires (thesis Eq. 3.1); then the arm holds still.
///
/// A new one takes over from the last without a jerk, if the guard is the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolGoal {
    /// Where the tool should be.
    pub base_from_tcp: Pose,
    /// Stiffness and damping.
    pub impedance: Impedance,
    /// What keeps the joints from their limits meanwhile.
    pub guard: GuardSpec,
    /// The arm stops this long after the command unless another follows, seconds.
    pub valid_secs: f64,
}

/// Which guard keeps the joints of an arm from their limits; distances in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GuardSpec {
    /// None.
    None,
    /// The two thresholds of σ ([`crate::safety::SafetyEnvelope`]).
    Envelope {
        /// σ_1: within it the task acts in the null space alone.
        null_space_rad: f64,
        /// σ_2: within it the joint is pushed back.
        push_back_rad: f64,
    },
    /// The barrier ([`crate::barrier::JointBarrier`]).
    Barrier {
        /// Distance that it keeps from a limit.
        margin_rad: f64,
    },
}

/// Gains of Eq. 3.1. They multiply the operational-space inertia, so their unit is 1/s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impedance {
    /// Position gains along x, y and z of the base frame, 1/s².
    pub kp_position: Vector3<f64>,
    /// Rotation gains about x, y and z of the base frame, 1/s².
    pub kp_rotation: Vector3<f64>,
    /// Damping ratio; 1 is critical damping.
    pub damping_ratio: f64,
}

impl Impedance {
    /// The same gains along all axes, critically damped.
    pub fn uniform(kp_position: f64, kp_rotation: f64) -> Self {
        Self {
            kp_position: Vector3::repeat(kp_position),
            kp_rotation: Vector3::repeat(kp_rotation),
            damping_ratio: 1.0,
        }
    }
}

impl Default for Impedance {
    /// 150 1/s² and critical damping: the middle of the range `[0, 300]` that the thesis' experiments use.
    fn default() -> Self {
        Self::uniform(150.0, 150.0)
    }
}

/// Base poses to pass through, in the odometry frame.
#[derive(Debug, Clone, PartialEq)]
pub struct BasePath {
    /// Poses; the first may be where the base is.
    pub odom_from_base: Vec<Pose2>,
    /// Fraction of the robot's speed limits to use, in (0, 1].
    pub speed: f64,
}

/// A base velocity that expires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseTwist {
    /// x, y (m/s) and yaw (rad/s) in the base frame.
    pub velocity: Vector3<f64>,
    /// The base stops this long after the command unless another follows, seconds.
    pub valid_secs: f64,
}

/// A gripper goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GripperGoal {
    /// 0 closed to 1 open.
    pub opening: f64,
    /// Largest force, N; at most the robot's own limit.
    pub force_n: f64,
}

/// Names a command that was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MotionId(pub u64);

/// How a command goes.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionStatus {
    /// Still under way.
    Active,
    /// Arrived; for a gripper closing on an object, holding it.
    Done,
    /// Ended by its own guard, e.g. [`ToolPath::stop_force_n`].
    Guarded,
    /// Replaced by a newer command, or stopped.
    Preempted,
    /// Given up, and why, in one sentence.
    Aborted(String),
}

impl MotionStatus {
    /// Whether it has ended, in whatever way.
    pub fn is_over(&self) -> bool {
        *self != Self::Active
    }
}

/// Why a robot did not answer as asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// The command makes no sense for this robot.
    #[error("command refused: {reason}")]
    Refused {
        /// What was found and what was wanted.
        reason: String,
    },
    /// The robot has no such sensor or subsystem.
    #[error("robot `{robot}` has no {what}")]
    Absent {
        /// Its name.
        robot: String,
        /// What it lacks.
        what: &'static str,
    },
    /// The connection to the robot, or the simulation that stands in for it, failed.
    #[error("robot `{robot}` does not answer: {reason}")]
    Lost {
        /// Its name.
        robot: String,
        /// Why, as far as known.
        reason: String,
    },
}

/// A robot, simulated or real.
pub trait Robot {
    /// What it is made of.
    fn description(&self) -> &RobotDescription;

    /// The newest state that has arrived.
    ///
    /// # Errors
    /// [`RobotError::Lost`] if the robot does not answer.
    fn state(&mut self) -> Result<RobotState, RobotError>;

    /// Sends a goal and returns at once.
    ///
    /// # Errors
    /// [`RobotError::Refused`] for a goal outside the robot's limits, [`RobotError::Absent`] for a subsystem it does
    /// not have, [`RobotError::Lost`] if the robot does not answer.
    fn send(&mut self, command: Command) -> Result<MotionId, RobotError>;

    /// How a goal goes, as last heard.
    ///
    /// # Errors
    /// [`RobotError::Refused`] for an id that was never given or ended many motions ago, [`RobotError::Lost`] if the
    /// robot does not answer.
    fn progress(&mut self, id: MotionId) -> Result<MotionStatus, RobotError>;

    /// The newest laser scan.
    ///
    /// # Errors
    /// [`RobotError::Absent`] without a lidar, [`RobotError::Lost`] if the robot does not answer.
    fn scan(&mut self) -> Result<Stamped<LaserScan>, RobotError>;

    /// A new depth frame with instance labels.
    ///
    /// # Errors
    /// [`RobotError::Absent`] without a camera, [`RobotError::Lost`] if the robot does not answer.
    fn look(&mut self) -> Result<Stamped<DepthFrame>, RobotError>;

    /// Lets time pass.
    ///
    /// # Errors
    /// [`RobotError::Lost`] if the robot does not answer.
    fn wait(&mut self, secs: f64) -> Result<(), RobotError>;

    /// Stops everything where it is and holds.
    ///
    /// # Errors
    /// [`RobotError::Lost`] if the robot does not answer.
    fn stop(&mut self) -> Result<(), RobotError>;
}

/// Sends a goal and waits until it is over or `timeout_secs` of robot time have passed.
///
/// Asks `keep_going` at every look (each `period_secs`); when it says no, the robot is stopped.
///
/// # Errors
/// Whatever the robot's own calls return.
pub fn send_and_wait(
    robot: &mut dyn Robot,
    command: Command,
    timeout_secs: f64,
    keep_going: &mut dyn FnMut(&mut dyn Robot) -> Result<bool, RobotError>,
) -> Result<MotionStatus, RobotError> {
    /// Ten looks a second are enough to stop in time and few enough for a slow link.
    const PERIOD_SECS: f64 = 0.1;
    let started_secs = robot.state()?.time_secs;
    let id = robot.send(command)?;
    loop {
        robot.wait(PERIOD_SECS)?;
        let status = robot.progress(id)?;
        if status.is_over() {
            return Ok(status);
        }
        if !keep_going(robot)? {
            robot.stop()?;
            return Ok(MotionStatus::Preempted);
        }
        if robot.state()?.time_secs - started_secs > timeout_secs {
            robot.stop()?;
            return Ok(MotionStatus::Aborted(format!(
                "not done after {timeout_secs:.0} s"
            )));
        }
    }
}
