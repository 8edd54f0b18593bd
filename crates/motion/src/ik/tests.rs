use super::*;
use crate::robot::RobotModel;
use crate::scene::{Obstacle, ObstacleShape};
use crate::test_robots;
use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Collision-free configurations of a robot alone.
fn free_samples(scene: &mut PlanningScene, n: usize) -> Vec<Vec<f64>> {
    let robot = scene.robot().clone();
    let mut rng = rng(11);
    let mut samples = Vec::new();
    while samples.len() < n {
        let mut q = vec![0.0; robot.n()];
        robot.space().sample_into(&mut rng, &mut q);
        if scene.is_free(&q) {
            samples.push(q);
        }
    }
    samples
}

fn assert_solves(robot: &RobotModel, solution: &IkSolution, target: &Pose, options: &IkOptions) {
    let pose = robot.chain().base_from_tcp(&solution.q);
    let (linear, angular) = descent::residual(&pose, target, options.axis_free);
    assert!(linear.norm() <= options.position_tol_m + 1e-12, "{linear}");
    assert!(
        angular.norm() <= options.rotation_tol_rad + 1e-12,
        "{angular}"
    );
    assert!(
        robot.space().is_within_limits(&solution.q),
        "{:?}",
        solution.q
    );
}

#[test]
fn poses_of_free_configurations_are_solved_without_collision() {
    for name in ["panda", "iiwa7", "jaco", "movo"] {
        let robot = test_robots::load(name);
        let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
        let mut rng = rng(1);
        let samples = free_samples(&mut scene, 100);
        let mut n_solved = 0;
        for q in &samples {
            let target = robot.chain().base_from_tcp(q);
            let options = IkOptions {
                prefer: IkPreference::First,
                ..IkOptions::default()
            };
            let outcome = solve_ik(&mut scene, &target, &[], &options, &mut rng);
            if let IkOutcome::Solved(solution) = &outcome {
                n_solved += 1;
                assert_solves(&robot, solution, &target, &options);
                assert!(scene.is_free(&solution.q));
                let manipulability = scene.manipulability(&solution.q);
                assert!((solution.manipulability - manipulability).abs() < 1e-12);
            }
        }
        // Found: 100 for both; some poses have very few collision-free solutions.
        assert!(n_solved >= 97, "{name}: {n_solved} of 100");
    }
}

#[test]
fn the_preferred_solution_is_returned() {
    let robot = test_robots::load("movo");
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let ready = robot.q_ready();
    let target = robot.chain().base_from_tcp(&ready);
    let solve = |scene: &mut PlanningScene, prefer| {
        let options = IkOptions {
            prefer,
            ..IkOptions::default()
        };
        match solve_ik(
            scene,
            &target,
            std::slice::from_ref(&ready),
            &options,
            &mut rng(2),
        ) {
            IkOutcome::Solved(solution) => solution,
            IkOutcome::Failed(failure) => panic!("{failure:?}"),
        }
    };
    let near = solve(&mut scene, IkPreference::NearestSeed);
    assert!(
        robot.space().distance(&near.q, &ready) < 1e-6,
        "the seed is a solution"
    );
    let best = solve(&mut scene, IkPreference::Manipulability);
    assert!(best.manipulability >= near.manipulability);
    assert!(
        best.manipulability > 1.05 * near.manipulability,
        "{best:?} {near:?}"
    );
}

#[test]
fn many_solutions_differ_and_are_sorted() {
    let robot = test_robots::load("movo");
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let target = robot.chain().base_from_tcp(&robot.q_ready());
    let options = IkOptions::default();
    let all = solve_ik_many(&mut scene, &target, &[], &options, 6, &mut rng(3));
    assert_eq!(all.len(), 6);
    for (i, a) in all.iter().enumerate() {
        for b in &all[i + 1..] {
            assert!(robot.space().distance(a, b) >= SAME_SOLUTION);
        }
    }
    let values: Vec<f64> = all.iter().map(|q| scene.manipulability(q)).collect();
    assert!(values.is_sorted_by(|a, b| a >= b), "{values:?}");
}

#[test]
fn a_free_axis_leaves_the_turn_about_the_tool_open() {
    let robot = test_robots::load("jaco");
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let target = robot.chain().base_from_tcp(&robot.q_ready());
    let turned = target * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.0);
    let options = IkOptions {
        axis_free: true,
        ..IkOptions::default()
    };
    let near = IkOptions {
        prefer: IkPreference::NearestSeed,
        ..options
    };
    let outcome = solve_ik(&mut scene, &turned, &[robot.q_ready()], &near, &mut rng(4));
    assert!(
        robot
            .space()
            .distance(outcome.q().unwrap(), &robot.q_ready())
            < 1e-6
    );
    match solve_ik(&mut scene, &turned, &[], &options, &mut rng(4)) {
        IkOutcome::Solved(solution) => assert_solves(&robot, &solution, &turned, &options),
        IkOutcome::Failed(failure) => panic!("{failure:?}"),
    }
}

#[test]
fn failure_says_how_near_it_came_or_what_is_in_the_way() {
    let robot = test_robots::load("jaco");
    let options = IkOptions {
        restarts: 20,
        ..IkOptions::default()
    };
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let far = Pose::translation(3.0, 0.0, 0.5);
    match solve_ik(&mut scene, &far, &[], &options, &mut rng(5)) {
        IkOutcome::Failed(failure) => {
            assert!(failure.best_position_error_m > 1.5 && failure.collision.is_none());
            assert_eq!(failure.restarts, 20);
        }
        IkOutcome::Solved(solution) => panic!("{solution:?}"),
    }
    let target = robot.chain().base_from_tcp(&robot.q_ready());
    let wall = Obstacle {
        name: "wall".to_owned(),
        shape: ObstacleShape::Box {
            half_extents_m: [0.1, 0.1, 0.1],
        },
        base_from_obstacle: target,
    };
    let mut scene = PlanningScene::new(&robot, &[wall], None).unwrap();
    match solve_ik(
        &mut scene,
        &target,
        &[robot.q_ready()],
        &options,
        &mut rng(5),
    ) {
        IkOutcome::Failed(failure) => {
            let (a, b) = failure.collision.unwrap();
            assert!(a == "wall" || b == "wall");
        }
        IkOutcome::Solved(solution) => panic!("{solution:?}"),
    }
}

#[test]
fn the_same_seed_gives_the_same_solution() {
    let robot = test_robots::load("movo");
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let target = robot.chain().base_from_tcp(&robot.q_ready());
    let options = IkOptions::default();
    let first = solve_ik(&mut scene, &target, &[], &options, &mut rng(6));
    let second = solve_ik(&mut scene, &target, &[], &options, &mut rng(6));
    assert_eq!(first, second);
}
