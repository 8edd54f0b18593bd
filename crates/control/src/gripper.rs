//! Finger targets under a force limit, and when a grip is done.
//!
//! Fingers are position servos. Their target moves towards the goal at a steady speed; when the pads feel more than
//! the wanted force the target yields, so that any servo becomes a force-limited one, as long as it has pads that feel.
//! A servo's own force limit stays the upper bound.

use crate::ControlError;
use crate::robot::GripperGoal;

/// Time for the target to run from open to closed, seconds.
const STROKE_SECS: f64 = 1.0;

/// Speed at which the target yields to excess force, relative to the closing speed.
const YIELD_SPEED: f64 = 0.3;

/// Fraction of the stroke per second below which the fingers count as stopped.
const STOPPED_PER_SEC: f64 = 0.02;

/// How long the fingers must have stopped before the goal is judged, seconds.
const SETTLE_SECS: f64 = 0.25;

/// How near to the goal counts as reached, as a fraction of the stroke.
const REACHED: f64 = 0.03;

/// How far behind the fingers the target may run when nothing is felt, as a fraction of the stroke: enough for a
/// servo to reach its full force, little enough that it does not push for long when it is let go.
const LEAD_MAX: f64 = 0.6;

/// Pad force from which the fingers count as touching something, N.
pub const CONTACT_FORCE_N: f64 = 0.5;

/// How a gripper goal stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GripState {
    /// Fingers are moving.
    Moving,
    /// Fingers have reached the goal.
    Reached,
    /// Fingers have stopped on something they touch.
    Holding,
    /// Fingers have stopped short of the goal, touching nothing.
    Stuck,
}

/// Drives the fingers to an opening (0 closed to 1 open) under a force limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GripperController {
    /// The goal.
    pub goal: GripperGoal,
    /// Where the servo's target is, 0 closed to 1 open.
    pub target: f64,
    /// Time since the fingers stopped, seconds.
    pub stopped_secs: f64,
    /// Opening at the last step.
    pub opening_before: f64,
}

impl GripperController {
    /// A controller that holds the fingers where they are.
    pub fn holding(opening: f64, force_n: f64) -> Self {
        Self {
            goal: GripperGoal { opening, force_n },
            target: opening,
            stopped_secs: 0.0,
            opening_before: opening,
        }
    }

    /// Takes a new goal.
    ///
    /// # Errors
    /// [`ControlError::Value`] for an opening outside 0 to 1, or a force that is not positive.
    pub fn set_goal(&mut self, goal: GripperGoal) -> Result<(), ControlError> {
        if !(0.0..=1.0).contains(&goal.opening) {
            return Err(ControlError::Value {
                what: "gripper opening",
                found: format!("{}", goal.opening),
                expected: "0 (closed) to 1 (open)",
            });
        }
        if !(goal.force_n > 0.0 && goal.force_n.is_finite()) {
            return Err(ControlError::Value {
                what: "gripper force",
                found: format!("{} N", goal.force_n),
                expected: "a positive force",
            });
        }
        self.goal = goal;
        self.stopped_secs = 0.0;
        Ok(())
    }

    /// The servo's next target, 0 closed to 1 open, given the measured opening and the largest pad force.
    pub fn step(&mut self, opening: f64, pad_force_n: f64, dt_secs: f64) -> f64 {
        let step = dt_secs / STROKE_SECS;
        let closing = self.goal.opening < opening;
        if closing && pad_force_n > self.goal.force_n {
            self.target = (self.target + YIELD_SPEED * step).min(opening);
        } else {
            let towards = self
                .goal
                .opening
                .clamp(self.target - step, self.target + step);
            self.target = towards.clamp(opening - LEAD_MAX, opening + LEAD_MAX);
        }
        let speed = (opening - self.opening_before).abs() / dt_secs;
        self.opening_before = opening;
        self.stopped_secs = if speed < STOPPED_PER_SEC {
            self.stopped_secs + dt_secs
        } else {
            0.0
        };
        self.target
    }

    /// How the goal stands, given the measured opening and the pad forces.
    pub fn state(&self, opening: f64, pad_forces_n: &[f64]) -> GripState {
        let target_there = (self.target - self.goal.opening).abs() < REACHED;
        let reached = (opening - self.goal.opening).abs() < REACHED;
        if self.stopped_secs < SETTLE_SECS {
            return GripState::Moving;
        }
        let touching = pad_forces_n
            .iter()
            .filter(|force| **force > CONTACT_FORCE_N)
            .count();
        let closing = self.goal.opening < opening;
        if closing && touching >= 2.min(pad_forces_n.len()).max(1) {
            GripState::Holding
        } else if reached {
            GripState::Reached
        } else if target_there || (self.target - opening).abs() >= LEAD_MAX - REACHED {
            GripState::Stuck
        } else {
            GripState::Moving
        }
    }
}
