//! What every planner must do: find plans where there are some, and only there.

use std::path::PathBuf;

use factotum_task_planning::operator::{GroundAction, Plan};
use factotum_task_planning::planner::{
    FastDownward, Ferroplan, Limits, PlanOutcome, PlanQuality, Planner, PlannerError,
};
use factotum_task_planning::validate::validate;

use crate::tasks::{chores, coffee, tasks};

/// Fast Downward from the PATH or the active virtual environment.
#[expect(clippy::print_stderr, reason = "a skipped test says why")]
pub(crate) fn fast_downward() -> Option<FastDownward> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut candidates: Vec<PathBuf> = std::env::split_paths(&path).collect();
    candidates.extend(std::env::var_os("VIRTUAL_ENV").map(PathBuf::from));
    match FastDownward::discover(&candidates) {
        Ok(planner) => Some(planner),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

fn check_planner(planner: &dyn Planner) {
    for task in tasks() {
        let outcome = planner
            .solve(&task.domain, &task.problem, &Limits::default())
            .unwrap();
        match outcome {
            PlanOutcome::Solved { plan, .. } => {
                assert!(task.solvable, "{}: found {plan}", task.name);
                validate(&task.domain, &task.problem, &plan).unwrap();
            }
            PlanOutcome::Unsolvable { .. } => assert!(!task.solvable, "{}", task.name),
            other => panic!("{}: {other:?}", task.name),
        }
    }
}

#[test]
fn ferroplan_tells_solvable_from_unsolvable() {
    check_planner(&Ferroplan::default());
}

#[test]
fn fast_downward_tells_solvable_from_unsolvable() {
    if let Some(planner) = fast_downward() {
        check_planner(&planner);
    }
}

/// The dissertation's plan for coffee has eight actions, and there is no shorter one.
#[test]
fn coffee_takes_eight_actions() {
    let (domain, problem) = coffee();
    let planner = Ferroplan {
        quality: PlanQuality::Optimal,
    };
    let outcome = planner
        .solve(&domain, &problem, &Limits::default())
        .unwrap();
    let satisficing = Ferroplan::default()
        .solve(&domain, &problem, &Limits::default())
        .unwrap();
    let plan = outcome.plan().or(satisficing.plan()).unwrap().clone();
    assert_eq!(plan.cost, 8.0, "{plan}");
    assert_eq!(
        plan.steps.last(),
        Some(&GroundAction::new("PushButton", ["CoffeeMachine"]))
    );
}

/// Fast Downward rounds scaled costs; what comes back is the true cost, and optimal is optimal.
#[test]
fn optimal_plans_cost_the_same_in_both_planners() {
    let Some(fast_downward) = fast_downward() else {
        return;
    };
    // Landmark-cut takes neither conditional effects nor the axioms of quantified preconditions.
    for goal in ["bottle", "wrapper"] {
        let (domain, problem) = chores();
        let kept = domain
            .operators()
            .iter()
            .filter(|o| o.name() != "inspect")
            .cloned();
        let mut reduced = factotum_task_planning::operator::Domain::builder("chores");
        for t in domain.types() {
            reduced = reduced.object_type(&t.name, &t.type_name);
        }
        for c in domain.constants() {
            reduced = reduced.constant(&c.name, &c.type_name);
        }
        for p in domain.predicates() {
            let parameters = p
                .parameters
                .iter()
                .map(|p| (p.name.as_str(), p.type_name.as_str()));
            reduced = reduced.predicate(&p.name, parameters);
        }
        for f in domain.functions() {
            let parameters = f
                .parameters
                .iter()
                .map(|p| (p.name.as_str(), p.type_name.as_str()));
            reduced = reduced.function(&f.name, parameters);
        }
        let reduced = kept.fold(reduced, |b, o| b.operator(o)).build().unwrap();
        let goal = factotum_task_planning::operator::Condition::atom("in", [goal, "bin"]);
        let problem = problem.into_builder().goal(goal).build(&reduced).unwrap();
        let solve = |planner: &dyn Planner| -> Plan {
            let outcome = planner
                .solve(&reduced, &problem, &Limits::default())
                .unwrap();
            outcome
                .plan()
                .unwrap_or_else(|| panic!("{outcome:?}"))
                .clone()
        };
        let a = solve(&Ferroplan {
            quality: PlanQuality::Optimal,
        });
        let b = solve(&fast_downward.clone().with_quality(PlanQuality::Optimal));
        assert_eq!(a.cost, b.cost, "{a}\n{b}");
    }
}

#[test]
fn a_missing_planner_says_where_it_looked_and_how_to_get_it() {
    let candidates = [
        PathBuf::from("/nowhere/bin"),
        PathBuf::from("/nowhere/venv"),
    ];
    let error = FastDownward::discover(&candidates).unwrap_err();
    assert!(matches!(error, PlannerError::Missing { .. }));
    insta::assert_snapshot!(error, @"planner `fast-downward` not found; looked at `/nowhere/bin`, `/nowhere/venv`; install it with `pip install up-fast-downward`, or put `fast-downward.py` on the PATH");
}

#[test]
fn the_same_task_gives_the_same_plan_twice() {
    let (domain, problem) = chores();
    let solve = || {
        Ferroplan::default()
            .solve(&domain, &problem, &Limits::default())
            .unwrap()
    };
    assert_eq!(solve(), solve());
}

#[test]
fn a_problem_of_another_domain_is_refused() {
    let error = Ferroplan::default()
        .solve(&coffee().0, &chores().1, &Limits::default())
        .unwrap_err();
    insta::assert_snapshot!(error, @"planner `ferroplan` was given an invalid task: problem `household` is for domain `chores`, expected `coffee`");
}
