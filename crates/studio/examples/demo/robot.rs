//! The drawn robot: an omnidirectional base, a torso, a head and an arm of two links and a hand.

use std::f64::consts::{FRAC_PI_2, PI};

use factotum_protocol::{
    Body, BodyPose, Geometry, JointPosition, Pose, PosePlanar, Scene, SceneSource, Shape,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::home::{at, ball, post};

const SHOULDER: [f64; 3] = [0.12, -0.2, 1.0];
const UPPER_M: f64 = 0.42;
const FORE_M: f64 = 0.40;
const HAND_M: f64 = 0.2;

const SHELL: [f32; 4] = [0.93, 0.94, 0.95, 1.0];
const DARK: [f32; 4] = [0.17, 0.20, 0.23, 1.0];
const ACCENT: [f32; 4] = [0.10, 0.45, 0.70, 1.0];

/// Joints of the arm: shoulder yaw and pitch, elbow, wrist; all in radians.
pub(crate) type Arm = [f64; 4];

/// Folded for driving.
pub(crate) const TUCKED: Arm = [0.0, 0.35, 2.3, -0.6];

pub(crate) fn scene() -> Scene {
    let capsule = |length: f64, radius_m: f64, rgba| Shape {
        geometry: Geometry::Capsule {
            radius_m,
            half_length_m: length / 2.0,
        },
        pose: at([0.0, 0.0, length / 2.0]),
        rgba,
    };
    let cuboid = |position, half_extents_m, rgba| Shape {
        geometry: Geometry::Box { half_extents_m },
        pose: at(position),
        rgba,
    };
    let links = [
        (
            "base_link",
            vec![
                post([0.0, 0.0, 0.03], 0.34, 0.06, DARK),
                post([0.0, 0.0, 0.09], 0.33, 0.2, SHELL),
                post([0.0, 0.0, 0.29], 0.31, 0.03, DARK),
                post([0.0, 0.0, 0.17], 0.332, 0.02, ACCENT),
            ],
        ),
        (
            "torso",
            vec![
                cuboid([-0.05, 0.0, 0.62], [0.12, 0.14, 0.32], SHELL),
                cuboid([-0.05, 0.0, 0.98], [0.10, 0.20, 0.07], SHELL),
                cuboid([0.072, 0.0, 0.7], [0.005, 0.08, 0.14], DARK),
                ball([0.12, -0.2, 1.0], 0.085, DARK),
            ],
        ),
        (
            "head",
            vec![
                post([-0.03, 0.0, 1.05], 0.04, 0.1, DARK),
                cuboid([0.0, 0.0, 1.21], [0.08, 0.12, 0.07], SHELL),
                cuboid([0.078, 0.0, 1.21], [0.008, 0.10, 0.045], DARK),
                ball([0.085, 0.045, 1.21], 0.018, ACCENT),
                ball([0.085, -0.045, 1.21], 0.018, ACCENT),
            ],
        ),
        (
            "arm/upper",
            vec![
                capsule(UPPER_M, 0.055, SHELL),
                ball([0.0, 0.0, UPPER_M], 0.065, ACCENT),
            ],
        ),
        (
            "arm/fore",
            vec![
                capsule(FORE_M, 0.045, SHELL),
                ball([0.0, 0.0, FORE_M], 0.052, ACCENT),
            ],
        ),
        (
            "arm/hand",
            vec![
                post([0.0, 0.0, 0.02], 0.04, 0.08, DARK),
                cuboid([0.0, 0.045, 0.15], [0.012, 0.008, 0.05], DARK),
                cuboid([0.0, -0.045, 0.15], [0.012, 0.008, 0.05], DARK),
            ],
        ),
    ];
    let bodies = links.into_iter().map(|(name, shapes)| Body {
        name: name.to_owned(),
        pose: Pose::IDENTITY,
        shapes,
    });
    Scene {
        source: SceneSource::Robot,
        bodies: bodies.collect(),
    }
}

/// World from each link.
pub(crate) fn poses(base: PosePlanar, arm: Arm) -> Vec<BodyPose> {
    let world_from_base =
        Isometry3::new(Vector3::new(base.x, base.y, 0.0), Vector3::z() * base.yaw);
    let pitch = |z: f64, angle: f64| {
        Isometry3::from_parts(
            Translation3::new(0.0, 0.0, z),
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle),
        )
    };
    let shoulder = Isometry3::new(Vector3::from(SHOULDER), Vector3::z() * arm[0]);
    let world_from_upper = world_from_base * shoulder * pitch(0.0, arm[1]);
    let world_from_fore = world_from_upper * pitch(UPPER_M, arm[2]);
    let world_from_hand = world_from_fore * pitch(FORE_M, arm[3]);
    [
        ("base_link", world_from_base),
        ("torso", world_from_base),
        ("head", world_from_base),
        ("arm/upper", world_from_upper),
        ("arm/fore", world_from_fore),
        ("arm/hand", world_from_hand),
    ]
    .into_iter()
    .map(|(name, world_from_link)| BodyPose {
        name: name.to_owned(),
        pose: wire(&world_from_link),
    })
    .collect()
}

/// Where something held is.
pub(crate) fn held(links: &[BodyPose]) -> Option<Pose> {
    let hand = links.iter().find(|link| link.name == "arm/hand")?.pose;
    let [x, y, z, w] = hand.orientation_xyzw;
    let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    let grip = Vector3::from(hand.position) + rotation * Vector3::new(0.0, 0.0, 0.16);
    Some(at([grip.x, grip.y, grip.z - 0.09]))
}

pub(crate) fn joints(arm: Arm) -> Vec<JointPosition> {
    [
        "arm/shoulder_yaw",
        "arm/shoulder_pitch",
        "arm/elbow",
        "arm/wrist",
    ]
    .into_iter()
    .zip(arm)
    .map(|(name, position)| JointPosition {
        name: name.to_owned(),
        position,
    })
    .collect()
}

/// The arm that brings a level hand to a point, or as near to it as it reaches.
pub(crate) fn reach(base: PosePlanar, point: [f64; 3]) -> Arm {
    let (sin, cos) = base.yaw.sin_cos();
    let (dx, dy) = (point[0] - base.x, point[1] - base.y);
    let ahead = cos * dx + sin * dy - SHOULDER[0];
    let left = cos * dy - sin * dx - SHOULDER[1];
    let distance = (ahead.hypot(left) - HAND_M).max(0.1);
    let height = point[2] - SHOULDER[2];
    let length = distance.hypot(height).min(0.98 * (UPPER_M + FORE_M));
    // The law of cosines at the elbow, then at the shoulder; angles from the vertical.
    let bend = PI
        - ((UPPER_M * UPPER_M + FORE_M * FORE_M - length * length) / (2.0 * UPPER_M * FORE_M))
            .clamp(-1.0, 1.0)
            .acos();
    let lift = ((UPPER_M * UPPER_M + length * length - FORE_M * FORE_M) / (2.0 * UPPER_M * length))
        .clamp(-1.0, 1.0)
        .acos();
    let shoulder = distance.atan2(height) - lift;
    [
        left.atan2(ahead),
        shoulder,
        bend,
        FRAC_PI_2 - shoulder - bend,
    ]
}

fn wire(isometry: &Isometry3<f64>) -> Pose {
    let position = isometry.translation.vector;
    let rotation = isometry.rotation.coords;
    Pose {
        position: [position.x, position.y, position.z],
        orientation_xyzw: [rotation.x, rotation.y, rotation.z, rotation.w],
    }
}
