use super::*;
use crate::joint_space::JointLimit;
use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

const OPTIONS: SearchOptions = SearchOptions {
    n_nodes_max: 5_000,
    iterations_max: 5_000,
    step: 0.02,
    range: 0.5,
};

/// Two hinges; the second continuous.
fn space() -> JointSpace {
    let limited = JointLimit {
        lower: -2.0,
        upper: 2.0,
        velocity: 1.0,
        acceleration: 1.0,
        jerk: 1.0,
        continuous: false,
        slide: false,
    };
    let continuous = JointLimit {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        continuous: true,
        ..limited
    };
    JointSpace::new(vec![limited, continuous])
}

/// A wall at the first joint's zero with a door at the second's `door`.
fn wall(q: &[f64], door: f64) -> bool {
    let off_door = factotum_geometry::frames::wrap_angle(q[1] - door).abs();
    q[0].abs() > 0.1 || off_door < 0.2
}

fn check_path(path: &[Vec<f64>], start: &[f64], goal: &[f64], valid: impl Fn(&[f64]) -> bool) {
    let space = space();
    assert_eq!(path[0], start);
    assert!(space.distance(&path[path.len() - 1], goal) < 1e-9);
    for pair in path.windows(2) {
        let n = (space.distance(&pair[0], &pair[1]) / (0.1 * OPTIONS.step))
            .ceil()
            .max(1.0);
        for i in 0..=n as usize {
            let q = space.interpolate(&pair[0], &pair[1], i as f64 / n);
            // The checks are a step apart: the finer check allows half of one.
            assert!(valid(&q), "{q:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn both_planners_pass_the_door(seed in 0u64..1000, door in -3.0..3.0, from in -3.0..3.0) {
        let space = space();
        let (start, goal) = (vec![-1.0, from], vec![1.5, -from]);
        let loose = |q: &[f64]| {
            let off_door = factotum_geometry::frames::wrap_angle(q[1] - door).abs();
            q[0].abs() > 0.1 - 0.5 * OPTIONS.step || off_door < 0.2 + 0.5 * OPTIONS.step
        };
        for planner in ["connect", "star"] {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut validity = |q: &[f64]| wall(q, door);
            let goals = std::slice::from_ref(&goal);
            let options = SearchOptions { iterations_max: 2_000, ..OPTIONS };
            let search = match planner {
                "connect" => rrt_connect(&space, &mut validity, &start, goals, &options, &mut rng),
                _ => rrt_star(&space, &mut validity, &start, goals, &options, &mut rng),
            };
            let mut path = search.path.unwrap().waypoints;
            check_path(&path, &start, &goal, loose);
            let before = space.path_length(&path);
            shortcut(&space, &mut validity, &mut path, OPTIONS.step, 50, &mut rng);
            check_path(&path, &start, &goal, loose);
            prop_assert!(space.path_length(&path) <= before + 1e-9);
            unwrap_turns(&space, &mut path);
            for pair in path.windows(2) {
                prop_assert!((pair[1][1] - pair[0][1]).abs() <= std::f64::consts::PI + 1e-9);
            }
        }
    }
}

/// A longer search never gives a longer path, and the path nears the shortest one.
#[test]
fn rrt_star_shortens_with_iterations() {
    let space = space();
    let (start, goal) = (vec![-1.0, 0.0], vec![1.0, 0.0]);
    let length = |iterations_max: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let options = SearchOptions {
            iterations_max,
            ..OPTIONS
        };
        let mut validity = |q: &[f64]| wall(q, 1.0);
        let goals = std::slice::from_ref(&goal);
        let search = rrt_star(&space, &mut validity, &start, goals, &options, &mut rng);
        space.path_length(&search.path.unwrap().waypoints)
    };
    let lengths = [300, 1_000, 3_000].map(length);
    assert!(lengths.is_sorted_by(|a, b| a >= b), "{lengths:?}");
    // Around the door's near edge at 0.8: two legs of hypot(0.9, 0.8) and 0.2 between them.
    let shortest = 2.0 * 0.9_f64.hypot(0.8) + 0.2;
    assert!(lengths[2] < 1.05 * shortest, "{lengths:?} {shortest}");
}

#[test]
fn the_short_way_round_is_taken() {
    let space = space();
    let (start, goal) = (vec![0.5, 3.0], vec![0.5, -3.0]);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut free = |_: &[f64]| true;
    let search = rrt_connect(
        &space,
        &mut free,
        &start,
        std::slice::from_ref(&goal),
        &OPTIONS,
        &mut rng,
    );
    let mut path = search.path.unwrap().waypoints;
    unwrap_turns(&space, &mut path);
    let end = path[path.len() - 1][1];
    assert!((end - (std::f64::consts::TAU - 3.0)).abs() < 1e-9, "{end}");
}

#[test]
fn the_cap_that_ended_the_search_is_named() {
    let space = space();
    let (start, goal) = (vec![-1.0, 0.0], vec![1.0, 0.0]);
    let goals = std::slice::from_ref(&goal);
    let mut closed = |q: &[f64]| q[0].abs() > 0.1;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let few = SearchOptions {
        iterations_max: 10,
        ..OPTIONS
    };
    let search = rrt_connect(&space, &mut closed, &start, goals, &few, &mut rng);
    assert_eq!(
        (search.path, search.iterations),
        (Err(SearchLimit::Iterations), 10)
    );
    let small = SearchOptions {
        n_nodes_max: 20,
        ..OPTIONS
    };
    let search = rrt_connect(&space, &mut closed, &start, goals, &small, &mut rng);
    assert_eq!(search.path, Err(SearchLimit::Nodes));
    let search = rrt_star(&space, &mut closed, &start, goals, &small, &mut rng);
    assert_eq!(search.path, Err(SearchLimit::Nodes));
}

#[test]
fn a_motion_is_checked_everywhere_along_it() {
    let space = space();
    let (a, b) = (vec![-1.0, 0.0], vec![1.0, 0.0]);
    let mut checked = Vec::new();
    let mut validity = |q: &[f64]| {
        checked.push(q[0]);
        true
    };
    assert!(is_motion_valid(&space, &mut validity, &a, &b, 0.1));
    checked.push(a[0]);
    checked.sort_by(f64::total_cmp);
    assert_eq!(checked.len(), 21);
    assert!(
        checked
            .windows(2)
            .all(|pair| pair[1] - pair[0] <= 0.1 + 1e-12)
    );
}
