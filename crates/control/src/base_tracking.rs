//! Following a path of poses with an omnidirectional base.
//!
//! A reference runs along the path with a speed profile that keeps the limits on speed, turn rate and acceleration, and
//! slows down at corners; the base follows it by feed-forward of the reference's velocity and feedback of the error:
//!
//! ```text
//! u = v_ref + k (x_ref - x),  limited in speed and in change per step
//! ```
//!
//! Each segment of the path has a length in seconds, the larger of what its translation takes at full speed and what its
//! turn takes at full turn rate; `s` runs along the path in that measure, so that its rate is 1 at full speed. A corner
//! is passed at the speed at which turning the velocity around at the acceleration limit leaves the path by
//! [`CORNER_DEVIATION_M`]; sweeps from both ends make the profile reachable.
//!
//! The reference waits when the base falls behind ([`BEHIND_MAX_M`]), so that a base that is held up does not push ahead
//! to catch up; after [`STUCK_SECS`] without progress the tracker gives up.
//!
//! Poses and velocities: the path and the base's pose are in one frame (odometry); the command is in the base frame.

use factotum_descriptions::Base;
use factotum_geometry::Pose2;
use factotum_geometry::frames::wrap_angle;
use nalgebra::{Rotation2, Vector2, Vector3};

use crate::ControlError;
use crate::error::check_finite;

/// How far a corner may be cut by the speed profile, metres.
pub const CORNER_DEVIATION_M: f64 = 0.01;

/// Error at which the reference waits for the base, metres (and, at 0.3 m per radian, for its heading).
pub const BEHIND_MAX_M: f64 = 0.08;

/// Time without progress after which the base counts as stuck, seconds.
pub const STUCK_SECS: f64 = 3.0;

/// Share of the acceleration limit that the speed profile uses; the rest is left to the feedback.
const PROFILE_SHARE: f64 = 0.6;

/// Feedback gain, 1/s.
const FEEDBACK: f64 = 4.0;

/// Metres of error that one radian of heading error counts for.
const METRES_PER_RADIAN: f64 = 0.3;

/// Limits of an omnidirectional base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseLimits {
    /// Speed in any direction, m/s.
    pub velocity_max_m_per_s: f64,
    /// Turn rate, rad/s.
    pub yaw_rate_max_rad_per_s: f64,
    /// Acceleration, m/s²; turning keeps the same ratio of rate to acceleration.
    pub acceleration_max_m_per_s2: f64,
}

impl From<&Base> for BaseLimits {
    fn from(base: &Base) -> Self {
        Self {
            velocity_max_m_per_s: base.velocity_max_m_per_s,
            yaw_rate_max_rad_per_s: base.yaw_rate_max_rad_per_s,
            acceleration_max_m_per_s2: base.acceleration_max_m_per_s2,
        }
    }
}

impl BaseLimits {
    /// The same limits with the speeds scaled by `share` in (0, 1].
    pub fn scaled(self, share: f64) -> Self {
        Self {
            velocity_max_m_per_s: self.velocity_max_m_per_s * share,
            yaw_rate_max_rad_per_s: self.yaw_rate_max_rad_per_s * share,
            ..self
        }
    }

    /// Turn acceleration, rad/s²: full turn rate is reached as fast as full speed.
    pub fn yaw_acceleration_max_rad_per_s2(&self) -> f64 {
        self.acceleration_max_m_per_s2 * self.yaw_rate_max_rad_per_s / self.velocity_max_m_per_s
    }

    /// `velocity` (base frame; m/s, m/s, rad/s), slowed to the limits and at most one step's acceleration away from
    /// `before`, the velocity of the step before. Acceleration is counted in a frame that does not turn with the base.
    pub fn limit(
        &self,
        velocity: Vector3<f64>,
        before: Vector3<f64>,
        dt_secs: f64,
    ) -> Vector3<f64> {
        let linear = shorten(velocity.xy(), self.velocity_max_m_per_s);
        let yaw = velocity
            .z
            .clamp(-self.yaw_rate_max_rad_per_s, self.yaw_rate_max_rad_per_s);
        let linear_before = Rotation2::new(-before.z * dt_secs) * before.xy();
        let linear_step = shorten(
            linear - linear_before,
            self.acceleration_max_m_per_s2 * dt_secs,
        );
        let yaw_step_max = self.yaw_acceleration_max_rad_per_s2() * dt_secs;
        let yaw_step = (yaw - before.z).clamp(-yaw_step_max, yaw_step_max);
        let linear = linear_before + linear_step;
        Vector3::new(linear.x, linear.y, before.z + yaw_step)
    }
}

fn shorten(vector: Vector2<f64>, length_max: f64) -> Vector2<f64> {
    let length = vector.norm();
    if length > length_max {
        vector * (length_max / length)
    } else {
        vector
    }
}

/// When a path counts as driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GoalTolerance {
    /// Distance from the last pose, metres.
    pub position_m: f64,
    /// Heading from the last pose, radians.
    pub yaw_rad: f64,
}

impl Default for GoalTolerance {
    /// 1 cm and 1 degree.
    fn default() -> Self {
        Self {
            position_m: 0.01,
            yaw_rad: 0.0175,
        }
    }
}

/// How following a path stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrackState {
    /// On the way.
    Driving,
    /// Within the tolerance of the last pose, and slow.
    Arrived,
    /// No progress for [`STUCK_SECS`]; how far the last pose is, metres.
    Stuck {
        /// Straight distance to the last pose.
        remaining_m: f64,
    },
}

/// One straight piece of the path.
#[derive(Debug, Clone, PartialEq)]
struct Segment {
    from: Pose2,
    translation: Vector2<f64>,
    turn: f64,
    /// Length in seconds at full speed.
    length: f64,
    /// Allowed rate of `s` at its end.
    end_rate: f64,
}

/// Where a [`BaseTracker`] is on its path: all that changes from step to step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Progress {
    /// Segment of the reference.
    segment: usize,
    /// Position in it, seconds at full speed.
    along: f64,
    /// Rate of the reference along the path, 0 to 1.
    rate: f64,
    /// Time without progress, seconds.
    stuck_secs: f64,
}

/// Follows one path.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseTracker {
    segments: Vec<Segment>,
    end: Pose2,
    limits: BaseLimits,
    /// Smallest rate change per second that respects both accelerations.
    rate_slope: f64,
    progress: Progress,
}

impl BaseTracker {
    /// A tracker from `start` (where the base is) along `path`; the base moves at `velocity` (its own frame; m/s, m/s,
    /// rad/s), which the reference takes up as far as it leads along the path.
    ///
    /// # Errors
    /// [`ControlError`] if the path is empty, a number is not finite, or a limit is not positive.
    pub fn new(
        start: Pose2,
        velocity: Vector3<f64>,
        path: &[Pose2],
        limits: BaseLimits,
    ) -> Result<Self, ControlError> {
        let Some(end) = path.last().copied() else {
            return Err(ControlError::Value {
                what: "base path",
                found: "empty".to_owned(),
                expected: "at least one pose",
            });
        };
        for pose in std::iter::once(&start).chain(path) {
            let angle = pose.rotation.angle();
            check_finite("base path", pose.translation.vector.iter().chain([&angle]))?;
        }
        let values = [
            limits.velocity_max_m_per_s,
            limits.yaw_rate_max_rad_per_s,
            limits.acceleration_max_m_per_s2,
        ];
        if let Some(value) = values
            .iter()
            .find(|value| !(value.is_finite() && **value > 0.0))
        {
            return Err(ControlError::Value {
                what: "base limit",
                found: format!("{value}"),
                expected: "a positive number",
            });
        }
        let mut segments: Vec<Segment> = std::iter::once(&start)
            .chain(path)
            .zip(path)
            .filter_map(|(from, to)| segment(from, to, &limits))
            .collect();
        let rate_slope =
            PROFILE_SHARE * limits.acceleration_max_m_per_s2 / limits.velocity_max_m_per_s;
        let rate = segments.first().map_or(0.0, |first| {
            let linear = start.rotation * velocity.xy();
            let velocity = Vector3::new(linear.x, linear.y, METRES_PER_RADIAN * velocity.z);
            let full = velocity_at_full_rate(first);
            (velocity.dot(&full) / full.norm_squared()).clamp(0.0, 1.0)
        });
        set_corner_rates(&mut segments, &limits, rate_slope, rate);
        Ok(Self {
            segments,
            end,
            limits,
            rate_slope,
            progress: Progress {
                rate,
                ..Progress::default()
            },
        })
    }

    /// Where the path ends.
    pub fn end(&self) -> Pose2 {
        self.end
    }

    /// The next velocity command in the base frame (m/s, m/s, rad/s), and how it goes.
    ///
    /// `before` is the last command; `odom_from_base` the measured pose.
    pub fn step(
        &mut self,
        odom_from_base: &Pose2,
        before: Vector3<f64>,
        tolerance: &GoalTolerance,
        dt_secs: f64,
    ) -> (Vector3<f64>, TrackState) {
        let behind = pose_distance(odom_from_base, &self.reference().0);
        let advanced = behind < BEHIND_MAX_M && self.advance(dt_secs);
        if behind >= BEHIND_MAX_M {
            self.progress.rate = 0.0;
        }
        let (reference, velocity_ref) = self.reference();
        let error = reference.translation.vector - odom_from_base.translation.vector;
        let yaw_error = wrap_angle(reference.rotation.angle() - odom_from_base.rotation.angle());
        let rate = if behind < BEHIND_MAX_M {
            self.progress.rate
        } else {
            0.0
        };
        let linear = velocity_ref.xy() * rate + error * FEEDBACK;
        let in_base = odom_from_base.rotation.inverse() * linear;
        let yaw = velocity_ref.z * rate + yaw_error * FEEDBACK;
        let command = self
            .limits
            .limit(Vector3::new(in_base.x, in_base.y, yaw), before, dt_secs);
        self.progress.stuck_secs = if advanced {
            0.0
        } else {
            self.progress.stuck_secs + dt_secs
        };
        (command, self.judge(odom_from_base, &command, tolerance))
    }

    fn judge(
        &self,
        odom_from_base: &Pose2,
        command: &Vector3<f64>,
        tolerance: &GoalTolerance,
    ) -> TrackState {
        /// Commands below this count as standing still, m/s and rad/s.
        const SLOW: f64 = 0.02;
        let remaining = self.end.translation.vector - odom_from_base.translation.vector;
        let yaw = wrap_angle(self.end.rotation.angle() - odom_from_base.rotation.angle());
        let there = remaining.norm() < tolerance.position_m && yaw.abs() < tolerance.yaw_rad;
        if self.progress.segment >= self.segments.len() && there && command.norm() < SLOW {
            TrackState::Arrived
        } else if self.progress.stuck_secs > STUCK_SECS {
            TrackState::Stuck {
                remaining_m: remaining.norm(),
            }
        } else {
            TrackState::Driving
        }
    }

    /// The reference's pose, and its velocity in the path's frame at rate 1.
    fn reference(&self) -> (Pose2, Vector3<f64>) {
        let Some(segment) = self.segments.get(self.progress.segment) else {
            return (self.end, Vector3::zeros());
        };
        let share = self.progress.along / segment.length;
        let pose = Pose2::new(
            segment.from.translation.vector + segment.translation * share,
            segment.from.rotation.angle() + segment.turn * share,
        );
        let velocity = segment.translation / segment.length;
        (
            pose,
            Vector3::new(velocity.x, velocity.y, segment.turn / segment.length),
        )
    }

    /// Moves the reference; false at the end of the path.
    fn advance(&mut self, dt_secs: f64) -> bool {
        let Some(segment) = self.segments.get(self.progress.segment) else {
            self.progress.rate = 0.0;
            return false;
        };
        let remaining = segment.length - self.progress.along;
        let braking = (segment.end_rate.powi(2) + 2.0 * self.rate_slope * remaining).sqrt();
        let rate = (self.progress.rate + self.rate_slope * dt_secs)
            .min(1.0)
            .min(braking);
        self.progress.rate = rate;
        self.progress.along += rate * dt_secs;
        // The last centimetre of an end at rest would take for ever: the square root above goes to zero with it.
        let done = segment.length - self.progress.along;
        if done <= rate * dt_secs || done <= 0.5 * self.rate_slope * dt_secs * dt_secs {
            self.progress.along = 0.0;
            self.progress.segment += 1;
        }
        true
    }
}

fn segment(from: &Pose2, to: &Pose2, limits: &BaseLimits) -> Option<Segment> {
    let translation = to.translation.vector - from.translation.vector;
    let turn = wrap_angle(to.rotation.angle() - from.rotation.angle());
    let length = (translation.norm() / limits.velocity_max_m_per_s)
        .max(turn.abs() / limits.yaw_rate_max_rad_per_s);
    (length > 1e-9).then_some(Segment {
        from: *from,
        translation,
        turn,
        length,
        end_rate: 0.0,
    })
}

/// Velocity along a segment at rate 1, in the path's frame, with the turn in metres ([`METRES_PER_RADIAN`]).
fn velocity_at_full_rate(segment: &Segment) -> Vector3<f64> {
    let linear = segment.translation / segment.length;
    Vector3::new(
        linear.x,
        linear.y,
        segment.turn / segment.length * METRES_PER_RADIAN,
    )
}

/// Sets the rate allowed at the end of each segment: corners first, then a sweep from each end for reachability; the
/// first is entered at `rate`.
fn set_corner_rates(segments: &mut [Segment], limits: &BaseLimits, rate_slope: f64, mut rate: f64) {
    for i in 1..segments.len() {
        let (a, b) = (
            velocity_at_full_rate(&segments[i - 1]),
            velocity_at_full_rate(&segments[i]),
        );
        segments[i - 1].end_rate = corner_rate(&a, &b, limits);
    }
    for i in (1..segments.len()).rev() {
        let reachable =
            (segments[i].end_rate.powi(2) + 2.0 * rate_slope * segments[i].length).sqrt();
        segments[i - 1].end_rate = segments[i - 1].end_rate.min(reachable);
    }
    for segment in segments {
        rate = (rate.powi(2) + 2.0 * rate_slope * segment.length).sqrt();
        segment.end_rate = segment.end_rate.min(rate);
        rate = segment.end_rate;
    }
}

/// Rate at which a corner between two unit-rate velocities may be passed: the base begins to change its velocity by Δv
/// at the corner and, at acceleration a, has left the path by Δv² / 2a when it is done.
fn corner_rate(a: &Vector3<f64>, b: &Vector3<f64>, limits: &BaseLimits) -> f64 {
    let jump = (b - a).norm();
    let jump_max = (2.0 * limits.acceleration_max_m_per_s2 * CORNER_DEVIATION_M).sqrt();
    if jump > jump_max {
        jump_max / jump
    } else {
        1.0
    }
}

fn pose_distance(a: &Pose2, b: &Pose2) -> f64 {
    let linear = (a.translation.vector - b.translation.vector).norm();
    let yaw = wrap_angle(a.rotation.angle() - b.rotation.angle()).abs();
    linear + METRES_PER_RADIAN * yaw
}
