//! Collision check, inverse kinematics, joint paths and base paths on the shipped robots.
//!
//! Run with `cargo bench -p factotum-motion`. Robots that are not in `assets/robots` are left out.

use std::path::Path;

use divan::{Bencher, black_box};
use factotum_descriptions::RobotDescription;
use factotum_geometry::grid::map_server::StoredMap;
use factotum_motion::sampling::{SearchOptions, rrt_connect, shortcut};
use factotum_motion::{
    BasePathOptions, IkOptions, IkPreference, InflatedGrid, InflationOptions, Obstacle,
    ObstacleShape, PlanLimits, PlanningScene, Pose, Pose2, RobotModel, plan_base, plan_joints,
    solve_ik, time_path,
};
use nalgebra::Vector2;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

fn main() {
    divan::main();
}

fn robots() -> Vec<&'static str> {
    ["panda", "iiwa7", "jaco", "movo"]
        .into_iter()
        .filter(|name| dir(name).exists())
        .collect()
}

fn dir(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../assets/robots")
        .join(name)
        .join("robot.toml")
}

fn load(name: &str) -> RobotModel {
    let description = RobotDescription::load(&dir(name)).expect("a shipped robot.toml is good");
    RobotModel::load(&description).expect("a shipped robot loads")
}

/// A table with two boxes on it, within reach of every arm.
fn cluttered(robot: &RobotModel) -> PlanningScene {
    let tcp = robot
        .chain()
        .base_from_tcp(&robot.q_ready())
        .translation
        .vector;
    let a_box = |name: &str, shift: [f64; 3], half_extents_m: [f64; 3]| Obstacle {
        name: name.to_owned(),
        shape: ObstacleShape::Box { half_extents_m },
        base_from_obstacle: Pose::translation(tcp.x + shift[0], tcp.y + shift[1], tcp.z + shift[2]),
    };
    let obstacles = [
        a_box("table", [0.25, 0.0, -0.25], [0.3, 0.6, 0.02]),
        a_box("left", [0.05, 0.30, -0.1], [0.1, 0.03, 0.15]),
        a_box("right", [0.05, -0.30, -0.1], [0.1, 0.03, 0.15]),
    ];
    PlanningScene::new(robot, &obstacles, None).expect("boxes make a scene")
}

fn samples(robot: &RobotModel, scene: &mut PlanningScene, n: usize, free: bool) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut all = Vec::new();
    while all.len() < n {
        let mut q = vec![0.0; robot.n()];
        robot.space().sample_into(&mut rng, &mut q);
        if !free || scene.is_free(&q) {
            all.push(q);
        }
    }
    all
}

#[divan::bench(args = robots())]
fn jacobian(bencher: Bencher<'_, '_>, name: &str) {
    let robot = load(name);
    let q = robot.q_ready();
    let mut jacobian = robot.chain().jacobian(&q);
    bencher.bench_local(|| {
        robot
            .chain()
            .base_from_tcp_and_jacobian_into(black_box(&q), &mut jacobian)
    });
}

#[divan::bench(args = robots())]
fn collision_check(bencher: Bencher<'_, '_>, name: &str) {
    let robot = load(name);
    let mut scene = cluttered(&robot);
    let qs = samples(&robot, &mut scene, 256, false);
    let mut at = qs.iter().cycle();
    bencher.bench_local(|| at.next().is_some_and(|q| scene.is_free(black_box(q))));
}

/// Random reachable poses, first solution, tolerance 1e-5, no seed: the setting of ch4's table of peers.
#[divan::bench(args = robots(), sample_count = 1000, sample_size = 1)]
fn ik_without_collisions(bencher: Bencher<'_, '_>, name: &str) {
    let robot = load(name);
    let mut scene = PlanningScene::new(&robot, &[], None).expect("a robot makes a scene");
    let qs = samples(&robot, &mut scene, 1000, false);
    let mut at = qs.iter().cycle();
    let options = IkOptions {
        position_tol_m: 1e-5,
        rotation_tol_rad: 1e-5,
        restarts: 200,
        avoid_collision: false,
        prefer: IkPreference::First,
        ..IkOptions::default()
    };
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    bencher.bench_local(|| {
        let target = at
            .next()
            .map_or_else(Pose::identity, |q| robot.chain().base_from_tcp(q));
        solve_ik(&mut scene, &target, &[], &options, &mut rng)
    });
}

/// Eight collision-free candidates, the one of highest manipulability: the default.
#[divan::bench(args = robots(), sample_count = 200, sample_size = 1)]
fn ik_by_manipulability(bencher: Bencher<'_, '_>, name: &str) {
    let robot = load(name);
    let mut scene = cluttered(&robot);
    let qs = samples(&robot, &mut scene, 200, true);
    let mut at = qs.iter().cycle();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    bencher.bench_local(|| {
        let target = at
            .next()
            .map_or_else(Pose::identity, |q| robot.chain().base_from_tcp(q));
        solve_ik(&mut scene, &target, &[], &IkOptions::default(), &mut rng)
    });
}

#[divan::bench(args = robots(), sample_count = 100, sample_size = 1)]
fn joint_path(bencher: Bencher<'_, '_>, name: &str) {
    let robot = load(name);
    let mut scene = cluttered(&robot);
    let qs = samples(&robot, &mut scene, 101, true);
    let mut at = qs.windows(2).cycle();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    bencher.bench_local(|| {
        let pair = at.next().unwrap_or(&[]);
        plan_joints(
            &mut scene,
            &pair[0],
            &pair[1..],
            &PlanLimits::default(),
            &mut rng,
        )
    });
}

/// A wall with a window off the straight way, in the space of the Panda's joints; a check costs nothing.
#[divan::bench(sample_count = 1000, sample_size = 1)]
fn rrt_connect_wall(bencher: Bencher<'_, '_>) {
    let lower = [-2.967, -1.833, -2.967, -3.1, -2.967, -0.087, -2.967];
    let upper = [2.9671, 1.8326, 2.9671, 0.0873, 2.9671, 3.8223, 2.9671];
    let limits = lower
        .iter()
        .zip(upper)
        .map(|(&lower, upper)| factotum_motion::JointLimit {
            lower,
            upper,
            velocity: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
            continuous: false,
            slide: false,
        });
    let space = factotum_motion::JointSpace::new(limits.collect());
    let start = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
    let goal = [vec![2.35, 1.0, 0.0, -0.8, 0.0, 2.5, 0.785]];
    let options = SearchOptions {
        n_nodes_max: 100_000,
        iterations_max: 100_000,
        step: 0.05,
        range: 1.0,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    bencher.bench_local(|| {
        let mut validity = |q: &[f64]| {
            !(1.0 < q[0] && q[0] < 1.3) || ((q[1] + 0.9).abs() < 0.5 && (q[3] + 0.8).abs() < 0.5)
        };
        let search = rrt_connect(&space, &mut validity, &start, &goal, &options, &mut rng);
        let mut path = search.path.map(|path| path.waypoints).unwrap_or_default();
        shortcut(
            &space,
            &mut validity,
            &mut path,
            options.step,
            100,
            &mut rng,
        );
        path
    });
}

#[divan::bench(args = robots())]
fn timing(bencher: Bencher<'_, '_>, name: &str) {
    let robot = load(name);
    let mut scene = cluttered(&robot);
    let path = samples(&robot, &mut scene, 5, false);
    bencher.bench_local(|| time_path(&robot, black_box(&path), 1.0));
}

fn willow() -> Option<factotum_geometry::grid::OccupancyGrid> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/maps/willow-full-0.05.yaml");
    StoredMap::read(&file).ok()?.checked_grid().ok()
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn willow_inflate(bencher: Bencher<'_, '_>) {
    if let Some(grid) = willow() {
        bencher.bench_local(|| InflatedGrid::new(&grid, &InflationOptions::for_radius(0.3)));
    }
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn willow_base_path(bencher: Bencher<'_, '_>) {
    let Some(grid) = willow() else {
        return;
    };
    let planning = InflatedGrid::new(&grid, &InflationOptions::for_radius(0.3));
    // Two free places far apart, found along the two sides of the map.
    let [start, goal] = [(6.0, 10.0), (52.0, 30.0)].map(|(x, y)| {
        let near = (0..4000).map(|i| {
            let (r, angle) = (0.005 * f64::from(i), 2.4 * f64::from(i));
            nalgebra::Point2::new(x + r * angle.cos(), y + r * angle.sin())
        });
        let free = near
            .filter(|point| planning.is_free_at(point))
            .max_by(|a, b| {
                let key = |p: &nalgebra::Point2<f64>| planning.clearance_m(p);
                key(a).total_cmp(&key(b))
            });
        free.map_or_else(Pose2::identity, |p| Pose2::new(Vector2::new(p.x, p.y), 0.0))
    });
    bencher.bench_local(|| plan_base(&planning, &start, &goal, &BasePathOptions::default()));
}
