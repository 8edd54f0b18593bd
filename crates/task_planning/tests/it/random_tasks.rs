//! Laws over random tasks, with an exhaustive search as the truth about solvability.

use std::collections::{BTreeSet, VecDeque};

use factotum_task_planning::operator::{Condition, Domain, GroundAction, Operator, Plan, Problem};
use factotum_task_planning::planner::{Ferroplan, Limits, PlanOutcome, Planner};
use factotum_task_planning::validate::{World, execute, validate};
use proptest::prelude::*;

use crate::planners::fast_downward;

const FACTS: [&str; 6] = ["f0", "f1", "f2", "f3", "f4", "f5"];

/// What one operator reads, adds and deletes, as indices of facts; true reads positively.
type RandomOperator = (Vec<(usize, bool)>, Vec<usize>, Vec<usize>);

fn random_operator() -> impl Strategy<Value = RandomOperator> {
    let fact = || 0..FACTS.len();
    (
        prop::collection::vec((fact(), prop::bool::weighted(0.7)), 1..4),
        prop::collection::vec(fact(), 1..3),
        prop::collection::vec(fact(), 0..3),
    )
}

fn literal(fact: usize, positive: bool) -> Condition {
    if positive {
        Condition::atom(FACTS[fact], [])
    } else {
        Condition::not_atom(FACTS[fact], [])
    }
}

fn random_task() -> impl Strategy<Value = (Domain, Problem)> {
    let goal = prop::collection::btree_map(0..FACTS.len(), prop::bool::weighted(0.8), 1..4);
    let init = prop::collection::btree_set(0..FACTS.len(), 0..4);
    (prop::collection::vec(random_operator(), 1..8), init, goal).prop_map(
        |(operators, init, goal)| {
            let mut domain = Domain::builder("random");
            for fact in FACTS {
                domain = domain.predicate(fact, []);
            }
            for (i, (reads, adds, deletes)) in operators.into_iter().enumerate() {
                let mut operator = Operator::builder(format!("act-{i}"));
                for (fact, positive) in reads {
                    operator = operator.requires(literal(fact, positive));
                }
                for fact in adds {
                    operator = operator.adds(FACTS[fact], []);
                }
                for fact in deletes {
                    operator = operator.deletes(FACTS[fact], []);
                }
                domain = domain.operator(operator.build().unwrap());
            }
            let domain = domain.build().unwrap();
            let goal = goal
                .into_iter()
                .map(|(fact, positive)| literal(fact, positive));
            let mut problem = Problem::builder("random").goal(Condition::all(goal));
            for fact in init {
                problem = problem.fact(FACTS[fact], []);
            }
            let problem = problem.build(&domain).unwrap();
            (domain, problem)
        },
    )
}

/// Breadth-first search over all states: the length of a shortest plan.
fn shortest(domain: &Domain, problem: &Problem) -> Option<usize> {
    let world = World::new(domain, problem);
    let mut seen = BTreeSet::from([world.initial_state()]);
    let mut queue = VecDeque::from([(world.initial_state(), 0)]);
    while let Some((state, depth)) = queue.pop_front() {
        if world.unmet_goal(&state).is_empty() {
            return Some(depth);
        }
        for operator in domain.operators() {
            let action = GroundAction::new(operator.name(), [] as [&str; 0]);
            let bound = world.bind(&action).unwrap();
            if world.unmet_precondition(&state, &bound).is_empty() {
                let after = world.apply(&state, &bound, &operator.outcomes()[0]);
                if seen.insert(after.clone()) {
                    queue.push_back((after, depth + 1));
                }
            }
        }
    }
    None
}

fn check_against_truth(
    planner: &dyn Planner,
    domain: &Domain,
    problem: &Problem,
) -> Result<(), TestCaseError> {
    let truth = shortest(domain, problem);
    match planner.solve(domain, problem, &Limits::default()).unwrap() {
        PlanOutcome::Solved { plan, .. } => {
            prop_assert!(truth.is_some_and(|length| plan.steps.len() >= length));
            prop_assert!(validate(domain, problem, &plan).is_ok());
        }
        PlanOutcome::Unsolvable { .. } => prop_assert_eq!(truth, None),
        other => prop_assert!(false, "{:?}, truth {:?}", other, truth),
    }
    Ok(())
}

proptest! {
    #[test]
    fn ferroplan_agrees_with_exhaustive_search((domain, problem) in random_task()) {
        check_against_truth(&Ferroplan::default(), &domain, &problem)?;
    }

    /// Leaving out a step, or doing one twice, either fails with a reason or still solves the task;
    /// and what the validator accepts, plain simulation accepts.
    #[test]
    fn corrupted_plans_are_judged_as_simulation_judges_them(
        (domain, problem) in random_task(), at: prop::sample::Index, twice: bool
    ) {
        let outcome = Ferroplan::default().solve(&domain, &problem, &Limits::default()).unwrap();
        let Some(plan) = outcome.plan().filter(|plan| !plan.steps.is_empty()) else {
            return Ok(());
        };
        let mut steps = plan.steps.clone();
        let i = at.index(steps.len());
        if twice { steps.insert(i, steps[i].clone()) } else { drop(steps.remove(i)) }
        let valid = execute(&domain, &problem, &steps).is_ok();
        prop_assert_eq!(valid, simulate(&domain, &problem, &steps));
        let wrong_cost = Plan { steps, cost: plan.cost };
        prop_assert!(validate(&domain, &problem, &wrong_cost).is_err());
    }
}

/// A second, plainer reading of propositional STRIPS: sets of names, nothing shared with the validator.
fn simulate(domain: &Domain, problem: &Problem, steps: &[GroundAction]) -> bool {
    let mut facts: BTreeSet<String> = problem.init().iter().map(|a| a.symbol.clone()).collect();
    let holds = |facts: &BTreeSet<String>, condition: &Condition| {
        condition.conjuncts().iter().all(|part| match part {
            Condition::Atom(atom) => facts.contains(&atom.symbol),
            Condition::Not(inner) => match inner.as_ref() {
                Condition::Atom(atom) => !facts.contains(&atom.symbol),
                _ => unreachable!(),
            },
            _ => unreachable!(),
        })
    };
    for step in steps {
        let operator = domain.operator(&step.name).unwrap();
        if !holds(&facts, operator.precondition()) {
            return false;
        }
        let effects = &operator.outcomes()[0].effects;
        for effect in effects.iter().filter(|e| !e.adds) {
            facts.remove(&effect.atom.symbol);
        }
        for effect in effects.iter().filter(|e| e.adds) {
            facts.insert(effect.atom.symbol.clone());
        }
    }
    holds(&facts, problem.goal())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    #[test]
    fn fast_downward_agrees_with_exhaustive_search((domain, problem) in random_task()) {
        if let Some(planner) = fast_downward() {
            check_against_truth(&planner, &domain, &problem)?;
        }
    }
}
