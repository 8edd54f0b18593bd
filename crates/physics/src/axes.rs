//! MuJoCo's conventions and ours: quaternions are (w, x, y, z) there; its cameras look along −z with
//! y up, while optical frames (REP-103) look along +z with x right and y down.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use crate::Pose;

/// Rotation of the optical frame (z forward, x right, y down) in MuJoCo's camera frame.
const HALF_TURN_ABOUT_X: [f64; 4] = [0.0, 1.0, 0.0, 0.0];

/// A unit quaternion from MuJoCo's order (w, x, y, z); normalised, identity when it is zero.
pub fn quat_from_wxyz(wxyz: [f64; 4]) -> UnitQuaternion<f64> {
    let [w, x, y, z] = wxyz;
    UnitQuaternion::try_new(Quaternion::new(w, x, y, z), f64::MIN_POSITIVE)
        .unwrap_or_else(UnitQuaternion::identity)
}

/// MuJoCo's order (w, x, y, z) of a unit quaternion.
pub fn wxyz_from_quat(quat: &UnitQuaternion<f64>) -> [f64; 4] {
    [quat.w, quat.i, quat.j, quat.k]
}

/// A pose from MuJoCo's position and quaternion (w, x, y, z).
pub fn pose_from_mujoco(pos: [f64; 3], wxyz: [f64; 4]) -> Pose {
    Pose::from_parts(Translation3::from(pos), quat_from_wxyz(wxyz))
}

/// A pose from MuJoCo's position and row-major rotation matrix.
pub(crate) fn pose_from_pos_mat(pos: &[f64], mat: &[f64]) -> Pose {
    let rotation =
        nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_row_slice(mat));
    Pose::from_parts(
        Translation3::new(pos[0], pos[1], pos[2]),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

/// The optical frame (z forward, x right, y down) of a MuJoCo camera frame (−z forward, y up).
pub fn world_from_optical(world_from_mujoco_camera: &Pose) -> Pose {
    world_from_mujoco_camera * quat_from_wxyz(HALF_TURN_ABOUT_X)
}

/// The optical frame (z forward, x right, y down) of a frame in body convention (x forward, y left,
/// z up), REP-103.
pub fn world_from_optical_of_body_frame(world_from_camera: &Pose) -> Pose {
    // Columns: the optical axes x (right), y (down), z (forward) in the body frame.
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
        0.0, 0.0, 1.0, //
        -1.0, 0.0, 0.0, //
        0.0, -1.0, 0.0,
    ));
    world_from_camera * UnitQuaternion::from_rotation_matrix(&rotation)
}
