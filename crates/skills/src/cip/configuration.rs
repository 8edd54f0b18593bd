//! The joint configuration with which a grasp is taken.
//!
//! The dissertation takes, of many solutions of the inverse kinematics, the one with the highest manipulability value
//! (Eq. 3.2), or any. Ours looks ahead: it follows the tool along the object's motion from each solution, and takes the
//! one whose lowest value on the way is the highest. An arm that begins well may end at its limits.

use factotum_geometry::Pose;
use factotum_motion::{IkOptions, IkPreference, PlanningScene, solve_ik_many};
use nalgebra::{Matrix6, Matrix6xX, Vector6};
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
    /// The one whose lowest manipulability value along the object's motion is the highest.
    AlongMotion,
}

/// Configurations that bring the tool to the first of `motion`, the tool's poses along the object's motion in the base
/// frame; clear of the limits and of the robot itself, best first. One at most for a random choice.
pub fn configurations(
    scene: &mut PlanningScene,
    motion: &[Pose],
    choice: ConfigurationChoice,
    rng: &mut ChaCha8Rng,
) -> Vec<Vec<f64>> {
    let Some(base_from_tcp) = motion.first() else {
        return Vec::new();
    };
    let (prefer, n_wanted) = match choice {
        // Few are enough to draw from: descents begin at random configurations.
        ConfigurationChoice::Random => (IkPreference::First, 4),
        ConfigurationChoice::Manipulability | ConfigurationChoice::AlongMotion => {
            (IkPreference::Manipulability, N_SOLUTIONS)
        }
    };
    let options = IkOptions {
        prefer,
        restarts: N_RESTARTS,
        iterations: 40,
        n_candidates: n_wanted,
        ..IkOptions::default()
    };
    let found = solve_ik_many(scene, base_from_tcp, &[], &options, n_wanted, rng);
    let clear: Vec<Vec<f64>> = found
        .into_iter()
        .filter(|q| limit_distance(scene, q) > LIMIT_MARGIN_RAD)
        .collect();
    match choice {
        ConfigurationChoice::Random => clear.choose(rng).cloned().into_iter().collect(),
        ConfigurationChoice::Manipulability => clear,
        ConfigurationChoice::AlongMotion => {
            let mut rated: Vec<(f64, Vec<f64>)> = clear
                .into_iter()
                .map(|q| (lowest_along(scene, &q, motion), q))
                .collect();
            rated.sort_by(|a, b| b.0.total_cmp(&a.0));
            rated.into_iter().map(|(_, q)| q).collect()
        }
    }
}

/// Smallest distance of a turning joint to its limits, rad.
fn limit_distance(scene: &PlanningScene, q: &[f64]) -> f64 {
    let limits = scene.robot().limits();
    q.iter()
        .zip(limits)
        .filter(|(_, limit)| !limit.slide && !limit.continuous)
        .map(|(q, limit)| (q - limit.lower).min(limit.upper - q))
        .fold(f64::INFINITY, f64::min)
}

/// The lowest manipulability value while the tool goes along a motion from a configuration; below zero if it comes near a
/// limit, the more the earlier.
fn lowest_along(scene: &PlanningScene, q: &[f64], motion: &[Pose]) -> f64 {
    let robot = scene.robot();
    let chain = robot.chain();
    // The lift stays where it is.
    let n_still = robot.n() - robot.description().arm.joints.len();
    let mut q = q.to_vec();
    let mut jacobian = Matrix6xX::zeros(q.len());
    let mut lowest = f64::INFINITY;
    for (i, target) in motion.iter().enumerate() {
        // Two damped steps of Newton's method: the poses are near to each other.
        for _ in 0..2 {
            let pose = chain.base_from_tcp_and_jacobian_into(&q, &mut jacobian);
            jacobian.columns_mut(0, n_still).fill(0.0);
            let step = damped_step(&jacobian, &error_of(&pose, target));
            for (q, step) in q.iter_mut().zip(step.iter()) {
                *q += step;
            }
        }
        if limit_distance(scene, &q) < LIMIT_MARGIN_RAD {
            return i as f64 / motion.len() as f64 - 1.0;
        }
        lowest = lowest.min(scene.manipulability(&q));
    }
    lowest
}

fn error_of(from: &Pose, to: &Pose) -> Vector6<f64> {
    let shift = to.translation.vector - from.translation.vector;
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
    Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

fn damped_step(jacobian: &Matrix6xX<f64>, error: &Vector6<f64>) -> nalgebra::DVector<f64> {
    const DAMPING: f64 = 1e-4;
    let gram: Matrix6<f64> = jacobian * jacobian.transpose() + Matrix6::identity() * DAMPING;
    let solved = gram
        .cholesky()
        .map_or_else(Vector6::zeros, |cholesky| cholesky.solve(error));
    jacobian.transpose() * solved
}
