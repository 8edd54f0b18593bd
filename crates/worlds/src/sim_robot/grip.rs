//! The gripper's controller, and the scale that turns finger joints into an opening.

use factotum_control::gripper::{GripState, GripperController};
use factotum_control::{MotionId, MotionStatus};
use factotum_descriptions::RobotDescription;
use factotum_physics::{Model, PhysicsError, State};
use nalgebra::Vector3;

/// How long the fingers are given to reach each end when the scale is measured, seconds.
const MEASURE_SECS: f64 = 1.0;

/// How long a gripper goal may take, seconds.
const GRIP_TIMEOUT_SECS: f64 = 6.0;

/// Finger joint positions with the gripper closed and open.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GripperScale {
    closed: Vec<f64>,
    open: Vec<f64>,
}

impl GripperScale {
    /// Opens and closes the gripper of the robot's own model, without gravity, and reads its joints. That works for any
    /// coupling between drives and fingers.
    pub(crate) fn measure(
        robot: &RobotDescription,
        model: &Model,
    ) -> Result<Option<Self>, PhysicsError> {
        let Some(gripper) = &robot.gripper else {
            return Ok(None);
        };
        let floating = model.edited(|edit| {
            edit.set_gravity(Vector3::zeros());
            Ok(())
        })?;
        let mut state = State::new(&floating)?;
        let mut read_at = |targets: &[f64]| -> Result<Vec<f64>, PhysicsError> {
            for (actuator, target) in gripper.actuators.iter().zip(targets) {
                state.set_ctrl(floating.actuator(actuator)?, *target);
            }
            let until_secs = state.time_secs() + MEASURE_SECS;
            while state.time_secs() < until_secs {
                state.step()?;
            }
            gripper
                .joints
                .iter()
                .map(|joint| Ok(state.joint_position(floating.joint(joint)?)))
                .collect()
        };
        let closed = read_at(&gripper.closed)?;
        let open = read_at(&gripper.open)?;
        Ok(Some(Self { closed, open }))
    }

    /// Finger joint positions of an opening, 0 closed to 1 open.
    pub(crate) fn positions(&self, opening: f64) -> impl Iterator<Item = f64> + '_ {
        let strokes = self.closed.iter().zip(&self.open);
        strokes.map(move |(closed, open)| closed + (open - closed) * opening)
    }

    /// Opening, 0 closed to 1 open, of finger joint positions.
    pub(crate) fn opening(&self, positions: impl Iterator<Item = f64>) -> f64 {
        let strokes = self.closed.iter().zip(&self.open).zip(positions);
        let (sum, n) = strokes
            .filter(|((closed, open), _)| (*open - *closed).abs() > 1e-6)
            .map(|((closed, open), position)| (position - closed) / (open - closed))
            .fold((0.0, 0), |(sum, n), share| (sum + share, n + 1));
        if n == 0 {
            return 0.0;
        }
        (sum / f64::from(n)).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod holding;

/// The gripper's controller and the goal it serves.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GripControl {
    pub(crate) controller: GripperController,
    pub(crate) motion: Option<(MotionId, f64)>,
}

impl GripControl {
    pub(crate) fn new(opening: f64, force_n: f64) -> Self {
        Self {
            controller: GripperController::holding(opening, force_n),
            motion: None,
        }
    }

    /// The fingers' next target, 0 closed to 1 open, and a goal that ended with this step.
    pub(crate) fn step(
        &mut self,
        now_secs: f64,
        opening: f64,
        pad_forces_n: &[f64],
        dt_secs: f64,
    ) -> (f64, Option<(MotionId, MotionStatus)>) {
        let force = pad_forces_n.iter().copied().fold(0.0, f64::max);
        let target = self.controller.step(opening, force, dt_secs);
        let Some((id, start_secs)) = self.motion else {
            return (target, None);
        };
        let status = match self.controller.state(opening, pad_forces_n) {
            GripState::Reached | GripState::Holding => MotionStatus::Done,
            GripState::Stuck => MotionStatus::Aborted(format!(
                "the fingers stopped at {:.0} % open and touch nothing",
                opening * 100.0
            )),
            GripState::Moving if now_secs - start_secs > GRIP_TIMEOUT_SECS => {
                MotionStatus::Aborted(format!(
                    "the fingers did not come to rest in {GRIP_TIMEOUT_SECS:.0} s"
                ))
            }
            GripState::Moving => MotionStatus::Active,
        };
        if status.is_over() {
            self.motion = None;
            return (target, Some((id, status)));
        }
        (target, None)
    }
}
