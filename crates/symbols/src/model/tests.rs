//! A world small enough to know by heart, and what poor data make of it.

use factotum_task_planning::operator::GroundAction;
use factotum_task_planning::pddl::{DeterminiseOptions, determinise};
use factotum_task_planning::planner::{Ferroplan, Limits, PlanOutcome, Planner as _};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::transitions::Transition;

/// A corridor with a lamp: `go` leads to the other end from either, `switch` works at the right end only and is
/// missed one time in five; the goal is to stand at the left end with the lamp lit.
fn corridor(n_steps: usize, n_episodes: u64, seed: u64) -> Transitions {
    let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut transitions = Transitions::new(
        names(&["place", "lamp", "weather"]),
        names(&["go", "switch"]),
    );
    for episode in 0..n_episodes {
        let mut state = [0.1 + 0.01 * rng.random::<f64>(), 0.0, 0.5];
        for _ in 0..n_steps {
            let at_right = state[0] > 0.5;
            let can_switch = at_right && state[1] < 0.5;
            let switches = can_switch && rng.random::<f64>() < 0.5;
            let mut next_state = state;
            let jitter = 0.01 * rng.random::<f64>();
            if !switches {
                next_state[0] = if at_right { 0.1 } else { 0.9 } + jitter;
            } else if rng.random::<f64>() < 0.8 {
                next_state[1] = 1.0;
            } else {
                next_state[0] = 0.6 + jitter; // slipped
            }
            let goal_achieved = next_state[0] < 0.5 && next_state[1] > 0.5;
            transitions
                .push(&Transition {
                    state: &state,
                    option: usize::from(switches),
                    next_state: &next_state,
                    mask: None,
                    executable: &[true, can_switch],
                    episode,
                    reward: Some(-1.0),
                    goal_achieved,
                })
                .unwrap();
            state = next_state;
            if goal_achieved {
                break;
            }
        }
    }
    transitions
}

fn learn(transitions: &Transitions, seed: u64) -> SymbolicModel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    SymbolicModel::learn(transitions, &LearnParams::default(), &mut rng, &mut |_| {})
}

fn plan(model: &ModelRecord) -> PlanOutcome {
    let domain = model.domain("corridor").unwrap();
    let problem = model.problem("light", &domain).unwrap();
    let split = determinise(&domain, &problem, &DeterminiseOptions::default()).unwrap();
    Ferroplan::default()
        .solve(&split.domain, &split.problem, &Limits::default())
        .unwrap()
}

fn option_of(model: &ModelRecord, step: &GroundAction) -> String {
    let name = step.name.split("--").next().unwrap();
    model.explain(name).unwrap().option
}

#[test]
fn the_corridor_is_understood() {
    let model = learn(&corridor(20, 60, 1), 0);
    assert_eq!(model.factors().variables(), [vec![0], vec![1], vec![2]]);
    let record = model.record();
    let outcome = plan(&record);
    let plan = outcome.plan().unwrap_or_else(|| panic!("{outcome:?}"));
    let options: Vec<_> = plan
        .steps
        .iter()
        .map(|step| option_of(&record, step))
        .collect();
    assert_eq!(options, ["go", "switch", "go"], "{plan}");
    let goal = model.goal().unwrap();
    assert!(goal.probability > 0.8, "{}", goal.probability);
    assert_eq!(goal.condition.variables, [0, 1]);
}

#[test]
fn chance_shows_in_the_operator_with_the_share_that_was_seen() {
    let model = learn(&corridor(20, 200, 2), 0);
    let switch = model
        .operators()
        .iter()
        .find(|o| o.name.starts_with("switch"))
        .unwrap();
    let mut probabilities: Vec<_> = switch.outcomes.iter().map(|o| o.probability).collect();
    probabilities.sort_by(f64::total_cmp);
    assert_eq!(probabilities.len(), 2);
    assert!((probabilities[1] - 0.8).abs() < 0.1, "{probabilities:?}");
    assert_eq!(switch.outcomes[0].cost, Some(1.0));
}

#[test]
fn the_same_seed_gives_the_same_model() {
    let transitions = corridor(20, 30, 3);
    assert_eq!(learn(&transitions, 5), learn(&transitions, 5));
}

#[test]
fn stages_are_told_in_order() {
    let mut told = Vec::new();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let params = LearnParams::default();
    SymbolicModel::learn(&corridor(5, 5, 0), &params, &mut rng, &mut |stage| {
        told.push(stage)
    });
    assert_eq!(told.len(), 5);
    assert!(told.is_sorted());
}

#[test]
fn an_operator_explains_itself() {
    let model = learn(&corridor(20, 60, 1), 0).record();
    let name = &model
        .operators
        .iter()
        .find(|o| o.name.starts_with("switch"))
        .unwrap()
        .name;
    let explanation = model.explain(name).unwrap();
    assert_eq!(explanation.option, "switch");
    assert!(
        explanation.looks_at.contains(&"place".to_owned()),
        "{explanation}"
    );
    assert!(
        !explanation.looks_at.contains(&"weather".to_owned()),
        "{explanation}"
    );
    assert_eq!(explanation.rows.len(), explanation.n_positive);
    let text = explanation.to_string();
    for part in [
        "runs option `switch`",
        "held-out states",
        "then with probability",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let error = model
        .explain("swich-partition-0-0")
        .unwrap_err()
        .to_string();
    assert!(error.contains("did you mean `switch-partition-"), "{error}");
}

#[test]
fn people_rename_what_was_learned() {
    let mut model = learn(&corridor(20, 60, 1), 0).record();
    let n_steps = plan(&model).plan().unwrap().steps.len();
    model.rename("symbol_0", "at-the-left-end").unwrap();
    let operator = model.operators[0].name.clone();
    model.rename(&operator, "stroll").unwrap();
    assert_eq!(plan(&model).plan().unwrap().steps.len(), n_steps);
    let before = model.clone();
    for (from, to) in [
        ("symbol_1", "at-the-left-end"),
        ("symbol_1", "a b"),
        ("symbol_0", "c"),
    ] {
        let error = model.rename(from, to).unwrap_err().to_string();
        assert!(error.contains(from), "{error}");
    }
    assert!(model.rename("stroll", "").is_err());
    assert_eq!(model, before);
}

/// Less was seen, so less is known, and what is known can still be written down.
#[test]
fn poor_data_give_a_smaller_model() {
    let check = |transitions: &Transitions, n_operators: std::ops::RangeInclusive<usize>| {
        let model = learn(transitions, 0);
        assert!(
            n_operators.contains(&model.operators().len()),
            "{}",
            model.operators().len()
        );
        assert!(model.goal().is_none());
        assert!(plan(&model.record()).plan().is_none(), "no goal is known");
        model
    };
    let none = corridor(0, 0, 0);
    assert!(check(&none, 0..=0).start().is_empty());
    assert!(check(&corridor(1, 1, 0), 0..=0).goal().is_none());
    // One short episode; nothing is known of the goal.
    assert!(check(&corridor(6, 1, 4), 0..=6).goal().is_none());
    // Nothing but chance: every end state is somewhere else.
    let mut noise = Transitions::new(vec!["x".to_owned()], vec!["go".to_owned()]);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    for episode in 0..20 {
        noise
            .push(&Transition {
                state: &[100.0 * rng.random::<f64>()],
                option: 0,
                next_state: &[100.0 * rng.random::<f64>()],
                mask: None,
                executable: &[true],
                episode,
                reward: None,
                goal_achieved: false,
            })
            .unwrap();
    }
    // One wide effect, and nothing it hangs on.
    let model = check(&noise, 1..=1);
    assert!(model.operators()[0].precondition.is_empty());
}
