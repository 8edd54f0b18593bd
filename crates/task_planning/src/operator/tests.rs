//! Bad domains and problems are refused with the thing, what was found and what was wanted.

use super::*;

fn world() -> DomainBuilder {
    Domain::builder("world")
        .object_type("item", OBJECT)
        .object_type("cup", "item")
        .object_type("place", OBJECT)
        .predicate("on", [("i", "item"), ("p", "place")])
        .function("effort", [("i", "item")])
}

fn refused(operator: OperatorBuilder) -> String {
    let refused = operator
        .build()
        .and_then(|operator| world().operator(operator).build());
    refused.unwrap_err().to_string()
}

#[test]
fn faulty_operators_are_named() {
    let lift = || Operator::builder("lift").parameter("c", "cup");
    insta::assert_snapshot!(refused(lift().adds("om", ["?c", "?c"])), @"operator `lift` uses predicate `om`, which is not declared; did you mean `on`?");
    insta::assert_snapshot!(refused(lift().adds("on", ["?c"])), @"operator `lift` gives predicate `on` 1 argument(s), expected 2");
    insta::assert_snapshot!(refused(lift().adds("on", ["?c", "?c"])), @"operator `lift` gives `on` the argument `?c` of type `cup`, expected `place`");
    insta::assert_snapshot!(refused(lift().adds("on", ["?c", "?where"])), @"operator `lift` uses variable `?where`, which is not declared; declared: `?c`");
    insta::assert_snapshot!(refused(lift().adds("on", ["?c", "shelf"])), @"operator `lift` uses object `shelf`, which is not declared; none are declared");
    insta::assert_snapshot!(refused(lift().parameter("C", "cup")), @"parameter `C` is declared twice in operator `lift`");
    insta::assert_snapshot!(refused(lift().cost(-1.0)), @"operator `lift` has cost -1, expected a finite number of at least 0");
    insta::assert_snapshot!(refused(Operator::builder("pick up")), @"operator name `pick up` is not a PDDL name: expected a letter followed by letters, digits, `-` or `_`");
    insta::assert_snapshot!(refused(Operator::builder("x").parameter("c", "cub")), @"operator `x` uses type `cub`, which is not declared; did you mean `cup`?");
}

#[test]
fn probabilities_must_sum_to_one() {
    let with = |probabilities: &[f64]| {
        probabilities
            .iter()
            .fold(Operator::builder("toss"), |operator, p| {
                operator.outcome(Outcome {
                    probability: *p,
                    ..Outcome::certain()
                })
            })
    };
    assert!(with(&[0.3, 0.7]).build().is_ok());
    assert!(
        with(&[0.333, 0.333, 0.333]).build().is_ok(),
        "rounding of learned files"
    );
    insta::assert_snapshot!(refused(with(&[0.3, 0.6])), @"operator `toss` has outcome probabilities that sum to 0.8999999999999999, expected each in (0, 1] and sum 1");
    assert!(with(&[1.2, -0.2]).build().is_err());
    assert!(with(&[f64::NAN]).build().is_err());
    assert!(
        with(&[0.5, 0.5]).adds("on", []).build().is_err(),
        "effects beside outcomes"
    );
}

#[test]
fn types_must_form_a_tree() {
    let cyclic = Domain::builder("d")
        .object_type("a", "b")
        .object_type("b", "a")
        .build();
    assert!(matches!(cyclic, Err(OperatorError::TypeCycle { .. })));
    let orphan = Domain::builder("d").object_type("a", "b").build();
    insta::assert_snapshot!(orphan.unwrap_err(), @"domain `d` uses type `b`, which is not declared; did you mean `a`?");
    let twice = Domain::builder("d")
        .object_type("a", OBJECT)
        .object_type("A", OBJECT)
        .build();
    insta::assert_snapshot!(twice.unwrap_err(), @"type `A` is declared twice in domain `d`");
}

#[test]
fn subtypes_follow_the_tree() {
    let domain = world().build().unwrap();
    assert!(domain.is_subtype("cup", "item"));
    assert!(domain.is_subtype("cup", OBJECT));
    assert!(!domain.is_subtype("item", "cup"));
    assert!(!domain.is_subtype("cup", "place"));
}

#[test]
fn faulty_problems_are_named() {
    let domain = world().build().unwrap();
    let base = || {
        Problem::builder("p")
            .object("mug", "cup")
            .object("shelf", "place")
    };
    let refused = |problem: ProblemBuilder| problem.build(&domain).unwrap_err().to_string();
    assert!(base().fact("on", ["mug", "shelf"]).build(&domain).is_ok());
    insta::assert_snapshot!(refused(base().fact("on", ["shelf", "mug"])), @"the initial state of problem `p` gives `on` the argument `shelf` of type `place`, expected `item`");
    insta::assert_snapshot!(refused(base().object("Mug", "cup")), @"object `Mug` is declared twice in problem `p`");
    insta::assert_snapshot!(refused(base().goal(Condition::atom("on", ["mug", "shell"]))), @"the goal of problem `p` uses object `shell`, which is not declared; did you mean `shelf`?");
    insta::assert_snapshot!(refused(base().domain("other")), @"problem `p` is written for domain `other`, expected `world`");
    insta::assert_snapshot!(refused(base().value(Atom::new("effort", ["mug"]), f64::NAN)), @"(effort mug) has cost NaN, expected a finite number of at least 0");
}

/// References take the spelling of the declaration, so that later comparisons can be exact.
#[test]
fn spelling_follows_the_declaration() {
    let domain = world()
        .constant("Shelf", "PLACE")
        .operator(
            Operator::builder("Put")
                .parameter("C", "CUP")
                .adds("ON", ["?c", "shelf"])
                .build()
                .unwrap(),
        )
        .build()
        .unwrap();
    let effect = &domain.operator("put").unwrap().outcomes()[0].effects[0];
    assert_eq!(effect.atom.to_string(), "(on ?C Shelf)");
    assert_eq!(
        domain.operator("PUT").unwrap().parameters()[0].type_name,
        "cup"
    );
}
