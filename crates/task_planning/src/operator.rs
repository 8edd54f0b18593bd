//! Operators, domains, problems and plans: the symbolic model a task planner works on.
//!
//! An operator is the symbolic side of an option (dissertation 2.1.3): its precondition says when
//! the option can run, its outcomes what it may leave behind and how likely. Values are checked when
//! they are made, so whoever holds a [`Domain`] or [`Problem`] need not check names again.

mod action;
mod condition;
mod domain;
mod effect;
mod error;
mod plan;
mod problem;
mod scope;
#[cfg(test)]
mod tests;

pub use action::{Operator, OperatorBuilder, PROBABILITY_SUM_TOLERANCE, Provenance};
pub use condition::{AtomPattern, Binding, Condition, OBJECT, Term, TypedName};
pub(crate) use condition::{PredicateReads, Variables};
pub(crate) use domain::SignatureKind;
pub use domain::{Domain, DomainBuilder, Signature};
pub use effect::{Cost, Effect, Outcome};
pub use error::OperatorError;
pub use plan::{Atom, GroundAction, Plan};
pub use problem::{Objective, Problem, ProblemBuilder};
