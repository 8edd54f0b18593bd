//! Where the tool should be at a time: positions linear, rotations by slerp, between the timed poses of a
//! [`ToolPath`](crate::robot::ToolPath).

use factotum_geometry::Pose;
use nalgebra::{UnitQuaternion, Vector3, Vector6};

use crate::ControlError;
use crate::impedance::{ToolTarget, rotation_error};

/// Timed tool poses, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedPoses {
    poses: Vec<(f64, Pose)>,
}

impl TimedPoses {
    /// Checks and keeps the poses (seconds from the start, tool pose in the base frame).
    ///
    /// # Errors
    /// [`ControlError`] if there are none, a number is not finite, or time goes backwards.
    pub fn new(poses: Vec<(f64, Pose)>) -> Result<Self, ControlError> {
        let bad = |found: String, expected| {
            Err(ControlError::Value {
                what: "tool path",
                found,
                expected,
            })
        };
        if poses.is_empty() {
            return bad("empty".to_owned(), "at least one pose");
        }
        let mut before_secs = 0.0;
        for (index, (time_secs, pose)) in poses.iter().enumerate() {
            let finite = pose
                .translation
                .vector
                .iter()
                .all(|value| value.is_finite())
                && pose.rotation.coords.iter().all(|value| value.is_finite());
            if !time_secs.is_finite() || !finite {
                return bad(format!("not finite at pose {index}"), "finite numbers");
            }
            if *time_secs < before_secs {
                return bad(
                    format!("at {time_secs} s at pose {index}, after {before_secs} s"),
                    "times that start at 0 or later and never decrease",
                );
            }
            before_secs = *time_secs;
        }
        Ok(Self { poses })
    }

    /// Time of the last pose, seconds.
    pub fn duration_secs(&self) -> f64 {
        self.poses.last().map_or(0.0, |(time_secs, _)| *time_secs)
    }

    /// The last pose.
    pub fn end(&self) -> Pose {
        self.poses
            .last()
            .map_or_else(Pose::identity, |(_, pose)| *pose)
    }

    /// Pose and velocity at a time; before the first pose and after the last, that pose at rest.
    pub fn sample(&self, time_secs: f64) -> ToolTarget {
        let after = self.poses.partition_point(|(at, _)| *at <= time_secs);
        let (Some(before), Some((b_secs, b))) = (after.checked_sub(1), self.poses.get(after))
        else {
            let index = after.saturating_sub(1).min(self.poses.len() - 1);
            return ToolTarget::at_rest(self.poses[index].1);
        };
        let (a_secs, a) = self.poses[before];
        let duration = b_secs - a_secs;
        let rotation = rotation_error(&a, b);
        let fraction = (time_secs - a_secs) / duration;
        let linear = b.translation.vector - a.translation.vector;
        let position = a.translation.vector + linear * fraction;
        let mut velocity = Vector6::zeros();
        velocity
            .fixed_rows_mut::<3>(0)
            .copy_from(&(linear / duration));
        velocity
            .fixed_rows_mut::<3>(3)
            .copy_from(&(rotation / duration));
        ToolTarget {
            base_from_tcp: Pose::from_parts(
                position.into(),
                UnitQuaternion::from_scaled_axis(rotation * fraction) * a.rotation,
            ),
            velocity,
        }
    }
}

/// Rate at which a [`TargetTrim`] grows with the error, 1/s.
const TRIM_RATE: f64 = 2.0;

/// Largest trim of the position, metres.
const TRIM_MAX_M: f64 = 0.04;

/// Largest trim of the rotation, radians.
const TRIM_MAX_RAD: f64 = 0.25;

/// A slow, bounded shift of the target that takes away what joint friction leaves of the error.
///
/// Eq. 3.1 has no integral term: at 150 1/s² the hand of a Jaco, whose apparent mass is below a kilogram, stops
/// centimetres short of its target on the friction of its own gears. The bound keeps the compliance: against an
/// obstacle the force grows by no more than `Λ_p kp` times 4 cm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TargetTrim {
    position: Vector3<f64>,
    rotation: Vector3<f64>,
}

impl TargetTrim {
    /// The target, shifted.
    pub fn apply(&self, target: &ToolTarget) -> ToolTarget {
        let pose = &target.base_from_tcp;
        ToolTarget {
            base_from_tcp: Pose::from_parts(
                (pose.translation.vector + self.position).into(),
                UnitQuaternion::from_scaled_axis(self.rotation) * pose.rotation,
            ),
            velocity: target.velocity,
        }
    }

    /// Grows with the error between where the tool is and the target as it was given.
    pub fn update(&mut self, base_from_tcp: &Pose, target: &ToolTarget, dt_secs: f64) {
        let wanted = &target.base_from_tcp;
        let position = wanted.translation.vector - base_from_tcp.translation.vector;
        let step = TRIM_RATE * dt_secs;
        self.position = (self.position + position * step).cap_magnitude(TRIM_MAX_M);
        self.rotation = (self.rotation + rotation_error(base_from_tcp, wanted) * step)
            .cap_magnitude(TRIM_MAX_RAD);
    }
}
