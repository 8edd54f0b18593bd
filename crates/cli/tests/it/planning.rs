//! `factotum plan`.

use crate::{assert_refused, factotum_in, factotum_with};

const DOMAIN: &str = "\
(define (domain coffee)
  (:requirements :strips)
  (:predicates (mug-empty) (mug-full) (machine-on))
  (:action switch-on :parameters () :precondition (mug-empty) :effect (machine-on))
  (:action brew :parameters () :precondition (and (machine-on) (mug-empty))
    :effect (and (mug-full) (not (mug-empty)))))
";
const PROBLEM: &str =
    "(define (problem morning) (:domain coffee) (:init (mug-empty)) (:goal (mug-full)))\n";

fn plan(domain: &str, problem: &str) -> crate::Said {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("domain.pddl"), domain).unwrap();
    std::fs::write(dir.path().join("problem.pddl"), problem).unwrap();
    factotum_in(
        dir.path(),
        &["plan", "domain.pddl", "problem.pddl", "--json"],
    )
}

#[test]
fn coffee_is_planned() {
    let said = plan(DOMAIN, PROBLEM);
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let document = said.json();
    assert_eq!(document["outcome"], "solved");
    let actions: Vec<_> = document["plan"]
        .as_array()
        .unwrap()
        .iter()
        .map(|step| step["action"].clone())
        .collect();
    assert_eq!(actions, ["switch-on", "brew"]);
}

#[test]
fn that_there_is_no_plan_is_an_answer() {
    let said = plan(DOMAIN, &PROBLEM.replace("(:init (mug-empty))", "(:init)"));
    assert_eq!(said.code, Some(1), "{}", said.stderr);
    assert_eq!(said.json()["outcome"], "unsolvable");
}

#[test]
fn a_syntax_error_is_named_by_line_and_column() {
    let said = plan(&DOMAIN.replace("(:action brew", "(:action brew))"), PROBLEM);
    assert_refused(&said, &["domain.pddl:5:"]);
}

#[test]
fn a_file_cut_short_is_named_with_what_is_missing() {
    let said = plan(&DOMAIN[..DOMAIN.len() - 3], PROBLEM);
    assert_refused(&said, &["domain.pddl:", "expected `)`", "end of file"]);
}

#[test]
fn a_planner_that_is_not_there_is_named_with_where_it_was_sought() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("domain.pddl"), DOMAIN).unwrap();
    std::fs::write(dir.path().join("problem.pddl"), PROBLEM).unwrap();
    let nowhere = dir.path().join("nowhere");
    for arguments in [
        &["plan", "domain.pddl", "problem.pddl"][..],
        &["run", "--headless", "--no-folder"],
    ] {
        let arguments = [arguments, &["--planner", "fast-downward"]].concat();
        let said = factotum_with(dir.path(), &arguments, &[("FAST_DOWNWARD", &nowhere)]);
        assert_refused(
            &said,
            &["planner `fast-downward` not found", "nowhere", "install"],
        );
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let said = factotum_in(dir.path(), &["plan", "domain.pddl", "problem.pddl"]);
    assert_refused(&said, &["domain.pddl"]);
}
