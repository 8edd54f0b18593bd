//! The model as PPDDL, by the planner's own types.

use factotum_task_planning::operator::{
    AtomPattern, Condition, Cost, Domain, Effect, Operator, OperatorError, Outcome, Problem,
    Provenance,
};

use super::SymbolicModel;
use crate::operators::LearnedOperator;

/// Holds until an option could not run.
const NOT_FAILED: &str = "notfailed";

impl SymbolicModel {
    /// The operators as a domain; an operator that may fail has an outcome that deletes `notfailed`.
    ///
    /// # Errors
    /// A name given by a person that PDDL cannot write.
    pub fn domain(&self, name: &str) -> Result<Domain, OperatorError> {
        let mut domain = Domain::builder(name).predicate(NOT_FAILED, []);
        for symbol in self.vocabulary.symbols() {
            domain = domain.predicate(&symbol.name, []);
        }
        for operator in &self.operators {
            domain = domain.operator(self.pddl_operator(operator)?);
        }
        domain.build()
    }

    /// From the start symbols to the goal's; without a learned goal, to where the start is.
    ///
    /// # Errors
    /// The domain is not this model's.
    pub fn problem(&self, name: &str, domain: &Domain) -> Result<Problem, OperatorError> {
        let atom = |symbol: &usize| Condition::atom(self.symbol_name(*symbol), []);
        let goal = self.goal.iter().flat_map(|goal| &goal.symbols).map(atom);
        let mut problem = Problem::builder(name)
            .domain(domain.name())
            .fact(NOT_FAILED, [])
            .goal(Condition::all(
                std::iter::once(Condition::atom(NOT_FAILED, [])).chain(goal),
            ));
        for &symbol in &self.start {
            problem = problem.fact(self.symbol_name(symbol), []);
        }
        problem.build(domain)
    }

    fn symbol_name(&self, symbol: usize) -> &str {
        &self.vocabulary.symbols()[symbol].name
    }

    fn pddl_operator(&self, operator: &LearnedOperator) -> Result<Operator, OperatorError> {
        let pattern = |symbol: &usize| AtomPattern::new(self.symbol_name(*symbol), []);
        let provenance = Provenance::Learned {
            source: self.options[self.partitions[operator.partition].option].clone(),
            n_transitions: self.partitions[operator.partition].n_rows(),
        };
        let mut builder = Operator::builder(&operator.name)
            .provenance(provenance)
            .requires(Condition::atom(NOT_FAILED, []));
        for symbol in &operator.precondition {
            builder = builder.requires(Condition::Atom(pattern(symbol)));
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
            let adds = outcome.adds.iter().map(|s| Effect::add(pattern(s)));
            let deletes = outcome.deletes.iter().map(|s| Effect::delete(pattern(s)));
            builder = builder.outcome(Outcome {
                probability: runs * outcome.probability,
                effects: adds.chain(deletes).collect(),
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
