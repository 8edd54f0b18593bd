//! What every back end does alike: refusing tasks it cannot take, and judging what it returns.

use super::{PlanOutcome, PlanStats, PlannerError};
use crate::operator::{Domain, GroundAction, Plan, Problem};
use crate::validate::{PlanFault, World, execute};

/// Refuses probabilistic domains and problems of another domain.
pub(super) fn check_task(
    planner: &str,
    domain: &Domain,
    problem: &Problem,
) -> Result<(), PlannerError> {
    if problem.domain_name() != domain.name() {
        let (found, wanted) = (problem.domain_name(), domain.name());
        return Err(PlannerError::InvalidTask {
            planner: planner.to_owned(),
            reason: format!(
                "problem `{}` is for domain `{found}`, expected `{wanted}`",
                problem.name()
            ),
        });
    }
    if let Some(operator) = domain.operators().iter().find(|o| !o.is_deterministic()) {
        return Err(PlannerError::Unsupported {
            planner: planner.to_owned(),
            what: format!(
                "operator `{}` with its probabilistic outcomes",
                operator.name()
            ),
            hint: "determinise the domain first".to_owned(),
        });
    }
    Ok(())
}

/// Gives the steps the spelling of the task, runs them, and returns them with their true cost.
pub(super) fn accept(
    planner: &str,
    domain: &Domain,
    problem: &Problem,
    steps: &[GroundAction],
    stats: PlanStats,
) -> Result<PlanOutcome, PlannerError> {
    let world = World::new(domain, problem);
    let invalid = |fault| PlannerError::InvalidPlan {
        planner: planner.to_owned(),
        fault,
    };
    let spelled = |(i, step): (usize, &GroundAction)| match world.bind(step) {
        Ok(bound) => Ok(bound.ground_action()),
        Err(fault) => Err(PlanFault::Action {
            step: i + 1,
            action: step.clone(),
            fault: Box::new(fault),
        }),
    };
    let steps: Vec<_> = steps
        .iter()
        .enumerate()
        .map(spelled)
        .collect::<Result<_, _>>()
        .map_err(invalid)?;
    let valid = execute(domain, problem, &steps).map_err(invalid)?;
    Ok(PlanOutcome::Solved {
        plan: Plan {
            steps,
            cost: valid.cost,
        },
        stats,
    })
}
