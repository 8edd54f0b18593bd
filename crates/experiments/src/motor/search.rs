//! Policy search over movement primitives: PI²-CMA over the weights of each joint, the goal and the speed.

use factotum_learning::dmp::{DmpParams, PositionDmp, PositionMotion};
use factotum_learning::pi2::{Pi2Cma, Pi2Params, Pi2State};
use factotum_skills::bootstrap::{KinematicError, PlannedDemo};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use serde::{Deserialize, Serialize};

use super::{MotorError, MotorRig, MotorRollout};

/// Basis functions of each joint (thesis 4.3.1).
const N_KERNELS: usize = 32;

/// Standard deviations at the start of a search, the same whatever it begins from.
struct Exploration {
    /// Of each weight.
    weight: f64,
    /// Of the goal of each joint.
    goal_rad: f64,
    /// Of the logarithm of the speed.
    log_speed: f64,
}

const EXPLORATION: Exploration = Exploration {
    weight: 30.0,
    goal_rad: 0.05,
    log_speed: 0.1,
};

/// Standard deviations of a random policy: its motions are about as large as those of a plan.
const RANDOM: Exploration = Exploration {
    weight: 200.0,
    goal_rad: 0.5,
    log_speed: 0.1,
};

/// Where the first policy is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Init {
    /// The robot's own plan.
    Plan,
    /// Nowhere: random weights.
    Random,
}

impl Init {
    /// Name in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Random => "random",
        }
    }
}

/// A policy under search.
#[derive(Debug, Clone)]
pub struct MotorSearch {
    dmp: PositionDmp,
    motion: PositionMotion,
    search: Pi2Cma,
}

impl MotorSearch {
    /// Begins from a demonstration, or from random weights about standing still.
    ///
    /// # Errors
    /// [`MotorError`] for a demonstration that is too short.
    pub fn new(
        rig: &mut MotorRig,
        init: Init,
        error: &KinematicError,
        seed: u64,
    ) -> Result<(Self, Option<PlannedDemo>), MotorError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let params = DmpParams {
            n_kernels: N_KERNELS,
            ..DmpParams::default()
        };
        let (dmp, demo) = match init {
            Init::Plan => {
                let demo = rig.plan(error, &mut rng)?;
                let dmp = PositionDmp::learn(&demo.positions, demo.step_secs, &params)?;
                (dmp, Some(demo))
            }
            Init::Random => {
                let (still, step_secs) = rig.stillness(2 * N_KERNELS);
                (PositionDmp::learn(&still, step_secs, &params)?, None)
            }
        };
        let motion = dmp.demonstrated();
        let mut mean = dmp.parameters(&motion);
        let n_dims = motion.start.len();
        let n_weights = n_dims * N_KERNELS;
        let std = |exploration: &Exploration| {
            let mut std = vec![exploration.weight; n_weights];
            std.extend(vec![exploration.goal_rad; n_dims]);
            std.push(exploration.log_speed);
            std
        };
        if init == Init::Random {
            for (mean, std) in mean.iter_mut().zip(std(&RANDOM)) {
                let normal: f64 = StandardNormal.sample(&mut rng);
                *mean += std * normal;
            }
        }
        let blocks = dmp.parameter_blocks();
        let search = Pi2Cma::new(mean, std(&EXPLORATION), &blocks, Pi2Params::default(), seed)?;
        Ok((
            Self {
                dmp,
                motion,
                search,
            },
            demo,
        ))
    }

    /// The policy found so far.
    ///
    /// # Errors
    /// [`MotorError::Dmp`] if the search went where no primitive is.
    pub fn policy(&self) -> Result<(PositionDmp, PositionMotion), MotorError> {
        Ok(self.dmp.with_parameters(&self.motion, self.search.mean())?)
    }

    /// Tries `n` neighbours of the policy and learns from them.
    ///
    /// # Errors
    /// [`MotorError`] when the physics breaks down.
    pub fn epoch(&mut self, rig: &mut MotorRig, n: usize) -> Result<Vec<MotorRollout>, MotorError> {
        let samples = self.search.ask(n);
        let mut rollouts = Vec::with_capacity(n);
        for sample in &samples {
            let (dmp, motion) = self.dmp.with_parameters(&self.motion, sample)?;
            rollouts.push(rig.roll_out(&dmp, &motion, &mut |_| {})?);
        }
        let costs: Vec<f64> = rollouts
            .iter()
            .map(|rollout| -rollout.total_reward)
            .collect();
        self.search.tell(&samples, &costs)?;
        Ok(rollouts)
    }

    /// What must be stored to go on.
    pub fn state(&self) -> Pi2State {
        self.search.clone().into()
    }

    /// Goes on from what was stored.
    ///
    /// # Errors
    /// A reason, if that is of another policy.
    pub fn restore(&mut self, state: Pi2State) -> Result<(), String> {
        let search = Pi2Cma::try_from(state).map_err(|error| error.to_string())?;
        let (found, wanted) = (search.mean().len(), self.search.mean().len());
        if found != wanted {
            return Err(format!("{found} parameters, expected {wanted}"));
        }
        self.search = search;
        Ok(())
    }

    /// Updates made.
    pub fn n_updates(&self) -> u64 {
        self.search.n_updates()
    }
}
