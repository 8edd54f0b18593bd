//! Problems: the objects of a world, what holds in it at first, and the goal.

use std::collections::{BTreeMap, BTreeSet};

use super::condition::{Condition, TypedName};
use super::domain::{Domain, index_objects};
use super::error::OperatorError;
use super::plan::Atom;
use super::scope::{Names, Scope};
use crate::names::{fold, is_name};

/// What a planner should make of the plan's cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Objective {
    /// Any plan will do (shorter is nicer).
    #[default]
    AnyPlan,
    /// The cheaper by the operators' costs, the better.
    MinimizeCost,
}

/// A planning problem checked against its domain.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    name: String,
    domain: String,
    objects: Vec<TypedName>,
    init: BTreeSet<Atom>,
    values: BTreeMap<Atom, f64>,
    goal: Condition,
    objective: Objective,
}

impl Problem {
    /// Starts a problem without objects or facts, whose goal is already met.
    pub fn builder(name: impl Into<String>) -> ProblemBuilder {
        ProblemBuilder {
            name: name.into(),
            domain: None,
            objects: Vec::new(),
            init: Vec::new(),
            values: Vec::new(),
            goal: Condition::always(),
            objective: Objective::AnyPlan,
        }
    }

    /// Opens the problem for changes; `build` checks it anew.
    pub fn into_builder(self) -> ProblemBuilder {
        ProblemBuilder {
            name: self.name,
            domain: Some(self.domain),
            objects: self.objects,
            init: self.init.into_iter().collect(),
            values: self.values.into_iter().collect(),
            goal: self.goal,
            objective: self.objective,
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The name of the domain it was checked against.
    pub fn domain_name(&self) -> &str {
        &self.domain
    }

    /// Its own objects; the domain's constants come on top.
    pub fn objects(&self) -> &[TypedName] {
        &self.objects
    }

    /// What holds at first; everything else does not.
    pub fn init(&self) -> &BTreeSet<Atom> {
        &self.init
    }

    /// The values of the domain's functions.
    pub fn values(&self) -> &BTreeMap<Atom, f64> {
        &self.values
    }

    /// What shall hold in the end.
    pub fn goal(&self) -> &Condition {
        &self.goal
    }

    /// What makes one plan better than another.
    pub fn objective(&self) -> Objective {
        self.objective
    }
}

/// Collects the parts of a [`Problem`].
#[derive(Debug, Clone)]
pub struct ProblemBuilder {
    name: String,
    domain: Option<String>,
    objects: Vec<TypedName>,
    init: Vec<Atom>,
    values: Vec<(Atom, f64)>,
    goal: Condition,
    objective: Objective,
}

impl ProblemBuilder {
    /// Says which domain the problem is written for; `build` then refuses any other.
    pub fn domain(mut self, name: impl Into<String>) -> Self {
        self.domain = Some(name.into());
        self
    }

    /// Adds an object.
    pub fn object(mut self, name: impl Into<String>, type_name: impl Into<String>) -> Self {
        self.objects.push(TypedName::new(name, type_name));
        self
    }

    /// Adds a fact that holds at first.
    pub fn fact<'a>(
        mut self,
        predicate: impl Into<String>,
        args: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        self.init.push(Atom::new(predicate, args));
        self
    }

    /// Adds facts that hold at first.
    pub fn facts(mut self, facts: impl IntoIterator<Item = Atom>) -> Self {
        self.init.extend(facts);
        self
    }

    /// Sets the value of a function.
    pub fn value(mut self, function: Atom, value: f64) -> Self {
        self.values.push((function, value));
        self
    }

    /// Replaces all function values.
    pub(crate) fn replace_values(mut self, values: Vec<(Atom, f64)>) -> Self {
        self.values = values;
        self
    }

    /// Sets what shall hold in the end.
    pub fn goal(mut self, goal: Condition) -> Self {
        self.goal = goal;
        self
    }

    /// Sets what makes one plan better than another.
    pub fn objective(mut self, objective: Objective) -> Self {
        self.objective = objective;
        self
    }

    /// Checks the whole against the domain and finishes the problem.
    ///
    /// # Errors
    /// See [`OperatorError`]: another domain, objects given twice, unknown names or types, wrong arities.
    pub fn build(mut self, domain: &Domain) -> Result<Problem, OperatorError> {
        let owner = format!("problem `{}`", self.name);
        if !is_name(&self.name) {
            return Err(OperatorError::InvalidName {
                kind: "problem",
                name: self.name,
            });
        }
        if let Some(found) = self.domain.filter(|d| fold(d) != fold(domain.name())) {
            let wanted = domain.name().to_owned();
            return Err(OperatorError::OtherDomain {
                problem: self.name,
                found,
                wanted,
            });
        }
        let mut all: Vec<_> = domain
            .constants()
            .iter()
            .chain(&self.objects)
            .cloned()
            .collect();
        let by_name = index_objects(&domain.index.types, &mut all, &owner)?;
        let objects = all.split_off(domain.constants().len());
        let mut scope = Scope {
            index: &domain.index,
            objects: &by_name,
            variables: Names::new(),
            owner: format!("the initial state of {owner}"),
        };
        for atom in &mut self.init {
            scope.ground("predicate", atom)?;
        }
        for (atom, value) in &mut self.values {
            scope.ground("function", atom)?;
            if !(value.is_finite() && *value >= 0.0) {
                return Err(OperatorError::Cost {
                    owner: atom.to_string(),
                    found: *value,
                });
            }
        }
        scope.owner = format!("the goal of {owner}");
        scope.condition(&mut self.goal)?;
        Ok(Problem {
            name: self.name,
            domain: domain.name().to_owned(),
            objects,
            init: self.init.into_iter().collect(),
            values: self.values.into_iter().collect(),
            goal: self.goal,
            objective: self.objective,
        })
    }
}
