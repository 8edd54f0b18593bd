//! What makes a domain, an operator or a problem invalid.

use crate::names::nearest_hint;

/// Why a domain, operator or problem was refused.
///
/// `owner` says where the fault lies in the reader's words (for example ``operator `pick` `` or `the goal`).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OperatorError {
    /// A name PDDL cannot carry.
    #[error(
        "{kind} name `{name}` is not a PDDL name: expected a letter followed by letters, digits, `-` or `_`"
    )]
    InvalidName {
        /// What was named: type, predicate, object, ...
        kind: &'static str,
        /// The refused name.
        name: String,
    },
    /// A name declared twice (PDDL names do not differ by case).
    #[error("{kind} `{name}` is declared twice in {owner}")]
    Duplicate {
        /// What was named.
        kind: &'static str,
        /// The repeated name.
        name: String,
        /// Where.
        owner: String,
    },
    /// A name used and never declared.
    #[error(
        "{owner} uses {kind} `{name}`, which is not declared{}",
        nearest_hint(name, known)
    )]
    Unknown {
        /// What was named.
        kind: &'static str,
        /// The unknown name.
        name: String,
        /// Who uses it.
        owner: String,
        /// The names that are declared.
        known: Vec<String>,
    },
    /// A predicate or function with the wrong number of arguments.
    #[error("{owner} gives {kind} `{name}` {found} argument(s), expected {wanted}")]
    Arity {
        /// Predicate or function.
        kind: &'static str,
        /// Its name.
        name: String,
        /// Number of arguments found.
        found: usize,
        /// Number of arguments declared.
        wanted: usize,
        /// Who uses it.
        owner: String,
    },
    /// An argument whose type cannot be the declared one.
    #[error(
        "{owner} gives `{symbol}` the argument `{argument}` of type `{found}`, expected `{wanted}`"
    )]
    TypeMismatch {
        /// Predicate, function or action.
        symbol: String,
        /// The argument.
        argument: String,
        /// Its type.
        found: String,
        /// The declared type.
        wanted: String,
        /// Who uses it.
        owner: String,
    },
    /// Types that are their own ancestors.
    #[error("type `{name}` is its own ancestor")]
    TypeCycle {
        /// A type on the cycle.
        name: String,
    },
    /// A probability outside (0, 1], or outcomes that do not sum to 1.
    #[error(
        "{owner} has outcome probabilities that sum to {sum}, expected each in (0, 1] and sum 1"
    )]
    Probability {
        /// The operator.
        owner: String,
        /// What they sum to.
        sum: f64,
    },
    /// A cost that is negative or not finite.
    #[error("{owner} has cost {found}, expected a finite number of at least 0")]
    Cost {
        /// The operator or function value.
        owner: String,
        /// The refused cost.
        found: f64,
    },
    /// A problem written for another domain.
    #[error("problem `{problem}` is written for domain `{found}`, expected `{wanted}`")]
    OtherDomain {
        /// The problem.
        problem: String,
        /// The domain it names.
        found: String,
        /// The domain it was given.
        wanted: String,
    },
}
