//! Conditions: preconditions, goals and the conditions of conditional effects.

use super::error::{PddlError, Within as _};
use super::read_typed_list::read_variables;
use super::s_expression::{Items, Node};
use crate::operator::{AtomPattern, Condition, Term};

const CONDITION: &str = "a condition such as `(on ?x ?y)` or `(and ...)`";

/// Words that head a condition and so cannot name a predicate.
const RESERVED: &[&str] = &[
    "and",
    "or",
    "not",
    "imply",
    "forall",
    "exists",
    "when",
    "probabilistic",
    "=",
    "either",
];

/// Reads a condition; `()` is always true.
pub(super) fn read_condition(node: &Node) -> Result<Condition, PddlError> {
    let mut items = node.items(CONDITION)?;
    let Some(head) = items.next() else {
        return Ok(Condition::always());
    };
    let head_word =
        head.word("a predicate or `and`, `or`, `not`, `imply`, `forall`, `exists`, `=`")?;
    let keyword = head_word.to_ascii_lowercase();
    match keyword.as_str() {
        "and" => read_all(items).map(Condition::And),
        "or" => read_all(items).map(Condition::Or),
        "not" => {
            let inner = read_condition(items.expect(CONDITION)?)?;
            items.finish()?;
            Ok(Condition::Not(Box::new(inner)))
        }
        "imply" => {
            let premise = read_condition(items.expect(CONDITION)?)?;
            let conclusion = read_condition(items.expect(CONDITION)?)?;
            items.finish()?;
            Ok(Condition::Imply(Box::new(premise), Box::new(conclusion)))
        }
        "forall" | "exists" => {
            let variables = items.expect("a list of variables")?;
            let variables = read_variables(variables.items("a list of variables")?)
                .within(|| format!("the variables of a `{keyword}`"))?;
            let inner = Box::new(read_condition(items.expect(CONDITION)?)?);
            items.finish()?;
            Ok(match keyword.as_str() {
                "forall" => Condition::Forall(variables, inner),
                _ => Condition::Exists(variables, inner),
            })
        }
        "=" => {
            let a = read_term(items.expect("a term")?)?;
            let b = read_term(items.expect("a term")?)?;
            items.finish()?;
            Ok(Condition::Equal(a, b))
        }
        "<" | ">" | "<=" | ">=" => Err(PddlError::unsupported(
            head.at,
            format!("the numeric condition `{head_word}`"),
            "conditions are over predicates",
        )),
        "preference" => Err(PddlError::unsupported(
            head.at,
            "a `preference`",
            "state what must hold, and use action costs for what is nicer",
        )),
        _ => read_atom(node).map(Condition::Atom),
    }
}

fn read_all(mut items: Items<'_>) -> Result<Vec<Condition>, PddlError> {
    let mut conditions = Vec::new();
    while let Some(node) = items.next() {
        conditions.push(read_condition(node)?);
    }
    Ok(conditions)
}

/// Reads a predicate or function applied to terms.
pub(super) fn read_atom(node: &Node) -> Result<AtomPattern, PddlError> {
    let what = "an atom such as `(on ?x ?y)`";
    let mut items = node.items(what)?;
    let head = items.expect("a predicate")?;
    let symbol = head.word("a predicate")?;
    if RESERVED.contains(&symbol.to_ascii_lowercase().as_str()) {
        return Err(PddlError::syntax(head.at, "a predicate", head.shown()));
    }
    let mut terms = Vec::new();
    while let Some(term) = items.next() {
        terms.push(read_term(term)?);
    }
    Ok(AtomPattern {
        symbol: symbol.to_owned(),
        terms,
    })
}

fn read_term(node: &Node) -> Result<Term, PddlError> {
    match node.word("a variable or an object")? {
        "?" | "-" => Err(PddlError::syntax(
            node.at,
            "a variable or an object",
            node.shown(),
        )),
        word => Ok(Term::from(word)),
    }
}
