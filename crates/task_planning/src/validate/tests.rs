//! The judge names the step, the literal, and nothing else; and probabilities add up.

use super::*;
use crate::operator::{Atom, Condition, Effect, Operator, Outcome, Problem};
use crate::pddl::{parse_domain, parse_problem};

fn chores() -> (Domain, Problem) {
    let domain = parse_domain(include_str!("../../tests/tasks/chores/domain.pddl")).unwrap();
    let problem = parse_problem(
        include_str!("../../tests/tasks/chores/problem.pddl"),
        &domain,
    )
    .unwrap();
    (domain, problem)
}

/// A plan as text: `pick bottle table; throw-away bottle bin`.
fn steps(text: &str) -> Vec<GroundAction> {
    let step = |line: &str| {
        let mut words = line.split_whitespace();
        GroundAction::new(words.next().unwrap(), words)
    };
    text.split(';').map(step).collect()
}

const GOOD: &str = "pick bottle table; throw-away bottle bin; open-drawer cabinet; \
    take-out wrapper cabinet; throw-away wrapper bin; close-drawer cabinet; turn-off hall-light; \
    close-faucet sink; pick mug counter; place mug table; inspect";

#[test]
fn a_good_plan_costs_the_sum_of_its_steps() {
    let (domain, problem) = chores();
    let valid = execute(&domain, &problem, &steps(GOOD)).unwrap();
    assert_eq!(valid.states.len(), 12);
    assert_eq!(
        valid.cost,
        1.5 + 1.0 + 2.5 + 1.0 + 1.0 + 2.5 + 1.0 + 1.0 + 1.0 + 1.0 + 1.0
    );
    let plan = Plan {
        steps: steps(GOOD),
        cost: 3.0,
    };
    let fault = validate(&domain, &problem, &plan).unwrap_err();
    insta::assert_snapshot!(fault, @"the plan claims cost 3, expected 14.5");
}

#[test]
fn corrupted_plans_are_rejected_at_the_right_step() {
    let (domain, problem) = chores();
    let fault = |text: &str| {
        execute(&domain, &problem, &steps(text))
            .unwrap_err()
            .to_string()
    };
    insta::assert_snapshot!(fault(&GOOD.replace("pick bottle table; ", "")), @"step 1 (throw-away bottle bin) cannot run: (on bottle gripper) does not hold");
    insta::assert_snapshot!(fault(&GOOD.replace("open-drawer cabinet; ", "")), @"step 3 (take-out wrapper cabinet) cannot run: (open cabinet) does not hold");
    insta::assert_snapshot!(fault(&GOOD.replace("close-drawer cabinet; ", "")), @"step 10 (inspect) cannot run: (forall (?d - drawer) (not (open ?d))) does not hold");
    insta::assert_snapshot!(fault(&GOOD.replace("turn-off hall-light; ", "")), @"the goal is not reached after 10 step(s): (not (lit hall-light)) does not hold");
    insta::assert_snapshot!(fault(&GOOD.replace("inspect", "inspekt")), @"step 11 (inspekt): operator `inspekt` is not in the domain; did you mean `inspect`?");
    insta::assert_snapshot!(fault(&GOOD.replace("pick bottle table", "pick bottel table")), @"step 1 (pick bottel table): object `bottel` is not in the problem; did you mean `bottle`?");
    insta::assert_snapshot!(fault(&GOOD.replace("pick bottle table", "pick bottle")), @"step 1 (pick bottle): operator `pick` is given 1 argument(s), expected 2");
    insta::assert_snapshot!(fault(&GOOD.replace("pick bottle table", "pick bottle bin")), @"step 1 (pick bottle bin): operator `pick` is given `bin` of type `bin`, expected `surface`");
    insta::assert_snapshot!(fault("place mug gripper"), @"step 1 (place mug gripper) cannot run: (on mug gripper) and (not (= gripper gripper)) does not hold");
}

/// Where an action both deletes and adds an atom, the atom holds afterwards.
#[test]
fn an_add_wins_over_a_delete() {
    let domain = Domain::builder("d")
        .predicate("p", [])
        .operator(
            Operator::builder("blink")
                .adds("p", [])
                .deletes("p", [])
                .build()
                .unwrap(),
        )
        .build()
        .unwrap();
    let problem = Problem::builder("q")
        .goal(Condition::atom("p", []))
        .build(&domain)
        .unwrap();
    assert!(execute(&domain, &problem, &steps("blink")).is_ok());
}

/// Conditions of conditional effects are read before the action, and quantified effects reach all objects.
#[test]
fn conditional_effects_read_the_state_before() {
    let swap = Operator::builder("swap")
        .effect(Effect::add(pattern("p")).when(Condition::atom("q", [])))
        .effect(Effect::delete(pattern("q")).when(Condition::atom("q", [])))
        .effect(Effect::add(pattern("q")).when(Condition::atom("p", [])))
        .effect(Effect::delete(pattern("p")).when(Condition::atom("p", [])));
    let domain = Domain::builder("d")
        .predicate("p", [])
        .predicate("q", [])
        .operator(swap.build().unwrap())
        .build()
        .unwrap();
    let goal = Condition::all([Condition::atom("q", []), Condition::not_atom("p", [])]);
    let problem = Problem::builder("x")
        .fact("p", [])
        .goal(goal)
        .build(&domain)
        .unwrap();
    assert!(execute(&domain, &problem, &steps("swap")).is_ok());
    assert!(execute(&domain, &problem, &steps("swap; swap")).is_err());
}

fn pattern(symbol: &str) -> crate::operator::AtomPattern {
    crate::operator::AtomPattern::new(symbol, [])
}

/// Tries that succeed with 0.8 each: two tries reach the goal with 1 - 0.2^2.
fn trying() -> (Domain, Problem) {
    let outcome = |probability, effects| Outcome {
        probability,
        effects,
        ..Outcome::certain()
    };
    let domain = Domain::builder("try")
        .predicate("done", [])
        .predicate("broken", [])
        .operator(
            Operator::builder("try")
                .outcome(outcome(0.8, vec![Effect::add(pattern("done"))]))
                .outcome(outcome(0.2, Vec::new()))
                .build()
                .unwrap(),
        )
        .operator(
            Operator::builder("force")
                .requires(Condition::not_atom("broken", []))
                .outcome(outcome(0.5, vec![Effect::add(pattern("done"))]))
                .outcome(outcome(0.5, vec![Effect::add(pattern("broken"))]))
                .build()
                .unwrap(),
        )
        .build()
        .unwrap();
    let problem = Problem::builder("p")
        .goal(Condition::atom("done", []))
        .build(&domain)
        .unwrap();
    (domain, problem)
}

#[test]
fn a_plan_is_as_likely_as_its_outcomes_allow() {
    let (domain, problem) = trying();
    let start = || StateDistribution::certain(World::new(&domain, &problem).initial_state());
    let ask = |initial, text: &str| {
        let plan = Plan {
            steps: steps(text),
            cost: 0.0,
        };
        plan_probability(&domain, &problem, &initial, &plan).unwrap()
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} and {b}");
    close(ask(start(), "try").achieves_goal, 0.8);
    close(ask(start(), "try; try").achieves_goal, 0.96);
    // Forcing twice: the second only runs where the first did not break it.
    let forced = ask(start(), "force; force");
    close(forced.runs_through[1], 0.5);
    close(forced.achieves_goal, 0.5);
    // A start that may be broken already.
    let broken = State::new([Atom::new("broken", [] as [&str; 0])]);
    let mixed = StateDistribution::new([(State::default(), 0.75), (broken, 0.25)]).unwrap();
    let forced = ask(mixed, "force");
    close(forced.runs_through[0], 0.75);
    close(forced.achieves_goal, 0.375);
    close(forced.final_states.mass(), 0.75);
}

#[test]
fn the_validator_refuses_chance() {
    let (domain, problem) = trying();
    let fault = execute(&domain, &problem, &steps("try")).unwrap_err();
    insta::assert_snapshot!(fault, @"step 1 (try) may turn out in 2 ways, expected one; determinise the domain or ask for the plan's probability");
    assert!(StateDistribution::new([(State::default(), 1.5)]).is_err());
}
