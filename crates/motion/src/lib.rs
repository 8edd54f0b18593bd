//! Motion planning for a mobile manipulator: inverse kinematics, collision checks, joint paths, tool
//! lines, timing, base paths and grasps.
//!
//! Everything for the arm is planned in the **base frame**: the robot's `base_link` stands at the
//! origin and obstacles are given as `base_from_obstacle`. A [`PlanningScene`] is compiled from what
//! the caller believes about the world; this room never sees a simulation.
//!
//! The **chain** is the lift, if the robot has one, followed by the arm: a configuration is
//! `q = [lift?, arm...]` in m and rad, in the order of [`RobotModel::chain_joints`]. A joint without
//! limits turns on forever; paths then count its turns, so that successive waypoints are close.
//!
//! | module | holds |
//! |---|---|
//! | [`robot`] | the robot as planning sees it: chain, limits, self-collision pairs |
//! | [`scene`] | robot + believed obstacles + held object, collision checks |
//! | [`chain`] | forward kinematics and Jacobian by products of exponentials |
//! | [`joint_space`] | limits, distances and interpolation of configurations |
//! | [`manipulability`] | the measure of thesis Eq. 3.2 |
//! | [`ik`] | inverse kinematics with restarts |
//! | [`sampling`] | RRT-Connect, RRT*, shortcutting over any validity check |
//! | [`back_out`] | a short way out of contact, before a plan can begin |
//! | [`joint_path`] | collision-free joint paths in a scene |
//! | [`tool_line`] | straight tool motions |
//! | [`timing`] | jerk-limited timing with blended corners |
//! | [`base_path`] | paths of the base on an inflated occupancy grid |
//! | [`grasps`] | tool poses from class grasps and from point clouds |
//!
//! ```no_run
//! use factotum_descriptions::RobotDescription;
//! use factotum_motion::{
//!     IkOptions, IkOutcome, PathOutcome, PlanLimits, PlanningScene, RobotModel, plan_joints, solve_ik,
//!     time_path,
//! };
//! use rand::SeedableRng;
//!
//! let description = RobotDescription::load("assets/robots/movo".as_ref())?;
//! let robot = RobotModel::load(&description)?;
//! let mut scene = PlanningScene::new(&robot, &[], None)?;
//! let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
//! let target = robot.chain().base_from_tcp(&robot.q_ready());
//! let start = robot.q_rest();
//! let seeds = [start.clone()];
//! if let IkOutcome::Solved(goal) =
//!     solve_ik(&mut scene, &target, &seeds, &IkOptions::default(), &mut rng)
//!     && let PathOutcome::Solved(plan) =
//!         plan_joints(&mut scene, &start, &[goal.q], &PlanLimits::default(), &mut rng)
//! {
//!     let trajectory = time_path(&robot, &plan.path, 0.5)?;
//!     assert!(trajectory.duration_secs() > 0.0);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Searches are bounded by explicit caps and say which cap ended them; "no path" is an outcome, not an
//! error. Everything is deterministic given the random generator that is passed in.

pub mod back_out;
pub mod base_path;
pub mod chain;
pub mod error;
pub mod grasps;
pub mod ik;
pub mod joint_path;
pub mod joint_space;
pub mod manipulability;
pub mod robot;
pub mod sampling;
pub mod scene;
pub mod timing;
pub mod tool_line;

#[cfg(test)]
mod test_arms;
#[cfg(test)]
mod test_robots;

pub use back_out::back_out;
pub use base_path::{BaseOutcome, BasePathOptions, InflatedGrid, InflationOptions, plan_base};
pub use error::MotionError;
pub use ik::{IkFailure, IkOptions, IkOutcome, IkPreference, IkSolution, solve_ik, solve_ik_many};
pub use joint_path::{
    JointPathPlan, PathOutcome, PathStats, PlanLimits, plan_joints, plan_joints_star,
};
pub use joint_space::{JointLimit, JointSpace};
pub use robot::{
    MeetingPair, NamedFrame, PostureCheck, Reach, RobotCheck, RobotModel, check_robot,
};
pub use scene::{HeldObject, Obstacle, ObstacleShape, PlanningScene};
pub use timing::{TimingOptions, time_path, time_path_with};
pub use tool_line::{CartesianFailure, CartesianFailureReason, ToolLineOptions, plan_tool_line};

/// Position and orientation in space; `base_from_tcp: Pose` is the pose of the tool in the base frame.
pub type Pose = nalgebra::Isometry3<f64>;
/// Position and heading on the floor.
pub type Pose2 = nalgebra::Isometry2<f64>;
