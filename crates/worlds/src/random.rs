//! Random streams of a world: one per purpose, so that looking once more does not change how the odometry drifts.

use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// What a stream is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    Placement = 1,
    Odometry = 2,
    Lidar = 3,
    Camera = 4,
    Fault = 5,
}

/// The stream of a seed for one purpose.
pub(crate) fn stream(seed: u64, purpose: Purpose) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(purpose as u64);
    rng
}

/// A draw from the normal distribution of mean zero.
pub(crate) fn normal(rng: &mut impl Rng, deviation: f64) -> f64 {
    let draw: f64 = StandardNormal.sample(rng);
    draw * deviation
}

/// A draw from `[-half, half]`.
pub(crate) fn symmetric(rng: &mut impl Rng, half: f64) -> f64 {
    half * rng.random_range(-1.0..=1.0)
}
