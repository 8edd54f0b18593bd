//! What is wrong with an action or a plan.

use crate::names::nearest_hint;
use crate::operator::{Condition, GroundAction};

/// Why an action means nothing in a world.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ActionFault {
    /// No operator has that name.
    #[error("operator `{name}` is not in the domain{}", nearest_hint(name, known))]
    UnknownOperator {
        /// The unknown name.
        name: String,
        /// The operators there are.
        known: Vec<String>,
    },
    /// No object has that name.
    #[error("object `{name}` is not in the problem{}", nearest_hint(name, known))]
    UnknownObject {
        /// The unknown name.
        name: String,
        /// The objects there are.
        known: Vec<String>,
    },
    /// The wrong number of arguments.
    #[error("operator `{operator}` is given {found} argument(s), expected {wanted}")]
    Arity {
        /// The operator.
        operator: String,
        /// Number of arguments found.
        found: usize,
        /// Number of parameters.
        wanted: usize,
    },
    /// An argument of the wrong type.
    #[error("operator `{operator}` is given `{object}` of type `{found}`, expected `{wanted}`")]
    WrongType {
        /// The operator.
        operator: String,
        /// The object.
        object: String,
        /// Its type.
        found: String,
        /// The parameter's type.
        wanted: String,
    },
    /// A cost reads a function the problem gives no value.
    #[error("the cost reads {function}, which the problem gives no value")]
    NoValue {
        /// The ground function.
        function: String,
    },
}

/// Why a plan does not solve its problem. Steps count from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanFault {
    /// A step that is no action of the domain.
    #[error("step {step} {action}: {fault}")]
    Action {
        /// The step's number, from 1.
        step: usize,
        /// The step.
        action: GroundAction,
        /// What is wrong with it.
        fault: Box<ActionFault>,
    },
    /// A step whose precondition does not hold when its turn comes.
    #[error("step {step} {action} cannot run: {} does not hold", listed(unmet))]
    Precondition {
        /// The step's number, from 1.
        step: usize,
        /// The step.
        action: GroundAction,
        /// The conjuncts that do not hold, ground.
        unmet: Vec<Condition>,
    },
    /// A step whose operator may turn out in several ways.
    #[error(
        "step {step} {action} may turn out in {n_outcomes} ways, expected one; determinise the domain or ask for the plan's probability"
    )]
    Probabilistic {
        /// The step's number, from 1.
        step: usize,
        /// The step.
        action: GroundAction,
        /// Number of outcomes.
        n_outcomes: usize,
    },
    /// All steps run, and the goal does not hold.
    #[error(
        "the goal is not reached after {n_steps} step(s): {} does not hold",
        listed(unmet)
    )]
    Goal {
        /// Number of steps.
        n_steps: usize,
        /// The goal's conjuncts that do not hold.
        unmet: Vec<Condition>,
    },
    /// The plan claims a cost it does not have.
    #[error("the plan claims cost {claimed}, expected {found}")]
    Cost {
        /// The plan's own figure.
        claimed: f64,
        /// The sum over its steps.
        found: f64,
    },
}

fn listed(conditions: &[Condition]) -> String {
    conditions
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join(" and ")
}
