//! The base's controller: follows a path in the odometry frame, drives at a velocity until it expires, or stands still.

use factotum_control::base_tracking::{BaseLimits, BaseTracker, GoalTolerance, TrackState};
use factotum_control::{MotionId, MotionStatus};
use factotum_descriptions::Base;
use factotum_geometry::Pose2;
use nalgebra::Vector3;

/// A motion of the base under way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum BaseMotion {
    Path {
        id: MotionId,
        tracker: BaseTracker,
    },
    Twist {
        id: MotionId,
        velocity: Vector3<f64>,
        until_secs: f64,
    },
}

impl BaseMotion {
    pub(crate) fn id(&self) -> MotionId {
        match self {
            Self::Path { id, .. } | Self::Twist { id, .. } => *id,
        }
    }
}

/// The base's controller.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BaseControl {
    pub(crate) limits: BaseLimits,
    /// The last velocity command, base frame.
    pub(crate) command: Vector3<f64>,
    pub(crate) motion: Option<BaseMotion>,
}

impl BaseControl {
    pub(crate) fn new(base: &Base) -> Self {
        Self {
            limits: base.into(),
            command: Vector3::zeros(),
            motion: None,
        }
    }

    /// The next velocity command in the base frame, and a motion that ended with this step.
    pub(crate) fn step(
        &mut self,
        now_secs: f64,
        odom_from_base: &Pose2,
        dt_secs: f64,
    ) -> (Vector3<f64>, Option<(MotionId, MotionStatus)>) {
        let before = self.command;
        let mut ended = None;
        let standing = Vector3::zeros();
        self.command = match &mut self.motion {
            None => self.limits.limit(standing, before, dt_secs),
            Some(BaseMotion::Twist {
                id,
                velocity,
                until_secs,
            }) => {
                if now_secs >= *until_secs {
                    ended = Some((*id, MotionStatus::Done));
                    self.limits.limit(standing, before, dt_secs)
                } else {
                    self.limits.limit(*velocity, before, dt_secs)
                }
            }
            Some(BaseMotion::Path { id, tracker }) => {
                let tolerance = GoalTolerance::default();
                let (command, state) = tracker.step(odom_from_base, before, &tolerance, dt_secs);
                match state {
                    TrackState::Driving => {}
                    TrackState::Arrived => ended = Some((*id, MotionStatus::Done)),
                    TrackState::Stuck { remaining_m } => {
                        let reason = format!(
                            "the base is stuck {remaining_m:.2} m from the end of its path"
                        );
                        ended = Some((*id, MotionStatus::Aborted(reason)));
                    }
                }
                command
            }
        };
        if ended.is_some() {
            self.motion = None;
        }
        (self.command, ended)
    }
}
