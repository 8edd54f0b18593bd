use super::*;
use factotum_geometry::grid::{Cell, CellIndex, OccupancyGrid, cells_on_segment};
use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

const RESOLUTION_M: f64 = 0.05;

/// A free square room of 10 m with boxes at random places.
fn room(seed: u64, n_boxes: usize) -> OccupancyGrid {
    let mut grid =
        OccupancyGrid::filled(200, 200, RESOLUTION_M, Pose2::identity(), Cell::FREE).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..n_boxes {
        let (column, row) = (rng.random_range(0..180), rng.random_range(0..180));
        let (w, h) = (rng.random_range(1..30), rng.random_range(1..30));
        for column in column..(column + w).min(200) {
            for row in row..(row + h).min(200) {
                grid.set_cell(CellIndex { column, row }, Cell::OCCUPIED);
            }
        }
    }
    grid
}

fn inflated(grid: &OccupancyGrid, clearance_weight: f64) -> InflatedGrid {
    let options = InflationOptions {
        clearance_weight,
        ..InflationOptions::for_radius(0.3)
    };
    InflatedGrid::new(grid, &options)
}

fn pose(x: f64, y: f64, yaw: f64) -> Pose2 {
    Pose2::new(Vector2::new(x, y), yaw)
}

/// Cells reachable from one by edge and corner steps, by flood fill: an independent connectivity test.
fn is_connected(grid: &InflatedGrid, a: &Point2<f64>, b: &Point2<f64>) -> bool {
    let (Some(a), Some(b)) = (grid.cell_at(a), grid.cell_at(b)) else {
        return false;
    };
    let mut seen = vec![false; grid.costs().len()];
    let mut open = vec![a];
    while let Some(cell) = open.pop() {
        if seen[cell as usize] || !grid.is_free(cell) {
            continue;
        }
        seen[cell as usize] = true;
        // Diagonals need both sides free, so four neighbours decide.
        let w = grid.width() as u32;
        open.extend([cell + 1, cell - 1, cell + w, cell - w]);
    }
    seen[b as usize]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn paths_keep_their_distance_and_exist_when_they_can(
        seed in 0u64..1000,
        ends in prop::array::uniform4(0.5..9.5),
        yaws in prop::array::uniform2(-3.0..3.0),
    ) {
        let grid = room(seed, 12);
        let planning = inflated(&grid, 3.0);
        let (start, goal) = (pose(ends[0], ends[1], yaws[0]), pose(ends[2], ends[3], yaws[1]));
        let options = BasePathOptions { start_escape_m: 0.0, ..BasePathOptions::default() };
        let at = |pose: &Pose2| Point2::from(pose.translation.vector);
        match plan_base(&planning, &start, &goal, &options) {
            BaseOutcome::Solved { path, length_m, clearance_m } => {
                prop_assert_eq!(at(&path[0]), at(&start));
                prop_assert_eq!(at(&path[path.len() - 1]), at(&goal));
                prop_assert!((path[0].rotation.angle() - yaws[0]).abs() < 1e-9);
                prop_assert!((path[path.len() - 1].rotation.angle() - yaws[1]).abs() < 1e-9);
                let sum: f64 = path.windows(2).map(|pair| (at(&pair[1]) - at(&pair[0])).norm()).sum();
                prop_assert!((sum - length_m).abs() < 1e-6);
                // Re-checked every millimetre against the occupied cells: distances are between cell centres, so a
                // point is up to half a diagonal off at either end.
                let slack = RESOLUTION_M * 2f64.sqrt();
                for pair in path.windows(2) {
                    let (a, b) = (at(&pair[0]), at(&pair[1]));
                    let n = ((b - a).norm() / 0.001).ceil().max(1.0);
                    prop_assert!((b - a).norm() <= options.spacing_m + 1e-9);
                    for i in 0..=n as usize {
                        let p = a + (b - a) * (i as f64 / n);
                        prop_assert!(planning.clearance_m(&p) > 0.3 - slack, "{}", planning.clearance_m(&p));
                    }
                }
                prop_assert!(clearance_m > 0.3 - slack);
            }
            BaseOutcome::StartBlocked => prop_assert!(!planning.is_free_at(&at(&start))),
            BaseOutcome::GoalBlocked => prop_assert!(!planning.is_free_at(&at(&goal))),
            BaseOutcome::Unreachable => prop_assert!(!is_connected(&planning, &at(&start), &at(&goal))),
            BaseOutcome::LimitReached => prop_assert!(false, "the cap was not to be reached"),
        }
    }

    /// Without a preference for clearance the path is about as short as the grid allows.
    #[test]
    fn the_search_is_optimal_on_the_grid(seed in 0u64..1000, ends in prop::array::uniform4(0.5..9.5)) {
        let grid = room(seed, 12);
        let planning = inflated(&grid, 0.0);
        let cell = |x: f64, y: f64| planning.cell_at(&Point2::new(x, y)).filter(|&c| planning.is_free(c));
        let (Some(a), Some(b)) = (cell(ends[0], ends[1]), cell(ends[2], ends[3])) else {
            return Ok(());
        };
        let search::CellPath::Found(cells) = search::search(&planning, a, b, usize::MAX) else {
            return Ok(());
        };
        let cost: u32 = cells.windows(2).map(|pair| {
            let d = pair[0].abs_diff(pair[1]) as usize;
            search::step_cost(grid::UNIT, grid::UNIT, d != 1 && d != planning.width())
        }).sum();
        prop_assert_eq!(cost, dijkstra(&planning, a, b));
    }
}

/// Cost of the cheapest path by Dijkstra's algorithm with a binary heap: independent of the search under test.
fn dijkstra(grid: &InflatedGrid, a: u32, b: u32) -> u32 {
    use std::cmp::Reverse;
    use std::collections::BinaryHeap;
    let mut best = vec![u32::MAX; grid.costs().len()];
    let mut heap = BinaryHeap::from([Reverse((0, a))]);
    best[a as usize] = 0;
    while let Some(Reverse((cost, cell))) = heap.pop() {
        if cell == b {
            return cost;
        }
        let (column, row) = grid.column_row(cell);
        for (dc, dr) in [
            (1, 0),
            (-1, 0),
            (0, 1),
            (0, -1),
            (1, 1),
            (1, -1),
            (-1, 1),
            (-1, -1),
        ] {
            let at = |dc: i64, dr: i64| {
                ((row as i64 + dr) * grid.width() as i64 + column as i64 + dc) as u32
            };
            let free =
                grid.is_free(at(dc, dr)) && grid.is_free(at(dc, 0)) && grid.is_free(at(0, dr));
            let next = at(dc, dr);
            let cost = cost + if dc != 0 && dr != 0 { 181 } else { 128 };
            if free && cost < best[next as usize] {
                best[next as usize] = cost;
                heap.push(Reverse((cost, next)));
            }
        }
    }
    u32::MAX
}

/// A corridor with two ways round a pillar: with the preference the path stays away from the walls.
#[test]
fn clearance_is_preferred() {
    let mut grid =
        OccupancyGrid::filled(200, 100, RESOLUTION_M, Pose2::identity(), Cell::FREE).unwrap();
    for column in 60..140 {
        for row in 0..40 {
            grid.set_cell(CellIndex { column, row }, Cell::OCCUPIED);
        }
    }
    let solve = |weight: f64| match plan_base(
        &inflated(&grid, weight),
        &pose(1.0, 1.0, 0.0),
        &pose(9.0, 1.0, 0.0),
        &BasePathOptions::default(),
    ) {
        BaseOutcome::Solved {
            length_m,
            clearance_m,
            ..
        } => (length_m, clearance_m),
        other => panic!("{other:?}"),
    };
    let ((short, tight), (long, wide)) = (solve(0.0), solve(5.0));
    assert!(
        long > short && wide > tight + 0.1,
        "{short} {tight} {long} {wide}"
    );
}

#[test]
fn blocked_ends_are_told_apart() {
    let grid = room(0, 0);
    let mut walled = grid.clone();
    for row in 0..200 {
        walled.set_cell(CellIndex { column: 100, row }, Cell::OCCUPIED);
    }
    let planning = inflated(&walled, 3.0);
    let plan =
        |a: Pose2, b: Pose2, options: &BasePathOptions| plan_base(&planning, &a, &b, options);
    let options = BasePathOptions::default();
    let strict = BasePathOptions {
        start_escape_m: 0.0,
        ..options
    };
    let (left, right) = (pose(2.0, 5.0, 0.0), pose(8.0, 5.0, 0.0));
    let near_wall = pose(4.85, 5.0, 0.0);
    assert_eq!(plan(left, right, &options), BaseOutcome::Unreachable);
    assert_eq!(plan(near_wall, left, &strict), BaseOutcome::StartBlocked);
    assert_eq!(plan(left, near_wall, &options), BaseOutcome::GoalBlocked);
    assert_eq!(
        plan(left, pose(-1.0, 5.0, 0.0), &options),
        BaseOutcome::GoalBlocked
    );
    let few = BasePathOptions {
        n_expansions_max: 3,
        ..options
    };
    assert_eq!(
        plan(left, pose(2.0, 8.0, 0.0), &few),
        BaseOutcome::LimitReached
    );
    // A start in the inflated zone leaves it; a goal there may be moved.
    let BaseOutcome::Solved { path, .. } = plan(near_wall, left, &options) else {
        panic!("the start may escape");
    };
    assert_eq!(path[0].translation.vector, near_wall.translation.vector);
    let slack = BasePathOptions {
        goal_slack_m: 0.3,
        ..options
    };
    let BaseOutcome::Solved { path, .. } = plan(left, near_wall, &slack) else {
        panic!("the goal may be moved");
    };
    let end = Point2::from(path[path.len() - 1].translation.vector);
    assert!(planning.is_free_at(&end) && (end.x - 4.85).abs() < 0.3);
}

#[test]
fn staying_is_a_path() {
    let planning = inflated(&room(0, 0), 3.0);
    let (a, b) = (pose(5.0, 5.0, 0.0), pose(5.0, 5.0, 1.5));
    match plan_base(&planning, &a, &b, &BasePathOptions::default()) {
        BaseOutcome::Solved { path, length_m, .. } => {
            assert_eq!(length_m, 0.0);
            assert!((path[path.len() - 1].rotation.angle() - 1.5).abs() < 1e-12);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn headings_turn_evenly_the_short_way_or_follow_the_path() {
    let planning = inflated(&room(0, 0), 3.0);
    let (a, b) = (pose(2.0, 5.0, 3.0), pose(8.0, 5.0, -3.0));
    let yaws = |heading| {
        let options = BasePathOptions {
            heading,
            ..BasePathOptions::default()
        };
        match plan_base(&planning, &a, &b, &options) {
            BaseOutcome::Solved { path, .. } => path
                .iter()
                .map(|pose| pose.rotation.angle())
                .collect::<Vec<_>>(),
            other => panic!("{other:?}"),
        }
    };
    assert!(
        yaws(Heading::Even)
            .iter()
            .all(|yaw| yaw.abs() >= 3.0 - 1e-9)
    );
    let along = yaws(Heading::AlongPath);
    assert!(along[1..along.len() - 1].iter().all(|yaw| yaw.abs() < 1e-6));
    assert_eq!((along[0], along[along.len() - 1]), (3.0, -3.0));
}

/// The Willow Garage building, if it is there: a path from one end to the other.
#[test]
#[expect(clippy::print_stdout, reason = "a skipped test says why")]
fn a_path_across_a_real_building() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/maps/willow-full-0.05.yaml");
    if !file.exists() {
        println!("skipped: {} is not here", file.display());
        return;
    }
    let map = factotum_geometry::grid::map_server::StoredMap::read(&file).unwrap();
    let grid = map.checked_grid().unwrap();
    let planning = inflated(&grid, 3.0);
    // The two free cells of the largest region that are farthest apart in x.
    let free: Vec<u32> = (0..planning.costs().len() as u32)
        .filter(|&c| planning.is_free(c))
        .collect();
    let by_x = |&cell: &u32| planning.column_row(cell).0;
    let (mut left, mut right) = (free.clone(), free);
    left.sort_by_key(by_x);
    right.sort_by_key(|cell| std::cmp::Reverse(by_x(cell)));
    let at = |cell: u32| planning.center(cell);
    let pair = left
        .iter()
        .step_by(97)
        .flat_map(|&a| right.iter().step_by(997).map(move |&b| (a, b)));
    let (a, b) = pair
        .take(500)
        .find(|&(a, b)| is_connected(&planning, &at(a), &at(b)))
        .unwrap();
    let (start, goal) = (Pose2::new(at(a).coords, 0.0), Pose2::new(at(b).coords, 1.0));
    let BaseOutcome::Solved { path, length_m, .. } =
        plan_base(&planning, &start, &goal, &BasePathOptions::default())
    else {
        panic!("connected, yet no path");
    };
    assert!(length_m > 0.8 * (at(b) - at(a)).norm() && length_m < 500.0);
    for pair in path.windows(2) {
        let (a, b) = (pair[0].translation.vector, pair[1].translation.vector);
        let (a, b) = (
            planning.lattice_point(&a.into()),
            planning.lattice_point(&b.into()),
        );
        for place in cells_on_segment(&a, &b) {
            let index = grid.index_of_signed(place).unwrap();
            assert!(grid.cell(index).is_free());
        }
    }
}
