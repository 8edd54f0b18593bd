//! How likely a plan is to run and to reach the goal (dissertation 2.1.3).
//!
//! A probabilistic plan p = {o_1, ..., o_n} starts from states drawn from a distribution Z. The
//! distribution is carried forward exactly: the mass in states where o_i's precondition does not
//! hold is lost at step i, the rest branches over o_i's outcomes. Equal states are merged, so the
//! work grows with the number of distinct reachable states, which is capped.

use std::collections::BTreeMap;

use super::fault::PlanFault;
use super::world::{BoundAction, State, World};
use crate::operator::{Domain, Plan, Problem};

/// Distinct states beyond which the exact distribution is not followed.
pub const N_STATES_MAX: usize = 100_000;

/// A distribution over states; the probabilities sum to at most 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StateDistribution(BTreeMap<State, f64>);

impl StateDistribution {
    /// All mass on one state.
    pub fn certain(state: State) -> Self {
        Self(BTreeMap::from([(state, 1.0)]))
    }

    /// States with their probabilities.
    ///
    /// # Errors
    /// A probability outside \[0, 1\], or a sum above 1 (beyond rounding).
    pub fn new(
        states: impl IntoIterator<Item = (State, f64)>,
    ) -> Result<Self, PlanProbabilityError> {
        let mut distribution = Self::default();
        for (state, probability) in states {
            if !(0.0..=1.0).contains(&probability) {
                return Err(PlanProbabilityError::NotADistribution { found: probability });
            }
            distribution.add(state, probability);
        }
        let found = distribution.mass();
        if found > 1.0 + 1e-9 {
            return Err(PlanProbabilityError::NotADistribution { found });
        }
        Ok(distribution)
    }

    /// The sum of all probabilities.
    pub fn mass(&self) -> f64 {
        self.0.values().sum()
    }

    /// The states with their probabilities, in order.
    pub fn states(&self) -> &BTreeMap<State, f64> {
        &self.0
    }

    fn add(&mut self, state: State, probability: f64) {
        *self.0.entry(state).or_insert(0.0) += probability;
    }
}

/// How likely a plan is.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanProbability {
    /// Probability that every step could run up to and including step i, for each step.
    pub runs_through: Vec<f64>,
    /// Probability that all steps run and the goal holds in the end.
    pub achieves_goal: f64,
    /// Where the plan leads, over the mass that ran through.
    pub final_states: StateDistribution,
}

/// Why a plan's probability could not be told.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanProbabilityError {
    /// A step that is no action of the domain.
    #[error(transparent)]
    Plan(#[from] PlanFault),
    /// Numbers that are no distribution.
    #[error(
        "the initial distribution has a probability or sum of {found}, expected at most 1 and at least 0"
    )]
    NotADistribution {
        /// The offending number.
        found: f64,
    },
    /// Too many distinct states.
    #[error(
        "the plan reaches {found} distinct states at step {step}, expected at most {N_STATES_MAX}"
    )]
    TooManyStates {
        /// Number of states.
        found: usize,
        /// The step's number, from 1.
        step: usize,
    },
}

/// The probability of a plan from an initial distribution.
///
/// # Errors
/// A step that is no action of the domain, or more than [`N_STATES_MAX`] distinct states.
pub fn plan_probability(
    domain: &Domain,
    problem: &Problem,
    initial: &StateDistribution,
    plan: &Plan,
) -> Result<PlanProbability, PlanProbabilityError> {
    let world = World::new(domain, problem);
    let mut now = initial.clone();
    let mut runs_through = Vec::with_capacity(plan.steps.len());
    for (i, action) in plan.steps.iter().enumerate() {
        let step = i + 1;
        let bound = world.bind(action).map_err(|fault| PlanFault::Action {
            step,
            action: action.clone(),
            fault: Box::new(fault),
        })?;
        let (next, ran) = advance(&world, &now, &bound);
        if next.0.len() > N_STATES_MAX {
            return Err(PlanProbabilityError::TooManyStates {
                found: next.0.len(),
                step,
            });
        }
        runs_through.push(ran);
        now = next;
    }
    let reached = now
        .0
        .iter()
        .filter(|(state, _)| world.unmet_goal(state).is_empty());
    let achieves_goal = reached.map(|(_, probability)| probability).sum();
    Ok(PlanProbability {
        runs_through,
        achieves_goal,
        final_states: now,
    })
}

/// The distribution after an action, and the mass in which the action could run.
fn advance(
    world: &World<'_>,
    now: &StateDistribution,
    action: &BoundAction<'_>,
) -> (StateDistribution, f64) {
    let outcomes = action.operator().outcomes();
    // Learned files round probabilities, so a sum may miss 1; the mass must not leak through that.
    let sum: f64 = outcomes.iter().map(|o| o.probability).sum();
    let mut next = StateDistribution::default();
    let mut ran = 0.0;
    for (state, probability) in &now.0 {
        if !world.unmet_precondition(state, action).is_empty() {
            continue;
        }
        ran += probability;
        for outcome in outcomes {
            let after = world.apply(state, action, outcome);
            next.add(after, probability * outcome.probability / sum);
        }
    }
    (next, ran)
}
