//! Interpolation of timed tool poses.

use factotum_control::tool_path::TimedPoses;
use factotum_geometry::Pose;
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;

fn pose(x: f64, yaw: f64) -> Pose {
    Pose::new(Vector3::new(x, 0.1, 0.2), Vector3::z() * yaw)
}

#[test]
fn half_way_is_half_way() {
    let path = TimedPoses::new(vec![(0.0, pose(0.0, 0.0)), (2.0, pose(1.0, 1.0))]).unwrap();
    let middle = path.sample(1.0);
    assert!((middle.base_from_tcp.translation.x - 0.5).abs() < 1e-12);
    assert!((middle.base_from_tcp.rotation.angle() - 0.5).abs() < 1e-12);
    assert!((middle.velocity[0] - 0.5).abs() < 1e-12 && (middle.velocity[5] - 0.5).abs() < 1e-12);
}

#[test]
fn it_rests_before_and_after() {
    let path = TimedPoses::new(vec![(0.5, pose(0.0, 0.0)), (1.0, pose(1.0, 1.0))]).unwrap();
    for (time_secs, x) in [(-1.0, 0.0), (0.2, 0.0), (1.0, 1.0), (9.0, 1.0)] {
        let sample = path.sample(time_secs);
        assert_eq!(sample.base_from_tcp.translation.x, x);
        assert_eq!(sample.velocity.norm(), 0.0);
    }
}

#[test]
fn nonsense_is_refused() {
    let error = |poses| TimedPoses::new(poses).unwrap_err().to_string();
    assert_eq!(
        error(vec![]),
        "tool path is empty, expected at least one pose"
    );
    assert_eq!(
        error(vec![(1.0, pose(0.0, 0.0)), (0.5, pose(0.0, 0.0))]),
        "tool path is at 0.5 s at pose 1, after 1 s, expected times that start at 0 or later and never decrease"
    );
    assert_eq!(
        error(vec![(f64::NAN, pose(0.0, 0.0))]),
        "tool path is not finite at pose 0, expected finite numbers"
    );
}

proptest! {
    #[test]
    fn the_velocity_is_the_derivative(x in -1.0..1.0_f64, axis in prop::array::uniform3(-1.0..1.0_f64), t in 0.1..1.9_f64) {
        let end = Pose::from_parts(
            Vector3::new(x, 0.3, -x).into(),
            UnitQuaternion::from_scaled_axis(Vector3::from(axis)),
        );
        let path = TimedPoses::new(vec![(0.0, pose(0.0, 0.2)), (2.0, end)]).unwrap();
        let h = 1e-5;
        let (before, now, after) = (path.sample(t - h), path.sample(t), path.sample(t + h));
        let linear = (after.base_from_tcp.translation.vector - before.base_from_tcp.translation.vector) / (2.0 * h);
        let turn = after.base_from_tcp.rotation * before.base_from_tcp.rotation.inverse();
        let angular = turn.scaled_axis() / (2.0 * h);
        prop_assert!((linear - now.velocity.fixed_rows::<3>(0)).norm() < 1e-6);
        prop_assert!((angular - now.velocity.fixed_rows::<3>(3)).norm() < 1e-5);
    }
}
