//! Taking commands: what makes no sense for this robot is refused, the rest becomes a motion.

use factotum_control::base_tracking::BaseTracker;
use factotum_control::impedance::Posture;
use factotum_control::tool_path::{TargetTrim, TimedPoses};
use factotum_control::tool_servo::{JointGuard, ToolServo};
use factotum_control::{
    ArmState, BasePath, BaseTwist, Command, ControlError, GripperGoal, Impedance, MotionId,
    MotionStatus, RobotError, ToolGoal, ToolPath,
};
use factotum_descriptions::{Arm, JointTrajectory, nearest_name};
use factotum_geometry::Pose2;
use nalgebra::DVector;

use super::arm::{ArmMotion, Column};
use super::base::BaseMotion;
use super::{SimRobot, planar};

/// How far the first point of a trajectory may be from where the joint is, rad or m.
const START_OFF_MAX: f64 = 0.1;

/// How far the first tool pose may be from where the tool is, metres.
const TOOL_START_OFF_MAX_M: f64 = 0.1;

/// Slack on joint limits, rad or m.
const LIMIT_SLACK: f64 = 1e-3;

/// Motions whose end is remembered.
const N_STATUSES_KEPT: usize = 64;

/// Slack on speed limits.
const SPEED_SLACK: f64 = 1.05;

fn refused<T>(reason: String) -> Result<T, RobotError> {
    Err(RobotError::Refused { reason })
}

fn refusal(error: impl std::fmt::Display) -> RobotError {
    RobotError::Refused {
        reason: error.to_string(),
    }
}

fn check_impedance(impedance: &Impedance) -> Result<(), RobotError> {
    let mut gains = impedance
        .kp_position
        .iter()
        .chain(&impedance.kp_rotation)
        .chain([&impedance.damping_ratio]);
    if gains.any(|gain| !(gain.is_finite() && *gain >= 0.0)) {
        return refused(format!(
            "impedance {impedance:?}; expected finite gains, zero or more"
        ));
    }
    Ok(())
}

impl SimRobot {
    /// Checks a command and starts it.
    pub(super) fn accept(&mut self, command: Command) -> Result<MotionId, RobotError> {
        let id = MotionId(self.live.next_id);
        let preempted = match command {
            Command::Joints(trajectory) => self.start_joints(id, trajectory)?,
            Command::Tool(path) => self.start_tool(id, path)?,
            Command::ToolGoal(goal) => self.start_tool_goal(id, goal)?,
            Command::BasePath(path) => self.start_base_path(id, &path)?,
            Command::BaseTwist(twist) => self.start_base_twist(id, &twist)?,
            Command::Gripper(goal) => self.start_gripper(id, goal)?,
        };
        self.live.next_id += 1;
        self.end(preempted.map(|old| (old, MotionStatus::Preempted)));
        self.live.statuses.insert(id, MotionStatus::Active);
        self.forget_old_motions();
        Ok(id)
    }

    /// Nobody asks for a motion that many others have followed; a day's worth of them would fill the snapshots.
    fn forget_old_motions(&mut self) {
        let statuses = &mut self.live.statuses;
        let n_spent = statuses.len().saturating_sub(N_STATUSES_KEPT);
        let over = statuses.iter().filter(|(_, status)| status.is_over());
        let spent: Vec<MotionId> = over.map(|(id, _)| *id).take(n_spent).collect();
        for id in spent {
            statuses.remove(&id);
        }
    }

    /// Preempts everything and holds.
    pub(super) fn stop_all(&mut self) {
        let readings = self.readings();
        let arm = if self.live.arm.motion.is_some() {
            self.live.lift.target_m = readings.lift_m;
            self.live.arm.stop(&readings.arm_positions)
        } else {
            None
        };
        let base = self.live.base.as_mut().and_then(|base| base.motion.take());
        let grip = self.live.grip.as_mut().and_then(|grip| grip.motion.take());
        for id in [arm, base.map(|motion| motion.id()), grip.map(|(id, _)| id)]
            .into_iter()
            .flatten()
        {
            self.live.statuses.insert(id, MotionStatus::Preempted);
        }
    }

    fn start_joints(
        &mut self,
        id: MotionId,
        trajectory: JointTrajectory,
    ) -> Result<Option<MotionId>, RobotError> {
        let columns = self.columns(&trajectory)?;
        self.check_trajectory(&trajectory, &columns)?;
        let readings = self.readings();
        let preempted = self.preempt_arm(&readings.arm_positions, readings.lift_m);
        self.live.arm.motion = Some(ArmMotion::Joints {
            id,
            start_secs: self.state.time_secs(),
            trajectory,
            columns,
        });
        Ok(preempted)
    }

    /// What each joint of a trajectory is.
    fn columns(&self, trajectory: &JointTrajectory) -> Result<Vec<Column>, RobotError> {
        let robot = &self.config.robot;
        let lift = robot.lift.as_ref().map(|lift| lift.joint.as_str());
        let mut columns = Vec::new();
        for name in trajectory.joints() {
            let column = if Some(name.as_str()) == lift {
                Column::Lift
            } else if let Some(joint) = robot.arm.joints.iter().position(|joint| joint == name) {
                Column::Arm(joint)
            } else {
                let known = robot.arm.joints.iter().map(String::as_str).chain(lift);
                let nearest = nearest_name(name, known)
                    .map(|nearest| format!("; did you mean `{nearest}`?"))
                    .unwrap_or_default();
                return refused(format!(
                    "trajectory joint `{name}` is neither a joint of the arm nor the lift{nearest}"
                ));
            };
            if columns.contains(&column) {
                return refused(format!("trajectory names joint `{name}` twice"));
            }
            columns.push(column);
        }
        Ok(columns)
    }

    fn check_trajectory(
        &self,
        trajectory: &JointTrajectory,
        columns: &[Column],
    ) -> Result<(), RobotError> {
        let readings = self.readings();
        let arm = &self.config.robot.arm;
        let arm_limits = self.dynamics.joint_limits();
        let lift_speed = self
            .config
            .robot
            .lift
            .as_ref()
            .map_or(0.0, |lift| lift.velocity_max_m_per_s);
        for (i, (column, name)) in columns.iter().zip(trajectory.joints()).enumerate() {
            let (now, limits, speed_max) = match column {
                Column::Arm(joint) => (
                    readings.arm_positions[*joint],
                    arm_limits[*joint],
                    arm.velocity_max_rad_per_s[*joint],
                ),
                Column::Lift => (readings.lift_m, self.dynamics.lift_limits(), lift_speed),
            };
            let first = trajectory.points()[0].positions[i];
            if (first - now).abs() > START_OFF_MAX {
                return refused(format!(
                    "the trajectory starts with joint `{name}` at {first:.3}, but it is at {now:.3}"
                ));
            }
            for point in trajectory.points() {
                let (position, speed) = (point.positions[i], point.velocities[i].abs());
                if let Some([low, high]) = limits
                    && !(low - LIMIT_SLACK..=high + LIMIT_SLACK).contains(&position)
                {
                    return refused(format!(
                        "joint `{name}` at {position:.3} is outside its limits [{low:.3}, {high:.3}]"
                    ));
                }
                if speed > speed_max * SPEED_SLACK {
                    return refused(format!(
                        "joint `{name}` at speed {speed:.3} is faster than its limit {speed_max:.3}"
                    ));
                }
            }
        }
        Ok(())
    }

    fn start_tool(&mut self, id: MotionId, path: ToolPath) -> Result<Option<MotionId>, RobotError> {
        let ToolPath {
            base_from_tcp,
            impedance,
            stop_force_n,
            tolerance_m,
        } = path;
        let poses = TimedPoses::new(base_from_tcp).map_err(refusal)?;
        check_impedance(&impedance)?;
        if tolerance_m.is_nan() || tolerance_m <= 0.0 {
            return refused(format!(
                "tool tolerance {tolerance_m} m; expected a positive length"
            ));
        }
        let readings = self.readings();
        let arm = self.arm_state(&readings)?;
        let start = poses.sample(0.0).base_from_tcp;
        let off = (start.translation.vector - arm.base_from_tcp.translation.vector).norm();
        if off > TOOL_START_OFF_MAX_M {
            return refused(format!("the tool path starts {off:.3} m from the tool"));
        }
        let preempted = self.preempt_arm(&readings.arm_positions, readings.lift_m);
        self.live.arm.trim = TargetTrim::default();
        self.live.arm.motion = Some(ArmMotion::Tool {
            id,
            start_secs: self.state.time_secs(),
            path: poses,
            impedance,
            posture: Posture::soft(DVector::from_vec(readings.arm_positions)),
            stop_force_n,
            tolerance_m,
            tare: self.live.arm.wrench.wrench(&arm),
        });
        Ok(preempted)
    }

    fn start_tool_goal(
        &mut self,
        id: MotionId,
        goal: ToolGoal,
    ) -> Result<Option<MotionId>, RobotError> {
        check_impedance(&goal.impedance)?;
        if !(goal.valid_secs > 0.0 && goal.valid_secs.is_finite()) {
            return refused(format!(
                "a tool goal for {} s; expected a positive time",
                goal.valid_secs
            ));
        }
        let readings = self.readings();
        let arm = self.arm_state(&readings)?;
        let way = goal.base_from_tcp.translation.vector - arm.base_from_tcp.translation.vector;
        let is_near = way.norm() <= TOOL_START_OFF_MAX_M;
        if !(is_near && goal.base_from_tcp.rotation.coords.norm().is_finite()) {
            return refused(format!(
                "the tool goal is {:.3} m from the tool, expected at most {TOOL_START_OFF_MAX_M} m",
                way.norm()
            ));
        }
        let until_secs = self.state.time_secs() + goal.valid_secs;
        let (preempted, servo) = match self.live.arm.motion.take() {
            Some(ArmMotion::Goal {
                id,
                goal: last,
                servo,
                ..
            }) if last.guard == goal.guard => (Some(id), servo),
            other => {
                self.live.arm.motion = other;
                let servo = self.tool_servo(&goal, &arm).map_err(refusal)?;
                let preempted = self.preempt_arm(&readings.arm_positions, readings.lift_m);
                (preempted, Box::new(servo))
            }
        };
        self.live.arm.motion = Some(ArmMotion::Goal {
            id,
            until_secs,
            goal,
            servo,
        });
        Ok(preempted)
    }

    /// A servo for a goal, from an arm at rest.
    fn tool_servo(&self, goal: &ToolGoal, arm: &ArmState) -> Result<ToolServo, ControlError> {
        let Arm {
            torque_max_nm,
            velocity_max_rad_per_s,
            ..
        } = &self.config.robot.arm;
        let limits = self.dynamics.joint_limits();
        let guard = JointGuard::new(goal.guard, &limits, velocity_max_rad_per_s, torque_max_nm)?;
        let mut servo = ToolServo::new(torque_max_nm, guard, arm.positions.clone());
        servo.restart(arm)?;
        Ok(servo)
    }

    /// Ends the arm's motion, if there is one; joints that the next does not name hold where they are.
    fn preempt_arm(&mut self, arm_positions: &[f64], lift_m: f64) -> Option<MotionId> {
        self.live.arm.motion.as_ref()?;
        self.live.lift.target_m = lift_m;
        self.live.arm.stop(arm_positions)
    }

    fn start_base_path(
        &mut self,
        id: MotionId,
        path: &BasePath,
    ) -> Result<Option<MotionId>, RobotError> {
        if !(path.speed > 0.0 && path.speed <= 1.0) {
            return refused(format!(
                "base speed {}; expected more than 0, at most 1",
                path.speed
            ));
        }
        let odom_from_base = self.live.odometry.odom_from_base;
        let Some(base) = &mut self.live.base else {
            return Err(self.absent("mobile base"));
        };
        let limits = base.limits.scaled(path.speed);
        let tracker = BaseTracker::new(odom_from_base, base.command, &path.odom_from_base, limits)
            .map_err(refusal)?;
        let preempted = base.motion.replace(BaseMotion::Path { id, tracker });
        self.disturb_path(&path.odom_from_base)?;
        Ok(preempted.map(|motion| motion.id()))
    }

    /// Lets the fault see that the robot sets off.
    fn disturb_path(&mut self, odom_path: &[Pose2]) -> Result<(), RobotError> {
        let Some(base) = &self.config.robot.base else {
            return Ok(());
        };
        if !self.fault_switch.is_armed() {
            return Ok(());
        }
        let world_from_base = planar(&self.state, self.assembly.robot.link);
        let world_from_odom = world_from_base * self.live.odometry.odom_from_base.inverse();
        let world_path: Vec<Pose2> = odom_path
            .iter()
            .map(|pose| world_from_odom * pose)
            .collect();
        self.live
            .fault
            .on_base_path(
                &self.assembly,
                &mut self.state,
                &world_path,
                base.footprint_radius_m,
            )
            .map_err(|error| self.lost(&error))
    }

    fn start_base_twist(
        &mut self,
        id: MotionId,
        twist: &BaseTwist,
    ) -> Result<Option<MotionId>, RobotError> {
        let numbers = twist.velocity.iter().chain([&twist.valid_secs]);
        if numbers.into_iter().any(|value| !value.is_finite()) || twist.valid_secs < 0.0 {
            return refused(format!(
                "base twist {twist:?}; expected finite numbers and a time, zero or more"
            ));
        }
        let until_secs = self.state.time_secs() + twist.valid_secs;
        let Some(base) = &mut self.live.base else {
            return Err(self.absent("mobile base"));
        };
        let motion = BaseMotion::Twist {
            id,
            velocity: twist.velocity,
            until_secs,
        };
        Ok(base.motion.replace(motion).map(|motion| motion.id()))
    }

    fn start_gripper(
        &mut self,
        id: MotionId,
        goal: GripperGoal,
    ) -> Result<Option<MotionId>, RobotError> {
        let now_secs = self.state.time_secs();
        let force_max_n = self
            .config
            .robot
            .gripper
            .as_ref()
            .map_or(0.0, |g| g.force_max_n);
        let Some(grip) = &mut self.live.grip else {
            return Err(self.absent("gripper"));
        };
        if goal.force_n > force_max_n {
            return refused(format!(
                "gripper force {} N is more than its limit {force_max_n} N",
                goal.force_n
            ));
        }
        grip.controller.set_goal(goal).map_err(refusal)?;
        Ok(grip.motion.replace((id, now_secs)).map(|(old, _)| old))
    }
}
