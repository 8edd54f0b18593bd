//! The model as it is kept: what people read and planners need, by names.
//!
//! Densities and classifiers stay behind; their means, deviations and scores are here. A record can be explained,
//! renamed by a person, written as PDDL, and kept as text (it is plain data for serde).

use serde::{Deserialize, Serialize};

use super::SymbolicModel;
use crate::partition::{LeftOut, LeftOutReason};
use crate::spatial::{Independence, Place, Verdict};
use crate::subgoal::SubgoalCheck;

/// A learned model by names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelRecord {
    /// The state variables.
    pub variables: Vec<String>,
    /// The options.
    pub options: Vec<String>,
    /// The variables that change together.
    pub factors: Vec<Vec<String>>,
    /// The symbols that hold at the start, one a factor.
    pub start: Vec<String>,
    /// The goal; absent if it was never reached or no symbols stand for it.
    pub goal: Option<GoalRecord>,
    /// The vocabulary.
    #[serde(default)]
    pub symbols: Vec<SymbolRecord>,
    /// The operators.
    #[serde(default)]
    pub operators: Vec<OperatorRecord>,
    /// The parts of the options that operators run.
    #[serde(default)]
    pub partitions: Vec<PartitionRecord>,
    /// The navigation symbols; none if space is a variable like any other.
    #[serde(default)]
    pub places: Vec<PlaceRecord>,
    /// Whether where an option can run depends on the rest, as tested.
    #[serde(default)]
    pub independence: Vec<IndependenceRecord>,
    /// The transitions that were of no use, and why.
    #[serde(default)]
    pub left_out: Vec<LeftOutRecord>,
}

/// A navigation symbol: the base is where an option can run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceRecord {
    /// Its name.
    pub name: String,
    /// The option.
    pub option: String,
    /// The variables of the base's pose.
    pub variables: Vec<String>,
    /// The mean of each over the places from which the option could run.
    pub means: Vec<f64>,
    /// The standard deviation of each.
    pub deviations: Vec<f64>,
    /// From how many states the option could run.
    pub n_positive: usize,
    /// From how many it could not, though the rest was right.
    pub n_negative: usize,
    /// Balanced accuracy on held-out states, if there were enough.
    pub score: Option<f64>,
    /// How likely the option can run from a place that this symbol offers.
    pub reliability: f64,
    /// The symbols that it is for; none if it is for whatever the rest is like.
    pub context: Vec<String>,
}

/// The test of spatial independence of an option, or of a part of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndependenceRecord {
    /// The option.
    pub option: String,
    /// Its navigation symbol, or what the names of several begin with.
    pub place: String,
    /// States in which it could run.
    pub n_positive: usize,
    /// States in which it could not, though the rest was right.
    pub n_negative: usize,
    /// Log-likelihood gained by seeing the rest besides the place, nats a held-out state.
    pub gain_nats: Option<f64>,
    /// Its standard error.
    pub gain_error_nats: Option<f64>,
    /// What follows.
    pub verdict: Verdict,
}

/// The goal by symbols.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalRecord {
    /// One symbol for each factor the goal hangs on.
    pub symbols: Vec<String>,
    /// How likely the goal is reached where they hold.
    pub probability: f64,
    /// The variables the goal hangs on.
    pub looks_at: Vec<String>,
}

/// A symbol: its variables are near these values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SymbolRecord {
    /// Its name.
    pub name: String,
    /// The variables it is about.
    pub variables: Vec<String>,
    /// The mean of each variable where the symbol holds.
    pub means: Vec<f64>,
    /// The standard deviation of each.
    pub deviations: Vec<f64>,
    /// The samples it stands on.
    pub n_samples: usize,
}

/// A part of an option, whose outcomes do not depend on where it starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartitionRecord {
    /// The option.
    pub option: String,
    /// The variables its precondition hangs on.
    pub looks_at: Vec<String>,
    /// In how many states it was seen to be able to run.
    pub n_positive: usize,
    /// In how many states it was seen not to be able to run.
    pub n_negative: usize,
    /// Balanced accuracy of the precondition on held-out states, if there were enough.
    pub score: Option<f64>,
    /// The outcomes, from 0, whose end depends on the start: their density is wider than what comes of one start.
    pub not_subgoal: Vec<usize>,
    /// For each outcome the transitions it was seen in, as rows of the recording from 0.
    pub rows: Vec<Vec<usize>>,
}

/// A partition from certain symbols.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatorRecord {
    /// Its name.
    pub name: String,
    /// The partition it runs, as a place in [`ModelRecord::partitions`], from 0.
    pub partition: usize,
    /// The symbols it needs.
    pub needs: Vec<String>,
    /// How likely it can run where they hold.
    pub probability: f64,
    /// The same as planners are told: 1 where failure is not worth a word.
    pub run_probability: f64,
    /// The navigation symbol it needs.
    pub place: Option<String>,
    /// What may come of it.
    pub outcomes: Vec<OutcomeRecord>,
}

/// What may come of an operator that runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutcomeRecord {
    /// How likely, among the outcomes.
    pub probability: f64,
    /// The symbols that hold after it.
    pub adds: Vec<String>,
    /// The symbols that hold no more.
    pub deletes: Vec<String>,
    /// Whether the base may be elsewhere after it.
    #[serde(default)]
    pub moves_base: bool,
    /// What it cost on average, if rewards were recorded.
    pub cost: Option<f64>,
}

/// Transitions that were of no use.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOutRecord {
    /// The option.
    pub option: String,
    /// The variables that changed.
    pub changed: Vec<String>,
    /// How many transitions.
    pub n_rows: usize,
    /// Why.
    pub reason: LeftOutReason,
}

/// Why something cannot be explained or renamed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NameError {
    /// No such name.
    #[error("the model has no {kind} `{found}`{hint}")]
    Unknown {
        /// What was looked for.
        kind: &'static str,
        /// The name asked for.
        found: String,
        /// The nearest name, as a question.
        hint: String,
    },
    /// The new name is taken or none that PDDL can write.
    #[error("`{from}` cannot be called `{to}`: {reason}")]
    Refused {
        /// The name there is.
        from: String,
        /// The name wanted.
        to: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A name that stands in the record and means nothing there: the text was changed by hand.
    #[error("operator `{operator}` names {kind} `{found}`, which the model does not have")]
    Dangling {
        /// The operator.
        operator: String,
        /// What was looked for.
        kind: &'static str,
        /// The name.
        found: String,
    },
}

impl SymbolicModel {
    /// The model as it is kept.
    pub fn record(&self) -> ModelRecord {
        let variables = |of: &[usize]| self.variable_names(of);
        let symbols = |of: &[usize]| -> Vec<String> {
            of.iter()
                .map(|&s| self.vocabulary.symbols()[s].name.clone())
                .collect()
        };
        let symbol = |symbol: &crate::vocabulary::Symbol| SymbolRecord {
            name: symbol.name.clone(),
            variables: variables(symbol.density.variables()),
            means: symbol.density.mean(),
            deviations: symbol.density.deviation(),
            n_samples: symbol.density.samples().n_rows(),
        };
        let operator = |operator: &crate::operators::LearnedOperator| OperatorRecord {
            name: operator.name.clone(),
            partition: operator.partition,
            needs: symbols(&operator.precondition),
            probability: operator.probability,
            run_probability: operator.run_probability,
            place: (operator.place.zip(self.space.as_ref()))
                .map(|(place, space)| space.places[place].name.clone()),
            outcomes: (operator.outcomes.iter())
                .map(|outcome| OutcomeRecord {
                    probability: outcome.probability,
                    adds: symbols(&outcome.adds),
                    deletes: symbols(&outcome.deletes),
                    moves_base: outcome.moves_base,
                    cost: outcome.cost,
                })
                .collect(),
        };
        let place = |place: &Place| PlaceRecord {
            name: place.name.clone(),
            option: self.options[place.option].clone(),
            variables: self.spatial_variables.clone(),
            means: place.spread.iter().map(|(mean, _)| *mean).collect(),
            deviations: place
                .spread
                .iter()
                .map(|(_, deviation)| *deviation)
                .collect(),
            n_positive: place.condition.n_positive,
            n_negative: place.condition.n_negative,
            score: place.condition.score,
            reliability: place.reliability,
            context: symbols(&place.context),
        };
        let independence = |tested: &Independence| IndependenceRecord {
            option: self.options[tested.option].clone(),
            place: tested.place.clone(),
            n_positive: tested.n_positive,
            n_negative: tested.n_negative,
            gain_nats: tested.gain.map(|g| g.mean_nats),
            gain_error_nats: tested.gain.map(|g| g.error_nats),
            verdict: tested.verdict,
        };
        let space = self.space.iter();
        let partitions = self.partitions.iter().zip(&self.preconditions);
        let not_subgoal = |checks: &[Option<SubgoalCheck>]| -> Vec<usize> {
            let holds = |o: &usize| checks[*o].is_none_or(|check| check.holds);
            (0..checks.len()).filter(|o| !holds(o)).collect()
        };
        ModelRecord {
            variables: self.variables.clone(),
            options: self.options.clone(),
            factors: (self.factors.variables().iter())
                .map(|f| variables(f))
                .collect(),
            start: symbols(&self.start),
            goal: self.goal.as_ref().map(|goal| GoalRecord {
                symbols: symbols(&goal.symbols),
                probability: goal.probability,
                looks_at: variables(&goal.condition.variables),
            }),
            symbols: self.vocabulary.symbols().iter().map(symbol).collect(),
            operators: self.operators.iter().map(operator).collect(),
            partitions: partitions
                .zip(&self.subgoals)
                .map(|((partition, precondition), subgoals)| PartitionRecord {
                    option: self.options[partition.option].clone(),
                    looks_at: variables(&precondition.variables),
                    n_positive: precondition.n_positive,
                    n_negative: precondition.n_negative,
                    score: precondition.score,
                    not_subgoal: not_subgoal(subgoals),
                    rows: partition.outcomes.iter().map(|o| o.rows.clone()).collect(),
                })
                .collect(),
            places: space.clone().flat_map(|s| &s.places).map(place).collect(),
            independence: space
                .flat_map(|s| &s.independence)
                .map(independence)
                .collect(),
            left_out: self
                .left_out
                .iter()
                .map(|l| self.left_out_record(l))
                .collect(),
        }
    }

    fn left_out_record(&self, left_out: &LeftOut) -> LeftOutRecord {
        LeftOutRecord {
            option: self.options[left_out.option].clone(),
            changed: self.variable_names(&left_out.mask),
            n_rows: left_out.n_rows,
            reason: left_out.reason,
        }
    }

    fn variable_names(&self, variables: &[usize]) -> Vec<String> {
        let name = |&v: &usize| self.variables[v].clone();
        variables.iter().map(name).collect()
    }
}

impl ModelRecord {
    /// Gives a symbol or an operator another name, wherever it stands.
    ///
    /// # Errors
    /// There is none of this name, the new name is taken, or PDDL cannot write it. The record is then as it was.
    pub fn rename(&mut self, from: &str, to: &str) -> Result<(), NameError> {
        let names = (self.symbols.iter().map(|s| &s.name))
            .chain(self.operators.iter().map(|o| &o.name))
            .chain(self.places.iter().map(|p| &p.name))
            .map(String::as_str);
        position("symbol, place or operator", from, names)?;
        let mut renamed = self.clone();
        for name in renamed.names_mut().filter(|name| *name == from) {
            to.clone_into(name);
        }
        if let Err(error) = renamed.domain("renamed") {
            return Err(NameError::Refused {
                from: from.to_owned(),
                to: to.to_owned(),
                reason: error.to_string(),
            });
        }
        *self = renamed;
        Ok(())
    }

    /// Every place where a symbol or an operator is named.
    fn names_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let goal = self.goal.iter_mut().flat_map(|goal| &mut goal.symbols);
        let symbols = self.symbols.iter_mut().map(|s| &mut s.name);
        let operators = self.operators.iter_mut().flat_map(|o| {
            let outcomes =
                (o.outcomes.iter_mut()).flat_map(|o| o.adds.iter_mut().chain(&mut o.deletes));
            std::iter::once(&mut o.name)
                .chain(&mut o.needs)
                .chain(&mut o.place)
                .chain(outcomes)
        });
        let places = (self.places.iter_mut())
            .flat_map(|p| std::iter::once(&mut p.name).chain(&mut p.context));
        let tested = self.independence.iter_mut().map(|i| &mut i.place);
        self.start
            .iter_mut()
            .chain(goal)
            .chain(symbols)
            .chain(operators)
            .chain(places)
            .chain(tested)
    }
}

/// Where a name stands among others.
pub(super) fn position<'a>(
    kind: &'static str,
    wanted: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, NameError> {
    (names.clone().position(|name| name == wanted)).ok_or_else(|| {
        let nearest = names.min_by_key(|name| strsim::levenshtein(name, wanted));
        NameError::Unknown {
            kind,
            found: wanted.to_owned(),
            hint: nearest.map_or(String::new(), |name| format!("; did you mean `{name}`?")),
        }
    })
}
