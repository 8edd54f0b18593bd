//! The tasks the planner tests share, each with whether it can be solved.

use factotum_task_planning::operator::{Atom, Condition, Domain, Problem};
use factotum_task_planning::pddl::{parse_domain, parse_problem};

/// A task and the truth about it.
#[derive(Debug)]
pub(crate) struct Task {
    pub(crate) name: String,
    pub(crate) domain: Domain,
    pub(crate) problem: Problem,
    pub(crate) solvable: bool,
}

pub(crate) fn coffee() -> (Domain, Problem) {
    let domain = parse_domain(include_str!("../tasks/coffee/domain.pddl")).unwrap();
    let problem = parse_problem(include_str!("../tasks/coffee/problem.pddl"), &domain).unwrap();
    (domain, problem)
}

pub(crate) fn chores() -> (Domain, Problem) {
    let domain = parse_domain(include_str!("../tasks/chores/domain.pddl")).unwrap();
    let problem = parse_problem(include_str!("../tasks/chores/problem.pddl"), &domain).unwrap();
    (domain, problem)
}

/// Rooms in a row, each door locked; the key of door i lies in room `key_rooms[i]`, the parcel in the
/// last room, and it is wanted in the first.
fn delivery(key_rooms: &[usize]) -> (Domain, Problem) {
    let domain = parse_domain(include_str!("../tasks/delivery/domain.pddl")).unwrap();
    let n_rooms = key_rooms.len() + 1;
    let mut problem = Problem::builder("row")
        .object("parcel", "parcel")
        .fact("free", [])
        .fact("robot-in", ["room-0"])
        .fact("parcel-in", ["parcel", &format!("room-{}", n_rooms - 1)])
        .goal(Condition::atom("parcel-in", ["parcel", "room-0"]));
    for i in 0..n_rooms {
        problem = problem.object(format!("room-{i}"), "room");
    }
    for (i, key_room) in key_rooms.iter().enumerate() {
        let (door, key) = (format!("door-{i}"), format!("key-{i}"));
        let (a, b) = (format!("room-{i}"), format!("room-{}", i + 1));
        problem = problem.object(&door, "door").object(&key, "key").facts([
            Atom::new("between", [&door, &a, &b]),
            Atom::new("between", [&door, &b, &a]),
            Atom::new("fits", [&key, &door]),
            Atom::new("key-in", [key.clone(), format!("room-{key_room}")]),
        ]);
    }
    let problem = problem.build(&domain).unwrap();
    (domain, problem)
}

/// A task of the same domain with another goal.
fn with_goal(name: &str, task: (Domain, Problem), goal: Condition, solvable: bool) -> Task {
    let (domain, problem) = task;
    let problem = problem.into_builder().goal(goal).build(&domain).unwrap();
    Task {
        name: name.to_owned(),
        domain,
        problem,
        solvable,
    }
}

/// Solvable and unsolvable tasks over all domains.
pub(crate) fn tasks() -> Vec<Task> {
    let named = |name: &str, (domain, problem): (Domain, Problem), solvable| Task {
        name: name.to_owned(),
        domain,
        problem,
        solvable,
    };
    let brewed = Condition::atom("brewed", ["CoffeeMachine"]);
    let in_bin = Condition::atom("in", ["bottle", "bin"]);
    let light_off = Condition::not_atom("lit", ["hall-light"]);
    let faucet_closed = Condition::not_atom("running", ["sink"]);
    let shut = |task: (Domain, Problem)| {
        let open = Atom::new("lid-open", ["CoffeeMachine"]);
        let facts: Vec<_> = task
            .1
            .init()
            .iter()
            .filter(|f| **f != open)
            .cloned()
            .collect();
        let mut builder = Problem::builder("shut").goal(brewed.clone()).facts(facts);
        for object in task.1.objects() {
            builder = builder.object(&object.name, &object.type_name);
        }
        let problem = builder.build(&task.0).unwrap();
        (task.0, problem)
    };
    vec![
        named("coffee", coffee(), true),
        named("coffee, lid shut from the start", shut(coffee()), false),
        with_goal(
            "coffee with the lid open",
            coffee(),
            Condition::all([
                brewed.clone(),
                Condition::atom("lid-open", ["CoffeeMachine"]),
            ]),
            false,
        ),
        named("all chores", chores(), true),
        with_goal("throw the bottle away", chores(), in_bin, true),
        with_goal("turn the light off", chores(), light_off.clone(), true),
        with_goal("close the faucet", chores(), faucet_closed, true),
        with_goal(
            "nothing to do",
            chores(),
            Condition::atom("hand-empty", []),
            true,
        ),
        with_goal(
            "the mug is no rubbish",
            chores(),
            Condition::atom("in", ["mug", "bin"]),
            false,
        ),
        with_goal(
            "on and off at once",
            chores(),
            Condition::all([light_off, Condition::atom("lit", ["hall-light"])]),
            false,
        ),
        named("keys in order", delivery(&[0, 1, 2]), true),
        named("all keys in the first room", delivery(&[0, 0, 0, 0]), true),
        named("a key behind its own door", delivery(&[0, 2, 1]), false),
        named("a key two doors too far", delivery(&[0, 3, 0]), false),
    ]
}
