//! Effects, flattened into the joint outcomes of an operator.
//!
//! PPDDL nests `probabilistic` anywhere; two of them in one `and` turn out independently. Reading
//! multiplies them out, so that an operator has one list of outcomes whose probabilities sum to 1.
//! Mass that the text leaves out belongs to "nothing happens".

use super::error::PddlError;
use super::read_condition::{read_atom, read_condition};
use super::read_typed_list::read_variables;
use super::s_expression::{Items, Node};
use crate::operator::{
    AtomPattern, Condition, Cost, Effect, Outcome, PROBABILITY_SUM_TOLERANCE, Term, TypedName,
};

/// Joint outcomes beyond which an operator is refused.
const N_OUTCOMES_MAX: usize = 1024;

const EFFECT: &str =
    "an effect such as `(on ?x ?y)`, `(not ...)`, `(and ...)` or `(probabilistic ...)`";

/// Reads an effect; `()` and `(and)` change nothing.
pub(super) fn read_effect(node: &Node) -> Result<Vec<Outcome>, PddlError> {
    let mut items = node.items(EFFECT)?;
    let Some(head) = items.next() else {
        return Ok(vec![Outcome::certain()]);
    };
    match head.keyword().as_deref() {
        Some("and") => read_and(items),
        Some("probabilistic") => read_probabilistic(items, node),
        Some("when") => read_when(items, node),
        Some("forall") => read_forall(items, node),
        Some("increase" | "decrease") => read_cost(items, head),
        Some("assign" | "scale-up" | "scale-down") => Err(PddlError::unsupported(
            head.at,
            format!("the numeric effect {}", head.shown()),
            "only `(increase (total-cost) ...)` and `(decrease (reward) ...)` are",
        )),
        Some("not") => {
            let atom = read_atom(items.expect("an atom")?)?;
            items.finish()?;
            Ok(vec![changing(Effect::delete(atom))])
        }
        _ => Ok(vec![changing(Effect::add(read_atom(node)?))]),
    }
}

fn changing(effect: Effect) -> Outcome {
    Outcome {
        effects: vec![effect],
        ..Outcome::certain()
    }
}

fn read_and(mut items: Items<'_>) -> Result<Vec<Outcome>, PddlError> {
    let mut joint = vec![Outcome::certain()];
    while let Some(node) = items.next() {
        let part = read_effect(node)?;
        let n_joint = joint.len() * part.len();
        if n_joint > N_OUTCOMES_MAX {
            let expected = format!("at most {N_OUTCOMES_MAX} joint outcomes");
            return Err(PddlError::syntax(node.at, expected, format!("{n_joint}")));
        }
        let mut next = Vec::with_capacity(n_joint);
        for a in &joint {
            for b in &part {
                next.push(both(a, b, node)?);
            }
        }
        joint = next;
    }
    Ok(joint)
}

/// Two independent outcomes happening together.
fn both(a: &Outcome, b: &Outcome, node: &Node) -> Result<Outcome, PddlError> {
    let cost = match (&a.cost, &b.cost) {
        (cost, zero) | (zero, cost) if zero.is_zero() => cost.clone(),
        (Cost::Constant(x), Cost::Constant(y)) => Cost::Constant(x + y),
        _ => {
            let hint = "add the values up in one function";
            return Err(PddlError::unsupported(
                node.at,
                "a second cost function",
                hint,
            ));
        }
    };
    let effects = a.effects.iter().chain(&b.effects).cloned().collect();
    Ok(Outcome {
        probability: a.probability * b.probability,
        effects,
        cost,
    })
}

fn read_probabilistic(mut items: Items<'_>, node: &Node) -> Result<Vec<Outcome>, PddlError> {
    let mut outcomes = Vec::new();
    let mut sum = 0.0;
    while let Some(number) = items.next() {
        let probability = read_number(number, "a probability")?;
        if !(0.0..=1.0).contains(&probability) {
            return Err(PddlError::syntax(
                number.at,
                "a probability in [0, 1]",
                number.shown(),
            ));
        }
        sum += probability;
        for mut outcome in read_effect(items.expect(EFFECT)?)? {
            outcome.probability *= probability;
            if outcome.probability > 0.0 {
                outcomes.push(outcome);
            }
        }
    }
    if sum > 1.0 + PROBABILITY_SUM_TOLERANCE {
        let expected = "probabilities that sum to at most 1";
        return Err(PddlError::syntax(
            node.at,
            expected,
            format!("a sum of {sum}"),
        ));
    }
    if 1.0 - sum > PROBABILITY_SUM_TOLERANCE || outcomes.is_empty() {
        outcomes.push(Outcome {
            probability: 1.0 - sum,
            ..Outcome::certain()
        });
    }
    Ok(outcomes)
}

fn read_when(mut items: Items<'_>, node: &Node) -> Result<Vec<Outcome>, PddlError> {
    let condition = read_condition(items.expect("a condition")?)?;
    let mut outcomes = read_effect(items.expect(EFFECT)?)?;
    items.finish()?;
    for outcome in &mut outcomes {
        refuse_cost(outcome, node, "when")?;
        for effect in &mut outcome.effects {
            let hidden = effect.forall.iter().find(|v| mentions(&condition, &v.name));
            if let Some(TypedName { name, .. }) = hidden {
                let what = format!("a `forall` that hides `?{name}` of the `when` around it");
                return Err(PddlError::unsupported(
                    node.at,
                    what,
                    "rename the inner variable",
                ));
            }
            effect.when = match (condition.is_always(), effect.when.is_always()) {
                (true, _) => std::mem::take(&mut effect.when),
                (_, true) => condition.clone(),
                _ => Condition::And(vec![condition.clone(), std::mem::take(&mut effect.when)]),
            };
        }
    }
    Ok(outcomes)
}

fn mentions(condition: &Condition, variable: &str) -> bool {
    let is_it = |term: &Term| matches!(term, Term::Variable(v) if v.eq_ignore_ascii_case(variable));
    let mut found = false;
    condition.visit(&mut |part| {
        found |= match part {
            Condition::Atom(atom) => atom.terms.iter().any(is_it),
            Condition::Equal(a, b) => is_it(a) || is_it(b),
            _ => false,
        }
    });
    found
}

fn read_forall(mut items: Items<'_>, node: &Node) -> Result<Vec<Outcome>, PddlError> {
    let variables = items
        .expect("a list of variables")?
        .items("a list of variables")?;
    let variables = read_variables(variables)?;
    let mut outcomes = read_effect(items.expect(EFFECT)?)?;
    items.finish()?;
    if outcomes.len() > 1 {
        let hint = "let the operator take the object as a parameter";
        return Err(PddlError::unsupported(
            node.at,
            "`probabilistic` inside `forall`",
            hint,
        ));
    }
    for outcome in &mut outcomes {
        refuse_cost(outcome, node, "forall")?;
        for effect in &mut outcome.effects {
            let inner = std::mem::take(&mut effect.forall);
            effect.forall = variables.iter().cloned().chain(inner).collect();
        }
    }
    Ok(outcomes)
}

fn refuse_cost(outcome: &Outcome, node: &Node, around: &str) -> Result<(), PddlError> {
    if outcome.cost.is_zero() {
        return Ok(());
    }
    let what = format!("a cost inside `{around}`");
    Err(PddlError::unsupported(
        node.at,
        what,
        "move it to the top of the effect",
    ))
}

/// `(increase (total-cost) c)` and `(decrease (reward) c)` both cost c.
fn read_cost(mut items: Items<'_>, head: &Node) -> Result<Vec<Outcome>, PddlError> {
    let (fluent, verb) = match head.keyword().as_deref() {
        Some("increase") => ("total-cost", "increase"),
        _ => ("reward", "decrease"),
    };
    let node = items.expect("a numeric function")?;
    if node.head().as_deref() != Some(fluent) {
        let hint = format!("`{verb}` is understood for `({fluent})` only");
        return Err(PddlError::unsupported(
            node.at,
            format!("`{verb}` of {}", node.shown()),
            hint,
        ));
    }
    let amount = items.expect("a number or a function")?;
    items.finish()?;
    let cost = match amount.as_word() {
        Some(_) => Cost::Constant(read_cost_value(amount)?),
        None => Cost::Function(read_function(amount)?),
    };
    Ok(vec![Outcome {
        cost,
        ..Outcome::certain()
    }])
}

fn read_cost_value(node: &Node) -> Result<f64, PddlError> {
    let value = read_number(node, "a cost")?;
    if value < 0.0 {
        return Err(PddlError::syntax(
            node.at,
            "a cost of at least 0",
            node.shown(),
        ));
    }
    Ok(value)
}

fn read_function(node: &Node) -> Result<AtomPattern, PddlError> {
    match node.head().as_deref() {
        Some(operator @ ("+" | "-" | "*" | "/")) => Err(PddlError::unsupported(
            node.at,
            format!("arithmetic with `{operator}`"),
            "give the problem a function with the result",
        )),
        _ => read_atom(node),
    }
}

/// Reads a finite number.
pub(super) fn read_number(node: &Node, expected: &str) -> Result<f64, PddlError> {
    let number = node.as_word().and_then(|word| word.parse::<f64>().ok());
    number
        .filter(|value| value.is_finite())
        .ok_or_else(|| PddlError::syntax(node.at, expected, node.shown()))
}
