//! The arm's controller: follows a joint trajectory, a tool path under variable impedance, or holds still.

use factotum_control::impedance::{OperationalSpace, Posture, ToolTarget, impedance_torques_in};
use factotum_control::joint_tracking::{JointGains, JointTarget, JointTracker};
use factotum_control::safety::{SafetyEnvelope, Zone};
use factotum_control::tool_path::{TargetTrim, TimedPoses};
use factotum_control::tool_servo::ToolServo;
use factotum_control::torque_limit::TorqueLimiter;
use factotum_control::wrench_estimate::WrenchEstimate;
use factotum_control::{ArmState, ControlError, Impedance, MotionId, MotionStatus, ToolGoal};
use factotum_descriptions::{Arm, JointTrajectory};
use nalgebra::{DVector, Vector6};

/// Thresholds of σ for tool paths, rad. Narrower than those of the thesis' experiments (0.3 and 0.2), because these paths
/// are planned within the joint limits; a policy that explores needs the wider ones.
const GUARD_RAD: [f64; 3] = [0.06, 0.03, 0.005];

/// How near each joint must be to the end of a trajectory, rad.
const ARRIVED_RAD: f64 = 0.015;

/// How near the lift must be, metres.
const ARRIVED_M: f64 = 0.004;

/// Joint speed below which the arm has arrived, rad/s.
const SLOW_RAD_PER_S: f64 = 0.05;

/// How long the arm may take to arrive after the last point, seconds.
const SETTLE_SECS: f64 = 2.0;

/// How far a joint may fall behind its trajectory, rad: more than any disturbance of the arm's own, less than it takes
/// to press hard.
const BEHIND_MAX_RAD: f64 = 0.3;

/// How far the tool may fall behind its path, metres.
const TOOL_BEHIND_MAX_M: f64 = 0.25;

/// Time a tool motion runs before its force guard listens, seconds: the estimate's filter must settle.
const GUARD_DELAY_SECS: f64 = 0.06;

/// What a column of a joint trajectory drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
    Arm(usize),
    Lift,
}

/// A motion of the arm under way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ArmMotion {
    Joints {
        id: MotionId,
        start_secs: f64,
        trajectory: JointTrajectory,
        columns: Vec<Column>,
    },
    Tool {
        id: MotionId,
        start_secs: f64,
        path: TimedPoses,
        impedance: Impedance,
        posture: Posture,
        stop_force_n: Option<f64>,
        tolerance_m: f64,
        /// Force estimate when the motion began: friction and what is in the hand.
        tare: Vector6<f64>,
    },
    Goal {
        id: MotionId,
        until_secs: f64,
        goal: ToolGoal,
        servo: Box<ToolServo>,
    },
}

impl ArmMotion {
    pub(crate) fn id(&self) -> MotionId {
        match self {
            Self::Joints { id, .. } | Self::Tool { id, .. } | Self::Goal { id, .. } => *id,
        }
    }
}

/// What the arm controller asks for in one step.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ArmCommand {
    /// Motor torques, N m, limited.
    pub(crate) torques: DVector<f64>,
    /// Where the lift should be, if the motion moves it.
    pub(crate) lift_m: Option<f64>,
    /// A motion that ended with this step.
    pub(crate) ended: Option<(MotionId, MotionStatus)>,
}

/// The arm's controller.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ArmControl {
    pub(crate) tracker: JointTracker,
    pub(crate) limiter: TorqueLimiter,
    pub(crate) wrench: WrenchEstimate,
    pub(crate) hold: DVector<f64>,
    pub(crate) motion: Option<ArmMotion>,
    /// Correction of the tool motion under way.
    pub(crate) trim: TargetTrim,
    envelope: SafetyEnvelope,
}

impl ArmControl {
    pub(crate) fn new(
        arm: &Arm,
        limits: Vec<Option<[f64; 2]>>,
        positions: &[f64],
    ) -> Result<Self, ControlError> {
        let [null_space, push_back, failure] = GUARD_RAD;
        let envelope = SafetyEnvelope::new(limits, arm.torque_max_nm.clone())?
            .with_thresholds(null_space, push_back, failure)?;
        Ok(Self {
            tracker: JointTracker::new(JointGains::default(), &arm.torque_max_nm),
            limiter: TorqueLimiter::new(&arm.torque_max_nm),
            wrench: WrenchEstimate::new(positions.len()),
            hold: DVector::from_row_slice(positions),
            motion: None,
            trim: TargetTrim::default(),
            envelope,
        })
    }

    /// Holds the arm where it is; the motion under way is returned.
    pub(crate) fn stop(&mut self, positions: &[f64]) -> Option<MotionId> {
        self.hold = DVector::from_row_slice(positions);
        self.motion.take().map(|motion| motion.id())
    }

    /// Torques for the next step.
    pub(crate) fn step(
        &mut self,
        now_secs: f64,
        arm: &ArmState,
        lift_m: f64,
        dt_secs: f64,
    ) -> Result<ArmCommand, ControlError> {
        let applied = self.limiter.last().clone();
        self.wrench.update(arm, &applied, dt_secs)?;
        let Some(mut motion) = self.motion.take() else {
            let target = JointTarget::at_rest(self.hold.clone());
            let torques = self.tracker.torques(arm, &target, dt_secs)?;
            return self.command(&torques, None, None, dt_secs);
        };
        let (torques, lift_target, status) = match &mut motion {
            ArmMotion::Joints {
                start_secs,
                trajectory,
                columns,
                ..
            } => self.follow_joints(
                now_secs - *start_secs,
                trajectory,
                columns,
                arm,
                lift_m,
                dt_secs,
            )?,
            ArmMotion::Tool { .. } => {
                let (torques, status) = self.follow_tool(now_secs, &motion, arm, dt_secs)?;
                (torques, None, status)
            }
            ArmMotion::Goal {
                until_secs,
                goal,
                servo,
                ..
            } => {
                let target = ToolTarget::at_rest(goal.base_from_tcp);
                let torques = servo
                    .torques(arm, &target, &goal.impedance, dt_secs)?
                    .clone();
                // They are within the motors' limits, which must not be applied twice.
                self.limiter.set_last(&torques)?;
                let status = if now_secs < *until_secs - 0.5 * dt_secs {
                    MotionStatus::Active
                } else {
                    MotionStatus::Done
                };
                (torques, None, status)
            }
        };
        if status.is_over() {
            self.hold = match (&motion, &status) {
                // The end of the trajectory, not where friction left the joint.
                (ArmMotion::Joints { .. }, MotionStatus::Done) => self.hold.clone(),
                _ => arm.positions.clone(),
            };
            return self.command(&torques, lift_target, Some((motion.id(), status)), dt_secs);
        }
        self.motion = Some(motion);
        self.command(&torques, lift_target, None, dt_secs)
    }

    fn command(
        &mut self,
        wished: &DVector<f64>,
        lift_m: Option<f64>,
        ended: Option<(MotionId, MotionStatus)>,
        dt_secs: f64,
    ) -> Result<ArmCommand, ControlError> {
        Ok(ArmCommand {
            torques: self.limiter.limit(wished, dt_secs)?.clone(),
            lift_m,
            ended,
        })
    }

    fn follow_joints(
        &mut self,
        time_secs: f64,
        trajectory: &JointTrajectory,
        columns: &[Column],
        arm: &ArmState,
        lift_m: f64,
        dt_secs: f64,
    ) -> Result<(DVector<f64>, Option<f64>, MotionStatus), ControlError> {
        let point = trajectory.sample(time_secs);
        let next = trajectory.sample(time_secs + dt_secs);
        let mut target = JointTarget::at_rest(self.hold.clone());
        let mut lift_target = None;
        for (i, column) in columns.iter().enumerate() {
            match column {
                Column::Arm(joint) => {
                    target.positions[*joint] = point.positions[i];
                    target.velocities[*joint] = point.velocities[i];
                    target.accelerations[*joint] =
                        (next.velocities[i] - point.velocities[i]) / dt_secs;
                }
                Column::Lift => lift_target = Some(point.positions[i]),
            }
        }
        let status = self.judge_joints(time_secs, trajectory, &target, arm, lift_target, lift_m);
        if status == MotionStatus::Done {
            self.hold.copy_from(&target.positions);
        }
        let torques = self.tracker.torques(arm, &target, dt_secs)?;
        Ok((torques, lift_target, status))
    }

    fn judge_joints(
        &self,
        time_secs: f64,
        trajectory: &JointTrajectory,
        target: &JointTarget,
        arm: &ArmState,
        lift_target: Option<f64>,
        lift_m: f64,
    ) -> MotionStatus {
        let errors = &target.positions - &arm.positions;
        let (worst, error) = errors.iter().map(|error| error.abs()).enumerate().fold(
            (0, 0.0),
            |worst, (joint, error)| {
                if error > worst.1 {
                    (joint, error)
                } else {
                    worst
                }
            },
        );
        if error > BEHIND_MAX_RAD {
            return MotionStatus::Aborted(format!(
                "arm joint {} is {error:.2} rad off its trajectory: something is in the way",
                worst + 1
            ));
        }
        let over_secs = time_secs - trajectory.duration_secs();
        if over_secs < 0.0 {
            return MotionStatus::Active;
        }
        let lift_error = lift_target.map_or(0.0, |target| (target - lift_m).abs());
        let slow = arm.velocities.amax() < SLOW_RAD_PER_S;
        if error < ARRIVED_RAD && lift_error < ARRIVED_M && slow {
            return MotionStatus::Done;
        }
        if over_secs < SETTLE_SECS {
            return MotionStatus::Active;
        }
        MotionStatus::Aborted(if lift_error >= ARRIVED_M {
            format!(
                "the lift stopped {:.0} mm short of its goal",
                lift_error * 1e3
            )
        } else {
            format!(
                "arm joint {} stopped {error:.3} rad short of its goal",
                worst + 1
            )
        })
    }

    fn follow_tool(
        &mut self,
        now_secs: f64,
        motion: &ArmMotion,
        arm: &ArmState,
        dt_secs: f64,
    ) -> Result<(DVector<f64>, MotionStatus), ControlError> {
        let ArmMotion::Tool {
            start_secs,
            path,
            impedance,
            posture,
            stop_force_n,
            tolerance_m,
            tare,
            ..
        } = motion
        else {
            return Ok((arm.bias.clone(), MotionStatus::Active));
        };
        let time_secs = now_secs - start_secs;
        let target = path.sample(time_secs);
        let space = OperationalSpace::of(arm)?;
        let gains = self.envelope.cap(*impedance);
        self.trim.update(&arm.base_from_tcp, &target, dt_secs);
        let trimmed = self.trim.apply(&target);
        let task = impedance_torques_in(&space, arm, &trimmed, &gains, Some(posture))?;
        let (torques, zone) = self.envelope.guard(arm, &space, task)?;

        let error =
            (target.base_from_tcp.translation.vector - arm.base_from_tcp.translation.vector).norm();
        let force = (self.wrench.wrench(arm) - tare).fixed_rows::<3>(0).norm();
        let over_secs = time_secs - path.duration_secs();
        let status =
            if stop_force_n.is_some_and(|limit| force > limit) && time_secs > GUARD_DELAY_SECS {
                MotionStatus::Guarded
            } else if let Some((joint, distance)) = self.envelope.violation(&arm.positions) {
                MotionStatus::Aborted(format!(
                    "arm joint {} is {distance:.3} rad from its limit",
                    joint + 1
                ))
            } else if error > TOOL_BEHIND_MAX_M {
                MotionStatus::Aborted(format!(
                    "the tool is {:.0} mm off its path: something holds it",
                    error * 1e3
                ))
            } else if over_secs < 0.0 {
                MotionStatus::Active
            } else if error < *tolerance_m && arm.velocities.amax() < SLOW_RAD_PER_S {
                MotionStatus::Done
            } else if over_secs < SETTLE_SECS {
                MotionStatus::Active
            } else {
                let why = match &zone {
                    Zone::Free => String::new(),
                    Zone::NullSpace(joints) | Zone::PushBack(joints) => joints
                        .first()
                        .map(|joint| format!(": arm joint {} is at its limit", joint + 1))
                        .unwrap_or_default(),
                };
                MotionStatus::Aborted(format!(
                    "the tool stopped {:.0} mm short of its goal{why}",
                    error * 1e3
                ))
            };
        Ok((torques, status))
    }
}
