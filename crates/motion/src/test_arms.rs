//! Arms for tests, from published Denavit-Hartenberg parameters; no physics needed.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use nalgebra::{Point3, Unit, Vector3};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::Pose;
use crate::chain::{KinematicChain, Screw};
use crate::joint_space::{JointLimit, JointSpace};

/// A chain with its space of configurations.
#[derive(Debug)]
pub(crate) struct TestArm {
    pub(crate) chain: KinematicChain,
    pub(crate) space: JointSpace,
}

pub(crate) fn all() -> [TestArm; 4] {
    [panda(), iiwa7(), jaco(), lift_and_arm()]
}

/// A uniform configuration.
pub(crate) fn sample(arm: &TestArm, seed: u64) -> Vec<f64> {
    let mut q = vec![0.0; arm.space.n()];
    arm.space
        .sample_into(&mut ChaCha8Rng::seed_from_u64(seed), &mut q);
    q
}

pub(crate) fn hinge(range: Option<[f64; 2]>, velocity: f64) -> JointLimit {
    let [lower, upper] = range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    JointLimit {
        lower,
        upper,
        velocity,
        acceleration: 5.0 * velocity,
        jerk: 100.0 * velocity,
        continuous: range.is_none(),
        slide: false,
    }
}

/// Rotation about z by theta and shift along z by d, seen from the frame before.
fn about_z(theta: f64, d: f64) -> Pose {
    Pose::new(Vector3::new(0.0, 0.0, d), Vector3::z() * theta)
}

/// Rotation about x by alpha and shift along x by a, seen from the frame before.
fn about_x(alpha: f64, a: f64) -> Pose {
    Pose::new(Vector3::new(a, 0.0, 0.0), Vector3::x() * alpha)
}

/// The z axis of a frame as a hinge.
fn z_of(frame: &Pose) -> Screw {
    Screw::Hinge {
        axis: Unit::new_normalize(frame.rotation * Vector3::z()),
        point: Point3::from(frame.translation.vector),
    }
}

/// Franka Emika Panda with hand: Franka Control Interface documentation, "Denavit-Hartenberg parameters" (Craig).
pub(crate) fn panda() -> TestArm {
    let a = [0.0, 0.0, 0.0, 0.0825, -0.0825, 0.0, 0.088];
    let d = [0.333, 0.0, 0.316, 0.0, 0.384, 0.0, 0.0];
    let alpha = [
        0.0, -FRAC_PI_2, FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, FRAC_PI_2, FRAC_PI_2,
    ];
    let mut frame = Pose::identity();
    let mut screws = Vec::new();
    for i in 0..7 {
        frame *= about_x(alpha[i], a[i]) * about_z(0.0, d[i]);
        screws.push(z_of(&frame));
    }
    frame *= about_z(-FRAC_PI_4, 0.107 + 0.1034);
    let ranges = [
        [-2.8973, 2.8973],
        [-1.7628, 1.7628],
        [-2.8973, 2.8973],
        [-3.0718, -0.0698],
        [-2.8973, 2.8973],
        [-0.0175, 3.7525],
        [-2.8973, 2.8973],
    ];
    let velocities = [2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61];
    let limits = ranges
        .iter()
        .zip(velocities)
        .map(|(&range, v)| hinge(Some(range), v))
        .collect();
    TestArm {
        chain: KinematicChain::new(screws, frame),
        space: JointSpace::new(limits),
    }
}

/// KUKA LBR iiwa 7 R800, straight up at zero: axis heights and ranges of its data sheet.
pub(crate) fn iiwa7() -> TestArm {
    let axes = [
        (Vector3::z(), 0.0),
        (Vector3::y(), 0.34),
        (Vector3::z(), 0.54),
        (-Vector3::y(), 0.74),
        (Vector3::z(), 0.94),
        (Vector3::y(), 1.14),
        (Vector3::z(), 1.266),
    ];
    let screws = axes
        .iter()
        .map(|&(axis, height)| Screw::Hinge {
            axis: Unit::new_normalize(axis),
            point: Point3::new(0.0, 0.0, height),
        })
        .collect();
    let ranges_deg: [f64; 7] = [170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 175.0];
    let limits = ranges_deg
        .iter()
        .map(|deg| hinge(Some([-deg.to_radians(), deg.to_radians()]), 1.7))
        .collect();
    let tcp = Pose::translation(0.0, 0.0, 1.266);
    TestArm {
        chain: KinematicChain::new(screws, tcp),
        space: JointSpace::new(limits),
    }
}

/// Kinova j2s7s300: classic Denavit-Hartenberg parameters and ranges of its user guide; four joints are continuous.
pub(crate) fn jaco() -> TestArm {
    let d = [-0.2755, 0.0, -0.410, -0.0098, -0.3111, 0.0, -0.2638];
    let alpha = [
        FRAC_PI_2, FRAC_PI_2, FRAC_PI_2, FRAC_PI_2, FRAC_PI_2, FRAC_PI_2, PI,
    ];
    let mut frame = about_x(PI, 0.0);
    let mut screws = Vec::new();
    for i in 0..7 {
        screws.push(z_of(&frame));
        frame *= about_z(0.0, d[i]) * about_x(alpha[i], 0.0);
    }
    let range = |deg: f64| Some([deg.to_radians(), (360.0 - deg).to_radians()]);
    let ranges = [
        None,
        range(47.0),
        None,
        range(30.0),
        None,
        range(65.0),
        None,
    ];
    let limits = ranges.iter().map(|&range| hinge(range, 0.8)).collect();
    TestArm {
        chain: KinematicChain::new(screws, frame),
        space: JointSpace::new(limits),
    }
}

/// A vertical slide of 0.4 m under an iiwa.
pub(crate) fn lift_and_arm() -> TestArm {
    let arm = iiwa7();
    let mut screws = vec![Screw::Slide {
        axis: Vector3::z_axis(),
    }];
    screws.extend_from_slice(arm.chain.screws());
    let lift = JointLimit {
        slide: true,
        ..hinge(Some([0.0, 0.4]), 0.1)
    };
    let mut limits = vec![lift];
    limits.extend_from_slice(arm.space.limits());
    let tcp = Pose::translation(0.0, 0.0, 1.266);
    TestArm {
        chain: KinematicChain::new(screws, tcp),
        space: JointSpace::new(limits),
    }
}
