use super::*;
use crate::test_home::{Home, errors, pose2};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

#[test]
fn the_robot_finds_itself_in_its_home() {
    let home = Home::household();
    let grid = home.grid();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut n_found, mut n_wrong, mut n_ambiguous) = (0, 0, 0);
    for _ in 0..12 {
        let truth = home.free_pose(0.25, &mut rng);
        let scan = home.scan(&truth, 0.01, &mut rng);
        match localise_globally(&grid, &scan, &LocaliseParams::default()) {
            Localisation::Found(pose) => {
                let (apart_m, turned_rad) = errors(&pose.map_from_base, &truth);
                let is_right = apart_m < 0.05 && turned_rad < 0.03;
                n_found += usize::from(is_right);
                n_wrong += usize::from(!is_right);
            }
            Localisation::Ambiguous { candidates } => {
                n_ambiguous += 1;
                assert!(
                    candidates
                        .iter()
                        .any(|c| errors(&c.map_from_base, &truth).0 < 0.1),
                    "{truth} {candidates:?}"
                );
            }
            lost @ Localisation::Lost { .. } => panic!("at {truth}: {lost:?}"),
        }
    }
    assert_eq!(n_wrong, 0);
    assert!(n_found >= 11, "{n_found} of 12, {n_ambiguous} ambiguous");
}

#[test]
fn a_strange_home_is_not_mistaken_for_ones_own() {
    let grid = Home::household().grid();
    let home = Home::elsewhere();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut n_lost = 0;
    for _ in 0..4 {
        let scan = home.scan(&home.free_pose(0.25, &mut rng), 0.01, &mut rng);
        let outcome = localise_globally(&grid, &scan, &LocaliseParams::default());
        n_lost += usize::from(matches!(outcome, Localisation::Lost { .. }));
    }
    assert!(n_lost == 4, "{n_lost} of 4");
}

#[test]
fn a_room_that_looks_alike_both_ways_is_ambiguous() {
    let home = Home::bare_room();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let truth = pose2(1.2, 1.1, 0.4);
    let outcome = localise_globally(
        &home.grid(),
        &home.scan(&truth, 0.01, &mut rng),
        &LocaliseParams::default(),
    );
    let Localisation::Ambiguous { candidates } = outcome else {
        panic!("{outcome:?}");
    };
    let opposite = pose2(5.0 - 1.2, 3.0 - 1.1, 0.4 + PI);
    for wanted in [truth, opposite] {
        assert!(
            candidates
                .iter()
                .any(|c| errors(&c.map_from_base, &wanted).0 < 0.05),
            "{wanted}: {candidates:?}"
        );
    }
}

#[test]
fn driving_decides_between_like_rooms() {
    let home = Home::twin_rooms();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut localiser = GlobalLocaliser::new(&home.grid(), LocaliseParams::default());
    // From the left room's corner, through the door at y > 3.2, into the right room.
    let path = crate::test_home::drive(&[[0.9, 1.3], [2.6, 1.6], [3.4, 3.6], [4.9, 3.6]]);
    let mut outcomes = Vec::new();
    for (i, pose) in path.iter().enumerate().filter(|(i, _)| i % 5 == 0) {
        let odom = path[0].inverse() * pose;
        outcomes.push((
            i,
            *pose,
            localiser.update(&odom, &home.scan(pose, 0.01, &mut rng)),
        ));
    }
    let (_, truth, last) = &outcomes[outcomes.len() - 1];
    let Localisation::Found(pose) = last else {
        panic!("{last:?}");
    };
    assert!(
        errors(&pose.map_from_base, truth).0 < 0.05,
        "{pose:?} {truth}"
    );
    for (i, truth, outcome) in &outcomes {
        if let Localisation::Found(pose) = outcome {
            assert!(
                errors(&pose.map_from_base, truth).0 < 0.1,
                "wrong at step {i}"
            );
        }
    }
}

#[test]
fn empty_scans_and_blank_maps_leave_the_robot_lost() {
    let home = Home::household();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut scan = home.scan(&pose2(1.0, 1.0, 0.0), 0.01, &mut rng);
    let blank = OccupancyGrid::filled(
        40,
        40,
        0.05,
        Pose2::identity(),
        factotum_geometry::grid::Cell::UNKNOWN,
    )
    .unwrap();
    assert!(matches!(
        localise_globally(&blank, &scan, &LocaliseParams::default()),
        Localisation::Lost { .. }
    ));
    scan.ranges_m.fill(f64::INFINITY);
    assert!(matches!(
        localise_globally(&home.grid(), &scan, &LocaliseParams::default()),
        Localisation::Lost { .. }
    ));
}

/// A real building, where the shared data are at hand: the robot finds itself on a floor of 58 x 53 m.
#[test]
fn the_robot_finds_itself_in_a_real_building() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/maps/willow-full.yaml"
    );
    let Ok(stored) = factotum_geometry::grid::map_server::StoredMap::read(path.as_ref()) else {
        #[expect(clippy::print_stderr, reason = "a skipped test says so")]
        {
            eprintln!("skipped: no {path}");
        }
        return;
    };
    let map = stored.checked_grid().unwrap();
    let clear = map.inflate(0.4);
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut localiser = GlobalLocaliser::new(&map, LocaliseParams::default());
    let mut n_found = 0;
    for _ in 0..2 {
        let truth = loop {
            let pose = pose2(
                rng.random_range(0.0..58.0),
                rng.random_range(0.0..52.0),
                rng.random_range(-3.0..3.0),
            );
            let here = Point2::from(pose.translation.vector);
            if clear.cell_at(&here).is_free()
                && scan_of_grid(&map, &pose).hits_in_base().len() > 250
            {
                break pose;
            }
        };
        localiser.candidates.clear();
        let outcome = localiser.update(&Pose2::identity(), &scan_of_grid(&map, &truth));
        match outcome {
            Localisation::Found(pose) => {
                let (apart_m, turned_rad) = errors(&pose.map_from_base, &truth);
                assert!(apart_m < 0.15 && turned_rad < 0.05, "{truth}: {pose:?}");
                n_found += 1;
            }
            // Offices are alike: one scan may not tell them apart, but must not miss the right one.
            Localisation::Ambiguous { candidates } => {
                assert!(
                    candidates
                        .iter()
                        .any(|c| errors(&c.map_from_base, &truth).0 < 0.15),
                    "{truth}"
                );
            }
            lost @ Localisation::Lost { .. } => panic!("{truth}: {lost:?}"),
        }
    }
    assert!(n_found >= 1, "{n_found} of 2");
}

/// A sweep of 360 rays over a grid's own occupied cells.
fn scan_of_grid(map: &OccupancyGrid, pose: &Pose2) -> LaserScan {
    let (range_max_m, step) = (12.0, 2.0 * PI / 360.0);
    let lidar = Point2::from(pose.translation.vector);
    let ranges_m = (0..360)
        .map(|i| {
            let angle = f64::from(i) * step - PI;
            let end = pose * Point2::new(range_max_m * angle.cos(), range_max_m * angle.sin());
            cells_on_segment(&map.lattice_point(&lidar), &map.lattice_point(&end))
                .filter_map(|place| map.index_of_signed(place))
                .find(|index| map.cell(*index).is_occupied())
                .map_or(f64::INFINITY, |index| (map.center_of(index) - lidar).norm())
        })
        .collect();
    LaserScan {
        angle_min_rad: -PI,
        angle_step_rad: step,
        ranges_m,
        range_min_m: 0.05,
        range_max_m,
        base_from_lidar: Pose2::identity(),
    }
}
