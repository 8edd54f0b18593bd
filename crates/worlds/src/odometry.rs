//! Wheel odometry: what the base believes of its own way.
//!
//! Each true motion, seen from the base, is added with a scale error that stays for the life of the world (wheel
//! diameters) and a random walk that grows with the way (slip). The result is continuous and drifts, as REP-105 asks of
//! the odometry frame. It starts at identity, wherever the robot stands.

use factotum_geometry::Pose2;
use nalgebra::{Vector2, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::noise::Noise;
use crate::random::{Purpose, normal, stream};

/// Motions shorter than this (metres plus radians) are taken as standing still: encoders do not drift at rest.
const STILL: f64 = 1e-9;

/// Integrates noisy motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Odometry {
    pub(crate) odom_from_base: Pose2,
    pub(crate) scale: f64,
    pub(crate) turn_scale: f64,
    pub(crate) walk_m: f64,
    pub(crate) walk_rad: f64,
    pub(crate) true_before: Pose2,
    pub(crate) rng: ChaCha8Rng,
}

impl Odometry {
    pub(crate) fn new(seed: u64, noise: &Noise, world_from_base: Pose2) -> Self {
        let mut rng = stream(seed, Purpose::Odometry);
        Self {
            odom_from_base: Pose2::identity(),
            scale: 1.0 + normal(&mut rng, noise.odometry_scale),
            turn_scale: 1.0 + normal(&mut rng, noise.odometry_turn_scale),
            walk_m: noise.odometry_walk_m,
            walk_rad: noise.odometry_walk_rad,
            true_before: world_from_base,
            rng,
        }
    }

    /// Adds the motion since the last call.
    pub(crate) fn update(&mut self, world_from_base: Pose2) {
        let motion = self.true_before.inv_mul(&world_from_base);
        let (linear, turn) = (motion.translation.vector, motion.rotation.angle());
        let way = linear.norm() + turn.abs() * 0.3;
        if way < STILL {
            return;
        }
        self.true_before = world_from_base;
        let spread = way.sqrt();
        let slip = Vector2::new(
            normal(&mut self.rng, self.walk_m * spread),
            normal(&mut self.rng, self.walk_m * spread),
        );
        let felt_turn = turn * self.turn_scale + normal(&mut self.rng, self.walk_rad * spread);
        self.odom_from_base *= Pose2::new(linear * self.scale + slip, felt_turn);
    }

    /// A velocity in the base frame as the encoders report it.
    pub(crate) fn felt_velocity(&self, velocity: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            velocity.x * self.scale,
            velocity.y * self.scale,
            velocity.z * self.turn_scale,
        )
    }
}
