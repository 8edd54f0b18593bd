use super::*;
use crate::sensing::LaserScan;
use nalgebra::Vector2;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

fn pose2(x: f64, y: f64, yaw: f64) -> Pose2 {
    Pose2::new(Vector2::new(x, y), yaw)
}

/// A grid of 1 m cells from rows of text, top row first: `#` occupied, `.` free, anything else unknown.
fn drawn(rows: &[&str]) -> OccupancyGrid {
    let cells = rows
        .iter()
        .rev()
        .flat_map(|row| row.chars())
        .map(|c| match c {
            '#' => Cell::OCCUPIED,
            '.' => Cell::FREE,
            _ => Cell::UNKNOWN,
        })
        .collect();
    OccupancyGrid::new(rows[0].len(), rows.len(), 1.0, Pose2::identity(), cells).unwrap()
}

fn at(column: usize, row: usize) -> CellIndex {
    CellIndex { column, row }
}

prop_compose! {
    fn random_grid()(width in 1..24usize, height in 1..24usize)
        (cells in prop::collection::vec(prop_oneof![4 => Just(Cell::FREE), 1 => Just(Cell::OCCUPIED), 1 => Just(Cell::UNKNOWN)], width * height),
         width in Just(width), height in Just(height),
         x in -5.0..5.0f64, y in -5.0..5.0f64, yaw in -3.0..3.0f64) -> OccupancyGrid {
        OccupancyGrid::new(width, height, 0.1, pose2(x, y, yaw), cells).unwrap()
    }
}

proptest! {
    #[test]
    fn the_centre_of_a_cell_lies_in_it(grid in random_grid()) {
        for index in grid.indices() {
            prop_assert_eq!(grid.index_at(&grid.center_of(index)), Some(index));
        }
    }

    #[test]
    fn distances_equal_those_of_exhaustive_search(grid in random_grid()) {
        let field = DistanceField::of(&grid, UnknownCells::Passable);
        let obstacles: Vec<_> = grid.indices().filter(|&i| grid.cell(i).is_occupied()).collect();
        for (index, &found) in grid.indices().zip(field.distances_m()) {
            let wanted = obstacles
                .iter()
                .map(|o| (index.column as f64 - o.column as f64).hypot(index.row as f64 - o.row as f64) * 0.1)
                .fold(f64::INFINITY, f64::min);
            prop_assert!(f64::from(found) == wanted || (f64::from(found) - wanted).abs() < 1e-6, "{index:?}: {found} {wanted}");
        }
    }

    #[test]
    fn inflation_covers_exactly_the_radius(grid in random_grid(), radius in 0.0..0.6f64) {
        let inflated = grid.inflate(radius);
        let field = DistanceField::of(&grid, UnknownCells::Passable);
        for (index, &distance) in grid.indices().zip(field.distances_m()) {
            let wanted = if f64::from(distance) <= radius { Cell::OCCUPIED } else { grid.cell(index) };
            prop_assert_eq!(inflated.cell(index), wanted);
        }
    }

    #[test]
    fn traversal_is_connected_and_touches_the_segment(
        a in prop::array::uniform2(-20.0..20.0f64), b in prop::array::uniform2(-20.0..20.0f64)
    ) {
        let (from, to) = (Point2::from(a), Point2::from(b));
        let cells: Vec<_> = cells_on_segment(&from, &to).collect();
        prop_assert_eq!(cells[0], SignedCell::containing(&from));
        prop_assert_eq!(cells[cells.len() - 1], SignedCell::containing(&to));
        for pair in cells.windows(2) {
            prop_assert_eq!(pair[0].column.abs_diff(pair[1].column) + pair[0].row.abs_diff(pair[1].row), 1);
        }
        for cell in cells {
            // The segment passes within half a diagonal of the centre of each cell it crosses.
            let centre = Point2::new(cell.column as f64 + 0.5, cell.row as f64 + 0.5);
            let along = (to - from).norm_squared();
            let t = if along > 0.0 { ((centre - from).dot(&(to - from)) / along).clamp(0.0, 1.0) } else { 0.0 };
            prop_assert!((centre - (from + t * (to - from))).norm() <= 0.5f64.sqrt() + 1e-9);
        }
    }

    #[test]
    fn line_of_sight_goes_both_ways_between_cell_centres(grid in random_grid(), pick in prop::array::uniform4(0..1000usize)) {
        let index = |c: usize, r: usize| at(c % grid.width(), r % grid.height());
        let (a, b) = (grid.center_of(index(pick[0], pick[1])), grid.center_of(index(pick[2], pick[3])));
        // A sight line through a lattice corner may pass it on either side; move one end off such lines.
        let b = b + Vector2::new(1.3e-4, 2.9e-4);
        prop_assert_eq!(grid.has_line_of_sight(&a, &b), grid.has_line_of_sight(&b, &a));
        prop_assert!(!grid.is_line_free(&a, &b) || grid.has_line_of_sight(&a, &b));
    }

    #[test]
    fn a_map_overlaps_itself_wholly(grid in random_grid()) {
        let overlap = map_overlap(&grid, &grid, &Pose2::identity(), 0.05);
        prop_assert_eq!(overlap, MapOverlap { free_iou: 1.0, occupied_iou: 1.0, occupied_precision: 1.0, occupied_recall: 1.0, coverage: 1.0 });
    }

    #[test]
    fn frontiers_are_a_partition_of_the_frontier_cells(grid in random_grid()) {
        let mut cells: Vec<_> = frontiers(&grid, 1).into_iter().flat_map(|f| f.cells).collect();
        cells.sort_by_key(|c| (c.row, c.column));
        let wanted: Vec<_> = grid
            .indices()
            .filter(|&i| grid.cell(i).is_free() && grid.edge_neighbours(i).any(|n| grid.cell(n).is_unknown()))
            .collect();
        prop_assert_eq!(cells, wanted);
    }
}

#[test]
fn a_turned_origin_turns_the_cells() {
    let mut grid =
        OccupancyGrid::filled(4, 2, 0.5, pose2(1.0, 2.0, FRAC_PI_2), Cell::FREE).unwrap();
    grid.set_cell(at(3, 0), Cell::OCCUPIED);
    // Column 3 lies 1.75 m along the grid's x, which points along the world's y.
    let centre = grid.center_of(at(3, 0));
    assert!(
        (centre - Point2::new(0.75, 3.75)).norm() < 1e-12,
        "{centre}"
    );
    assert!(grid.cell_at(&Point2::new(0.8, 3.6)).is_occupied());
    assert!(
        grid.cell_at(&Point2::new(1.1, 3.6)).is_unknown(),
        "outside nothing is known"
    );
}

#[test]
fn points_that_are_not_finite_are_outside() {
    let grid = drawn(&["..", ".."]);
    for v in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        assert_eq!(grid.index_at(&Point2::new(v, 0.5)), None);
        assert!(!grid.is_line_free(&Point2::new(0.5, 0.5), &Point2::new(0.5, -1.0)));
    }
}

#[test]
fn thresholds_split_occupancies() {
    let states = [-1, 0, 25, 26, 64, 65, 100].map(|v| Cell::from_ros(v).unwrap().state());
    use CellState::{Free, Occupied, Unknown};
    assert_eq!(
        states,
        [Unknown, Free, Free, Unknown, Unknown, Occupied, Occupied]
    );
    assert_eq!(Cell::from_ros(-2), None);
    assert_eq!(Cell::from_ros(101), None);
}

#[test]
fn grids_that_cannot_be_are_refused() {
    let message = |e: Result<OccupancyGrid, GridError>| e.unwrap_err().to_string();
    let new = |w, h, r, n| OccupancyGrid::new(w, h, r, Pose2::identity(), vec![Cell::FREE; n]);
    assert_eq!(
        message(new(3, 2, 0.1, 5)),
        "grid of 3 x 2 has 5 cells, expected 6"
    );
    assert_eq!(
        message(new(1, 1, 0.0, 1)),
        "grid resolution is 0 m, expected a positive finite number"
    );
    assert!(new(1, 1, f64::NAN, 1).is_err());
    assert!(
        message(OccupancyGrid::filled(
            usize::MAX,
            2,
            0.1,
            Pose2::identity(),
            Cell::FREE
        ))
        .contains("larger than the 67108864 allowed")
    );
    assert!(OccupancyGrid::new(1, 1, 0.1, pose2(f64::NAN, 0.0, 0.0), vec![Cell::FREE]).is_err());
    assert!(
        OccupancyGrid::filled(0, 0, 0.1, Pose2::identity(), Cell::FREE)
            .unwrap()
            .inflate(1.0)
            .cells()
            .is_empty()
    );
}

#[test]
fn walls_block_sight_and_unknown_floor_blocks_driving() {
    let grid = drawn(&[
        "....#", //
        ".??.#", "....#",
    ]);
    let (left, right) = (Point2::new(0.5, 1.5), Point2::new(3.5, 1.5));
    assert!(grid.has_line_of_sight(&left, &right));
    assert!(!grid.is_line_free(&left, &right));
    assert!(!grid.has_line_of_sight(&left, &Point2::new(4.9, 1.5)));
    assert!(grid.is_line_free(&Point2::new(0.5, 0.5), &Point2::new(3.5, 0.5)));
}

#[test]
fn interpolated_distances_have_the_gradient_of_finite_differences() {
    let mut grid = OccupancyGrid::filled(30, 30, 0.1, pose2(0.3, -0.2, 0.4), Cell::FREE).unwrap();
    grid.set_cell(at(4, 9), Cell::OCCUPIED);
    grid.set_cell(at(20, 22), Cell::OCCUPIED);
    let field = DistanceField::of(&grid, UnknownCells::Passable);
    for index in [at(8, 3), at(15, 15), at(25, 10)] {
        let p = grid.center_of(index) + Vector2::new(0.013, 0.021);
        let (_, gradient) = field.interpolate(&p).unwrap();
        let value = |d: Vector2<f64>| field.interpolate(&(p + d)).unwrap().0;
        let h = 1e-5;
        let numeric = Vector2::new(
            value(Vector2::new(h, 0.0)) - value(Vector2::new(-h, 0.0)),
            value(Vector2::new(0.0, h)) - value(Vector2::new(0.0, -h)),
        ) / (2.0 * h);
        assert!((gradient - numeric).norm() < 1e-4, "{gradient} {numeric}");
    }
    let empty = OccupancyGrid::filled(3, 3, 0.1, Pose2::identity(), Cell::FREE).unwrap();
    let field = DistanceField::of(&empty, UnknownCells::Passable);
    assert_eq!(field.interpolate(&Point2::new(0.15, 0.15)), None);
    assert_eq!(
        field.distance_at(&Point2::new(0.15, 0.15)),
        Some(f64::INFINITY)
    );
    assert_eq!(field.distance_at(&Point2::new(0.15, 0.35)), None);
}

#[test]
fn frontiers_come_largest_first_and_point_at_free_cells() {
    let grid = drawn(&[
        "?????????", //
        "?..#....?",
        "#..#....?",
        "#########",
    ]);
    let found = frontiers(&grid, 1);
    assert_eq!(
        found.iter().map(Frontier::n_cells).collect::<Vec<_>>(),
        [5, 2]
    );
    assert!(grid.cell(found[0].nearest_cell).is_free());
    assert!(
        found[0].cells.iter().all(|c| c.column > 3),
        "the wall separates them"
    );
    assert_eq!(frontiers(&grid, 3).len(), 1);
    assert!(
        frontiers(&drawn(&["..", ".."]), 1).is_empty(),
        "the border is no frontier"
    );
}

/// Ranges of a lidar in a rectangular room [0, w] x [0, h], with a square pillar.
fn scan_in_room(world_from_base: &Pose2, width_m: f64, height_m: f64) -> LaserScan {
    let n = 360;
    let step = TAU / f64::from(n);
    let ranges_m = (0..n)
        .map(|i| {
            let direction = world_from_base.rotation
                * Vector2::new((f64::from(i) * step).cos(), (f64::from(i) * step).sin());
            let p = world_from_base.translation.vector;
            let to_wall = |p: f64, d: f64, size: f64| {
                if d > 0.0 {
                    (size - p) / d
                } else if d < 0.0 {
                    -p / d
                } else {
                    f64::INFINITY
                }
            };
            to_wall(p.x, direction.x, width_m).min(to_wall(p.y, direction.y, height_m))
        })
        .collect();
    LaserScan {
        angle_min_rad: 0.0,
        angle_step_rad: step,
        ranges_m,
        range_min_m: 0.05,
        range_max_m: 12.0,
        base_from_lidar: Pose2::identity(),
    }
}

#[test]
fn a_room_seen_from_a_few_places_is_mapped() {
    let mut mapper = GridMapper::new(GridMapperParams::default()).unwrap();
    assert!(mapper.grid().is_none());
    for (x, y, yaw) in [
        (1.0, 1.0, 0.0),
        (3.0, 2.0, 1.0),
        (4.5, 0.7, 2.0),
        (2.0, 2.5, -2.0),
        (0.5, 2.0, 0.3),
    ] {
        let pose = pose2(x, y, yaw);
        mapper
            .integrate(&pose, &scan_in_room(&pose, 5.0, 3.0))
            .unwrap();
    }
    let grid = mapper.grid().unwrap();
    let mut truth =
        OccupancyGrid::filled(102, 62, 0.05, pose2(-0.05, -0.05, 0.0), Cell::FREE).unwrap();
    for index in truth.indices().collect::<Vec<_>>() {
        if index.row == 0 || index.column == 0 || index.row == 61 || index.column == 101 {
            truth.set_cell(index, Cell::OCCUPIED);
        }
    }
    let overlap = map_overlap(&grid, &truth, &Pose2::identity(), 0.075);
    // The walls lie on borders of cells, so rounding thickens some of them by one cell.
    assert!(overlap.free_iou > 0.95, "{overlap:?}");
    assert!(
        overlap.occupied_precision > 0.99 && overlap.occupied_recall > 0.95,
        "{overlap:?}"
    );
    let shifted = map_overlap(&grid, &truth, &pose2(0.5, 0.0, 0.0), 0.075);
    assert!(
        shifted.free_iou < 0.92 && shifted.occupied_recall < 0.8,
        "{shifted:?}"
    );
}

#[test]
fn a_wall_is_known_far_finer_than_a_cell() {
    let mut mapper = GridMapper::new(GridMapperParams::default()).unwrap();
    for (x, y, yaw) in [(0.5, 0.7, 0.0), (1.0, 1.0, 1.0), (1.5, 0.4, 2.0)] {
        let pose = pose2(x, y, yaw);
        let scan = scan_in_room(&pose, 2.018, 2.0);
        mapper.integrate(&pose, &scan).unwrap();
    }
    let grid = mapper.grid().unwrap();
    let places = mapper.places_in_cells();
    let wall = grid.index_at(&Point2::new(2.018, 1.02)).unwrap();
    let left_m = grid.world_from_grid().translation.x + wall.column as f64 * 0.05;
    let found_m = left_m + 0.05 * f64::from(places[wall.row * grid.width() + wall.column][0]);
    assert!((found_m - 2.018).abs() < 0.002, "{found_m} m");
    let floor = grid.index_at(&Point2::new(1.0, 0.8)).unwrap();
    assert_eq!(places[floor.row * grid.width() + floor.column], [0.5, 0.5]);
}

#[test]
fn what_moved_away_is_unlearned_and_maps_go_on_from_a_grid() {
    let pose = pose2(1.0, 1.0, 0.0);
    let mut mapper = GridMapper::new(GridMapperParams::default()).unwrap();
    for _ in 0..20 {
        mapper
            .integrate(&pose, &scan_in_room(&pose, 2.0, 2.0))
            .unwrap();
    }
    let wall = Point2::new(2.01, 1.02);
    assert!(mapper.grid().unwrap().cell_at(&wall).is_occupied());
    let mut mapper = GridMapper::from_grid(&mapper.grid().unwrap(), *mapper.params()).unwrap();
    assert!(mapper.grid().unwrap().cell_at(&wall).is_occupied());
    for _ in 0..20 {
        mapper
            .integrate(&pose, &scan_in_room(&pose, 3.0, 2.0))
            .unwrap();
    }
    assert!(mapper.grid().unwrap().cell_at(&wall).is_free());
}

#[test]
fn rays_without_return_clear_the_floor_unless_told_not_to() {
    let mut scan = scan_in_room(&pose2(1.0, 1.0, 0.0), 2.0, 2.0);
    scan.ranges_m.fill(f64::INFINITY);
    scan.range_max_m = 2.0;
    let counts = |clear_without_return| {
        let mut mapper = GridMapper::new(GridMapperParams {
            clear_without_return,
            ..GridMapperParams::default()
        })
        .unwrap();
        mapper.integrate(&Pose2::identity(), &scan).unwrap();
        mapper.grid().unwrap().count_states()
    };
    // A disc of radius 2 m holds about 5,027 cells of 5 cm.
    assert!(
        (4500..5600).contains(&counts(true)[0]),
        "{:?}",
        counts(true)
    );
    assert_eq!(counts(false)[0], 0);
}

#[test]
fn scans_out_of_reach_are_refused_and_leave_the_map() {
    let pose = pose2(1.0, 1.0, 0.0);
    let scan = scan_in_room(&pose, 2.0, 2.0);
    let mut mapper = GridMapper::new(GridMapperParams::default()).unwrap();
    mapper.integrate(&pose, &scan).unwrap();
    let before = mapper.grid();
    assert!(matches!(
        mapper.integrate(&pose2(1e6, 1e6, 0.0), &scan),
        Err(GridError::TooLarge { .. })
    ));
    assert_eq!(
        mapper.integrate(&pose2(f64::NAN, 0.0, 0.0), &scan),
        Err(GridError::Origin)
    );
    assert_eq!(mapper.grid(), before);
    assert!(
        GridMapper::new(GridMapperParams {
            resolution_m: -1.0,
            ..GridMapperParams::default()
        })
        .is_err()
    );
}
