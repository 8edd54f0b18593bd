//! Problem files, and domain and problem read together.

use super::error::{PddlError, Within as _};
use super::read_condition::{read_atom, read_condition};
use super::read_domain::{DomainExtras, check_requirements, read_domain, read_header};
use super::read_effect::read_number;
use super::read_typed_list::read_names;
use super::s_expression::{self, Items, Node};
use crate::names::fold;
use crate::operator::{Atom, Domain, OBJECT, Objective, Problem, ProblemBuilder, Term, TypedName};

/// What to do where a problem's objects have types that the domain does not declare.
///
/// PDDL forbids it. Files learned by the skills-to-symbols line of work do it for objects no
/// operator mentions, and their own planner never minded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UndeclaredTypes {
    /// Refuse the problem.
    #[default]
    Refuse,
    /// Declare them in the domain, directly under `object`.
    Declare,
}

/// A domain and a problem that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct ParsedTask {
    /// The domain.
    pub domain: Domain,
    /// The problem.
    pub problem: Problem,
    /// Types that were declared for the problem's sake (see [`UndeclaredTypes::Declare`]).
    pub added_types: Vec<String>,
}

/// Reads a PDDL problem of the domain.
///
/// # Errors
/// See [`PddlError`]; every variant has the place.
pub fn parse_problem(text: &str, domain: &Domain) -> Result<Problem, PddlError> {
    let root = s_expression::parse(text, PROBLEM)?;
    read_problem(&root, domain).within(|| "the problem".to_owned())
}

/// Reads a domain and a problem together.
///
/// # Errors
/// See [`PddlError`]; the context says in which of the two texts the place is.
pub fn parse_task(
    domain_text: &str,
    problem_text: &str,
    undeclared: UndeclaredTypes,
) -> Result<ParsedTask, PddlError> {
    let domain_root = s_expression::parse(domain_text, "`(define (domain ...) ...)`")
        .within(|| "the domain".to_owned())?;
    let problem_root =
        s_expression::parse(problem_text, PROBLEM).within(|| "the problem".to_owned())?;
    let read = |types| {
        read_domain(&domain_root, DomainExtras { types }).within(|| "the domain".to_owned())
    };
    let mut domain = read(Vec::new())?;
    let mut added_types = Vec::new();
    if undeclared == UndeclaredTypes::Declare {
        added_types = undeclared_types(&problem_root, &domain)?;
        domain = read(added_types.clone())?;
    }
    let problem = read_problem(&problem_root, &domain).within(|| "the problem".to_owned())?;
    Ok(ParsedTask {
        domain,
        problem,
        added_types,
    })
}

const PROBLEM: &str = "`(define (problem ...) ...)`";

/// Types of the problem's objects that the domain does not have, in order of appearance.
fn undeclared_types(root: &Node, domain: &Domain) -> Result<Vec<String>, PddlError> {
    let mut missing: Vec<String> = Vec::new();
    let mut items = root.items(PROBLEM)?;
    while let Some(section) = items.next() {
        if section.head().as_deref() != Some(":objects") {
            continue;
        }
        let mut content = section.items(PROBLEM)?;
        content.next();
        for TypedName { type_name, .. } in read_names(content, "an object's name")? {
            let declared = domain.types().iter().map(|t| &t.name).chain(&missing);
            if !declared.map(|t| fold(t)).any(|t| t == fold(&type_name))
                && fold(&type_name) != OBJECT
            {
                missing.push(type_name);
            }
        }
    }
    Ok(missing)
}

fn read_problem(root: &Node, domain: &Domain) -> Result<Problem, PddlError> {
    let mut items = root.items(PROBLEM)?;
    items.literal("define")?;
    let mut builder = Problem::builder(read_header(&mut items, "problem")?);
    let mut has_goal = false;
    while let Some(section) = items.next() {
        let mut content = section.items("a section such as `(:init ...)`")?;
        let head = content.expect("a section such as `:init`")?;
        has_goal |= head.keyword().as_deref() == Some(":goal");
        builder =
            read_section(builder, head, content).within(|| format!("section {}", head.shown()))?;
    }
    if !has_goal {
        items.expect("a `(:goal ...)`")?;
    }
    builder
        .build(domain)
        .map_err(|e| PddlError::invalid(root.at, e))
}

fn read_section(
    mut builder: ProblemBuilder,
    head: &Node,
    mut content: Items<'_>,
) -> Result<ProblemBuilder, PddlError> {
    match head.keyword().as_deref() {
        Some(":domain") => {
            builder = builder.domain(content.word("the name of the domain")?);
            content.finish()?;
        }
        Some(":requirements") => check_requirements(content)?,
        Some(":objects") => {
            for TypedName { name, type_name } in read_names(content, "an object's name")? {
                builder = builder.object(name, type_name);
            }
        }
        Some(":init") => {
            while let Some(node) = content.next() {
                builder = read_fact(builder, node)?;
            }
        }
        Some(":goal") => {
            builder = builder.goal(read_condition(content.expect("a condition")?)?);
            content.finish()?;
        }
        Some(":metric") => builder = builder.objective(read_metric(content)?),
        _ => {
            let expected = "`:domain`, `:requirements`, `:objects`, `:init`, `:goal` or `:metric`";
            return Err(PddlError::syntax(head.at, expected, head.shown()));
        }
    }
    Ok(builder)
}

fn read_fact(builder: ProblemBuilder, node: &Node) -> Result<ProblemBuilder, PddlError> {
    match node.head().as_deref() {
        Some("=") => read_value(builder, node),
        // A fact that does not hold needs no word: what is not listed does not hold.
        Some("not") => Ok(builder),
        Some("probabilistic") => Err(PddlError::unsupported(
            node.at,
            "a probabilistic initial state",
            "give the plan's probability an initial distribution instead",
        )),
        _ => Ok(builder.facts([read_ground_atom(node)?])),
    }
}

fn read_value(builder: ProblemBuilder, node: &Node) -> Result<ProblemBuilder, PddlError> {
    let mut items = node.items("`(= (function ...) number)`")?;
    items.literal("=")?;
    let function = items.expect("a function such as `(distance a b)`")?;
    let value = read_number(items.expect("a number")?, "a number")?;
    items.finish()?;
    match function.head().as_deref() {
        Some("total-cost" | "reward") => Ok(builder),
        _ => Ok(builder.value(read_ground_atom(function)?, value)),
    }
}

fn read_ground_atom(node: &Node) -> Result<Atom, PddlError> {
    let pattern = read_atom(node)?;
    let args = pattern.terms.into_iter().map(|term| match term {
        Term::Object(name) => Ok(name),
        Term::Variable(name) => Err(PddlError::syntax(
            node.at,
            "an atom over objects",
            format!("`?{name}`"),
        )),
    });
    Ok(Atom {
        symbol: pattern.symbol,
        args: args.collect::<Result<_, _>>()?,
    })
}

fn read_metric(mut content: Items<'_>) -> Result<Objective, PddlError> {
    let direction = content.expect("`minimize` or `maximize`")?;
    let fluent = content.expect("`(total-cost)` or `(reward)`")?;
    content.finish()?;
    match (direction.keyword().as_deref(), fluent.head().as_deref()) {
        (Some("minimize"), Some("total-cost")) | (Some("maximize"), Some("reward")) => {
            Ok(Objective::MinimizeCost)
        }
        _ => Err(PddlError::unsupported(
            direction.at,
            format!("the metric {} {}", direction.shown(), fluent.shown()),
            "understood are `minimize (total-cost)` and `maximize (reward)`",
        )),
    }
}
