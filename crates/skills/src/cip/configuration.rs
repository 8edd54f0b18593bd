//! The joint configuration with which a grasp is taken: of many solutions of the inverse kinematics the one with the
//! highest manipulability value (thesis Eq. 3.2), or any.

use factotum_geometry::Pose;
use factotum_motion::{IkOptions, IkPreference, PlanningScene, solve_ik_many};
use rand::seq::IndexedRandom as _;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Solutions that are compared: what the dissertation's code samples.
const N_SOLUTIONS: usize = 50;

/// Descents for them.
const N_RESTARTS: usize = 100;

/// How near to a limit a joint of a solution may be, rad: as in the code.
const LIMIT_MARGIN_RAD: f64 = 0.1;

/// Which solution is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ConfigurationChoice {
    /// Any.
    Random,
    /// The one with the highest manipulability value.
    Manipulability,
}

/// Configurations that bring the tool to a pose, clear of the limits and of the robot itself, best first or in no order.
pub fn configurations(
    scene: &mut PlanningScene,
    base_from_tcp: &Pose,
    choice: ConfigurationChoice,
    rng: &mut ChaCha8Rng,
) -> Vec<Vec<f64>> {
    let (prefer, n_wanted) = match choice {
        // Few are enough to draw from: descents begin at random configurations.
        ConfigurationChoice::Random => (IkPreference::First, 4),
        ConfigurationChoice::Manipulability => (IkPreference::Manipulability, N_SOLUTIONS),
    };
    let options = IkOptions {
        prefer,
        restarts: N_RESTARTS,
        iterations: 40,
        n_candidates: n_wanted,
        ..IkOptions::default()
    };
    let found = solve_ik_many(scene, base_from_tcp, &[], &options, n_wanted, rng);
    let limits = scene.robot().limits();
    let is_clear = |q: &Vec<f64>| {
        q.iter().zip(limits).all(|(q, limit)| {
            limit.slide
                || limit.continuous
                || (q - limit.lower).min(limit.upper - q) > LIMIT_MARGIN_RAD
        })
    };
    let clear: Vec<Vec<f64>> = found.into_iter().filter(is_clear).collect();
    match choice {
        ConfigurationChoice::Random => clear.choose(rng).cloned().into_iter().collect(),
        ConfigurationChoice::Manipulability => clear,
    }
}
