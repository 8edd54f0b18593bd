//! Time to read and to solve the small tasks that the tests use.

use factotum_task_planning::operator::{Domain, Problem};
use factotum_task_planning::pddl::{parse_domain, parse_problem};
use factotum_task_planning::planner::{Ferroplan, Limits, PlanOutcome, Planner as _};
use factotum_task_planning::validate::validate;

fn main() {
    divan::main();
}

const TASKS: [(&str, &str, &str); 2] = [
    (
        "coffee",
        include_str!("../tests/tasks/coffee/domain.pddl"),
        include_str!("../tests/tasks/coffee/problem.pddl"),
    ),
    (
        "chores",
        include_str!("../tests/tasks/chores/domain.pddl"),
        include_str!("../tests/tasks/chores/problem.pddl"),
    ),
];

fn texts(name: &str) -> (&'static str, &'static str) {
    let (_, domain, problem) = TASKS
        .into_iter()
        .find(|task| task.0 == name)
        .unwrap_or(TASKS[0]);
    (domain, problem)
}

fn read(name: &str) -> Option<(Domain, Problem)> {
    let (domain, problem) = texts(name);
    let domain = parse_domain(domain).ok()?;
    let problem = parse_problem(problem, &domain).ok()?;
    Some((domain, problem))
}

fn solve(domain: &Domain, problem: &Problem) -> Option<PlanOutcome> {
    Ferroplan::default()
        .solve(domain, problem, &Limits::default())
        .ok()
}

#[divan::bench(args = ["coffee", "chores"])]
fn parse(bencher: divan::Bencher<'_, '_>, name: &str) {
    bencher.bench(|| read(divan::black_box(name)));
}

#[divan::bench(args = ["coffee", "chores"])]
fn ferroplan(bencher: divan::Bencher<'_, '_>, name: &str) {
    bencher.with_inputs(|| read(name)).bench_refs(|task| {
        task.as_ref()
            .and_then(|(domain, problem)| solve(domain, problem))
    });
}

#[divan::bench(args = ["coffee", "chores"])]
fn judge(bencher: divan::Bencher<'_, '_>, name: &str) {
    let solved = read(name).and_then(|(domain, problem)| {
        let plan = solve(&domain, &problem)?.plan()?.clone();
        Some((domain, problem, plan))
    });
    bencher.bench(|| {
        solved
            .as_ref()
            .map(|(domain, problem, plan)| validate(domain, problem, plan))
    });
}
