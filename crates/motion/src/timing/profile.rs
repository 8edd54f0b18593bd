//! Speed along a straight segment: from one speed to another in least time under jerk limits.

use rsruckig::error::ThrowErrorHandler;
use rsruckig::input_parameter::InputParameter;
use rsruckig::prelude::{Ruckig, RuckigResult};
use rsruckig::trajectory::Trajectory;
use rsruckig::util::DataArrayOrVec;

use crate::error::MotionError;
use crate::joint_space::JointLimit;

/// Limits of the motion along a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpeedLimits {
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) jerk: f64,
}

impl SpeedLimits {
    /// The tightest of the joints' limits for a motion along a unit direction.
    pub(super) fn along(direction: &[f64], limits: &[JointLimit]) -> Self {
        let tightest = |of: fn(&JointLimit) -> f64| {
            limits
                .iter()
                .zip(direction)
                .map(|(limit, u)| of(limit) / u.abs())
                .fold(f64::INFINITY, f64::min)
        };
        Self {
            speed: tightest(|limit| limit.velocity),
            acceleration: tightest(|limit| limit.acceleration),
            jerk: tightest(|limit| limit.jerk),
        }
    }

    /// Distance needed to change between two speeds, accelerations zero at both ends.
    fn distance_between(&self, a: f64, b: f64) -> f64 {
        let change = (b - a).abs();
        // Either the acceleration limit is not reached (two jerk phases) or it is (three).
        let duration = if change * self.jerk <= self.acceleration * self.acceleration {
            2.0 * (change / self.jerk).sqrt()
        } else {
            change / self.acceleration + self.acceleration / self.jerk
        };
        0.5 * (a + b) * duration
    }
}

/// The highest speed, within the limits, that can be changed to or from `speed` over `distance`.
pub(super) fn reachable_speed(speed: f64, distance: f64, limits: &SpeedLimits) -> f64 {
    // The distance grows with the higher speed, so bisection finds it; a little is left for rounding.
    const ROUNDING: f64 = 1.0 - 1e-9;
    if limits.distance_between(speed, limits.speed) <= distance {
        return limits.speed;
    }
    let (mut low, mut high) = (speed.min(limits.speed), limits.speed);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if limits.distance_between(speed, middle) <= distance * ROUNDING {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Speed over time along a straight segment.
#[derive(Debug)]
pub(super) struct SpeedProfile {
    trajectory: Option<Trajectory<1>>,
}

impl SpeedProfile {
    /// The fastest profile over `length` between the two speeds.
    pub(super) fn new(
        length: f64,
        speed_from: f64,
        speed_to: f64,
        limits: &SpeedLimits,
    ) -> Result<Self, MotionError> {
        const LENGTH_ZERO: f64 = 1e-12;
        if length <= LENGTH_ZERO {
            return Ok(Self { trajectory: None });
        }
        let mut input = InputParameter::<1>::new(None);
        input.current_velocity[0] = speed_from;
        input.target_position[0] = length;
        input.target_velocity[0] = speed_to;
        input.max_velocity[0] = limits.speed;
        input.max_acceleration[0] = limits.acceleration;
        input.max_jerk[0] = limits.jerk;
        // The path is not run backwards.
        let mut generator = Ruckig::<1, ThrowErrorHandler>::new(None, 1e-3);
        let mut trajectory = Trajectory::<1>::new(None);
        let failed = |reason: String| MotionError::Timing {
            length,
            speed_from,
            speed_to,
            reason,
        };
        let result = generator
            .calculate(&input, &mut trajectory)
            .map_err(|error| failed(error.to_string()))?;
        if result != RuckigResult::Working || !trajectory.duration.is_finite() {
            return Err(failed(format!("{result:?}")));
        }
        Ok(Self {
            trajectory: Some(trajectory),
        })
    }

    pub(super) fn duration_secs(&self) -> f64 {
        self.trajectory
            .as_ref()
            .map_or(0.0, |trajectory| trajectory.duration)
    }

    /// Length and speed at a time.
    pub(super) fn at(&self, time_secs: f64) -> (f64, f64) {
        let Some(trajectory) = &self.trajectory else {
            return (0.0, 0.0);
        };
        let mut position = DataArrayOrVec::<f64, 1>::new(None, 0.0);
        let mut velocity = DataArrayOrVec::<f64, 1>::new(None, 0.0);
        trajectory.at_time(
            time_secs,
            &mut Some(&mut position),
            &mut Some(&mut velocity),
            &mut None,
            &mut None,
            &mut None,
        );
        (position[0], velocity[0])
    }
}
