//! Operators: the symbolic side of an option, with where it came from.

use super::condition::{AtomPattern, Condition, TypedName};
use super::effect::{Cost, Effect, Outcome};
use super::error::OperatorError;
use crate::names::{fold, is_name};

/// How far the probabilities of an operator's outcomes may be from 1.
///
/// Learned files round each probability to three decimals, so a handful of outcomes may miss 1 by a few thousandths.
pub const PROBABILITY_SUM_TOLERANCE: f64 = 5e-3;

/// Where an operator comes from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Provenance {
    /// Shipped or written by hand.
    #[default]
    Given,
    /// Learned by the robot from its own transitions.
    Learned {
        /// What it was learned from: a file, a run, a home.
        source: String,
        /// How many transitions support it.
        n_transitions: usize,
    },
    /// Taught by a person.
    Taught {
        /// Who taught it.
        teacher: String,
    },
}

impl std::fmt::Display for Provenance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Given => f.write_str("given"),
            Self::Learned {
                source,
                n_transitions,
            } => {
                write!(f, "learned from {n_transitions} transitions of {source}")
            }
            Self::Taught { teacher } => write!(f, "taught by {teacher}"),
        }
    }
}

/// A parametrised action: when it can run, and what it may leave behind.
///
/// Made by [`Operator::builder`]; whether its predicates and types exist is checked when a
/// [`Domain`](super::Domain) takes it in.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    pub(super) name: String,
    pub(super) parameters: Vec<TypedName>,
    pub(super) precondition: Condition,
    pub(super) outcomes: Vec<Outcome>,
    pub(super) provenance: Provenance,
}

impl Operator {
    /// Starts an operator that needs nothing and changes nothing.
    pub fn builder(name: impl Into<String>) -> OperatorBuilder {
        OperatorBuilder {
            name: name.into(),
            parameters: Vec::new(),
            precondition: Vec::new(),
            certain: Outcome::certain(),
            outcomes: Vec::new(),
            provenance: Provenance::Given,
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its parameters, in order.
    pub fn parameters(&self) -> &[TypedName] {
        &self.parameters
    }

    /// When it can run.
    pub fn precondition(&self) -> &Condition {
        &self.precondition
    }

    /// How it may turn out: at least one outcome, their probabilities sum to 1.
    pub fn outcomes(&self) -> &[Outcome] {
        &self.outcomes
    }

    /// Where it comes from.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Whether it always turns out the same way.
    pub fn is_deterministic(&self) -> bool {
        self.outcomes.len() == 1
    }
}

/// Builds an [`Operator`] step by step.
///
/// ```
/// use factotum_task_planning::operator::{Condition, Operator};
///
/// let pick = Operator::builder("pick")
///     .parameter("o", "item")
///     .requires(Condition::atom("hand-empty", []))
///     .adds("holding", ["?o"])
///     .deletes("hand-empty", [])
///     .cost(1.0)
///     .build()?;
/// assert!(pick.is_deterministic());
/// # Ok::<(), factotum_task_planning::operator::OperatorError>(())
/// ```
#[derive(Debug, Clone)]
pub struct OperatorBuilder {
    name: String,
    parameters: Vec<TypedName>,
    precondition: Vec<Condition>,
    certain: Outcome,
    outcomes: Vec<Outcome>,
    provenance: Provenance,
}

impl OperatorBuilder {
    /// Adds a parameter, named without `?`.
    pub fn parameter(mut self, name: impl Into<String>, type_name: impl Into<String>) -> Self {
        self.parameters.push(TypedName::new(name, type_name));
        self
    }

    /// Adds a conjunct to the precondition.
    pub fn requires(mut self, condition: Condition) -> Self {
        self.precondition.push(condition);
        self
    }

    /// The atom becomes true (`"?m"` is a variable, anything else an object).
    pub fn adds<'a>(
        self,
        symbol: impl Into<String>,
        terms: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        self.effect(Effect::add(AtomPattern::new(symbol, terms)))
    }

    /// The atom becomes false.
    pub fn deletes<'a>(
        self,
        symbol: impl Into<String>,
        terms: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        self.effect(Effect::delete(AtomPattern::new(symbol, terms)))
    }

    /// Adds any effect.
    pub fn effect(mut self, effect: Effect) -> Self {
        self.certain.effects.push(effect);
        self
    }

    /// What one execution costs.
    pub fn cost(self, cost: f64) -> Self {
        self.cost_term(Cost::Constant(cost))
    }

    /// What one execution costs, perhaps read from the problem's function values.
    pub fn cost_term(mut self, cost: Cost) -> Self {
        self.certain.cost = cost;
        self
    }

    /// Adds a probabilistic outcome. An operator has either outcomes or the plain effects above, not both.
    pub fn outcome(mut self, outcome: Outcome) -> Self {
        self.outcomes.push(outcome);
        self
    }

    /// Says where the operator comes from.
    pub fn provenance(mut self, provenance: Provenance) -> Self {
        self.provenance = provenance;
        self
    }

    /// Checks and finishes the operator.
    ///
    /// # Errors
    /// A name PDDL cannot write, a parameter given twice, outcome probabilities outside (0, 1] or not
    /// summing to 1 within [`PROBABILITY_SUM_TOLERANCE`], outcomes beside plain effects, or a negative cost.
    pub fn build(self) -> Result<Operator, OperatorError> {
        let owner = format!("operator `{}`", self.name);
        if !is_name(&self.name) {
            return Err(OperatorError::InvalidName {
                kind: "operator",
                name: self.name,
            });
        }
        check_distinct("parameter", &owner, &self.parameters)?;
        let outcomes = match (self.outcomes.is_empty(), self.certain == Outcome::certain()) {
            (true, _) => vec![self.certain],
            (false, true) => self.outcomes,
            (false, false) => {
                // The plain effects stand for an outcome of probability 1 beside the others.
                let sum = 1.0 + self.outcomes.iter().map(|o| o.probability).sum::<f64>();
                return Err(OperatorError::Probability { owner, sum });
            }
        };
        check_probabilities(&owner, &outcomes)?;
        for outcome in &outcomes {
            if let Cost::Constant(found) = outcome.cost
                && !(found.is_finite() && found >= 0.0)
            {
                return Err(OperatorError::Cost { owner, found });
            }
        }
        let mut outcomes = outcomes;
        if let [only] = outcomes.as_mut_slice() {
            only.probability = 1.0;
        }
        let mut precondition = self.precondition;
        let precondition = match precondition.len() {
            1 => precondition.remove(0),
            _ => Condition::And(precondition),
        };
        Ok(Operator {
            name: self.name,
            parameters: self.parameters,
            precondition,
            outcomes,
            provenance: self.provenance,
        })
    }
}

fn check_probabilities(owner: &str, outcomes: &[Outcome]) -> Result<(), OperatorError> {
    let sum: f64 = outcomes.iter().map(|o| o.probability).sum();
    let each = outcomes
        .iter()
        .all(|o| o.probability > 0.0 && o.probability <= 1.0);
    if !each || (sum - 1.0).abs() > PROBABILITY_SUM_TOLERANCE {
        return Err(OperatorError::Probability {
            owner: owner.to_owned(),
            sum,
        });
    }
    Ok(())
}

/// Refuses names PDDL cannot write and names given twice.
pub(super) fn check_distinct(
    kind: &'static str,
    owner: &str,
    names: &[TypedName],
) -> Result<(), OperatorError> {
    let mut seen = std::collections::BTreeSet::new();
    for TypedName { name, .. } in names {
        if !is_name(name) {
            return Err(OperatorError::InvalidName {
                kind,
                name: name.clone(),
            });
        }
        if !seen.insert(fold(name)) {
            return Err(OperatorError::Duplicate {
                kind,
                name: name.clone(),
                owner: owner.to_owned(),
            });
        }
    }
    Ok(())
}
