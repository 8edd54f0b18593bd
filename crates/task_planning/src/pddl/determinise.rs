//! From PPDDL to PDDL: one operator for each outcome, whose cost says how unlikely it is.
//!
//! All-outcomes determinisation (Yoon, Fern & Givan, "FF-Replan", ICAPS 2007) with the costs of
//! maximum-likelihood planning: an outcome of probability p costs -w ln p, so that the cheapest
//! plan is the sequence of outcomes most likely to happen as planned, exp(-cost / w). Costs are
//! rounded up to whole numbers, because several planners take no others; with w = 1000 the error is
//! below 0.1 % of a step's probability.
//!
//! The dissertation plans on learned PPDDL (5.4). Re-planning its own learned domains so, with Fast
//! Downward, finds the plans its probabilistic planner found.

use std::collections::BTreeMap;

use crate::names::fold;
use crate::operator::{
    Cost, Domain, GroundAction, Objective, Operator, OperatorError, Outcome, Plan, PredicateReads,
    Problem,
};

/// How to determinise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeterminiseOptions {
    /// Cost of one nat of improbability, w above. Default 1000.
    pub cost_per_nat: f64,
    /// How much of the operators' own costs is added. Default 0: likelihood alone counts.
    pub own_cost_weight: f64,
}

impl Default for DeterminiseOptions {
    fn default() -> Self {
        Self {
            cost_per_nat: 1000.0,
            own_cost_weight: 0.0,
        }
    }
}

/// A deterministic domain and problem, and where its operators come from.
#[derive(Debug, Clone)]
pub struct Determinised {
    /// The deterministic domain.
    pub domain: Domain,
    /// The problem, now asking for the cheapest plan.
    pub problem: Problem,
    origins: BTreeMap<String, Origin>,
}

/// One outcome of one operator of the probabilistic domain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// The operator's name.
    pub operator: String,
    /// Which of its outcomes, from 0.
    pub outcome_idx: usize,
}

impl Determinised {
    /// The outcome a deterministic operator stands for.
    pub fn origin(&self, operator: &str) -> Option<&Origin> {
        self.origins.get(&fold(operator))
    }

    /// The plan in the names of the probabilistic domain, at the same cost.
    pub fn restore(&self, plan: &Plan) -> Plan {
        let original = |step: &GroundAction| match self.origin(&step.name) {
            Some(origin) => GroundAction::new(&origin.operator, &step.args),
            None => step.clone(),
        };
        Plan {
            steps: plan.steps.iter().map(original).collect(),
            cost: plan.cost,
        }
    }
}

/// Splits every operator into one for each outcome that can be of use.
///
/// Outcomes that add nothing are left out where that provably loses no plan: no condition of the
/// domain or problem reads a negative literal, and no effect is conditional. The failure outcomes of
/// learned domains are of this kind. An operator with one outcome keeps its name; the others get
/// `--outcome-N` appended. The domain's function costs count only where `own_cost_weight` is 0,
/// since a sum of a function and a number is no PDDL cost; see [`OperatorError::Cost`].
///
/// # Errors
/// A name is taken already, or an operator's cost is a function while `own_cost_weight` is not 0.
pub fn determinise(
    domain: &Domain,
    problem: &Problem,
    options: &DeterminiseOptions,
) -> Result<Determinised, OperatorError> {
    let drop_useless = is_monotone(domain, problem);
    let mut operators = Vec::new();
    let mut origins = BTreeMap::new();
    for operator in domain.operators() {
        for (outcome_idx, outcome) in operator.outcomes().iter().enumerate() {
            if drop_useless && !outcome.effects.iter().any(|e| e.adds) {
                continue;
            }
            let split = only_outcome(operator, outcome_idx, outcome, options)?;
            let origin = Origin {
                operator: operator.name().to_owned(),
                outcome_idx,
            };
            origins.insert(fold(split.name()), origin);
            operators.push(split);
        }
    }
    let domain = domain.clone().into_builder().operators(operators).build()?;
    let problem = problem
        .clone()
        .into_builder()
        .objective(Objective::MinimizeCost)
        .build(&domain)?;
    Ok(Determinised {
        domain,
        problem,
        origins,
    })
}

fn only_outcome(
    operator: &Operator,
    outcome_idx: usize,
    outcome: &Outcome,
    options: &DeterminiseOptions,
) -> Result<Operator, OperatorError> {
    let own = match &outcome.cost {
        _ if options.own_cost_weight == 0.0 => 0.0,
        Cost::Constant(value) => options.own_cost_weight * value,
        Cost::Function(_) => {
            let owner = format!("operator `{}` (a function)", operator.name());
            return Err(OperatorError::Cost {
                owner,
                found: f64::NAN,
            });
        }
    };
    let name = match operator.is_deterministic() {
        true => operator.name().to_owned(),
        false => format!("{}--outcome-{outcome_idx}", operator.name()),
    };
    let mut builder = Operator::builder(name)
        .requires(operator.precondition().clone())
        .provenance(operator.provenance().clone());
    for parameter in operator.parameters() {
        builder = builder.parameter(&parameter.name, &parameter.type_name);
    }
    for effect in &outcome.effects {
        builder = builder.effect(effect.clone());
    }
    builder
        .cost(improbability_cost(outcome.probability, options) + own)
        .build()
}

/// -w ln p in whole numbers, never negative.
fn improbability_cost(probability: f64, options: &DeterminiseOptions) -> f64 {
    (-options.cost_per_nat * probability.ln()).max(0.0).ceil()
}

/// Whether more facts never hurt: no negative literal is read and no effect is conditional.
fn is_monotone(domain: &Domain, problem: &Problem) -> bool {
    let mut reads = PredicateReads::default();
    problem.goal().polarity(false, &mut reads);
    let mut conditional = false;
    for operator in domain.operators() {
        operator.precondition().polarity(false, &mut reads);
        conditional |= operator
            .outcomes()
            .iter()
            .flat_map(|o| &o.effects)
            .any(|e| !e.is_plain());
    }
    reads.negative.is_empty() && !conditional
}
