//! The model as PPDDL, by the planner's own types.
//!
//! Where space was learned apart, each navigation symbol is a predicate that operators need, and an operator brings it
//! about: the path planner's, which can go there from anywhere as far as this model knows.

use factotum_task_planning::operator::{
    AtomPattern, Condition, Cost, Domain, Effect, Operator, OperatorError, Outcome, Problem,
    Provenance,
};

use super::record::{ModelRecord, OperatorRecord, PlaceRecord};

/// Holds until an option could not run.
const NOT_FAILED: &str = "notfailed";

/// The goal where none was learned: no operator brings it about, so no planner can call an empty plan a success.
const GOAL_UNKNOWN: &str = "goal-never-reached-in-the-recording";

/// HEURISTIC: how likely the base arrives where it goes. No drive is certain, and planners send the base about for nothing
/// if that costs nothing.
const ARRIVES: f64 = 0.999;

impl ModelRecord {
    /// The operators as a domain; an operator that may fail has an outcome that deletes `notfailed`.
    ///
    /// # Errors
    /// A name given by a person that PDDL cannot write.
    pub fn domain(&self, name: &str) -> Result<Domain, OperatorError> {
        let mut domain = Domain::builder(name).predicate(NOT_FAILED, []);
        if self.goal.is_none() {
            domain = domain.predicate(GOAL_UNKNOWN, []);
        }
        for symbol in &self.symbols {
            domain = domain.predicate(&symbol.name, []);
        }
        for place in &self.places {
            domain = domain.predicate(&place.name, []);
        }
        for operator in &self.operators {
            domain = domain.operator(self.pddl_operator(operator)?);
        }
        for place in &self.places {
            domain = domain.operator(self.navigation(place)?);
        }
        domain.build()
    }

    /// From the start symbols to the goal's; without a learned goal there is no plan.
    ///
    /// # Errors
    /// The domain is not this model's.
    pub fn problem(&self, name: &str, domain: &Domain) -> Result<Problem, OperatorError> {
        let goal: Vec<&str> = match &self.goal {
            Some(goal) => goal.symbols.iter().map(String::as_str).collect(),
            None => vec![GOAL_UNKNOWN],
        };
        let mut problem = Problem::builder(name)
            .domain(domain.name())
            .fact(NOT_FAILED, [])
            .goal(Condition::all(
                std::iter::once(NOT_FAILED)
                    .chain(goal)
                    .map(|symbol| Condition::atom(symbol, [])),
            ));
        for symbol in &self.start {
            problem = problem.fact(symbol, []);
        }
        problem.build(domain)
    }

    /// The base goes to where a navigation symbol holds; whether it still is where another holds is not known.
    fn navigation(&self, place: &PlaceRecord) -> Result<Operator, OperatorError> {
        let name = place.name.strip_prefix("at-").unwrap_or(&place.name);
        let others = self.places.iter().filter(|p| p.name != place.name);
        let arrives = std::iter::once(Effect::add(AtomPattern::new(&place.name, [])))
            .chain(others.map(|other| Effect::delete(AtomPattern::new(&other.name, []))));
        let outcome = |probability, effects| Outcome {
            probability,
            effects,
            cost: Cost::default(),
        };
        Operator::builder(format!("go-to-{name}"))
            .requires(Condition::atom(NOT_FAILED, []))
            .outcome(outcome(ARRIVES, arrives.collect()))
            .outcome(outcome(
                1.0 - ARRIVES,
                vec![Effect::delete(AtomPattern::new(NOT_FAILED, []))],
            ))
            .build()
    }

    fn pddl_operator(&self, operator: &OperatorRecord) -> Result<Operator, OperatorError> {
        let mut builder =
            Operator::builder(&operator.name).requires(Condition::atom(NOT_FAILED, []));
        if let Some(partition) = self.partitions.get(operator.partition) {
            builder = builder.provenance(Provenance::Learned {
                source: partition.option.clone(),
                n_transitions: partition.rows.iter().map(Vec::len).sum(),
            });
        }
        for symbol in operator.needs.iter().chain(&operator.place) {
            builder = builder.requires(Condition::atom(symbol, []));
        }
        let runs = operator.run_probability;
        if runs < 1.0 {
            builder = builder.outcome(Outcome {
                probability: 1.0 - runs,
                effects: vec![Effect::delete(AtomPattern::new(NOT_FAILED, []))],
                cost: Cost::default(),
            });
        }
        for outcome in &operator.outcomes {
            let pattern = |symbol: &String| AtomPattern::new(symbol, []);
            let adds = outcome.adds.iter().map(|s| Effect::add(pattern(s)));
            let deletes = outcome.deletes.iter().map(|s| Effect::delete(pattern(s)));
            let moved = self.places.iter().filter(|_| outcome.moves_base);
            let left = moved.map(|place| Effect::delete(pattern(&place.name)));
            builder = builder.outcome(Outcome {
                probability: runs * outcome.probability,
                effects: adds.chain(deletes).chain(left).collect(),
                cost: Cost::Constant(hundredths(outcome.cost.unwrap_or(0.0))),
            });
        }
        builder.build()
    }
}

/// Costs are known no better, and files are easier to read.
fn hundredths(cost: f64) -> f64 {
    (cost * 100.0).round() / 100.0
}
