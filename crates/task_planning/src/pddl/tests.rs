//! What is understood, what is refused and where, and that writing then reading changes nothing.

use proptest::prelude::*;

use super::*;
use crate::operator::{
    AtomPattern, Condition, Cost, Domain, Effect, OBJECT, Objective, Operator, Outcome, Problem,
    Provenance, Term, TypedName,
};

const COFFEE: &str = include_str!("../../tests/tasks/coffee/domain.pddl");
const CHORES: &str = include_str!("../../tests/tasks/chores/domain.pddl");
const HOUSEHOLD: &str = include_str!("../../tests/tasks/chores/problem.pddl");

fn refused(text: &str) -> String {
    parse_domain(text).unwrap_err().to_string()
}

#[test]
fn a_missing_parenthesis_is_placed() {
    let cut = COFFEE.trim_end().strip_suffix(')').unwrap();
    insta::assert_snapshot!(refused(cut), @"48:29: expected `)` for the list opened at 4:1, got end of file");
    insta::assert_snapshot!(refused(&format!("{COFFEE})")), @"49:1: expected end of file (the list opened at 4:1 is complete), got `)`");
}

#[test]
fn errors_say_what_was_being_read() {
    let swapped = |from: &str, to: &str| refused(&COFFEE.replacen(from, to, 1));
    insta::assert_snapshot!(swapped("(not (lid-open ?m)))", "(not (lid-open ?m) ?m))"), @r#"
    42:36: expected `)`, got `?m`
      while reading the effect
      while reading action `CloseLid`
      while reading the domain
    "#);
    insta::assert_snapshot!(swapped("(holding ?v)\n        :effect", "(and (forall ?v (full ?v)))\n        :effect"), @r#"
    28:36: expected a list of variables, got `?v`
      while reading the precondition
      while reading action `Place`
      while reading the domain
    "#);
    insta::assert_snapshot!(swapped(":precondition (holding ?v)", ":precond (holding ?v)"), @r#"
    28:9: expected `:parameters`, `:precondition` or `:effect`, each once, got `:precond`
      while reading action `Place`
      while reading the domain
    "#);
    insta::assert_snapshot!(swapped("(brewed ?m)))", "(brewd ?m)))"), @r#"
    44:5: operator `PushButton` uses predicate `brewd`, which is not declared; did you mean `brewed`?
      while reading the domain
    "#);
    insta::assert_snapshot!(swapped("(at ?v ?s) (hand-empty)", "(at ?v) (hand-empty)"), @r#"
    26:5: operator `Place` gives predicate `at` 1 argument(s), expected 2
      while reading the domain
    "#);
}

#[test]
fn what_is_not_supported_says_so() {
    let section = |text: &str| refused(&format!("(define (domain d)\n  {text})"));
    insta::assert_snapshot!(section("(:durative-action go)"), @r#"
    2:4: `:durative-action` is not supported; write it with actions and predicates
      while reading section `:durative-action`
      while reading the domain
    "#);
    insta::assert_snapshot!(section("(:requirements :strips :time)"), @r#"
    2:26: `:time` is not supported; understood are :strips :typing :negative-preconditions :disjunctive-preconditions :existential-preconditions :universal-preconditions :quantified-preconditions :equality :conditional-effects :adl :action-costs :probabilistic-effects :rewards :mdp :fluents :numeric-fluents
      while reading section `:requirements`
      while reading the domain
    "#);
    insta::assert_snapshot!(section("(:predicates (p ?x - (either a b)))"), @r#"
    2:24: an `either` type is not supported; declare a common parent type
      while reading the parameters of `p`
      while reading section `:predicates`
      while reading the domain
    "#);
    insta::assert_snapshot!(section("(:action a :precondition (> (fuel) 3))"), @r#"
    2:29: the numeric condition `>` is not supported; conditions are over predicates
      while reading the precondition
      while reading action `a`
      while reading the domain
    "#);
    insta::assert_snapshot!(section("(:action a :effect (increase (fuel) 3))"), @r#"
    2:32: `increase` of `(fuel)` is not supported; `increase` is understood for `(total-cost)` only
      while reading the effect
      while reading action `a`
      while reading the domain
    "#);
    insta::assert_snapshot!(section("(:action a :effect (probabilistic 0.7 (p) 0.7 (q)))"), @r#"
    2:22: expected probabilities that sum to at most 1, got a sum of 1.4
      while reading the effect
      while reading action `a`
      while reading the domain
    "#);
}

#[test]
fn hostile_nesting_is_refused_without_a_crash() {
    insta::assert_snapshot!(refused(&"(".repeat(100_000)), @"1:129: expected at most 128 nested lists, got `(`");
    insta::assert_snapshot!(refused(""), @"1:1: expected `(define (domain ...) ...)`, got end of file");
    insta::assert_snapshot!(refused("define"), @"1:1: expected `(define (domain ...) ...)`, got `define`");
}

#[test]
fn a_problem_must_fit_its_domain() {
    let domain = parse_domain(CHORES).unwrap();
    let swapped = |from: &str, to: &str| {
        parse_problem(&HOUSEHOLD.replacen(from, to, 1), &domain)
            .unwrap_err()
            .to_string()
    };
    insta::assert_snapshot!(swapped("(:domain chores)", "(:domain coffee)"), @r#"
    1:1: problem `household` is written for domain `coffee`, expected `chores`
      while reading the problem
    "#);
    insta::assert_snapshot!(swapped("bin - bin", "bin - bim"), @r#"
    1:1: object `bin` uses type `bim`, which is not declared; did you mean `bin`?
      while reading the problem
    "#);
    insta::assert_snapshot!(swapped("(:goal (and (tidy)", "(:goal (and (tidy ?x)"), @r#"
    1:1: the goal of problem `household` uses variable `?x`, which is not declared; none are declared
      while reading the problem
    "#);
    insta::assert_snapshot!(swapped("(effort mug) 1)", "(effort mug) one)"), @r#"
    17:72: expected a number, got `one`
      while reading section `:init`
      while reading the problem
    "#);
    insta::assert_snapshot!(swapped("(rubbish bottle)", "(rubbish ?bottle)"), @r#"
    12:27: expected an atom over objects, got `?bottle`
      while reading section `:init`
      while reading the problem
    "#);
}

/// Independent chances in one effect multiply out; what a text leaves open is "nothing happens".
#[test]
fn chances_multiply_out() {
    let text = "(define (domain d) (:predicates (p) (q))
        (:action a :effect (and
            (probabilistic 0.5 (p)) (probabilistic 0.25 (q) 0.75 (not (q)))
            (decrease (reward) 2.5))))";
    let domain = parse_domain(text).unwrap();
    let outcomes = domain.operators()[0].outcomes();
    let shown: Vec<_> = outcomes
        .iter()
        .map(|o| (o.probability, o.effects.len()))
        .collect();
    assert_eq!(shown, [(0.125, 2), (0.375, 2), (0.125, 1), (0.375, 1)]);
    assert!(outcomes.iter().all(|o| o.cost == Cost::Constant(2.5)));
}

#[test]
fn shipped_tasks_survive_writing_and_reading() {
    for text in [COFFEE, CHORES] {
        let domain = parse_domain(text).unwrap();
        assert_eq!(parse_domain(&write_domain(&domain)).unwrap(), domain);
    }
    let domain = parse_domain(CHORES).unwrap();
    let problem = parse_problem(HOUSEHOLD, &domain).unwrap();
    assert_eq!(
        parse_problem(&write_problem(&problem), &domain).unwrap(),
        problem
    );
    assert_eq!(problem.objective(), Objective::MinimizeCost);
}

#[test]
fn written_pddl_reads_well() {
    let learned = Provenance::Learned {
        source: "kitchen\n(evil)".to_owned(),
        n_transitions: 60,
    };
    let domain = Domain::builder("lamp")
        .object_type("switch", OBJECT)
        .predicate("lit", [("s", "switch")])
        .operator(
            Operator::builder("press")
                .parameter("s", "switch")
                .requires(Condition::not_atom("lit", ["?s"]))
                .adds("lit", ["?s"])
                .cost(1.5)
                .provenance(learned)
                .build()
                .unwrap(),
        )
        .build()
        .unwrap();
    insta::assert_snapshot!(write_domain(&domain), @r#"
    (define (domain lamp)
        (:requirements :strips :action-costs :negative-preconditions :typing)
        (:types
            switch - object)
        (:predicates
            (lit ?s - switch))
        (:functions
            (total-cost) - number)

        ; learned from 60 transitions of kitchen(evil)
        (:action press
            :parameters (?s - switch)
            :precondition (not (lit ?s))
            :effect (and (lit ?s) (increase (total-cost) 1.5)))
    )
    "#);
}

#[test]
fn determinising_splits_outcomes_and_prices_them() {
    let text = "(define (domain d) (:predicates (ok) (p))
        (:action a :precondition (ok)
            :effect (probabilistic 0.2 (not (ok)) 0.3 (p) 0.5 (and (p) (not (ok)))))
        (:action b :effect (ok)))";
    let domain = parse_domain(text).unwrap();
    let problem = parse_problem(
        "(define (problem q) (:domain d) (:init (ok)) (:goal (p)))",
        &domain,
    )
    .unwrap();
    let split = determinise(&domain, &problem, &DeterminiseOptions::default()).unwrap();
    let shown: Vec<_> = split
        .domain
        .operators()
        .iter()
        .map(|o| (o.name().to_owned(), o.outcomes()[0].cost.clone()))
        .collect();
    // The outcome that only deletes can help no plan and is left out; -1000 ln 0.3 = 1203.97.
    assert_eq!(
        shown,
        [
            ("a--outcome-1".to_owned(), Cost::Constant(1204.0)),
            ("a--outcome-2".to_owned(), Cost::Constant(694.0)),
            ("b".to_owned(), Cost::Constant(0.0)),
        ]
    );
    assert_eq!(split.origin("A--OUTCOME-2").unwrap().outcome_idx, 2);
    assert_eq!(split.problem.objective(), Objective::MinimizeCost);
    // With a negative goal, deleting may be what is wanted.
    let problem = problem
        .into_builder()
        .goal(Condition::not_atom("ok", []))
        .build(&domain)
        .unwrap();
    let split = determinise(&domain, &problem, &DeterminiseOptions::default()).unwrap();
    assert_eq!(split.domain.operators().len(), 4);
}

const TYPES: [&str; 3] = [OBJECT, "thing", "Mug"];
const PARAMETERS: [(&str, &str); 2] = [("x", "thing"), ("y", "Mug")];

fn term() -> impl Strategy<Value = Term> {
    prop::sample::select(vec!["?x", "?y", "cup-1", "Table_2"]).prop_map(Term::from)
}

fn atom() -> impl Strategy<Value = AtomPattern> {
    prop_oneof![
        Just(AtomPattern::new("flag", [])),
        term().prop_map(|t| AtomPattern {
            symbol: "On-Top".to_owned(),
            terms: vec![t]
        }),
        (term(), term()).prop_map(|(a, b)| AtomPattern {
            symbol: "near".to_owned(),
            terms: vec![a, b]
        }),
    ]
}

fn condition() -> impl Strategy<Value = Condition> {
    let leaf = prop_oneof![
        3 => atom().prop_map(Condition::Atom),
        1 => (term(), term()).prop_map(|(a, b)| Condition::Equal(a, b)),
    ];
    leaf.prop_recursive(3, 16, 3, |inner| {
        let variables = prop::sample::select(TYPES.to_vec())
            .prop_map(|type_name| vec![TypedName::new("x", type_name), TypedName::new("z", "Mug")]);
        prop_oneof![
            inner.clone().prop_map(|c| Condition::Not(Box::new(c))),
            prop::collection::vec(inner.clone(), 0..3).prop_map(Condition::And),
            prop::collection::vec(inner.clone(), 0..3).prop_map(Condition::Or),
            (inner.clone(), inner.clone())
                .prop_map(|(a, b)| Condition::Imply(Box::new(a), Box::new(b))),
            (variables.clone(), inner.clone()).prop_map(|(v, c)| Condition::Forall(v, Box::new(c))),
            (variables, inner).prop_map(|(v, c)| Condition::Exists(v, Box::new(c))),
        ]
    })
}

fn effect() -> impl Strategy<Value = Effect> {
    let when = prop_oneof![2 => Just(Condition::always()), 1 => condition()];
    (atom(), any::<bool>(), when, any::<bool>()).prop_map(|(atom, adds, when, forall)| {
        let forall = if forall {
            vec![TypedName::new("w", "thing")]
        } else {
            Vec::new()
        };
        Effect {
            forall,
            when,
            atom,
            adds,
        }
    })
}

fn cost() -> impl Strategy<Value = Cost> {
    prop_oneof![
        Just(Cost::default()),
        (0.001..1e6).prop_map(Cost::Constant),
        Just(Cost::Function(AtomPattern::new("effort", ["?y"]))),
    ]
}

fn operator(name: &'static str) -> impl Strategy<Value = Operator> {
    let outcome = (1u32..1000, prop::collection::vec(effect(), 0..3), cost());
    (condition(), prop::collection::vec(outcome, 1..4)).prop_map(move |(condition, outcomes)| {
        let sum: u32 = outcomes.iter().map(|(weight, ..)| weight).sum();
        let mut builder = Operator::builder(name).requires(condition);
        for (parameter, type_name) in PARAMETERS {
            builder = builder.parameter(parameter, type_name);
        }
        for (weight, effects, cost) in outcomes {
            let probability = f64::from(weight) / f64::from(sum);
            builder = builder.outcome(Outcome {
                probability,
                effects,
                cost,
            });
        }
        builder.build().unwrap()
    })
}

fn task() -> impl Strategy<Value = (Domain, Problem)> {
    let goal = condition().prop_map(|c| {
        // Goals have no parameters: bind them by a quantifier.
        let variables = vec![TypedName::new("x", "thing"), TypedName::new("y", "Mug")];
        Condition::Exists(variables, Box::new(c))
    });
    (
        operator("act"),
        operator("Other-act"),
        goal,
        any::<bool>(),
        0.0..1e3,
    )
        .prop_map(|(a, b, goal, minimize, value)| {
            let domain = Domain::builder("round-trip")
                .object_type("thing", OBJECT)
                .object_type("Mug", "thing")
                .constant("cup-1", "Mug")
                .constant("Table_2", "thing")
                .predicate("flag", [])
                .predicate("On-Top", [("a", "thing")])
                .predicate("near", [("a", "thing"), ("b", OBJECT)])
                .function("effort", [("m", "Mug")])
                .operator(a)
                .operator(b)
                .build()
                .unwrap();
            let objective = if minimize {
                Objective::MinimizeCost
            } else {
                Objective::AnyPlan
            };
            let problem = Problem::builder("p")
                .object("mug-3", "Mug")
                .fact("On-Top", ["mug-3"])
                .fact("near", ["cup-1", "Table_2"])
                .value(crate::operator::Atom::new("effort", ["mug-3"]), value)
                .goal(goal)
                .objective(objective)
                .build(&domain)
                .unwrap();
            (domain, problem)
        })
}

proptest! {
    #[test]
    fn writing_then_reading_changes_nothing((domain, problem) in task()) {
        let text = write_domain(&domain);
        let again = parse_domain(&text).map_err(|e| TestCaseError::fail(format!("{e}\n{text}")))?;
        prop_assert_eq!(&again, &domain, "{}", text);
        let text = write_problem(&problem);
        let again = parse_problem(&text, &domain)
            .map_err(|e| TestCaseError::fail(format!("{e}\n{text}")))?;
        prop_assert_eq!(again, problem, "{}", text);
    }

    /// Damaged files give an error with a place inside the text, or still mean something; never a panic.
    #[test]
    fn damaged_text_never_panics(cut in 0usize..2000, insert in "[()a-z?:;= -]{0,6}") {
        let at = cut.min(CHORES.len());
        let damaged = format!("{}{insert}{}", &CHORES[..at], &CHORES[(at + 3).min(CHORES.len())..]);
        if let Err(error) = parse_domain(&damaged) {
            prop_assert!(error.position().line <= damaged.lines().count() + 1);
        }
    }
}
