//! Writing the reduced task as a propositional domain and problem.

use super::formula::Formula;
use super::{FactId, GroundTask, Instance, ReducedTask};
use crate::operator::{AtomPattern, Condition, Domain, Effect, Operator, OperatorError, Problem};

/// Actions are called `a0`, `a1`, ...; the index leads back to the action.
pub(super) fn action_idx(name: &str) -> Option<usize> {
    name.strip_prefix(['a', 'A'])?.parse().ok()
}

fn predicate(fact: FactId) -> String {
    format!("p{fact}")
}

/// The propositional task; facts are called `p0`, `p1`, ...
pub(super) fn emit(task: &GroundTask, problem: &Problem) -> Result<ReducedTask, OperatorError> {
    let mut read = vec![false; task.facts.len()];
    let mut note = |formula: &Formula| formula.literals(&mut |fact, _| read[fact] = true);
    note(&task.goal);
    for instance in &task.instances {
        note(&instance.precondition);
        for effect in &instance.effects {
            note(&effect.when);
        }
    }
    for effect in task.instances.iter().flat_map(|i| &i.effects) {
        read[effect.fact] = true;
    }
    let mut domain = Domain::builder("reduced");
    let mut reduced = Problem::builder("reduced").objective(problem.objective());
    for fact in (0..task.facts.len()).filter(|fact| read[*fact]) {
        domain = domain.predicate(predicate(fact), []);
        if task.facts.initially[fact] {
            reduced = reduced.fact(predicate(fact), []);
        }
    }
    for (i, instance) in task.instances.iter().enumerate() {
        domain = domain.operator(operator(i, instance)?);
    }
    let domain = domain.build()?;
    let problem = reduced.goal(condition(&task.goal)).build(&domain)?;
    let actions = task.instances.iter().map(|i| i.action.clone()).collect();
    Ok(ReducedTask {
        domain,
        problem,
        actions,
    })
}

fn operator(i: usize, instance: &Instance) -> Result<Operator, OperatorError> {
    let mut builder = Operator::builder(format!("a{i}"))
        .requires(condition(&instance.precondition))
        .cost(instance.cost);
    for effect in &instance.effects {
        let atom = AtomPattern::new(predicate(effect.fact), []);
        let change = if effect.adds {
            Effect::add(atom)
        } else {
            Effect::delete(atom)
        };
        builder = builder.effect(change.when(condition(&effect.when)));
    }
    builder.build()
}

fn condition(formula: &Formula) -> Condition {
    match formula {
        Formula::True => Condition::always(),
        Formula::False => Condition::Or(Vec::new()),
        Formula::Literal(fact, true) => Condition::atom(predicate(*fact), []),
        Formula::Literal(fact, false) => Condition::not_atom(predicate(*fact), []),
        Formula::And(parts) => Condition::And(parts.iter().map(condition).collect()),
        Formula::Or(parts) => Condition::Or(parts.iter().map(condition).collect()),
    }
}
