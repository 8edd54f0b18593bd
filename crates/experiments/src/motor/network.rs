//! A Gaussian policy whose mean is a network of where arm and object are (thesis 4.3.1), cloned from demonstrations and
//! improved by the natural policy gradient, with the demonstrations at its side (DAPG) or without (NPG).
//!
//! Demonstrations are the plan, played by an arm without mass that begins off its start and follows a bent copy of it:
//!
//! ```text
//! a_k = (p_k+1 - p_k) / dt + c (p_k - q_k)         q_k+1 = q_k + a_k dt
//! ```
//!
//! with p the plan and its bend, c as for a primitive. So what is cloned leads back to the plan. No rollout is spent on it.

use factotum_learning::policy_gradient::{
    CloningParams, Demonstrations, GaussianParams, GaussianPolicy, NaturalGradient,
    NaturalGradientParams, Trajectory, clone_behaviour,
};
use factotum_learning::replay::Ending;
use factotum_skills::bootstrap::JointDemo;
use factotum_skills::cip::rig::Reading;
use factotum_worlds::TaskRig;
use nalgebra::DVector;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::primitive::CATCH_UP_PER_SEC;
use super::rig::Controller;
use super::search::{MotorSearch, SearchName, SearchState};
use super::{MotorError, MotorRig, MotorRollout};

/// Demonstrations made of what was shown (thesis 4.3.1).
const N_DEMOS: usize = 10;

/// Standard deviation of where a demonstration begins, rad.
const START_NOISE_RAD: f64 = 0.05;

/// Standard deviation of the bend at each of its knots, rad.
const BEND_RAD: f64 = 0.02;

/// Knots of a bend, evenly over the plan.
const N_KNOTS: usize = 6;

/// ln of the standard deviation of an action at the start, rad/s.
const LOG_STD: f32 = 0.0;

/// A network under search.
#[derive(Debug, Clone)]
pub(super) struct NetworkSearch {
    search: NaturalGradient,
    seed: u64,
}

impl NetworkSearch {
    /// Begins with what demonstrations show, or without any with random weights.
    pub(super) fn new(
        rig: &MotorRig,
        demos: &[JointDemo],
        search: SearchName,
        seed: u64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, MotorError> {
        let n_joints = rig.n_joints();
        let params = GaussianParams {
            log_std: LOG_STD,
            ..GaussianParams::default()
        };
        let mut policy = GaussianPolicy::new(n_joints + 1, n_joints, &params, rng)?;
        let shown = (!demos.is_empty()).then(|| noisy_copies(demos, rng));
        if let Some(shown) = &shown {
            policy.standardise_by(shown)?;
            clone_behaviour(&mut policy, shown, &CloningParams::default(), rng)?;
        }
        let shown = match (search, shown) {
            (SearchName::Dapg, None) => return Err(MotorError::NothingShown),
            (SearchName::Dapg, shown) => shown,
            _ => None,
        };
        let search = NaturalGradient::new(policy, shown, NaturalGradientParams::default())?;
        Ok(Self { search, seed })
    }
}

impl MotorSearch for NetworkSearch {
    fn roll_out(
        &mut self,
        rig: &mut MotorRig,
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<MotorRollout, MotorError> {
        let mut acting = Acting::new(self.search.policy().clone(), None);
        rig.roll_out(&mut acting, watch)
    }

    fn epoch(&mut self, rig: &mut MotorRig, n: usize) -> Result<Vec<MotorRollout>, MotorError> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        // Stream 0 drew what it began with.
        rng.set_stream(self.n_updates() + 1);
        let mut acting = Acting::new(self.search.policy().clone(), Some(rng));
        let mut rollouts = Vec::with_capacity(n);
        let mut trajectories = Vec::with_capacity(n);
        for _ in 0..n {
            rollouts.push(rig.roll_out(&mut acting, &mut |_| {})?);
            trajectories.push(acting.taken());
        }
        self.search.tell(&trajectories)?;
        Ok(rollouts)
    }

    fn state(&self) -> SearchState {
        SearchState::Network(Box::new(self.search.clone()))
    }

    fn restore(&mut self, state: SearchState) -> Result<(), String> {
        let SearchState::Network(search) = state else {
            return Err("it is of a primitive, expected a network".to_owned());
        };
        let sizes = |search: &NaturalGradient| {
            let policy = search.policy();
            [policy.n_observation(), policy.n_action()]
        };
        let (found, wanted) = (sizes(&search), sizes(&self.search));
        if found != wanted {
            return Err(format!(
                "{found:?} observations and actions, expected {wanted:?}"
            ));
        }
        self.search = *search;
        Ok(())
    }

    fn n_updates(&self) -> u64 {
        self.search.n_updates().into()
    }
}

/// A network that moves the arm, and what it saw, did and earned.
struct Acting {
    policy: GaussianPolicy,
    /// Of the noise of its actions; without it they are the mean.
    noise: Option<ChaCha8Rng>,
    action: Vec<f32>,
    taken: Trajectory,
}

impl Acting {
    fn new(policy: GaussianPolicy, noise: Option<ChaCha8Rng>) -> Self {
        Self {
            action: vec![0.0; policy.n_action()],
            policy,
            noise,
            taken: nothing_taken(),
        }
    }

    /// The rollout since the last call.
    fn taken(&mut self) -> Trajectory {
        std::mem::replace(&mut self.taken, nothing_taken())
    }
}

fn nothing_taken() -> Trajectory {
    Trajectory {
        observations: Vec::new(),
        actions: Vec::new(),
        rewards: Vec::new(),
        ending: Ending::Terminal,
    }
}

impl Controller for Acting {
    fn act(&mut self, seen: &Reading, action: &mut [f64]) -> Result<(), MotorError> {
        let observation = observation(&seen.arm_positions, seen.object_joint);
        match &mut self.noise {
            Some(rng) => self
                .policy
                .sample_into(&observation, rng, &mut self.action)?,
            None => self.policy.mean_into(&observation, &mut self.action)?,
        }
        for (action, value) in action.iter_mut().zip(&self.action) {
            *action = f64::from(*value);
        }
        if self.noise.is_some() {
            self.taken.observations.extend(observation);
            self.taken.actions.extend(&self.action);
        }
        Ok(())
    }

    fn earn(&mut self, reward: f64) {
        if self.noise.is_some() {
            self.taken.rewards.push(reward as f32);
        }
    }
}

/// s = (q_R, q_O).
fn observation(arm: &[f64], object: f64) -> Vec<f32> {
    let joints = arm.iter().chain([&object]);
    joints.map(|position| *position as f32).collect()
}

/// Demonstrations about some, about each in turn.
fn noisy_copies(demos: &[JointDemo], rng: &mut ChaCha8Rng) -> Demonstrations {
    let mut shown = Demonstrations::default();
    for demo in demos.iter().cycle().take(N_DEMOS) {
        let Some(first) = demo.positions.first() else {
            continue;
        };
        let n = first.len();
        let n_steps = demo.positions.len() - 1;
        let mut normal = |std: f64| {
            let mut values = || -> f64 { StandardNormal.sample(rng) };
            DVector::from_fn(n, |_, _| std * values())
        };
        let knots: Vec<DVector<f64>> = (0..N_KNOTS).map(|_| normal(BEND_RAD)).collect();
        let bent = |k: usize| &demo.positions[k] + bend(&knots, k as f64 / n_steps as f64);
        let mut q = first + normal(START_NOISE_RAD);
        for k in 0..n_steps {
            let action =
                (bent(k + 1) - bent(k)) / demo.step_secs + (bent(k) - &q) * CATCH_UP_PER_SEC;
            let seen = observation(q.as_slice(), demo.object[k]);
            shown.observations.extend(seen);
            shown
                .actions
                .extend(action.iter().map(|value| *value as f32));
            q += action * demo.step_secs;
        }
    }
    shown
}

/// The line through knots at a share of their way.
fn bend(knots: &[DVector<f64>], share: f64) -> DVector<f64> {
    let at = share * (knots.len() - 1) as f64;
    let i = (at as usize).min(knots.len() - 2);
    let rest = at - i as f64;
    &knots[i] * (1.0 - rest) + &knots[i + 1] * rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_differ_and_lead_back_to_the_plan() {
        let n_steps = 100;
        let at = |k: usize| k as f64 / n_steps as f64;
        let demo = JointDemo {
            positions: (0..=n_steps)
                .map(|k| DVector::from_vec(vec![at(k), -at(k)]))
                .collect(),
            object: (0..=n_steps).map(at).collect(),
            step_secs: 0.05,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let shown = noisy_copies(std::slice::from_ref(&demo), &mut rng);
        assert_eq!(shown.observations.len(), 3 * N_DEMOS * n_steps);
        assert_eq!(shown.actions.len(), 2 * N_DEMOS * n_steps);
        let rms = |step: usize| {
            let rows = shown.observations.chunks_exact(3).skip(step);
            let off = rows.step_by(n_steps).map(|row| {
                assert!((f64::from(row[2]) - at(step)).abs() < 1e-6);
                (f64::from(row[0]) - at(step)).powi(2)
            });
            (off.sum::<f64>() / N_DEMOS as f64).sqrt()
        };
        // Ten values of standard deviations 0.05, and then about 0.02.
        assert!((0.025..0.085).contains(&rms(0)), "{}", rms(0));
        assert!((0.004..0.04).contains(&rms(80)), "{}", rms(80));
        // On its way it does what the plan does, and what brings it back.
        for step in 0..n_steps {
            let mean: f32 = shown.actions[2 * step..].iter().step_by(2 * n_steps).sum();
            let mean = f64::from(mean) / N_DEMOS as f64;
            assert!((mean - 0.2).abs() < 0.3, "{mean} at step {step}");
        }
    }
}
