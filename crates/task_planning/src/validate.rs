//! An independent judge of plans: it says at which step which condition fails, and what a plan costs.
//!
//! It shares no grounding, pruning or compilation with the planners it judges (see [`World`]), so a
//! fault in those cannot hide itself. The executive uses the same semantics to know what an action
//! should have changed.
//!
//! ```
//! use factotum_task_planning::operator::{Condition, Domain, GroundAction, Operator, Plan, Problem};
//! use factotum_task_planning::validate::validate;
//!
//! let domain = Domain::builder("lamp")
//!     .predicate("on", [])
//!     .operator(Operator::builder("press").adds("on", []).build()?)
//!     .build()?;
//! let problem = Problem::builder("light").goal(Condition::atom("on", [])).build(&domain)?;
//! let plan = Plan { steps: vec![GroundAction::new("press", [] as [&str; 0])], cost: 1.0 };
//! assert_eq!(validate(&domain, &problem, &plan)?.cost, 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod fault;
mod probability;
#[cfg(test)]
mod tests;
mod world;

pub use fault::{ActionFault, PlanFault};
pub use probability::{
    N_STATES_MAX, PlanProbability, PlanProbabilityError, StateDistribution, plan_probability,
};
pub use world::{BoundAction, State, World};

use crate::operator::{Domain, GroundAction, Plan, Problem};

/// How far a plan's claimed cost may be from the sum over its steps, relative to it.
///
/// Planners that only take integers scale and round costs; their sums are recomputed before a plan is returned, so
/// this covers rounding in f64 sums only.
const COST_TOLERANCE_REL: f64 = 1e-9;

/// What a valid plan does.
#[derive(Debug, Clone, PartialEq)]
pub struct ValidPlan {
    /// The sum of the steps' costs; their number where the domain has no costs.
    pub cost: f64,
    /// The state before the first step and after each step.
    pub states: Vec<State>,
}

/// Runs the plan from the initial state and checks every step, the goal and the claimed cost.
///
/// # Errors
/// The first fault, with its step.
pub fn validate(domain: &Domain, problem: &Problem, plan: &Plan) -> Result<ValidPlan, PlanFault> {
    let valid = execute(domain, problem, &plan.steps)?;
    if (plan.cost - valid.cost).abs() > COST_TOLERANCE_REL * valid.cost.max(1.0) {
        return Err(PlanFault::Cost {
            claimed: plan.cost,
            found: valid.cost,
        });
    }
    Ok(valid)
}

/// Like [`validate`] for bare steps, which claim no cost.
///
/// # Errors
/// The first fault, with its step.
pub fn execute(
    domain: &Domain,
    problem: &Problem,
    steps: &[GroundAction],
) -> Result<ValidPlan, PlanFault> {
    let world = World::new(domain, problem);
    let mut states = vec![world.initial_state()];
    let mut cost = 0.0;
    for (i, action) in steps.iter().enumerate() {
        let (after, paid) = execute_step(&world, &states[i], i + 1, action)?;
        cost += if domain.uses_costs() { paid } else { 1.0 };
        states.push(after);
    }
    let unmet = world.unmet_goal(&states[steps.len()]);
    if !unmet.is_empty() {
        return Err(PlanFault::Goal {
            n_steps: steps.len(),
            unmet,
        });
    }
    Ok(ValidPlan { cost, states })
}

fn execute_step(
    world: &World<'_>,
    state: &State,
    step: usize,
    action: &GroundAction,
) -> Result<(State, f64), PlanFault> {
    let fault = |fault| PlanFault::Action {
        step,
        action: action.clone(),
        fault: Box::new(fault),
    };
    let bound = world.bind(action).map_err(fault)?;
    let unmet = world.unmet_precondition(state, &bound);
    if !unmet.is_empty() {
        return Err(PlanFault::Precondition {
            step,
            action: action.clone(),
            unmet,
        });
    }
    match bound.operator().outcomes() {
        [outcome] => {
            let paid = world.cost(&bound, outcome).map_err(fault)?;
            Ok((world.apply(state, &bound, outcome), paid))
        }
        outcomes => {
            let n_outcomes = outcomes.len();
            Err(PlanFault::Probabilistic {
                step,
                action: action.clone(),
                n_outcomes,
            })
        }
    }
}
