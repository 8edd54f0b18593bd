//! Whole-number costs for planners that take no others.

use crate::operator::{Cost, Domain, Operator, OperatorError, Outcome, Problem};

/// Scales that are tried, in order; costs that are whole under none of them are rounded at the last.
const SCALES: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];

/// How far a scaled cost may be from a whole number and still count as one (f64 rounding only).
const WHOLE_TOLERANCE: f64 = 1e-6;

/// The task with all costs multiplied by one scale and rounded.
pub(super) fn with_integer_costs(
    domain: &Domain,
    problem: &Problem,
) -> Result<(Domain, Problem), OperatorError> {
    let scale = scale(domain, problem);
    let whole = |cost: f64| (cost * scale).round();
    let mut operators = Vec::new();
    for operator in domain.operators() {
        operators.push(with_costs(operator, whole)?);
    }
    let domain = domain.clone().into_builder().operators(operators).build()?;
    let values = problem
        .values()
        .iter()
        .map(|(atom, v)| (atom.clone(), whole(*v)))
        .collect();
    let problem = problem
        .clone()
        .into_builder()
        .replace_values(values)
        .build(&domain)?;
    Ok((domain, problem))
}

fn scale(domain: &Domain, problem: &Problem) -> f64 {
    let outcomes = domain.operators().iter().flat_map(Operator::outcomes);
    let constants = outcomes.filter_map(|outcome| match outcome.cost {
        Cost::Constant(value) => Some(value),
        Cost::Function(_) => None,
    });
    let costs: Vec<f64> = constants
        .chain(problem.values().values().copied())
        .collect();
    let is_whole = |value: f64| (value - value.round()).abs() <= WHOLE_TOLERANCE;
    let fits = |scale: &&f64| costs.iter().all(|cost| is_whole(cost * **scale));
    SCALES
        .iter()
        .find(fits)
        .copied()
        .unwrap_or(SCALES[SCALES.len() - 1])
}

fn with_costs(operator: &Operator, whole: impl Fn(f64) -> f64) -> Result<Operator, OperatorError> {
    let mut builder = Operator::builder(operator.name())
        .requires(operator.precondition().clone())
        .provenance(operator.provenance().clone());
    for parameter in operator.parameters() {
        builder = builder.parameter(&parameter.name, &parameter.type_name);
    }
    for outcome in operator.outcomes() {
        let cost = match &outcome.cost {
            Cost::Constant(value) => Cost::Constant(whole(*value)),
            function @ Cost::Function(_) => function.clone(),
        };
        builder = builder.outcome(Outcome {
            cost,
            ..outcome.clone()
        });
    }
    builder.build()
}
