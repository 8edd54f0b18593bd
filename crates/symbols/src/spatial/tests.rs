//! Kitchens small enough to simulate here: a base that goes anywhere, and things to do at some places.
#![expect(
    clippy::float_cmp_const,
    reason = "the mug is in one of three states, each a number of its own"
)]

use std::collections::BTreeSet;

use factotum_task_planning::operator::Plan;
use factotum_task_planning::pddl::{DeterminiseOptions, determinise};
use factotum_task_planning::planner::{Ferroplan, Limits, Planner as _};
use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::model::{LearnParams, ModelRecord, SymbolicModel};
use crate::partition::LeftOutReason;
use crate::transitions::{Transition, Transitions};

/// x and y of the base in [0, 1], then the rest.
type State = Vec<f64>;

/// A kitchen's rules.
struct Kitchen {
    variables: &'static [&'static str],
    options: &'static [&'static str],
    start: &'static [f64],
    /// Options that can run, or not, wherever the base is.
    anywhere: &'static [usize],
    can: fn(&State, usize) -> bool,
    /// What the option does to a state it can run in.
    run: fn(&mut State, usize, &mut ChaCha8Rng),
    is_goal: fn(&State) -> bool,
}

const X: usize = 0;
const Y: usize = 1;
const MUG: usize = 2;
const COFFEE: usize = 3;

const ON_TABLE: f64 = 0.0;
const HELD: f64 = 0.5;
const IN_MACHINE: f64 = 1.0;

fn is_near(state: &State, x: f64, y: f64) -> bool {
    (state[X] - x).hypot(state[Y] - y) < 0.2
}

fn go_anywhere(state: &mut State, rng: &mut ChaCha8Rng) {
    state[X] = rng.random();
    state[Y] = rng.random();
}

/// Go; pick the mug at the table; put it into the machine; brew; and from anywhere turn the radio on and off. Where to
/// stand depends on nothing else.
const COFFEE_KITCHEN: Kitchen = Kitchen {
    variables: &["x", "y", "mug", "coffee", "radio"],
    options: &["go", "pick", "put", "brew", "radio"],
    start: &[0.5, 0.5, ON_TABLE, 0.0, 0.0],
    anywhere: &[0, 4],
    can: |state, option| match option {
        1 => state[MUG] == ON_TABLE && is_near(state, 0.2, 0.25),
        2 => state[MUG] == HELD && is_near(state, 0.8, 0.7),
        3 => state[MUG] == IN_MACHINE && state[COFFEE] == 0.0 && is_near(state, 0.75, 0.7),
        _ => true,
    },
    run: |state, option, rng| match option {
        1 => state[MUG] = HELD,
        2 => state[MUG] = IN_MACHINE,
        3 => state[COFFEE] = 1.0,
        4 => state[4] = 1.0 - state[4],
        _ => go_anywhere(state, rng),
    },
    is_goal: |state| state[COFFEE] == 1.0,
};

/// The mug is on one of two tables; from anywhere, a push brings it to the other, and a held mug is put back.
const TWO_TABLES: Kitchen = Kitchen {
    variables: &["x", "y", "mug", "table"],
    options: &["go", "pick", "push", "back"],
    start: &[0.5, 0.5, ON_TABLE, 0.0],
    anywhere: &[0, 2, 3],
    can: |state, option| match option {
        1 if state[3] == 0.0 => state[MUG] == ON_TABLE && is_near(state, 0.2, 0.25),
        1 => state[MUG] == ON_TABLE && is_near(state, 0.8, 0.7),
        2 => state[MUG] == ON_TABLE,
        3 => state[MUG] == HELD,
        _ => true,
    },
    run: |state, option, rng| match option {
        1 => state[MUG] = HELD,
        2 => state[3] = 1.0 - state[3],
        3 => state[MUG] = ON_TABLE,
        _ => go_anywhere(state, rng),
    },
    is_goal: |state| state[MUG] == HELD && state[3] == 1.0,
};

/// One button lights the lamp it is at.
const TWO_LAMPS: Kitchen = Kitchen {
    variables: &["x", "y", "left lamp", "right lamp"],
    options: &["go", "press"],
    start: &[0.5, 0.5, 0.0, 0.0],
    anywhere: &[0],
    can: |state, option| match option {
        1 => {
            (is_near(state, 0.2, 0.5) && state[2] == 0.0)
                || (is_near(state, 0.8, 0.5) && state[3] == 0.0)
        }
        _ => true,
    },
    run: |state, option, rng| match option {
        1 if state[X] < 0.5 => state[2] = 1.0,
        1 => state[3] = 1.0,
        _ => go_anywhere(state, rng),
    },
    is_goal: |state| state[2] == 1.0 && state[3] == 1.0,
};

impl Kitchen {
    /// So many tries: mostly something that can be done at this place, else the base goes elsewhere; one try in five is any.
    fn explore(&self, n_tries: usize, seed: u64) -> Transitions {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        let mut transitions = Transitions::new(names(self.variables), names(self.options));
        let (mut state, mut episode) = (self.start.to_vec(), 0);
        for _ in 0..n_tries {
            let n_options = self.options.len();
            let executable: Vec<bool> = (0..n_options).map(|o| (self.can)(&state, o)).collect();
            let can_all: Vec<usize> = (0..n_options).filter(|&o| executable[o]).collect();
            let here: Vec<usize> = (can_all.iter().copied())
                .filter(|o| !self.anywhere.contains(o))
                .collect();
            let choices = match rng.random_range(0..5) {
                0 => &can_all[..],
                _ if here.is_empty() => &[0],
                _ => &here,
            };
            let option = choices[rng.random_range(0..choices.len())];
            let mut next_state = state.clone();
            (self.run)(&mut next_state, option, &mut rng);
            let goal_achieved = (self.is_goal)(&next_state);
            transitions
                .push(&Transition {
                    state: &state,
                    option,
                    next_state: &next_state,
                    mask: None,
                    executable: &executable,
                    episode,
                    reward: None,
                    goal_achieved,
                })
                .unwrap();
            state = next_state;
            if goal_achieved {
                state = self.start.to_vec();
                go_anywhere(&mut state, &mut rng);
                episode += 1;
            }
        }
        transitions
    }

    /// How often a plan reaches the goal, the base's places drawn from the navigation symbols.
    fn success_rate(&self, model: &SymbolicModel, plan: &Plan, seed: u64) -> f64 {
        const N_RUNS: u32 = 50;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let record = model.record();
        let mut n_achieved = 0;
        for _ in 0..N_RUNS {
            let mut state = self.start.to_vec();
            for step in &plan.steps {
                if let Some(place) = step.name.strip_prefix("go-to-") {
                    let name = format!("at-{place}");
                    let places = &model.space().unwrap().places;
                    let place = places.iter().find(|p| p.name == name).unwrap();
                    (state[X], state[Y]) = sample(place, &mut rng);
                    continue;
                }
                let name = step.name.split("--").next().unwrap();
                let option = record.explain(name).unwrap().option;
                let option = self.options.iter().position(|o| *o == option).unwrap();
                if (self.can)(&state, option) {
                    (self.run)(&mut state, option, &mut rng);
                }
            }
            n_achieved += u32::from((self.is_goal)(&state));
        }
        f64::from(n_achieved) / f64::from(N_RUNS)
    }
}

/// The likeliest of some places drawn from a navigation symbol by rejection, as grounding one in a home gives them.
fn sample(place: &Place, rng: &mut ChaCha8Rng) -> (f64, f64) {
    const N_DRAWS: usize = 10;
    let mut best = (f64::NEG_INFINITY, (0.0, 0.0));
    let mut n_accepted = 0;
    while n_accepted < N_DRAWS {
        let at = [rng.random::<f64>(), rng.random()];
        let values: Vec<f64> = place.condition.variables.iter().map(|&v| at[v]).collect();
        let p = place.condition.probability(&values);
        if rng.random::<f64>() < p {
            n_accepted += 1;
            if p > best.0 {
                best = (p, (at[0], at[1]));
            }
        }
    }
    best.1
}

fn learn(transitions: &Transitions, spatial: Option<SpatialParams>) -> SymbolicModel {
    let params = LearnParams {
        spatial,
        ..LearnParams::default()
    };
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    SymbolicModel::learn(transitions, &params, &mut rng, &mut |_| {})
}

fn learn_apart(transitions: &Transitions) -> SymbolicModel {
    learn(transitions, Some(SpatialParams::new(vec![X, Y])))
}

fn plan(record: &ModelRecord) -> Option<Plan> {
    let domain = record.domain("kitchen").unwrap();
    let problem = record.problem("chore", &domain).unwrap();
    let split = determinise(&domain, &problem, &DeterminiseOptions::default()).unwrap();
    let outcome = Ferroplan::default()
        .solve(&split.domain, &split.problem, &Limits::default())
        .unwrap();
    outcome.plan().map(|plan| split.restore(plan))
}

fn verdict(model: &SymbolicModel, option: &str) -> Verdict {
    let record = model.record();
    let tested = record.independence.iter().find(|i| i.option == option);
    tested
        .unwrap_or_else(|| panic!("no test of {option}"))
        .verdict
}

#[test]
fn coffee_is_planned_without_space_and_made_with_it() {
    let kitchen = &COFFEE_KITCHEN;
    let model = learn_apart(&kitchen.explore(600, 1));
    let record = model.record();
    assert_eq!(record.variables, ["mug", "coffee", "radio"]);
    assert_eq!(model.summary(&[]).factors, [vec![2], vec![3], vec![4]]);
    assert_eq!(
        verdict(&model, "pick"),
        Verdict::Holds,
        "{:?}",
        record.independence
    );
    let plan = plan(&record).unwrap();
    let names: Vec<_> = plan
        .steps
        .iter()
        .map(|s| s.name.split("-partition").next().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "go-to-pick",
            "pick",
            "go-to-put",
            "put",
            "go-to-brew",
            "brew"
        ]
    );
    let rate = kitchen.success_rate(&model, &plan, 2);
    assert!(rate > 0.8, "{rate}");
    // Going is the path planner's.
    let moves = record.left_out.iter().find(|l| l.option == "go").unwrap();
    assert_eq!(moves.reason, LeftOutReason::OnlyMoved);
}

/// What the property is for (dissertation Fig. 5.4): a plan from few tries.
#[test]
fn fewer_tries_are_enough_with_spatial_independence() {
    let kitchen = &COFFEE_KITCHEN;
    let n_of = |spatial: Option<SpatialParams>| {
        let solved = |seed: &u64| {
            let tries = kitchen.explore(100, *seed);
            plan(&learn(&tries, spatial.clone()).record()).is_some()
        };
        (0..10).filter(solved).count()
    };
    let (with, without) = (n_of(Some(SpatialParams::new(vec![X, Y]))), n_of(None));
    // As measured: 10 and 3; without it, 400 tries are needed.
    assert!(
        with >= 9 && without <= 6,
        "with {with}, without {without} of 10"
    );
}

#[test]
fn where_independence_fails_operators_have_places_of_their_own() {
    let kitchen = &TWO_TABLES;
    let model = learn_apart(&kitchen.explore(1000, 3));
    let record = model.record();
    assert_eq!(
        verdict(&model, "pick"),
        Verdict::Fails,
        "{:?}",
        record.independence
    );
    assert_ne!(
        verdict(&model, "push"),
        Verdict::Fails,
        "{:?}",
        record.independence
    );
    let of_pick: BTreeSet<_> = (record.operators.iter())
        .filter(|o| o.name.starts_with("pick"))
        .map(|o| o.place.clone().unwrap())
        .collect();
    assert_eq!(of_pick.len(), 2, "{of_pick:?}");
    let plan = plan(&record).unwrap();
    let rate = kitchen.success_rate(&model, &plan, 4);
    assert!(rate > 0.8, "{rate}: {plan}");
}

#[test]
fn effects_that_places_tell_apart_are_operators_of_their_own() {
    let kitchen = &TWO_LAMPS;
    let model = learn_apart(&kitchen.explore(600, 5));
    let record = model.record();
    assert!(
        record.operators.iter().all(|o| o.outcomes.len() == 1),
        "which lamp it is, is no chance: {:?}",
        record.operators
    );
    let plan = plan(&record).unwrap();
    let rate = kitchen.success_rate(&model, &plan, 6);
    assert!(rate > 0.8, "{rate}: {plan}");
}

#[test]
fn the_same_seed_gives_the_same_model() {
    let tries = COFFEE_KITCHEN.explore(150, 7);
    assert_eq!(learn_apart(&tries), learn_apart(&tries));
}

/// Nothing, next to nothing, and a base that never moved.
#[test]
fn poor_data_give_a_smaller_model() {
    for n_tries in [0, 1, 10, 30] {
        let record = learn_apart(&COFFEE_KITCHEN.explore(n_tries, 8)).record();
        assert!(plan(&record).is_none() || n_tries == 30);
        assert!(
            (record.independence.iter()).all(|i| i.verdict == Verdict::Untested || n_tries == 30)
        );
    }
    let mut still = COFFEE_KITCHEN.explore(200, 9);
    still = still.project(&[2, 3]);
    let record = learn(&still, Some(SpatialParams::new(vec![1]))).record();
    assert_eq!(record.variables, ["mug"]);
}

/// Finite sets of states (place, rest) as in Definition 5.3.1.
type StateSet = BTreeSet<(u8, u8)>;

fn proj_place_freed(set: &StateSet) -> BTreeSet<u8> {
    set.iter().map(|(_, rest)| *rest).collect()
}

fn proj_rest_freed(set: &StateSet) -> BTreeSet<u8> {
    set.iter().map(|(place, _)| *place).collect()
}

fn is_spatially_independent(set: &StateSet) -> bool {
    let (places, rests) = (proj_rest_freed(set), proj_place_freed(set));
    let product = places
        .iter()
        .flat_map(|p| rests.iter().map(move |r| (*p, *r)));
    product.eq(set.iter().copied())
}

proptest! {
    /// Theorem 1, both ways: from every state whose rest allows the option, going to any place of σ leads into the
    /// initiation set, exactly if that set is spatially independent.
    #[test]
    fn going_to_the_symbol_suffices_exactly_under_independence(
        initiation in prop::collection::btree_set((0_u8..4, 0_u8..4), 0..12),
    ) {
        let sigma = proj_rest_freed(&initiation);
        let suffices = initiation
            .iter()
            .all(|(_, rest)| sigma.iter().all(|place| initiation.contains(&(*place, *rest))));
        prop_assert_eq!(suffices, is_spatially_independent(&initiation));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    /// Theorem 1 for what is learned: where the initiation set is a disc of places times some states of the rest, the
    /// test says so, and the option can run at every place that σ is sure of.
    #[test]
    fn the_option_can_run_at_the_places_of_its_learned_symbol(
        x in 0.3..0.7_f64, y in 0.3..0.7_f64, n_right in 1_usize..3, seed: u64
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let is_in = |place: [f64; 2]| (place[0] - x).hypot(place[1] - y) < 0.3;
        let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        let mut tries = Transitions::new(names(&["x", "y", "rest", "done"]), names(&["do"]));
        for episode in 0..400 {
            let rest = rng.random_range(0..3_usize);
            let place = [rng.random(), rng.random()];
            let can = rest < n_right && is_in(place);
            let state = [place[0], place[1], 0.5 * rest as f64, 0.0];
            let next_state = [place[0], place[1], 0.5 * rest as f64, f64::from(u8::from(can))];
            tries
                .push(&Transition {
                    state: &state,
                    option: 0,
                    next_state: &next_state,
                    mask: None,
                    executable: &[can],
                    episode,
                    reward: None,
                    goal_achieved: false,
                })
                .unwrap();
        }
        let model = learn_apart(&tries);
        prop_assert_ne!(verdict(&model, "do"), Verdict::Fails);
        let place = &model.space().unwrap().places[0];
        let mut n_right = 0;
        for _ in 0..200 {
            let (x, y) = sample(place, &mut rng);
            n_right += usize::from(is_in([x, y]));
        }
        prop_assert!(n_right >= 170, "{} of 200", n_right);
    }
}
