//! Jerk-limited timing of a joint path.
//!
//! The path is a chain of straight segments in joint space. Its corners are rounded by blends ([`Blend`]) that stay
//! within a given distance of the path and are crossed at constant speed along the path; on the straight
//! rest of each segment the speed follows a time-optimal jerk-limited profile (Berscheid & Kröger,
//! "Jerk-limited Real-time Trajectory Generation with Arbitrary Target States", RSS 2021, by `rsruckig`).
//! So the arm does not stop at corners, leaves the checked path nowhere by more than the given distance, and
//! keeps every joint's velocity, acceleration and jerk limit everywhere.
//!
//! A waypoint that occurs twice in a row is a stop: its corner is not rounded.
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | s | length along the path, Euclidean in joint values | rad (m) |
//! | u | unit tangent dq/ds of a segment | - |

mod blend;
mod profile;
mod simplify;

pub use blend::Blend;

use factotum_descriptions::{JointTrajectory, TrajectoryPoint};

use crate::error::MotionError;
use crate::joint_space::JointLimit;
use crate::robot::RobotModel;
use profile::{SpeedLimits, SpeedProfile, reachable_speed};

/// How a path is timed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimingOptions {
    /// Fraction of the velocity limits to use, in (0, 1]; accelerations scale with its square, jerks with its
    /// cube, so that the motion is the full-speed one slowed down.
    pub speed_scale: f64,
    /// Largest distance of a rounded corner from the path (rad, Euclidean in joint values); 0 stops at every corner.
    pub blend_deviation_rad: f64,
    /// Waypoints nearer than this to the straight line through their neighbours are left out (rad).
    pub simplify_rad: f64,
    /// Distance of the trajectory's points, seconds.
    pub sample_secs: f64,
}

impl Default for TimingOptions {
    fn default() -> Self {
        Self {
            speed_scale: 1.0,
            blend_deviation_rad: 0.02,
            simplify_rad: 5e-4,
            sample_secs: 0.01,
        }
    }
}

/// Times a joint path of the robot's chain at a fraction of its limits.
///
/// # Errors
/// [`MotionError`] if the path is empty, a waypoint has the wrong length or is not finite, or `speed_scale` is
/// not in (0, 1].
pub fn time_path(
    robot: &RobotModel,
    path: &[Vec<f64>],
    speed_scale: f64,
) -> Result<JointTrajectory, MotionError> {
    time_path_with(
        robot,
        path,
        &TimingOptions {
            speed_scale,
            ..TimingOptions::default()
        },
    )
}

/// Times a joint path of the robot's chain.
///
/// # Errors
/// As [`time_path`].
pub fn time_path_with(
    robot: &RobotModel,
    path: &[Vec<f64>],
    options: &TimingOptions,
) -> Result<JointTrajectory, MotionError> {
    time_joint_path(robot.chain_joints(), robot.limits(), path, options)
}

/// Times a joint path of any joints.
///
/// # Errors
/// As [`time_path`].
pub fn time_joint_path(
    joints: &[String],
    limits: &[JointLimit],
    path: &[Vec<f64>],
    options: &TimingOptions,
) -> Result<JointTrajectory, MotionError> {
    let motion = TimedMotion::new(limits, path, options)?;
    let n_steps = (motion.duration_secs() / options.sample_secs)
        .ceil()
        .max(1.0) as usize;
    let points = if motion.duration_secs() > 0.0 {
        (0..=n_steps)
            .map(|i| {
                let time_secs = motion.duration_secs() * i as f64 / n_steps as f64;
                motion.at(time_secs)
            })
            .collect()
    } else {
        vec![motion.at(0.0)]
    };
    Ok(JointTrajectory::new(joints.to_vec(), points)?)
}

/// A timed path in closed form.
#[derive(Debug)]
pub struct TimedMotion {
    pieces: Vec<Piece>,
    end: Vec<f64>,
}

/// A part of the motion, with the time at which it begins.
#[derive(Debug)]
struct Piece {
    start_secs: f64,
    duration_secs: f64,
    kind: PieceKind,
}

#[derive(Debug)]
enum PieceKind {
    Straight {
        from: Vec<f64>,
        direction: Vec<f64>,
        profile: SpeedProfile,
    },
    Corner {
        blend: Blend,
        speed: f64,
    },
}

/// A straight segment of the path.
struct Segment {
    from: Vec<f64>,
    direction: Vec<f64>,
    length: f64,
    limits: SpeedLimits,
}

impl TimedMotion {
    /// Times a path.
    ///
    /// # Errors
    /// As [`time_path`].
    pub fn new(
        limits: &[JointLimit],
        path: &[Vec<f64>],
        options: &TimingOptions,
    ) -> Result<Self, MotionError> {
        check(limits, path, options)?;
        let limits: Vec<JointLimit> = limits
            .iter()
            .map(|limit| scaled(limit, options.speed_scale))
            .collect();
        // 1. Segments, and which of their joints are stops.
        let (segments, is_stop) = segments_of(&limits, path, options.simplify_rad);
        let Some(last) = segments.last() else {
            return Ok(Self {
                pieces: Vec::new(),
                end: path[0].clone(),
            });
        };
        let end = point_on(last, last.length);
        // 2. Corners: how far they reach into their segments and how fast they may be crossed.
        let corners = corners_of(&segments, &is_stop, options.blend_deviation_rad);
        // 3. Speeds at the corners that the straight parts between them can reach and brake from.
        let reach = |i: usize| corners[i].as_ref().map_or(0.0, Blend::reach);
        let straight: Vec<f64> = (0..segments.len())
            .map(|i| (segments[i].length - reach(i) - reach(i + 1)).max(0.0))
            .collect();
        let mut speeds: Vec<f64> = corners
            .iter()
            .map(|corner| {
                corner
                    .as_ref()
                    .map_or(0.0, |blend| blend.speed_max(&limits))
            })
            .collect();
        for i in 0..segments.len() {
            speeds[i + 1] =
                speeds[i + 1].min(reachable_speed(speeds[i], straight[i], &segments[i].limits));
        }
        for i in (0..segments.len()).rev() {
            speeds[i] = speeds[i].min(reachable_speed(
                speeds[i + 1],
                straight[i],
                &segments[i].limits,
            ));
        }
        // 4. The pieces, one after another.
        let mut pieces = Vec::with_capacity(2 * segments.len());
        let mut start_secs = 0.0;
        let mut add = |duration_secs: f64, kind: PieceKind| {
            pieces.push(Piece {
                start_secs,
                duration_secs,
                kind,
            });
            start_secs += duration_secs;
        };
        for (i, segment) in segments.iter().enumerate() {
            let [speed_from, speed_to] = [speeds[i], speeds[i + 1]];
            let profile = SpeedProfile::new(straight[i], speed_from, speed_to, &segment.limits)?;
            let from = point_on(segment, reach(i));
            let direction = segment.direction.clone();
            add(
                profile.duration_secs(),
                PieceKind::Straight {
                    from,
                    direction,
                    profile,
                },
            );
            if let Some(blend) = &corners[i + 1] {
                let corner = PieceKind::Corner {
                    blend: blend.clone(),
                    speed: speed_to,
                };
                add(blend.length() / speed_to, corner);
            }
        }
        Ok(Self { pieces, end })
    }

    /// Duration, seconds.
    pub fn duration_secs(&self) -> f64 {
        self.pieces
            .last()
            .map_or(0.0, |piece| piece.start_secs + piece.duration_secs)
    }

    /// Positions and velocities at a time.
    pub fn at(&self, time_secs: f64) -> TrajectoryPoint {
        let idx = self
            .pieces
            .partition_point(|piece| piece.start_secs <= time_secs);
        let Some(piece) = idx.checked_sub(1).map(|idx| &self.pieces[idx]) else {
            let velocities = vec![0.0; self.end.len()];
            return TrajectoryPoint {
                time_secs,
                positions: self.end.clone(),
                velocities,
            };
        };
        let local_secs = (time_secs - piece.start_secs).clamp(0.0, piece.duration_secs);
        let (positions, velocities) = match &piece.kind {
            PieceKind::Straight {
                from,
                direction,
                profile,
            } => {
                let (s, speed) = profile.at(local_secs);
                (
                    from.iter()
                        .zip(direction)
                        .map(|(from, u)| from + s * u)
                        .collect(),
                    direction.iter().map(|u| speed * u).collect(),
                )
            }
            PieceKind::Corner { blend, speed } => {
                let (q, tangent) = blend.at(speed * local_secs);
                (q, tangent.iter().map(|u| speed * u).collect())
            }
        };
        TrajectoryPoint {
            time_secs,
            positions,
            velocities,
        }
    }
}

fn check(
    limits: &[JointLimit],
    path: &[Vec<f64>],
    options: &TimingOptions,
) -> Result<(), MotionError> {
    let value = |what, found: f64, wanted| {
        Err(MotionError::Value {
            what,
            found: found.to_string(),
            wanted,
        })
    };
    if path.is_empty() {
        return value("number of waypoints", 0.0, "at least one");
    }
    for q in path {
        if q.len() != limits.len() {
            return Err(MotionError::Width {
                what: "waypoint",
                found: q.len(),
                wanted: limits.len(),
            });
        }
        if let Some(&found) = q.iter().find(|q| !q.is_finite()) {
            return Err(MotionError::NotFinite {
                what: "position in a waypoint",
                found,
            });
        }
    }
    if !(options.speed_scale > 0.0 && options.speed_scale <= 1.0) {
        return value("speed_scale", options.speed_scale, "in (0, 1]");
    }
    if !(options.blend_deviation_rad >= 0.0 && options.blend_deviation_rad.is_finite()) {
        return value(
            "blend_deviation_rad",
            options.blend_deviation_rad,
            "zero or positive",
        );
    }
    if !(options.sample_secs > 0.0 && options.sample_secs.is_finite()) {
        return value("sample_secs", options.sample_secs, "positive");
    }
    Ok(())
}

fn scaled(limit: &JointLimit, speed_scale: f64) -> JointLimit {
    JointLimit {
        velocity: limit.velocity * speed_scale,
        acceleration: limit.acceleration * speed_scale.powi(2),
        jerk: limit.jerk * speed_scale.powi(3),
        ..*limit
    }
}

/// Segments shorter than this are waypoints that occur twice.
const LENGTH_ZERO: f64 = 1e-9;

/// The segments, and for each of their ends (first start included) whether the motion stops there.
fn segments_of(
    limits: &[JointLimit],
    path: &[Vec<f64>],
    simplify_rad: f64,
) -> (Vec<Segment>, Vec<bool>) {
    let (path, is_stop_at_waypoint) = simplify::simplify(path, simplify_rad, LENGTH_ZERO);
    let segments: Vec<Segment> = path
        .windows(2)
        .map(|pair| {
            let difference: Vec<f64> = pair[1].iter().zip(&pair[0]).map(|(b, a)| b - a).collect();
            let length = difference.iter().map(|d| d * d).sum::<f64>().sqrt();
            let direction: Vec<f64> = difference.iter().map(|d| d / length).collect();
            let limits = SpeedLimits::along(&direction, limits);
            Segment {
                from: pair[0].clone(),
                direction,
                length,
                limits,
            }
        })
        .collect();
    (segments, is_stop_at_waypoint)
}

/// The blend at each segment end (first start included), or nothing where the motion stops.
fn corners_of(segments: &[Segment], is_stop: &[bool], deviation: f64) -> Vec<Option<Blend>> {
    let mut corners = vec![None];
    for (i, pair) in segments.windows(2).enumerate() {
        let (a, b) = (&pair[0], &pair[1]);
        // Half of each segment belongs to each of its ends.
        let reach_max = 0.5 * a.length.min(b.length);
        let blend = (!is_stop[i + 1])
            .then(|| Blend::new(&b.from, &a.direction, &b.direction, reach_max, deviation))
            .flatten();
        corners.push(blend);
    }
    corners.push(None);
    corners
}

fn point_on(segment: &Segment, s: f64) -> Vec<f64> {
    segment
        .from
        .iter()
        .zip(&segment.direction)
        .map(|(from, u)| from + s * u)
        .collect()
}

#[cfg(test)]
mod tests;
