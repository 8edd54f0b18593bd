//! Time of scan matching, mapping and global localisation in a made-up room with furniture.

use divan::Bencher;
use factotum_geometry::Pose2;
use factotum_geometry::grid::OccupancyGrid;
use factotum_perception::localise::{LocaliseParams, localise_globally};
use factotum_perception::scan_match::{PoseGuess, ScanMatchParams, ScanMatcher};
use factotum_perception::sensing::LaserScan;
use factotum_perception::slam::{Slam2d, SlamParams};
use nalgebra::{Point2, Vector2};
use std::f64::consts::TAU;

fn main() {
    divan::main();
}

fn pose2(x: f64, y: f64, yaw: f64) -> Pose2 {
    Pose2::new(Vector2::new(x, y), yaw)
}

/// Corners (x0, y0, x1, y1) of the room and what stands in it (m).
const BOXES: [[f64; 4]; 4] = [
    [0.0, 0.0, 8.0, 6.0],
    [2.9, 0.0, 4.4, 0.6],
    [6.1, 2.1, 7.3, 2.9],
    [0.0, 5.1, 0.9, 6.0],
];

/// A sweep of 360 rays without noise.
fn scan(pose: &Pose2) -> LaserScan {
    let step = TAU / 360.0;
    let from = pose.translation.vector;
    let range = |angle: f64| {
        let direction = pose.rotation * Vector2::new(angle.cos(), angle.sin());
        let mut nearest = f64::INFINITY;
        for [x0, y0, x1, y1] in BOXES {
            for (axis, wall) in [(0, x0), (0, x1), (1, y0), (1, y1)] {
                let t = (wall - from[axis]) / direction[axis];
                let other = from[1 - axis] + t * direction[1 - axis];
                let span = if axis == 0 { y0..=y1 } else { x0..=x1 };
                if t > 0.0 && span.contains(&other) {
                    nearest = nearest.min(t);
                }
            }
        }
        nearest
    };
    LaserScan {
        angle_min_rad: 0.0,
        angle_step_rad: step,
        ranges_m: (0..360).map(|i| range(f64::from(i) * step)).collect(),
        range_min_m: 0.05,
        range_max_m: 12.0,
        base_from_lidar: Pose2::identity(),
    }
}

/// The room as mapped from a few places.
fn map() -> Option<OccupancyGrid> {
    let start = pose2(1.5, 1.5, 0.0);
    let mut slam = Slam2d::new(start, SlamParams::default()).ok()?;
    for (x, y) in [
        (1.5, 1.5),
        (1.8, 2.4),
        (2.0, 4.0),
        (4.0, 4.5),
        (5.0, 3.0),
        (5.3, 1.2),
        (7.5, 1.0),
    ] {
        let pose = pose2(x, y, 0.0);
        slam.update(&(start.inverse() * pose), &scan(&pose)).ok()?;
    }
    slam.map().cloned()
}

#[divan::bench]
fn match_one_scan(bencher: Bencher<'_, '_>) {
    let Some(map) = map() else { return };
    let matcher = ScanMatcher::new(&map, ScanMatchParams::default());
    let truth = pose2(3.0, 3.0, 0.5);
    let scan = scan(&truth);
    let guess = PoseGuess {
        map_from_base: truth * pose2(0.05, -0.08, 0.06),
        sigma_m: 0.1,
        sigma_rad: 0.06,
    };
    bencher.bench(|| matcher.match_scan(&scan, &guess));
}

#[divan::bench]
fn prepare_a_map_for_matching(bencher: Bencher<'_, '_>) {
    let Some(map) = map() else { return };
    bencher.bench(|| ScanMatcher::new(&map, ScanMatchParams::default()));
}

#[divan::bench]
fn one_key_frame_of_slam(bencher: Bencher<'_, '_>) {
    let Some(map) = map() else { return };
    let pose = pose2(3.0, 3.0, 0.5);
    let scan = scan(&pose);
    bencher
        .with_inputs(|| Slam2d::resume(&map, pose, SlamParams::default()))
        .bench_local_values(|slam| slam.map(|mut slam| slam.update(&Pose2::identity(), &scan)));
}

#[divan::bench]
fn localise_without_a_guess(bencher: Bencher<'_, '_>) {
    let Some(map) = map() else { return };
    let truth = Point2::new(3.0, 3.0);
    let scan = scan(&pose2(truth.x, truth.y, 0.5));
    bencher.bench(|| localise_globally(&map, &scan, &LocaliseParams::default()));
}
