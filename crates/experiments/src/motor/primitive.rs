//! A movement primitive of the arm's joints, and PI²-CMA over its weights, goal and speed.

use factotum_learning::dmp::{DmpParams, PositionDmp, PositionMotion, PositionRollout};
use factotum_learning::pi2::{Pi2Cma, Pi2Params};
use factotum_skills::bootstrap::JointDemo;
use factotum_skills::cip::rig::Reading;
use factotum_worlds::TaskRig;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::rig::Controller;
use super::search::{MotorSearch, SearchState};
use super::{MotorError, MotorRig, MotorRollout};

/// Basis functions of each joint (thesis 4.3.1).
const N_KERNELS: usize = 32;

/// Of what the arm lags behind the primitive, 1/s.
pub(super) const CATCH_UP_PER_SEC: f64 = 5.0;

/// A primitive may take from a tenth of a rollout's time to all of it.
const DURATION_SHARES: [f64; 2] = [0.1, 1.0];

/// Standard deviations at the start of a search, the same whatever it begins from.
struct Exploration {
    /// Of each weight.
    weight: f64,
    /// Of the goal of each joint.
    goal_rad: f64,
    /// Of the logarithm of the speed.
    log_speed: f64,
}

impl Exploration {
    /// Of all parameters.
    fn std(&self, n_dims: usize) -> Vec<f64> {
        let mut std = vec![self.weight; n_dims * N_KERNELS];
        std.extend(vec![self.goal_rad; n_dims]);
        std.push(self.log_speed);
        std
    }
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

/// A primitive under search.
#[derive(Debug, Clone)]
pub(super) struct PrimitiveSearch {
    dmp: PositionDmp,
    motion: PositionMotion,
    search: Pi2Cma,
}

impl PrimitiveSearch {
    /// Begins from a demonstration, or from random weights about standing still.
    pub(super) fn new(
        rig: &MotorRig,
        demo: Option<&JointDemo>,
        seed: u64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, MotorError> {
        let params = DmpParams {
            n_kernels: N_KERNELS,
            ..DmpParams::default()
        };
        let dmp = match demo {
            Some(demo) => PositionDmp::learn(&demo.positions, demo.step_secs, &params)?,
            None => {
                let (still, step_secs) = rig.stillness(2 * N_KERNELS);
                PositionDmp::learn(&still, step_secs, &params)?
            }
        };
        let motion = dmp.demonstrated();
        let mut mean = dmp.parameters(&motion);
        let n_dims = motion.start.len();
        if demo.is_none() {
            for (mean, std) in mean.iter_mut().zip(RANDOM.std(n_dims)) {
                let normal: f64 = StandardNormal.sample(rng);
                *mean += std * normal;
            }
        }
        let blocks = dmp.parameter_blocks();
        let std = EXPLORATION.std(n_dims);
        let search = Pi2Cma::new(mean, std, &blocks, Pi2Params::default(), seed)?;
        Ok(Self {
            dmp,
            motion,
            search,
        })
    }

    fn roll_out_with(
        &self,
        rig: &mut MotorRig,
        parameters: &[f64],
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<MotorRollout, MotorError> {
        let (dmp, motion) = self.dmp.with_parameters(&self.motion, parameters)?;
        let [shortest, longest] = DURATION_SHARES.map(|share| share * rig.duration_secs());
        let run = dmp.run(&PositionMotion {
            duration_s: motion.duration_s.clamp(shortest, longest),
            ..motion
        })?;
        let step_secs = rig.step_secs();
        rig.roll_out(&mut Playing { run, step_secs }, watch)
    }
}

impl MotorSearch for PrimitiveSearch {
    fn roll_out(
        &mut self,
        rig: &mut MotorRig,
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<MotorRollout, MotorError> {
        self.roll_out_with(rig, self.search.mean(), watch)
    }

    fn epoch(&mut self, rig: &mut MotorRig, n: usize) -> Result<Vec<MotorRollout>, MotorError> {
        let samples = self.search.ask(n);
        let mut rollouts = Vec::with_capacity(n);
        for sample in &samples {
            rollouts.push(self.roll_out_with(rig, sample, &mut |_| {})?);
        }
        let costs: Vec<f64> = rollouts
            .iter()
            .map(|rollout| -rollout.total_reward)
            .collect();
        self.search.tell(&samples, &costs)?;
        Ok(rollouts)
    }

    fn state(&self) -> SearchState {
        SearchState::Primitive(self.search.clone().into())
    }

    fn restore(&mut self, state: SearchState) -> Result<(), String> {
        let SearchState::Primitive(state) = state else {
            return Err("it is of a network, expected a primitive".to_owned());
        };
        let search = Pi2Cma::try_from(state).map_err(|error| error.to_string())?;
        let (found, wanted) = (search.mean().len(), self.search.mean().len());
        if found != wanted {
            return Err(format!("{found} parameters, expected {wanted}"));
        }
        self.search = search;
        Ok(())
    }

    fn n_updates(&self) -> u64 {
        self.search.n_updates()
    }
}

/// The velocity of the primitive, and a little of what the arm lags behind it.
struct Playing<'a> {
    run: PositionRollout<'a>,
    step_secs: f64,
}

impl Controller for Playing<'_> {
    fn act(&mut self, seen: &Reading, action: &mut [f64]) -> Result<(), MotorError> {
        let wished = self.run.advance(self.step_secs)?;
        for (i, action) in action.iter_mut().enumerate() {
            let lag = wished.position[i] - seen.arm_positions[i];
            *action = wished.velocity[i] + CATCH_UP_PER_SEC * lag;
        }
        Ok(())
    }
}
