//! Where the tool should be at a time: positions linear, rotations by slerp, between the timed poses of a
//! [`ToolPath`](crate::robot::ToolPath).

use factotum_geometry::Pose;
use nalgebra::{UnitQuaternion, Vector6};

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
