//! How much of a wished velocity is safe: so much that the base, told nothing more, comes to rest clear of everything.
//!
//! The way ahead is computed with the base's own limits on speed and acceleration: from its present velocity it goes for
//! the wished one for [`REACT_SECS`], then brakes. The wish's translation is scaled down until this way stays clear.
//! These are the admissible velocities of Fox, Burgard and Thrun ("The dynamic window approach to collision avoidance",
//! IEEE Robotics & Automation Magazine 4(1), 1997, eq. 14). Where we differ: one line of velocities is searched, the
//! wished one's, since a person chooses the direction; and the way there is not taken for a circle's arc.
//!
//! Turning is left as it is: the footprint is a circle about the axis of the turn.
//!
//! Frames: velocities (m/s, m/s, rad/s) and points (m) are in the base frame of now.

use factotum_control::base_tracking::BaseLimits;
use factotum_geometry::Pose2;
use nalgebra::{Point2, Rotation2, Vector2, Vector3};

/// Time for which a wish may go on unheard: as long as a command is valid, and as old as a scan may be, seconds.
const REACT_SECS: f64 = 0.4;
/// Step along the way, seconds: at half a metre a second, 2.5 cm.
const STEP_SECS: f64 = 0.05;
/// Steps after which a base counts as one that never comes to rest.
const N_STEPS_MAX: usize = 200;
/// Shares of the wish that are tried.
const N_SHARES: u32 = 10;

/// What is left of a wished velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SafeVelocity {
    /// The velocity that may be commanded.
    pub(crate) velocity: Vector3<f64>,
    /// What the whole wish would have come too near to, if anything.
    pub(crate) obstacle: Option<Point2<f64>>,
}

/// The largest share of a wish with which the base's middle stays `keep_m` away from every obstacle.
///
/// A base that stands nearer than that already may go where it comes no nearer.
pub(crate) fn safe_velocity(
    limits: &BaseLimits,
    velocity_now: &Vector3<f64>,
    wished: &Vector3<f64>,
    obstacles: &[Point2<f64>],
    keep_m: f64,
) -> SafeVelocity {
    /// Rounding, metres.
    const NEARER_M: f64 = 1e-9;
    let distance_now_m = obstacles
        .iter()
        .map(|obstacle| obstacle.coords.norm())
        .fold(f64::INFINITY, f64::min);
    let keep_m = keep_m.min(distance_now_m) - NEARER_M;
    let met_with = |share: f64| {
        let velocity = Vector3::new(share * wished.x, share * wished.y, wished.z);
        let met = first_met(&way(limits, velocity_now, &velocity), obstacles, keep_m);
        (velocity, met)
    };
    let (velocity, obstacle) = met_with(1.0);
    if obstacle.is_none() {
        return SafeVelocity { velocity, obstacle };
    }
    let clear = (1..N_SHARES)
        .rev()
        .map(|share| met_with(f64::from(share) / f64::from(N_SHARES)))
        .find(|(_, met)| met.is_none());
    SafeVelocity {
        velocity: clear.map_or(Vector3::new(0.0, 0.0, wished.z), |(velocity, _)| velocity),
        obstacle,
    }
}

/// Where the base will be while it goes for a velocity and then brakes, until it rests.
fn way(limits: &BaseLimits, velocity_now: &Vector3<f64>, wished: &Vector3<f64>) -> Vec<Pose2> {
    /// Slower than this is at rest, m/s and rad/s.
    const STILL: f64 = 1e-3;
    let n_react = (REACT_SECS / STEP_SECS).round() as usize;
    let (mut base_now_from_base, mut velocity) = (Pose2::identity(), *velocity_now);
    let mut poses = Vec::new();
    for step in 0..N_STEPS_MAX {
        let is_braking = step >= n_react;
        let goal = if is_braking {
            Vector3::zeros()
        } else {
            *wished
        };
        velocity = limits.limit(goal, velocity, STEP_SECS);
        if is_braking && velocity.norm() < STILL {
            break;
        }
        let turn_rad = velocity.z * STEP_SECS;
        let shift: Vector2<f64> = Rotation2::new(turn_rad / 2.0) * velocity.xy() * STEP_SECS;
        base_now_from_base *= Pose2::new(shift, turn_rad);
        poses.push(base_now_from_base);
    }
    poses
}

/// The obstacle that the way first comes nearer to than `keep_m`.
fn first_met(way: &[Pose2], obstacles: &[Point2<f64>], keep_m: f64) -> Option<Point2<f64>> {
    way.iter().find_map(|pose| {
        obstacles
            .iter()
            .find(|obstacle| (obstacle.coords - pose.translation.vector).norm() < keep_m)
            .copied()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEEP_M: f64 = 0.35;
    const LIMITS: BaseLimits = BaseLimits {
        velocity_max_m_per_s: 0.5,
        yaw_rate_max_rad_per_s: 0.8,
        acceleration_max_m_per_s2: 0.5,
    };

    /// A wall across the way, `ahead_m` ahead.
    fn wall(ahead_m: f64) -> Vec<Point2<f64>> {
        let across = -100..=100;
        across
            .map(|i| Point2::new(ahead_m, 0.02 * f64::from(i)))
            .collect()
    }

    /// Drives with a wish that is guarded ten times a second; where the base rests in the end.
    fn drive(wished: Vector3<f64>, obstacles: &[Point2<f64>], secs: f64) -> (Pose2, f64) {
        const DT_SECS: f64 = 0.01;
        let (mut pose, mut velocity, mut command) = (Pose2::identity(), Vector3::zeros(), wished);
        let mut nearest_m = f64::INFINITY;
        for step in 0..(secs / DT_SECS) as usize {
            if step % 10 == 0 {
                let seen: Vec<_> = obstacles.iter().map(|p| pose.inverse() * p).collect();
                command = safe_velocity(&LIMITS, &velocity, &wished, &seen, KEEP_M).velocity;
            }
            velocity = LIMITS.limit(command, velocity, DT_SECS);
            pose *= Pose2::new(velocity.xy() * DT_SECS, velocity.z * DT_SECS);
            for obstacle in obstacles {
                nearest_m = nearest_m.min((obstacle.coords - pose.translation.vector).norm());
            }
        }
        (pose, nearest_m)
    }

    #[test]
    fn in_the_open_every_wish_is_granted() {
        for wished in [Vector3::new(0.5, 0.0, 0.0), Vector3::new(-0.2, 0.3, 0.8)] {
            let safe = safe_velocity(&LIMITS, &Vector3::zeros(), &wished, &wall(5.0), KEEP_M);
            assert_eq!(safe.velocity, wished);
            assert_eq!(safe.obstacle, None);
        }
    }

    #[test]
    fn whoever_drives_at_a_wall_comes_near_and_not_too_near() {
        /// The way ahead and the drive are summed in steps of different length, metres.
        const STEPS_M: f64 = 1e-3;
        for wished in [
            Vector3::new(0.5, 0.0, 0.0),
            Vector3::new(0.35, 0.35, 0.0),
            Vector3::new(0.5, 0.0, 0.3),
        ] {
            let (_, nearest_m) = drive(wished, &wall(1.5), 12.0);
            assert!(
                (KEEP_M - STEPS_M..KEEP_M + 0.1).contains(&nearest_m),
                "{nearest_m} m with {wished:?}"
            );
        }
    }

    #[test]
    fn who_stands_too_near_may_turn_and_leave_and_not_come_nearer() {
        let still = Vector3::zeros();
        let near = wall(0.32);
        let wish = |wished| safe_velocity(&LIMITS, &still, &wished, &near, KEEP_M);
        let away = Vector3::new(-0.3, 0.0, 0.5);
        assert_eq!(wish(away).velocity, away);
        let nearer = wish(Vector3::new(0.1, 0.0, 0.5));
        assert_eq!(nearer.velocity, Vector3::new(0.0, 0.0, 0.5));
        assert!(nearer.obstacle.is_some_and(|at| at.x == 0.32));
    }

    #[test]
    fn the_present_speed_counts() {
        let wall = wall(0.9);
        let wished = Vector3::new(0.5, 0.0, 0.0);
        let slow = safe_velocity(&LIMITS, &Vector3::zeros(), &wished, &wall, KEEP_M);
        assert_eq!(slow.obstacle, None);
        let fast = safe_velocity(&LIMITS, &wished, &wished, &wall, KEEP_M);
        assert!(fast.obstacle.is_none());
        let near = safe_velocity(&LIMITS, &wished, &wished, &self::wall(0.7), KEEP_M);
        assert!(near.velocity.x < 0.5, "{near:?}");
    }
}
