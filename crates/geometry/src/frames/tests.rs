use super::*;
use approx::assert_abs_diff_eq;
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;

prop_compose! {
    fn rotation()(axis in prop::array::uniform3(-1.0..1.0f64), angle in -PI..PI) -> UnitQuaternion<f64> {
        let axis = Vector3::from(axis);
        nalgebra::Unit::try_new(axis, 1e-3)
            .map_or_else(UnitQuaternion::identity, |axis| UnitQuaternion::from_axis_angle(&axis, angle))
    }
}

prop_compose! {
    fn pose()(xyz in prop::array::uniform3(-100.0..100.0f64), rotation in rotation()) -> Pose {
        Pose::from_parts(Vector3::from(xyz).into(), rotation)
    }
}

/// The same rotation, whatever the sign of its quaternion.
fn assert_same(a: &Pose, b: &Pose, tolerance: f64) {
    let apart = (a.translation.vector - b.translation.vector).norm();
    let turned = a.rotation.angle_to(&b.rotation);
    // angle_to loses half the digits near 0; compare matrices instead.
    let matrix = (a.rotation.to_rotation_matrix().matrix()
        - b.rotation.to_rotation_matrix().matrix())
    .amax();
    assert!(
        apart <= tolerance && matrix <= tolerance,
        "{a} differs from {b}: {apart}, {turned}, {matrix}"
    );
}

proptest! {
    #[test]
    fn quaternion_components_round_trip(q in rotation()) {
        prop_assert!((quat_from_wxyz(wxyz_from_quat(&q)).unwrap().coords - q.coords).norm() < 1e-15);
        prop_assert!((quat_from_xyzw(xyzw_from_quat(&q)).unwrap().coords - q.coords).norm() < 1e-15);
        let [w, x, y, z] = wxyz_from_quat(&q);
        prop_assert_eq!(xyzw_from_quat(&q), [x, y, z, w]);
    }

    #[test]
    fn roll_pitch_yaw_round_trips(p in pose()) {
        let (xyz, rpy) = xyz_rpy_from_pose(&p);
        assert_same(&pose_from_xyz_rpy(xyz, rpy), &p, 1e-12);
        prop_assert!(rpy[1].abs() <= FRAC_PI_2);
    }

    #[test]
    fn roll_pitch_yaw_round_trips_around_its_singularity(
        roll in -PI..PI, yaw in -PI..PI, exponent in -17.0..-1.0f64, down in any::<bool>(), past in any::<bool>()
    ) {
        let off = 10f64.powf(exponent) * if past { 1.0 } else { -1.0 };
        let pitch = (FRAC_PI_2 + off) * if down { -1.0 } else { 1.0 };
        let p = pose_from_xyz_rpy([1.0, 2.0, 3.0], [roll, pitch, yaw]);
        let (xyz, rpy) = xyz_rpy_from_pose(&p);
        prop_assert!(rpy.iter().all(|v| v.is_finite()));
        assert_same(&pose_from_xyz_rpy(xyz, rpy), &p, 1e-11);
    }

    #[test]
    fn fixed_axis_order_is_roll_then_pitch_then_yaw(rpy in prop::array::uniform3(-1.5..1.5f64)) {
        let [r, p, y] = rpy;
        let expected = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), y)
            * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), p)
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), r);
        assert_same(&pose_from_xyz_rpy([0.0; 3], rpy), &Pose::from_parts(Vector3::zeros().into(), expected), 1e-14);
    }

    #[test]
    fn planar_poses_round_trip_and_compose(
        x in -9.0..9.0f64, y in -9.0..9.0f64, yaw in -PI..PI, x2 in -9.0..9.0f64, yaw2 in -PI..PI
    ) {
        let a = Pose2::new(nalgebra::Vector2::new(x, y), yaw);
        let b = Pose2::new(nalgebra::Vector2::new(x2, -y), yaw2);
        let lifted = planar_from_pose(&(pose_from_planar(&a, 0.7) * pose_from_planar(&b, 0.0)));
        let flat = a * b;
        prop_assert!((lifted.translation.vector - flat.translation.vector).norm() < 1e-12);
        prop_assert!(wrap_angle(lifted.rotation.angle() - flat.rotation.angle()).abs() < 1e-12);
    }

    #[test]
    fn wrapped_angles_are_in_range_and_equivalent(angle in -1e4..1e4f64) {
        let wrapped = wrap_angle(angle);
        prop_assert!(wrapped > -PI && wrapped <= PI);
        prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-9 && (wrapped.cos() - angle.cos()).abs() < 1e-9);
    }

    #[test]
    fn headset_poses_round_trip_and_compose(a in pose(), b in pose()) {
        assert_same(&ros_pose_from_xr(&xr_pose_from_ros(&a)), &a, 1e-12);
        // A change of axes is a homomorphism, so chains of frames survive it.
        assert_same(&ros_pose_from_xr(&(a * b)), &(ros_pose_from_xr(&a) * ros_pose_from_xr(&b)), 1e-11);
    }
}

#[test]
fn wrap_angle_keeps_pi_and_maps_minus_pi_to_it() {
    assert_eq!(wrap_angle(PI), PI);
    assert_eq!(wrap_angle(-PI), PI);
    assert_eq!(wrap_angle(0.0), 0.0);
    assert!(wrap_angle(f64::NAN).is_nan());
    assert!(wrap_angle(f64::INFINITY).is_nan());
}

#[test]
fn roll_is_zero_exactly_at_the_singularity() {
    for sign in [1.0, -1.0] {
        let r = Matrix3::new(0.0, -0.6, sign * 0.8, 0.0, 0.8, sign * 0.6, -sign, 0.0, 0.0);
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(r));
        let (_, rpy) = xyz_rpy_from_pose(&Pose::from_parts(Vector3::zeros().into(), rotation));
        assert_abs_diff_eq!(rpy[1], sign * FRAC_PI_2, epsilon = 1e-7);
        assert_abs_diff_eq!(rpy[2], 0.6f64.atan2(0.8), epsilon = 1e-7);
    }
}

#[test]
fn quaternions_that_are_none_are_refused_with_what_was_found() {
    let error = quat_from_wxyz([1.0, 1.0, 0.0, 0.0]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "quaternion wxyz [1.0, 1.0, 0.0, 0.0] has norm 1.4142135623730951, expected 1 within 0.001"
    );
    assert!(quat_from_xyzw([0.0; 4]).is_err());
    assert!(quat_from_xyzw([f64::NAN, 0.0, 0.0, 1.0]).is_err());
    assert!(quat_from_xyzw([0.0, 0.0, 0.0, f64::INFINITY]).is_err());
    // Six digits, as text files carry, are near enough, and are normalised.
    let q = quat_from_xyzw([0.0, 0.0, 0.600001, 0.8]).unwrap();
    assert_abs_diff_eq!(q.norm(), 1.0, epsilon = 1e-15);
}

#[test]
fn camera_axes_map_as_rep_103_says() {
    let q = body_from_optical();
    assert_abs_diff_eq!(q * Vector3::z(), Vector3::x(), epsilon = 1e-15); // forward
    assert_abs_diff_eq!(q * Vector3::x(), -Vector3::y(), epsilon = 1e-15); // right
    assert_abs_diff_eq!(q * Vector3::y(), -Vector3::z(), epsilon = 1e-15); // down
    assert_abs_diff_eq!(
        optical_from_body() * (q * Vector3::new(1.0, 2.0, 3.0)),
        Vector3::new(1.0, 2.0, 3.0),
        epsilon = 1e-15
    );
}

#[test]
fn headset_axes_map_forward_left_up() {
    let q = ros_from_xr_axes();
    assert_abs_diff_eq!(
        q * Vector3::new(0.0, 0.0, -1.0),
        Vector3::x(),
        epsilon = 1e-15
    ); // forward
    assert_abs_diff_eq!(
        q * Vector3::new(-1.0, 0.0, 0.0),
        Vector3::y(),
        epsilon = 1e-15
    ); // left
    assert_abs_diff_eq!(q * Vector3::y(), Vector3::z(), epsilon = 1e-15); // up
    assert_same(
        &ros_pose_from_xr(&Pose::identity()),
        &Pose::identity(),
        1e-15,
    );
    // A quarter turn about headset up is a quarter turn about our up.
    let xr = Pose::rotation(Vector3::y() * FRAC_PI_2);
    assert_same(
        &ros_pose_from_xr(&xr),
        &Pose::rotation(Vector3::z() * FRAC_PI_2),
        1e-15,
    );
}

#[test]
fn yaw_facing_looks_at_the_target() {
    let from = Point2::new(1.0, 1.0);
    assert_abs_diff_eq!(
        yaw_facing(&from, &Point2::new(1.0, 3.0)),
        FRAC_PI_2,
        epsilon = 1e-15
    );
    assert_abs_diff_eq!(
        yaw_facing(&from, &Point2::new(0.0, 1.0)),
        PI,
        epsilon = 1e-15
    );
    assert_eq!(yaw_facing(&from, &from), 0.0);
}

/// Bearings in Unity are atan2(dx, dz), clockwise; ours are the same headings, counter-clockwise.
#[test]
fn unity_is_our_mirror() {
    let unity = [1.0, 0.5, 2.0];
    let ours = point_from_unity(unity);
    assert_abs_diff_eq!(ours, Point3::new(2.0, -1.0, 0.5));
    assert_eq!(unity_from_point(&ours), unity);
    let bearing_unity = unity[0].atan2(unity[2]);
    let bearing = yaw_facing(&Point2::origin(), &ours.xy());
    assert_abs_diff_eq!(yaw_from_unity(bearing_unity), bearing, epsilon = 1e-15);
    assert_abs_diff_eq!(yaw_from_unity(3.0 * FRAC_PI_2), FRAC_PI_2, epsilon = 1e-15);
}
