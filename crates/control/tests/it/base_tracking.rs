//! Following paths with an ideal base, whose velocity is the command.

use factotum_control::base_tracking::{BaseLimits, BaseTracker, GoalTolerance, TrackState};
use factotum_geometry::Pose2;
use factotum_geometry::frames::wrap_angle;
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;

const STEP_SECS: f64 = 0.002;
const LIMITS: BaseLimits = BaseLimits {
    velocity_max_m_per_s: 0.5,
    yaw_rate_max_rad_per_s: 1.0,
    acceleration_max_m_per_s2: 0.5,
};

fn pose(x: f64, y: f64, yaw: f64) -> Pose2 {
    Pose2::new(Vector2::new(x, y), yaw)
}

struct Drive {
    state: TrackState,
    secs: f64,
    end: Pose2,
    off_path_m: f64,
    speed_max: f64,
    acceleration_max: f64,
}

/// Drives a path; `blocked_after_secs` stops the base whatever is commanded.
fn drive(path: &[Pose2], blocked_after_secs: f64) -> Drive {
    drive_sent_anew(path, blocked_after_secs, f64::INFINITY)
}

/// As [`drive`]; the end of the path is sent anew every so many seconds.
fn drive_sent_anew(path: &[Pose2], blocked_after_secs: f64, period_secs: f64) -> Drive {
    let mut base = pose(0.0, 0.0, 0.0);
    let mut tracker = BaseTracker::new(base, Vector3::zeros(), path, LIMITS).unwrap();
    let mut command = Vector3::zeros();
    let mut velocity = Vector2::zeros();
    let mut result = Drive {
        state: TrackState::Driving,
        secs: 0.0,
        end: base,
        off_path_m: 0.0,
        speed_max: 0.0,
        acceleration_max: 0.0,
    };
    let mut sent_secs = 0.0;
    while result.state == TrackState::Driving && result.secs < 200.0 {
        if result.secs - sent_secs > period_secs {
            tracker = BaseTracker::new(base, command, &path[path.len() - 1..], LIMITS).unwrap();
            sent_secs = result.secs;
        }
        let velocity_before = velocity;
        (command, result.state) =
            tracker.step(&base, command, &GoalTolerance::default(), STEP_SECS);
        result.speed_max = result.speed_max.max(command.xy().norm());
        velocity = base.rotation * command.xy();
        result.acceleration_max = result
            .acceleration_max
            .max((velocity - velocity_before).norm() / STEP_SECS);
        if result.secs < blocked_after_secs {
            let linear = base.rotation * command.xy() * STEP_SECS;
            let yaw = base.rotation.angle() + command.z * STEP_SECS;
            base = Pose2::new(base.translation.vector + linear, yaw);
        }
        let corners: Vec<Vector2<f64>> = std::iter::once(Vector2::zeros())
            .chain(path.iter().map(|pose| pose.translation.vector))
            .collect();
        let off = corners
            .windows(2)
            .map(|pair| distance_to_segment(base.translation.vector, pair[0], pair[1]))
            .fold(f64::INFINITY, f64::min);
        result.off_path_m = result.off_path_m.max(off);
        result.secs += STEP_SECS;
    }
    result.end = base;
    result
}

fn distance_to_segment(p: Vector2<f64>, a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    let along = b - a;
    let t = if along.norm() > 0.0 {
        ((p - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + along * t - p).norm()
}

#[test]
fn a_straight_path_takes_about_its_length_over_the_speed() {
    let result = drive(&[pose(3.0, 0.0, 0.0)], f64::INFINITY);
    assert_eq!(result.state, TrackState::Arrived);
    // 6 s at full speed, and 1.7 s for starting and stopping at six tenths of 0.5 m/s².
    assert!((7.4..8.8).contains(&result.secs), "{} s", result.secs);
}

#[test]
fn a_path_sent_anew_is_gone_on_with_at_speed() {
    let path = [pose(3.0, 0.0, 1.0)];
    let once = drive(&path, f64::INFINITY);
    let anew = drive_sent_anew(&path, f64::INFINITY, 0.5);
    assert_eq!(anew.state, TrackState::Arrived);
    assert!(
        anew.secs < once.secs + 0.5,
        "{} s and {} s",
        anew.secs,
        once.secs
    );
    assert!(anew.acceleration_max <= 1.01 * LIMITS.acceleration_max_m_per_s2);
}

#[test]
fn corners_and_turns_keep_the_path_within_two_centimetres() {
    let path = [
        pose(1.0, 0.0, 0.0),
        pose(1.0, 1.0, 1.57),
        pose(0.2, 1.0, 3.1),
        pose(0.2, 1.0, -2.0),
    ];
    let result = drive(&path, f64::INFINITY);
    assert_eq!(result.state, TrackState::Arrived);
    assert!(result.off_path_m < 0.02, "{} m", result.off_path_m);
}

#[test]
fn a_base_that_is_held_gives_up() {
    let result = drive(&[pose(3.0, 0.0, 0.0)], 2.0);
    let TrackState::Stuck { remaining_m } = result.state else {
        panic!("{:?}", result.state)
    };
    assert!((1.5..2.9).contains(&remaining_m), "{remaining_m} m");
    assert!(result.secs < 8.0, "{} s", result.secs);
}

#[test]
fn a_base_at_its_goal_has_arrived() {
    let result = drive(&[pose(0.0, 0.0, 0.0)], f64::INFINITY);
    assert_eq!(result.state, TrackState::Arrived);
    assert!(result.secs < 0.1);
}

#[test]
fn nonsense_is_refused() {
    let here = pose(0.0, 0.0, 0.0);
    let error = BaseTracker::new(here, Vector3::zeros(), &[], LIMITS).unwrap_err();
    assert_eq!(
        error.to_string(),
        "base path is empty, expected at least one pose"
    );
    assert!(BaseTracker::new(here, Vector3::zeros(), &[pose(f64::NAN, 0.0, 0.0)], LIMITS).is_err());
    assert!(BaseTracker::new(here, Vector3::zeros(), &[here], LIMITS.scaled(0.0)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn any_path_is_followed_within_limits(
        points in prop::collection::vec((-2.0..2.0_f64, -2.0..2.0_f64, -3.0..3.0_f64), 1..6),
    ) {
        let path: Vec<Pose2> = points.iter().map(|&(x, y, yaw)| pose(x, y, yaw)).collect();
        let result = drive(&path, f64::INFINITY);
        let end = path[path.len() - 1];
        prop_assert_eq!(result.state, TrackState::Arrived);
        prop_assert!(result.off_path_m < 0.02, "{} m off", result.off_path_m);
        prop_assert!((result.end.translation.vector - end.translation.vector).norm() < 0.01);
        prop_assert!(wrap_angle(result.end.rotation.angle() - end.rotation.angle()).abs() < 0.02);
        prop_assert!(result.speed_max <= LIMITS.velocity_max_m_per_s * 1.0001);
        prop_assert!(result.acceleration_max <= LIMITS.acceleration_max_m_per_s2 * 1.001);
    }
}
