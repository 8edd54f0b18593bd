//! Axis and quaternion conventions, all in this one place.
//!
//! Inside Factotum rotations are nalgebra types; components appear only at boundaries: `wxyz` in the
//! physics engine, `xyzw` on the wire and in ROS. Roll-pitch-yaw is fixed-axis X, Y, Z (REP-103):
//! `R = Rz(yaw) * Ry(pitch) * Rx(roll)`. Headset space (WebXR, OpenXR) is y up, -z forward. Unity's space is
//! left-handed: x right, y up, z forward.

use crate::{Pose, Pose2};
use nalgebra::{Matrix3, Point2, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};

/// Largest `| |q| - 1 |` accepted for a quaternion from outside: text files carry six or more digits.
pub const QUATERNION_NORM_TOLERANCE: f64 = 1e-3;

/// `cos(pitch)` below which roll and yaw are no longer separable in f64; roll is then set to 0.
const GIMBAL_COS_PITCH: f64 = 1e-12;

/// A rotation or pose from outside that is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The four components are not a unit quaternion.
    #[error(
        "quaternion {order} {components:?} has norm {norm}, expected 1 within {QUATERNION_NORM_TOLERANCE}"
    )]
    NotUnit {
        /// Order of the components, `wxyz` or `xyzw`.
        order: &'static str,
        /// The components as given.
        components: [f64; 4],
        /// Their Euclidean norm; NaN when a component is not finite.
        norm: f64,
    },
}

/// Rotation from components (w, x, y, z).
///
/// # Errors
/// [`FrameError::NotUnit`] when the norm differs from 1 by more than [`QUATERNION_NORM_TOLERANCE`].
pub fn quat_from_wxyz(wxyz: [f64; 4]) -> Result<UnitQuaternion<f64>, FrameError> {
    let [w, x, y, z] = wxyz;
    checked_quat(Quaternion::new(w, x, y, z), "wxyz", wxyz)
}

/// Components (w, x, y, z) of a rotation.
#[must_use]
pub fn wxyz_from_quat(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    [rotation.w, rotation.i, rotation.j, rotation.k]
}

/// Rotation from components (x, y, z, w).
///
/// # Errors
/// [`FrameError::NotUnit`] when the norm differs from 1 by more than [`QUATERNION_NORM_TOLERANCE`].
pub fn quat_from_xyzw(xyzw: [f64; 4]) -> Result<UnitQuaternion<f64>, FrameError> {
    let [x, y, z, w] = xyzw;
    checked_quat(Quaternion::new(w, x, y, z), "xyzw", xyzw)
}

/// Components (x, y, z, w) of a rotation.
#[must_use]
pub fn xyzw_from_quat(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    [rotation.i, rotation.j, rotation.k, rotation.w]
}

fn checked_quat(
    quaternion: Quaternion<f64>,
    order: &'static str,
    components: [f64; 4],
) -> Result<UnitQuaternion<f64>, FrameError> {
    let norm = quaternion.norm();
    if (norm - 1.0).abs() <= QUATERNION_NORM_TOLERANCE {
        Ok(UnitQuaternion::from_quaternion(quaternion))
    } else {
        Err(FrameError::NotUnit {
            order,
            components,
            norm,
        })
    }
}

/// Pose from a position (m) and fixed-axis roll, pitch, yaw (rad).
#[must_use]
pub fn pose_from_xyz_rpy(xyz: [f64; 3], rpy: [f64; 3]) -> Pose {
    let [roll, pitch, yaw] = rpy;
    Pose::from_parts(
        Vector3::from(xyz).into(),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// Position (m) and fixed-axis roll, pitch, yaw (rad) of a pose.
///
/// Pitch is in [-π/2, π/2], roll and yaw in (-π, π]. At pitch ±π/2 only a combination of roll and yaw
/// is defined: roll is then 0 and yaw carries the rest, so the pose is still reproduced.
#[must_use]
pub fn xyz_rpy_from_pose(pose: &Pose) -> ([f64; 3], [f64; 3]) {
    let r = pose.rotation.to_rotation_matrix();
    let cos_pitch = r[(2, 1)].hypot(r[(2, 2)]);
    let roll = if cos_pitch < GIMBAL_COS_PITCH {
        0.0
    } else {
        r[(2, 1)].atan2(r[(2, 2)])
    };
    // atan2 of both sides: asin alone loses half the digits near ±π/2.
    let pitch = (-r[(2, 0)]).atan2(cos_pitch);
    // Yaw from R * Rx(-roll) = Rz(yaw) * Ry(pitch), whose second column is (-sin yaw, cos yaw, 0) at any
    // pitch: near the singularity it takes up what rounding does to roll.
    let (sin_roll, cos_roll) = roll.sin_cos();
    let yaw = (r[(0, 2)] * sin_roll - r[(0, 1)] * cos_roll)
        .atan2(r[(1, 1)] * cos_roll - r[(1, 2)] * sin_roll);
    let rpy = [roll, pitch, yaw];
    (pose.translation.vector.into(), rpy)
}

/// The planar part (x, y, yaw) of a pose: z, roll and pitch are dropped.
///
/// Yaw is the heading of the body's x axis seen from above; when that axis is vertical, it is the
/// yaw of [`xyz_rpy_from_pose`] at its singularity.
#[must_use]
pub fn planar_from_pose(pose: &Pose) -> Pose2 {
    let ([x, y, _], [_, _, yaw]) = xyz_rpy_from_pose(pose);
    Pose2::new(nalgebra::Vector2::new(x, y), yaw)
}

/// The planar pose lifted to height `z_m`, level.
#[must_use]
pub fn pose_from_planar(planar: &Pose2, z_m: f64) -> Pose {
    let t = planar.translation.vector;
    pose_from_xyz_rpy([t.x, t.y, z_m], [0.0, 0.0, planar.rotation.angle()])
}

/// The same angle in (-π, π]; NaN and infinities give NaN.
#[must_use]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// Heading (rad) at `from` that looks at `to`; 0 when the two coincide.
#[must_use]
pub fn yaw_facing(from: &Point2<f64>, to: &Point2<f64>) -> f64 {
    let d = to - from;
    d.y.atan2(d.x)
}

/// A point given in Unity's left-handed axes (x right, y up, z forward), in ours (x forward, y left, z up).
///
/// The change of hands is a mirror, so it takes points and directions; rotations follow [`yaw_from_unity`].
#[must_use]
pub fn point_from_unity([right, up, forward]: [f64; 3]) -> Point3<f64> {
    Point3::new(forward, -right, up)
}

/// The inverse of [`point_from_unity`].
#[must_use]
pub fn unity_from_point(point: &Point3<f64>) -> [f64; 3] {
    [-point.y, point.z, point.x]
}

/// Our yaw, in (-π, π], of a heading about Unity's y axis (rad, clockwise from above, 0 along its z).
#[must_use]
pub fn yaw_from_unity(heading_rad: f64) -> f64 {
    wrap_angle(-heading_rad)
}

/// Rotation of a camera's optical frame (z forward, x right, y down) in its body frame (x forward, y left, z up).
#[must_use]
pub fn body_from_optical() -> UnitQuaternion<f64> {
    // Columns are the optical axes seen in the body: x = right = -y, y = down = -z, z = forward = x.
    axes([0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0])
}

/// Rotation of a camera's body frame in its optical frame; inverse of [`body_from_optical`].
#[must_use]
pub fn optical_from_body() -> UnitQuaternion<f64> {
    body_from_optical().inverse()
}

/// Rotation of headset axes (x right, y up, z backward) in ROS axes (x forward, y left, z up).
#[must_use]
pub fn ros_from_xr_axes() -> UnitQuaternion<f64> {
    // Columns: x = right = -y, y = up = z, z = backward = -x.
    axes([0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
}

/// Rotation of ROS axes in headset axes; inverse of [`ros_from_xr_axes`].
#[must_use]
pub fn xr_from_ros_axes() -> UnitQuaternion<f64> {
    ros_from_xr_axes().inverse()
}

/// A pose given in headset axes, re-expressed in ROS axes: both the space and the body change axes, so
/// a body that looks along its -z in the headset's space looks along its x in ours.
#[must_use]
pub fn ros_pose_from_xr(pose_xr: &Pose) -> Pose {
    let q = ros_from_xr_axes();
    Pose::from_parts(
        (q * pose_xr.translation.vector).into(),
        q * pose_xr.rotation * q.inverse(),
    )
}

/// A pose given in ROS axes, re-expressed in headset axes; inverse of [`ros_pose_from_xr`].
#[must_use]
pub fn xr_pose_from_ros(pose_ros: &Pose) -> Pose {
    let q = xr_from_ros_axes();
    Pose::from_parts(
        (q * pose_ros.translation.vector).into(),
        q * pose_ros.rotation * q.inverse(),
    )
}

/// Rotation from the rows of an exact, proper axis permutation.
fn axes(row_x: [f64; 3], row_y: [f64; 3], row_z: [f64; 3]) -> UnitQuaternion<f64> {
    let m = Matrix3::from_rows(&[row_x.into(), row_y.into(), row_z.into()]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(m))
}

#[cfg(test)]
mod tests;
