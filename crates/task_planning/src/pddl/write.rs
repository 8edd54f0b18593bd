//! Writing domains and problems, so that reading them back gives equal values.
//!
//! Provenance becomes a comment: PDDL has no place for it, and reading back gives `Given`.

use std::collections::BTreeSet;

use crate::operator::{
    AtomPattern, Condition, Cost, Domain, Effect, Objective, Operator, Outcome, Problem,
    Provenance, Signature, TypedName, Variables,
};

/// The domain as PDDL, or as PPDDL where an operator has more than one outcome.
pub fn write_domain(domain: &Domain) -> String {
    let mut text = format!("(define (domain {})\n", domain.name());
    write_list(&mut text, ":requirements", requirements(domain).into_iter());
    write_list(&mut text, ":types", domain.types().iter().map(typed));
    write_list(
        &mut text,
        ":constants",
        domain.constants().iter().map(typed),
    );
    write_list(
        &mut text,
        ":predicates",
        domain.predicates().iter().map(signature),
    );
    let total_cost = domain
        .uses_costs()
        .then(|| "(total-cost) - number".to_owned());
    let functions = domain
        .functions()
        .iter()
        .map(|f| format!("{} - number", signature(f)));
    write_list(
        &mut text,
        ":functions",
        total_cost.into_iter().chain(functions),
    );
    for operator in domain.operators() {
        text.push('\n');
        write_operator(&mut text, operator);
    }
    text.push_str(")\n");
    text
}

/// The problem as PDDL.
pub fn write_problem(problem: &Problem) -> String {
    let mut text = format!("(define (problem {})\n", problem.name());
    line(
        &mut text,
        1,
        &format!("(:domain {})", problem.domain_name()),
    );
    write_list(&mut text, ":objects", problem.objects().iter().map(typed));
    let minimizes = problem.objective() == Objective::MinimizeCost;
    let total = minimizes.then(|| "(= (total-cost) 0)".to_owned());
    let values = problem
        .values()
        .iter()
        .map(|(atom, value)| format!("(= {atom} {value})"));
    let facts = problem.init().iter().map(ToString::to_string);
    // An empty `:init` must be there all the same.
    text.push_str("    (:init");
    for item in facts.chain(total).chain(values) {
        text.push_str(&format!("\n        {item}"));
    }
    text.push_str(")\n");
    line(&mut text, 1, &format!("(:goal {})", problem.goal()));
    if minimizes {
        line(&mut text, 1, "(:metric minimize (total-cost))");
    }
    text.push_str(")\n");
    text
}

fn line(text: &mut String, depth: usize, content: &str) {
    text.push_str(&"    ".repeat(depth));
    text.push_str(content);
    text.push('\n');
}

/// `(:head item item ...)`, one item a line; nothing at all without items.
fn write_list(text: &mut String, head: &str, items: impl Iterator<Item = String>) {
    let items: Vec<_> = items.collect();
    if items.is_empty() {
        return;
    }
    if head == ":requirements" {
        line(text, 1, &format!("({head} {})", items.join(" ")));
        return;
    }
    line(text, 1, &format!("({head}"));
    for (i, item) in items.iter().enumerate() {
        let close = if i + 1 == items.len() { ")" } else { "" };
        line(text, 2, &format!("{item}{close}"));
    }
}

fn typed(name: &TypedName) -> String {
    format!("{} - {}", name.name, name.type_name)
}

fn signature(signature: &Signature) -> String {
    let gap = if signature.parameters.is_empty() {
        ""
    } else {
        " "
    };
    format!(
        "({}{gap}{})",
        signature.name,
        Variables(&signature.parameters)
    )
}

fn write_operator(text: &mut String, operator: &Operator) {
    if *operator.provenance() != Provenance::Given {
        // A teacher's name may hold anything, and a comment ends with its line.
        let provenance: String = operator
            .provenance()
            .to_string()
            .chars()
            .filter(|c| !c.is_control())
            .collect();
        line(text, 1, &format!("; {provenance}"));
    }
    line(text, 1, &format!("(:action {}", operator.name()));
    line(
        text,
        2,
        &format!(":parameters ({})", Variables(operator.parameters())),
    );
    line(
        text,
        2,
        &format!(":precondition {}", operator.precondition()),
    );
    let effect = match operator.outcomes() {
        [outcome] => outcome_text(outcome),
        outcomes => {
            let mut effect = "(probabilistic".to_owned();
            for outcome in outcomes {
                let part = format!(
                    "\n            {} {}",
                    outcome.probability,
                    outcome_text(outcome)
                );
                effect.push_str(&part);
            }
            effect.push(')');
            effect
        }
    };
    line(text, 2, &format!(":effect {effect})"));
}

fn outcome_text(outcome: &Outcome) -> String {
    let mut parts: Vec<_> = outcome.effects.iter().map(effect_text).collect();
    match &outcome.cost {
        zero if zero.is_zero() => {}
        Cost::Constant(value) => parts.push(format!("(increase (total-cost) {value})")),
        Cost::Function(function) => parts.push(format!("(increase (total-cost) {function})")),
    }
    match parts.as_slice() {
        [] => "(and)".to_owned(),
        parts => format!("(and {})", parts.join(" ")),
    }
}

fn effect_text(effect: &Effect) -> String {
    let mut text = literal(&effect.atom, effect.adds);
    if !effect.when.is_always() {
        text = format!("(when {} {text})", effect.when);
    }
    if !effect.forall.is_empty() {
        text = format!("(forall ({}) {text})", Variables(&effect.forall));
    }
    text
}

fn literal(atom: &AtomPattern, positive: bool) -> String {
    if positive {
        atom.to_string()
    } else {
        format!("(not {atom})")
    }
}

/// The requirements that what the domain holds calls for.
fn requirements(domain: &Domain) -> Vec<String> {
    let mut found = BTreeSet::new();
    if !domain.types().is_empty() {
        found.insert(":typing");
    }
    if domain.uses_costs() {
        found.insert(":action-costs");
    }
    for operator in domain.operators() {
        note_condition(operator.precondition(), &mut found);
        if !operator.is_deterministic() {
            found.insert(":probabilistic-effects");
        }
        for effect in operator.outcomes().iter().flat_map(|o| &o.effects) {
            note_condition(&effect.when, &mut found);
            if !effect.is_plain() {
                found.insert(":conditional-effects");
            }
        }
    }
    std::iter::once(":strips")
        .chain(found)
        .map(str::to_owned)
        .collect()
}

fn note_condition(condition: &Condition, found: &mut BTreeSet<&str>) {
    condition.visit(&mut |part| {
        found.extend(match part {
            Condition::Not(_) => Some(":negative-preconditions"),
            Condition::Equal(..) => Some(":equality"),
            Condition::Or(_) | Condition::Imply(..) => Some(":disjunctive-preconditions"),
            Condition::Forall(..) => Some(":universal-preconditions"),
            Condition::Exists(..) => Some(":existential-preconditions"),
            Condition::Atom(_) | Condition::And(_) => None,
        });
    });
}
