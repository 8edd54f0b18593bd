use super::*;
use crate::Pose;
use crate::robot::RobotModel;
use crate::scene::{Obstacle, ObstacleShape};
use crate::test_robots;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

fn a_box(name: &str, at: [f64; 3], half_extents_m: [f64; 3]) -> Obstacle {
    Obstacle {
        name: name.to_owned(),
        shape: ObstacleShape::Box { half_extents_m },
        base_from_obstacle: Pose::translation(at[0], at[1], at[2]),
    }
}

/// A table in front of the robot with a wall across it.
fn kitchen() -> Vec<Obstacle> {
    vec![
        a_box("table", [0.9, 0.0, 0.7], [0.3, 0.8, 0.02]),
        a_box("wall", [0.8, 0.0, 0.95], [0.2, 0.02, 0.2]),
    ]
}

/// Random free configurations.
fn free_samples(scene: &mut PlanningScene, n: usize, seed: u64) -> Vec<Vec<f64>> {
    let robot = scene.robot().clone();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
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

/// Ends, limits, and freedom from collision at a tenth of the planner's step.
fn assert_good(
    robot: &RobotModel,
    path: &[Vec<f64>],
    start: &[f64],
    goal: &[f64],
    scene: &mut PlanningScene,
) {
    let space = robot.space();
    assert_eq!(path[0], start);
    assert!(space.distance(&path[path.len() - 1], goal) < 1e-9);
    let fine = 0.1 * PlanLimits::default().step_rad;
    for pair in path.windows(2) {
        let n = (space.distance(&pair[0], &pair[1]) / fine).ceil().max(1.0);
        for i in 0..=n as usize {
            // Plain interpolation: the path is unwrapped.
            let t = i as f64 / n;
            let q: Vec<f64> = pair[0]
                .iter()
                .zip(&pair[1])
                .map(|(a, b)| a + t * (b - a))
                .collect();
            assert!(space.is_within_limits(&q), "{q:?}");
            assert_eq!(scene.collision(&q), None, "{q:?}");
        }
    }
}

#[test]
fn paths_between_free_configurations_are_found_and_free() {
    let robot = test_robots::load("movo");
    let mut scene = PlanningScene::new(&robot, &kitchen(), None).unwrap();
    let samples = free_samples(&mut scene, 12, 21);
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    for pair in samples.windows(2) {
        let (start, goal) = (&pair[0], &pair[1]);
        let goals = std::slice::from_ref(goal);
        match plan_joints(&mut scene, start, goals, &PlanLimits::default(), &mut rng) {
            PathOutcome::Solved(plan) => {
                assert_good(&robot, &plan.path, start, goal, &mut scene);
                assert!(plan.stats.length <= plan.stats.length_found + 1e-9);
                // Rounded corners included, the timed motion is free as well.
                let trajectory = crate::time_path(&robot, &plan.path, 1.0).unwrap();
                for i in 0..=1000 {
                    let time_secs = trajectory.duration_secs() * f64::from(i) / 1000.0;
                    assert_eq!(
                        scene.collision(&trajectory.sample(time_secs).positions),
                        None
                    );
                }
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn rrt_star_paths_are_free_too() {
    let robot = test_robots::load("jaco");
    let mut scene = PlanningScene::new(
        &robot,
        &[a_box("post", [0.4, 0.0, 0.5], [0.05, 0.05, 0.5])],
        None,
    )
    .unwrap();
    let samples = free_samples(&mut scene, 2, 31);
    let limits = PlanLimits {
        iterations_max: 300,
        ..PlanLimits::default()
    };
    let goals = std::slice::from_ref(&samples[1]);
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    match plan_joints_star(&mut scene, &samples[0], goals, &limits, &mut rng) {
        PathOutcome::Solved(plan) => {
            assert_good(&robot, &plan.path, &samples[0], &samples[1], &mut scene)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn one_of_several_goals_is_reached_and_named() {
    let robot = test_robots::load("movo");
    let mut scene = PlanningScene::new(&robot, &kitchen(), None).unwrap();
    let samples = free_samples(&mut scene, 3, 41);
    let mut outside = samples[1].clone();
    outside[0] = 9.0;
    let goals = [outside, samples[1].clone(), samples[2].clone()];
    let mut rng = ChaCha8Rng::seed_from_u64(42);
    match plan_joints(
        &mut scene,
        &samples[0],
        &goals,
        &PlanLimits::default(),
        &mut rng,
    ) {
        PathOutcome::Solved(plan) => {
            assert!(plan.goal_idx == 1 || plan.goal_idx == 2);
            assert_good(
                &robot,
                &plan.path,
                &samples[0],
                &goals[plan.goal_idx],
                &mut scene,
            );
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn why_there_is_no_path_is_said() {
    let robot = test_robots::load("movo");
    let ready = robot.q_ready();
    let tcp = robot.chain().base_from_tcp(&ready).translation.vector;
    let block = a_box("block", tcp.into(), [0.05, 0.05, 0.05]);
    let mut scene = PlanningScene::new(&robot, &[block], None).unwrap();
    let rest = robot.q_rest();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let limits = PlanLimits::default();
    let mut plan = |start: &[f64], goals: &[Vec<f64>]| {
        plan_joints(&mut scene, start, goals, &limits, &mut rng)
    };
    let has_block = |(a, b): &(String, String)| a == "block" || b == "block";
    assert!(
        matches!(plan(&ready, std::slice::from_ref(&rest)), PathOutcome::StartInCollision(pair) if has_block(&pair))
    );
    assert!(
        matches!(plan(&rest, std::slice::from_ref(&ready)), PathOutcome::GoalInCollision(pair) if has_block(&pair))
    );
    let mut high = rest.clone();
    high[0] = 2.0;
    let outside = PathOutcome::GoalOutsideLimits {
        joint: "lift".to_owned(),
        position: 2.0,
    };
    assert_eq!(plan(&rest, &[high]), outside);
    assert_eq!(plan(&rest, &[]), PathOutcome::NoGoal);
    assert_eq!(plan(&rest, &[vec![0.0]]), PathOutcome::NoGoal);
}

#[test]
fn a_cap_ends_the_search() {
    // A cage about the hand: no way out.
    let robot = test_robots::load("jaco");
    let ready = robot.q_ready();
    let tcp = robot.chain().base_from_tcp(&ready).translation.vector;
    let walls = [
        a_box("left", [tcp.x, tcp.y + 0.25, tcp.z], [0.3, 0.02, 0.3]),
        a_box("right", [tcp.x, tcp.y - 0.25, tcp.z], [0.3, 0.02, 0.3]),
        a_box("top", [tcp.x, tcp.y, tcp.z + 0.25], [0.3, 0.3, 0.02]),
        a_box("front", [tcp.x + 0.25, tcp.y, tcp.z], [0.02, 0.3, 0.3]),
    ];
    let mut scene = PlanningScene::new(&robot, &walls, None).unwrap();
    assert_eq!(scene.collision(&ready), None);
    let limits = PlanLimits {
        iterations_max: 5,
        ..PlanLimits::default()
    };
    let goal = robot.q_from_state(0.0, &[0.0, 3.1, 0.0, 3.1, 0.0, 3.1, 0.0]);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    match plan_joints(&mut scene, &ready, &[goal], &limits, &mut rng) {
        PathOutcome::LimitReached { limit, stats } => {
            assert_eq!((limit, stats.iterations), (SearchLimit::Iterations, 5));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_same_seed_gives_the_same_path() {
    let robot = test_robots::load("movo");
    let mut scene = PlanningScene::new(&robot, &kitchen(), None).unwrap();
    let samples = free_samples(&mut scene, 2, 51);
    let mut plan = || {
        let mut rng = ChaCha8Rng::seed_from_u64(52);
        plan_joints(
            &mut scene,
            &samples[0],
            &samples[1..],
            &PlanLimits::default(),
            &mut rng,
        )
    };
    assert_eq!(plan(), plan());
}
