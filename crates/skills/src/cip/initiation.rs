//! The grasp initiation set I_c: grasps in the object's frame, and with which probability the skill succeeds from each.
//!
//! The grasps that survive the checks are the domain of I_c (thesis 3.2.1); success rates over them are learned while
//! they are tried, as the arms of a bandit. Between them I_c is smooth: the probability of any tool pose `g` is the mean
//! of a Beta distribution whose counts are those of the known grasps, each weighed by how near it is,
//!
//! ```text
//! p(g) = (1 + Σ k(g, g_i) s_i) / (2 + Σ k(g, g_i) n_i),   k = exp(-|Δp|²/2ℓ_p² - Δθ²/2ℓ_θ²)
//! ```
//!
//! with s_i successes in n_i tries, ℓ_p = 0.01 m and ℓ_θ = 0.2 rad. The dissertation keeps the rates of the grasps alone.

use std::path::Path;

use factotum_descriptions::Placement;
use factotum_geometry::Pose;
use factotum_learning::bandit::{Arm, Bandit, BanditError, BanditParams};
use nalgebra::Vector3;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Length of the kernel in position, metres.
const KERNEL_M: f64 = 0.01;

/// Length of the kernel in orientation, radians.
const KERNEL_RAD: f64 = 0.2;

/// How a grasp is chosen to learn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GraspChoice {
    /// Any.
    Random,
    /// By upper confidence bounds of their success rates.
    Ucb,
}

/// A grasp and what is known of it, as in a file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownGrasp {
    /// Tool pose in Λ, with the object's joint where it starts.
    pub object_from_tcp: Placement,
    /// Width of what is between the fingers, metres.
    pub width_m: f64,
    /// Tries from it.
    #[serde(default)]
    pub n_tries: u32,
    /// Tries that ended in β_c.
    #[serde(default)]
    pub n_successes: u32,
}

/// Why there is no I_c.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InitiationError {
    /// No grasp is left, or counts make no sense.
    #[error(transparent)]
    Bandit(#[from] BanditError),
    /// The file cannot be read.
    #[error("cannot read `{path}`: {reason}")]
    Read {
        /// The file.
        path: String,
        /// What stands against it.
        reason: String,
    },
}

/// I_c.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspInitiation {
    /// As they were given, so that what is stored and read again is the same to the bit.
    given: Vec<KnownGrasp>,
    poses: Vec<Pose>,
    bandit: Bandit,
}

impl GraspInitiation {
    /// I_c over these grasps.
    ///
    /// # Errors
    /// [`InitiationError::Bandit`] for no grasp, or more successes than tries.
    pub fn new(grasps: &[KnownGrasp], params: BanditParams) -> Result<Self, InitiationError> {
        let arms = grasps.iter().map(|grasp| Arm {
            n_tries: grasp.n_tries,
            n_successes: grasp.n_successes,
        });
        Ok(Self {
            poses: grasps
                .iter()
                .map(|grasp| grasp.object_from_tcp.into())
                .collect(),
            given: grasps.to_vec(),
            bandit: Bandit::new(params, arms.collect())?,
        })
    }

    /// The grasps with what is known of them.
    pub fn grasps(&self) -> Vec<KnownGrasp> {
        let known = self.given.iter().zip(self.bandit.arms());
        known
            .map(|(grasp, arm)| KnownGrasp {
                n_tries: arm.n_tries,
                n_successes: arm.n_successes,
                ..*grasp
            })
            .collect()
    }

    /// Reads the grasps of a file that was written from [`Self::grasps`].
    ///
    /// # Errors
    /// [`InitiationError`] if it cannot be read.
    pub fn read(path: &Path, params: BanditParams) -> Result<Self, InitiationError> {
        let read = |reason: String| InitiationError::Read {
            path: path.display().to_string(),
            reason,
        };
        let text = std::fs::read_to_string(path).map_err(|error| read(error.to_string()))?;
        let grasps: Vec<KnownGrasp> =
            serde_json::from_str(&text).map_err(|error| read(error.to_string()))?;
        Self::new(&grasps, params)
    }

    /// Number of grasps.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether there are none; there always are.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// Tool pose of a grasp in Λ, with the object's joint where it starts.
    pub fn object_from_tcp(&self, grasp: usize) -> &Pose {
        &self.poses[grasp]
    }

    /// Width of what is between the fingers in a grasp, metres.
    pub fn width_m(&self, grasp: usize) -> f64 {
        self.given[grasp].width_m
    }

    /// Middle of all grasps, in Λ.
    pub fn middle(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = self.poses.iter().map(|pose| pose.translation.vector).sum();
        sum / self.poses.len().max(1) as f64
    }

    /// Probability that the skill succeeds from a tool pose in Λ; one half where nothing is known.
    pub fn probability(&self, object_from_tcp: &Pose) -> f64 {
        let (mut successes, mut tries) = (1.0, 2.0);
        for (pose, arm) in self.poses.iter().zip(self.bandit.arms()) {
            let distance_m =
                (pose.translation.vector - object_from_tcp.translation.vector).norm() / KERNEL_M;
            let angle = pose.rotation.angle_to(&object_from_tcp.rotation) / KERNEL_RAD;
            let nearness = (-0.5 * (distance_m * distance_m + angle * angle)).exp();
            successes += nearness * f64::from(arm.n_successes);
            tries += nearness * f64::from(arm.n_tries);
        }
        successes / tries
    }

    /// A grasp to learn from.
    pub fn explore(&self, choice: GraspChoice, rng: &mut ChaCha8Rng) -> usize {
        match choice {
            GraspChoice::Random => rng.random_range(0..self.poses.len()),
            GraspChoice::Ucb => self.bandit.choose(),
        }
    }

    /// The grasps from the most to the least promising, of equals the first.
    pub fn ranked(&self) -> Vec<usize> {
        let values: Vec<f64> = self
            .poses
            .iter()
            .map(|pose| self.probability(pose))
            .collect();
        let mut order: Vec<usize> = (0..self.poses.len()).collect();
        order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
        order
    }

    /// Keeps what came of a try.
    pub fn record(&mut self, grasp: usize, success: bool) {
        self.bandit.record(grasp, success);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grasp(x: f64, n_tries: u32, n_successes: u32) -> KnownGrasp {
        KnownGrasp {
            object_from_tcp: Placement {
                xyz: [x, 0.0, 0.0],
                rpy: [0.0; 3],
            },
            width_m: 0.02,
            n_tries,
            n_successes,
        }
    }

    #[test]
    fn a_pose_is_worth_what_is_known_nearby() {
        let known = GraspInitiation::new(
            &[grasp(0.0, 20, 20), grasp(0.1, 20, 0)],
            BanditParams::default(),
        )
        .unwrap();
        let at = |x: f64| known.probability(&Pose::translation(x, 0.0, 0.0));
        assert!((at(0.0) - 21.0 / 22.0).abs() < 1e-9);
        assert!((at(0.1) - 1.0 / 22.0).abs() < 1e-9);
        assert!((at(1.0) - 0.5).abs() < 1e-9);
        assert!(at(0.005) > at(0.05) && at(0.05) > at(0.095));
        assert_eq!(known.ranked(), [0, 1]);
    }

    #[test]
    fn what_is_learned_survives_a_file_and_no_grasp_is_refused() {
        let mut known = GraspInitiation::new(
            &[grasp(0.0, 0, 0), grasp(0.1, 3, 1)],
            BanditParams::default(),
        )
        .unwrap();
        known.record(1, true);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("grasps.json");
        std::fs::write(&path, serde_json::to_string(&known.grasps()).unwrap()).unwrap();
        let again = GraspInitiation::read(&path, BanditParams::default()).unwrap();
        assert_eq!(again.grasps()[1].n_successes, 2);
        assert_eq!(again.grasps(), known.grasps());
        assert!(GraspInitiation::new(&[], BanditParams::default()).is_err());
    }
}
