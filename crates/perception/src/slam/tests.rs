use super::*;
use crate::test_home::{Home, errors, household_round, odometry, pose2};
use factotum_geometry::grid::map_overlap;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

/// The household, mapped with odometry errors of `scale`: the map, and the largest and last pose errors.
fn map_household(scale: f64, seed: u64) -> (Slam2d, Vec<(f64, f64)>) {
    let home = Home::household();
    let poses = household_round();
    let odom = odometry(&poses, scale, seed);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut slam = Slam2d::new(poses[0], SlamParams::default()).unwrap();
    let found = poses
        .iter()
        .zip(&odom)
        .map(|(pose, odom)| {
            let scan = home.scan(pose, 0.01, &mut rng);
            errors(&slam.update(odom, &scan).unwrap().map_from_base, pose)
        })
        .collect();
    (slam, found)
}

#[test]
fn a_home_is_mapped_despite_odometry() {
    let truth = Home::household().grid();
    for (scale, seed) in [(0.03, 2), (0.05, 4)] {
        let (slam, found) = map_household(scale, seed);
        let overlap = map_overlap(slam.map().unwrap(), &truth, &Pose2::identity(), 0.1);
        let worst = found
            .iter()
            .fold((0.0f64, 0.0f64), |w, f| (w.0.max(f.0), w.1.max(f.1)));
        assert!(overlap.free_iou > 0.9, "odometry {scale}: {overlap:?}");
        assert!(
            overlap.occupied_precision > 0.9 && overlap.occupied_recall > 0.8,
            "odometry {scale}: {overlap:?}"
        );
        assert!(
            worst.0 < 0.06 && worst.1 < 0.03,
            "odometry {scale}: {worst:?}"
        );
    }
}

#[test]
fn the_same_drive_gives_the_same_map() {
    let run = || {
        let home = Home::household();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let poses = &household_round()[..80];
        let mut slam = Slam2d::new(poses[0], SlamParams::default()).unwrap();
        for (pose, odom) in poses.iter().zip(odometry(poses, 0.03, 5)) {
            slam.update(&odom, &home.scan(pose, 0.01, &mut rng))
                .unwrap();
        }
        slam
    };
    let (a, b) = (run(), run());
    assert_eq!(a.map(), b.map());
    assert_eq!(a.map_from_base(), b.map_from_base());
}

#[test]
fn the_pose_is_tracked_in_a_stored_map() {
    let home = Home::household();
    // Every other scan: half as often as in mapping.
    let poses: Vec<Pose2> = household_round().into_iter().step_by(2).collect();
    let odom = odometry(&poses, 0.05, 6);
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let start = poses[0] * pose2(0.05, -0.05, 0.03);
    let mut tracker = PoseTracker::new(
        &home.grid(),
        start,
        ScanMatchParams::default(),
        OdometryNoise::default(),
    );
    let mut worst = (0.0f64, 0.0f64);
    for (i, (pose, odom)) in poses.iter().zip(&odom).enumerate() {
        let update = tracker.update(odom, &home.scan(pose, 0.01, &mut rng));
        let error = errors(&update.map_from_base, pose);
        if i > 3 {
            worst = (worst.0.max(error.0), worst.1.max(error.1));
        }
        assert_eq!(update.source, PoseSource::Scan);
    }
    assert!(worst.0 < 0.05 && worst.1 < 0.02, "{worst:?}");
    assert!(!tracker.is_lost());
}

#[test]
fn a_robot_carried_away_notices_that_it_is_lost() {
    let home = Home::household();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut tracker = PoseTracker::new(
        &home.grid(),
        pose2(1.0, 1.0, 0.0),
        ScanMatchParams::default(),
        OdometryNoise::default(),
    );
    let elsewhere = pose2(6.0, 3.6, 2.0);
    for _ in 0..PoseTracker::N_REJECTED_LOST {
        tracker.update(&Pose2::identity(), &home.scan(&elsewhere, 0.01, &mut rng));
    }
    assert!(tracker.is_lost());
}

#[test]
fn odometry_bridges_scans_that_say_nothing() {
    let home = Home::household();
    let poses = household_round();
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut slam = Slam2d::new(poses[0], SlamParams::default()).unwrap();
    let odom = odometry(&poses, 0.0, 8);
    let mut n_before = 0;
    for (i, (pose, odom)) in poses.iter().zip(&odom).take(120).enumerate() {
        let mut scan = home.scan(pose, 0.01, &mut rng);
        if (50..80).contains(&i) {
            scan.ranges_m.fill(f64::INFINITY);
        }
        if i == 50 {
            n_before = slam.n_keyframes();
        }
        let update = slam.update(odom, &scan).unwrap();
        if (50..80).contains(&i) {
            assert_eq!(
                (update.source, slam.n_keyframes()),
                (PoseSource::Odometry, n_before)
            );
        }
    }
    let (apart_m, turned_rad) = errors(&slam.map_from_base(), &poses[119]);
    assert!(
        apart_m < 0.05 && turned_rad < 0.02,
        "{apart_m} {turned_rad}"
    );
    assert!(slam.n_keyframes() > n_before);
}

#[test]
fn mapping_goes_on_from_a_stored_map() {
    let home = Home::household();
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let pose = pose2(5.4, 1.0, 1.0);
    let start = pose * pose2(0.03, 0.03, 0.02);
    let mut slam = Slam2d::resume(&home.grid(), start, SlamParams::default()).unwrap();
    let before = map_overlap(slam.map().unwrap(), &home.grid(), &Pose2::identity(), 0.1);
    assert!(before.free_iou > 0.95, "{before:?}");
    let update = slam
        .update(&Pose2::identity(), &home.scan(&pose, 0.01, &mut rng))
        .unwrap();
    assert_eq!(update.source, PoseSource::Scan);
    assert!(errors(&update.map_from_base, &pose).0 < 0.05);
    assert_eq!(slam.n_keyframes(), 1);
}
