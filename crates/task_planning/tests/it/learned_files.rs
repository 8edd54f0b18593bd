//! PPDDL that others' learners wrote, unchanged (skipped where the data are absent).

use std::path::PathBuf;

use factotum_task_planning::operator::Plan;
use factotum_task_planning::pddl::{
    DeterminiseOptions, Determinised, ParsedTask, UndeclaredTypes, determinise, parse_task,
    write_domain, write_problem,
};
use factotum_task_planning::planner::{Ferroplan, Limits, PlanQuality, Planner};
use factotum_task_planning::validate::{StateDistribution, World, plan_probability};

use crate::planners::fast_downward;

/// Reads a task from the shared data, or says why not.
#[expect(clippy::print_stderr, reason = "a skipped test says why")]
fn read(folder: &str) -> Option<ParsedTask> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(folder);
    let text = |name: &str| std::fs::read_to_string(root.join(name));
    match (text("domain.pddl"), text("problem.pddl")) {
        (Ok(domain), Ok(problem)) => {
            Some(parse_task(&domain, &problem, UndeclaredTypes::Declare).unwrap())
        }
        (Err(error), _) | (_, Err(error)) => {
            eprintln!("skipped: {}: {error}", root.display());
            None
        }
    }
}

fn check_round_trip(task: &ParsedTask) {
    let again = parse_task(
        &write_domain(&task.domain),
        &write_problem(&task.problem),
        UndeclaredTypes::Refuse,
    )
    .unwrap();
    assert_eq!(again.domain, task.domain);
    assert_eq!(again.problem, task.problem);
}

/// Plans on the determinised task, and judges the plan in the probabilistic one.
fn most_likely_plan(task: &ParsedTask, planner: &dyn Planner) -> (Plan, f64) {
    let ParsedTask {
        domain, problem, ..
    } = task;
    let split: Determinised = determinise(domain, problem, &DeterminiseOptions::default()).unwrap();
    let outcome = planner
        .solve(&split.domain, &split.problem, &Limits::default())
        .unwrap();
    let plan = split.restore(outcome.plan().unwrap_or_else(|| panic!("{outcome:?}")));
    let initial = StateDistribution::certain(World::new(domain, problem).initial_state());
    let probability = plan_probability(domain, problem, &initial, &plan).unwrap();
    (plan, probability.achieves_goal)
}

fn optimal() -> Ferroplan {
    Ferroplan {
        quality: PlanQuality::Optimal,
    }
}

/// Five steps make coffee without navigation, as the dissertation's own criterion counts.
#[test]
fn the_coffee_domain_learned_without_space_is_planned() {
    let Some(task) = read("fig54/non-spatial-n60") else {
        return;
    };
    assert_eq!(task.added_types, ["type45", "type46", "type47", "type48"]);
    check_round_trip(&task);
    let (plan, probability) = most_likely_plan(&task, &optimal());
    assert_eq!(plan.steps.len(), 5, "{plan}");
    assert!(probability > 0.3 && probability < 1.0, "{probability}");
}

/// Seven steps with navigation.
#[test]
fn the_coffee_domain_learned_with_space_is_planned() {
    let Some(task) = read("fig54/spatial-n300") else {
        return;
    };
    check_round_trip(&task);
    let (plan, probability) = most_likely_plan(&task, &optimal());
    assert_eq!(plan.steps.len(), 7, "{plan}");
    assert!(probability > 0.1 && probability < 1.0, "{probability}");
}

/// 42 steps, of which the reference's model gives probability 0.2444.
#[test]
fn the_treasure_is_found() {
    let Some(task) = read("treasure_game") else {
        return;
    };
    assert_eq!(task.domain.operators().len(), 372);
    let n_probabilistic = task
        .domain
        .operators()
        .iter()
        .filter(|o| !o.is_deterministic())
        .count();
    assert_eq!(n_probabilistic, 169);
    check_round_trip(&task);
    let (plan, probability) = most_likely_plan(&task, &optimal());
    assert_eq!(plan.steps.len(), 42, "{plan}");
    assert!((probability - 0.2444).abs() < 5e-4, "{probability}");
}

#[test]
fn fast_downward_finds_plans_as_likely() {
    let Some(planner) = fast_downward() else {
        return;
    };
    let planner = planner.with_quality(PlanQuality::Optimal);
    for folder in [
        "fig54/non-spatial-n60",
        "fig54/spatial-n300",
        "treasure_game",
    ] {
        let Some(task) = read(folder) else { return };
        let (_, ours) = most_likely_plan(&task, &optimal());
        let (_, theirs) = most_likely_plan(&task, &planner);
        assert!(
            (ours - theirs).abs() < 1e-3 * ours,
            "{folder}: {ours} and {theirs}"
        );
    }
}
