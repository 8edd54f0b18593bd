use super::*;
use crate::test_home::{Home, errors, pose2};
use rand::SeedableRng as _;
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
    for _ in 0..6 {
        let scan = home.scan(&home.free_pose(0.25, &mut rng), 0.01, &mut rng);
        let outcome = localise_globally(&grid, &scan, &LocaliseParams::default());
        n_lost += usize::from(matches!(outcome, Localisation::Lost { .. }));
    }
    assert!(n_lost == 6, "{n_lost} of 6");
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
