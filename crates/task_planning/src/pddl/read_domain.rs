//! Domain files.

use super::error::{PddlError, Position, Within as _};
use super::read_condition::read_condition;
use super::read_effect::read_effect;
use super::read_typed_list::{read_names, read_variables};
use super::s_expression::{self, Items, Node};
use crate::operator::{
    Domain, DomainBuilder, Operator, Outcome, Signature, SignatureKind, TypedName,
};

/// Requirements whose constructs can be read, or that only announce constructs refused where they occur.
const REQUIREMENTS: &[&str] = &[
    ":strips",
    ":typing",
    ":negative-preconditions",
    ":disjunctive-preconditions",
    ":existential-preconditions",
    ":universal-preconditions",
    ":quantified-preconditions",
    ":equality",
    ":conditional-effects",
    ":adl",
    ":action-costs",
    ":probabilistic-effects",
    ":rewards",
    ":mdp",
    ":fluents",
    ":numeric-fluents",
];

/// Functions that stand for the cost itself, which every domain has.
const COST_FLUENTS: &[&str] = &["total-cost", "reward"];

/// Reads a PDDL or PPDDL domain.
///
/// What `:requirements` leaves out does not matter: learned files rarely list all they use.
///
/// # Errors
/// See [`PddlError`]; every variant has the place.
pub fn parse_domain(text: &str) -> Result<Domain, PddlError> {
    let root = s_expression::parse(text, "`(define (domain ...) ...)`")?;
    read_domain(&root, DomainExtras::default()).within(|| "the domain".to_owned())
}

/// Declarations to add to what the text declares.
#[derive(Debug, Default)]
pub(super) struct DomainExtras {
    /// Types directly under `object`.
    pub(super) types: Vec<String>,
}

pub(super) fn read_domain(root: &Node, extras: DomainExtras) -> Result<Domain, PddlError> {
    let mut items = root.items("`(define (domain ...) ...)`")?;
    items.literal("define")?;
    let name = read_header(&mut items, "domain")?;
    let mut builder = Domain::builder(name);
    for type_name in extras.types {
        builder = builder.object_type(type_name, crate::operator::OBJECT);
    }
    let mut operators: Vec<(Position, Operator)> = Vec::new();
    while let Some(section) = items.next() {
        let mut content = section.items("a section such as `(:predicates ...)`")?;
        let head = content.expect("a section such as `:predicates`")?;
        let keyword = head.keyword();
        if keyword.as_deref() == Some(":action") {
            operators.push((section.at, read_action(content, section.at)?));
        } else {
            builder = read_section(builder, head, content)
                .within(|| format!("section {}", head.shown()))?;
        }
    }
    let mut domain = builder
        .build()
        .map_err(|e| PddlError::invalid(root.at, e))?;
    for (at, operator) in operators {
        domain = domain
            .with_operator(operator)
            .map_err(|e| PddlError::invalid(at, e))?;
    }
    Ok(domain)
}

/// `(domain NAME)` or `(problem NAME)`.
pub(super) fn read_header<'a>(items: &mut Items<'a>, kind: &str) -> Result<&'a str, PddlError> {
    let expected = format!("`({kind} NAME)`");
    let mut header = items.expect(&expected)?.items(&expected)?;
    header.literal(kind)?;
    let name = header.word(&format!("the name of the {kind}"))?;
    header.finish()?;
    Ok(name)
}

fn read_section(
    mut builder: DomainBuilder,
    head: &Node,
    content: Items<'_>,
) -> Result<DomainBuilder, PddlError> {
    match head.keyword().as_deref() {
        Some(":requirements") => check_requirements(content)?,
        Some(":types") => {
            for TypedName { name, type_name } in read_names(content, "a type name")? {
                // Some files declare the root type too.
                if !name.eq_ignore_ascii_case(crate::operator::OBJECT) {
                    builder = builder.object_type(name, type_name);
                }
            }
        }
        Some(":constants") => {
            for TypedName { name, type_name } in read_names(content, "a constant's name")? {
                builder = builder.constant(name, type_name);
            }
        }
        Some(":predicates") => {
            for signature in read_signatures(content, "a predicate such as `(on ?x ?y)`")? {
                builder = builder.signature(SignatureKind::Predicate, signature);
            }
        }
        Some(":functions") => {
            for signature in read_signatures(content, "a function such as `(total-cost)`")? {
                if !COST_FLUENTS.contains(&signature.name.to_ascii_lowercase().as_str()) {
                    builder = builder.signature(SignatureKind::Function, signature);
                }
            }
        }
        Some(keyword @ (":derived" | ":durative-action" | ":constraints")) => {
            let hint = "write it with actions and predicates";
            return Err(PddlError::unsupported(
                head.at,
                format!("`{keyword}`"),
                hint,
            ));
        }
        _ => {
            let expected =
                "`:requirements`, `:types`, `:constants`, `:predicates`, `:functions` or `:action`";
            return Err(PddlError::syntax(head.at, expected, head.shown()));
        }
    }
    Ok(builder)
}

pub(super) fn check_requirements(mut content: Items<'_>) -> Result<(), PddlError> {
    while let Some(node) = content.next() {
        let requirement = node.word("a requirement such as `:strips`")?;
        if !REQUIREMENTS.contains(&requirement.to_ascii_lowercase().as_str()) {
            let hint = format!("understood are {}", REQUIREMENTS.join(" "));
            return Err(PddlError::unsupported(
                node.at,
                format!("`{requirement}`"),
                hint,
            ));
        }
    }
    Ok(())
}

fn read_signatures(mut items: Items<'_>, what: &str) -> Result<Vec<Signature>, PddlError> {
    let mut signatures = Vec::new();
    while let Some(node) = items.next() {
        // `- number` after functions is the only type they can have.
        if node.as_word() == Some("-") && !signatures.is_empty() {
            items.literal("number")?;
            continue;
        }
        let mut content = node.items(what)?;
        let name = content.word("a name")?.to_owned();
        let parameters =
            read_variables(content).within(|| format!("the parameters of `{name}`"))?;
        signatures.push(Signature { name, parameters });
    }
    Ok(signatures)
}

fn read_action(mut content: Items<'_>, at: Position) -> Result<Operator, PddlError> {
    let name = content
        .word("the action's name")
        .within(|| "an action".to_owned())?;
    read_action_body(name, content, at).within(|| format!("action `{name}`"))
}

fn read_action_body(
    name: &str,
    mut content: Items<'_>,
    at: Position,
) -> Result<Operator, PddlError> {
    let (mut parameters, mut precondition, mut outcomes) = (None, None, None);
    while let Some(key) = content.next() {
        let keyword = key.keyword().unwrap_or_default();
        match keyword.as_str() {
            ":parameters" if parameters.is_none() => {
                let list = content.expect("a list of parameters")?;
                let list = list.items("a list of parameters such as `(?x - item)`")?;
                parameters = Some(read_variables(list).within(|| "the parameters".to_owned())?);
            }
            ":precondition" if precondition.is_none() => {
                let node = content.expect("a condition")?;
                precondition = Some(read_condition(node).within(|| "the precondition".to_owned())?);
            }
            ":effect" if outcomes.is_none() => {
                let node = content.expect("an effect")?;
                outcomes = Some(read_effect(node).within(|| "the effect".to_owned())?);
            }
            _ => {
                let expected = "`:parameters`, `:precondition` or `:effect`, each once";
                return Err(PddlError::syntax(key.at, expected, key.shown()));
            }
        }
    }
    let mut builder = Operator::builder(name);
    for TypedName { name, type_name } in parameters.unwrap_or_default() {
        builder = builder.parameter(name, type_name);
    }
    if let Some(condition) = precondition {
        builder = builder.requires(condition);
    }
    for outcome in outcomes.unwrap_or_else(|| vec![Outcome::certain()]) {
        builder = builder.outcome(outcome);
    }
    builder.build().map_err(|e| PddlError::invalid(at, e))
}
