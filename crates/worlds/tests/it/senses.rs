//! What the robot senses is plausible, and errs as told.

use factotum_control::{Robot as _, RobotError};
use factotum_geometry::Pose2;
use factotum_geometry::grid::CellState;
use factotum_worlds::{Noise, SimRobot, WorldConfig};
use nalgebra::Point2;

use crate::fixture::{config, household, must, path_to, starting_at};

#[test]
fn every_laser_return_is_a_wall_or_furniture() {
    let mut robot = household(3);
    let scan = robot.scan().unwrap();
    let grid = robot.true_grid(0.02).unwrap();
    let world_from_base = robot.world_from_base();
    let hits = scan.data.hits_in_base();
    assert!(hits.len() > 300, "{} returns", hits.len());
    let near_solid = |point: &Point2<f64>| {
        let centre = world_from_base * point;
        (-2..=2).any(|i| {
            (-2..=2).any(|j| {
                let beside = Point2::new(
                    centre.x + f64::from(i) * 0.02,
                    centre.y + f64::from(j) * 0.02,
                );
                grid.cell_at(&beside).state() == CellState::Occupied
            })
        })
    };
    let n_good = hits.iter().filter(|point| near_solid(point)).count();
    assert!(
        n_good * 100 >= hits.len() * 99,
        "{n_good} of {}",
        hits.len()
    );
    // The start is free floor, and there is a good deal of it.
    let [free, occupied, _] = grid.count_states();
    assert!(
        grid.cell_at(&Point2::from(world_from_base.translation.vector))
            .is_free()
    );
    assert!(
        free as f64 * 4e-4 > 15.0 && occupied > 1000,
        "{free} free, {occupied} occupied"
    );
}

#[test]
fn a_scan_is_fresh_at_the_rate_of_the_lidar() {
    let mut robot = household(3);
    let first = robot.scan().unwrap();
    assert_eq!(robot.scan().unwrap(), first);
    robot.wait(0.1).unwrap();
    assert!((robot.scan().unwrap().time_secs - first.time_secs - 0.1).abs() < 1e-9);
}

#[test]
fn the_camera_sees_the_bottle_where_it_is() {
    let mut robot = starting_at(config(1), 2.2, 3.3, std::f64::consts::FRAC_PI_2);
    let frame = robot.look().unwrap().data;
    frame.check().unwrap();
    let label = frame
        .label_classes
        .iter()
        .position(|class| class == "bottle")
        .unwrap()
        + 1;
    let cloud = frame.cloud_in_base(|found| usize::from(found) == label);
    let points = cloud.points();
    assert!(points.len() > 20, "{} points", points.len());
    let bottle = robot.world_from_base().inverse()
        * Point2::from(
            robot
                .world_from_object("bottle_1")
                .unwrap()
                .translation
                .vector
                .xy(),
        );
    for point in points {
        let off = (point.xy() - bottle).norm();
        assert!(off < 0.05, "a point of the bottle is {off} m from its axis");
        assert!(
            (0.74..0.97).contains(&point.z),
            "a point of the bottle at height {}",
            point.z
        );
    }
}

#[test]
fn odometry_is_exact_without_noise_and_drifts_with_it() {
    let drift = |noise: Noise| {
        let mut robot = starting_at(WorldConfig { noise, ..config(5) }, 3.2, 1.2, 0.0);
        let start = robot.world_from_base();
        must(&mut robot, path_to(0.5, 0.3, 1.0));
        must(&mut robot, path_to(0.0, 2.0, -1.0));
        let odom: Pose2 = robot.state().unwrap().odom_from_base;
        let error = odom.inv_mul(&start.inv_mul(&robot.world_from_base()));
        error.translation.vector.norm() + error.rotation.angle().abs()
    };
    assert!(drift(Noise::none()) < 1e-6);
    let noisy = drift(Noise::default());
    assert!((1e-3..0.3).contains(&noisy), "{noisy}");
}

#[test]
fn noise_spreads_the_ranges_by_about_a_centimetre() {
    let mut clean = household(7);
    let mut noisy = SimRobot::new(WorldConfig {
        noise: Noise::default(),
        ..config(7)
    })
    .unwrap();
    let (clean, noisy) = (clean.scan().unwrap().data, noisy.scan().unwrap().data);
    let errors: Vec<f64> = clean
        .ranges_m
        .iter()
        .zip(&noisy.ranges_m)
        .filter(|(a, b)| a.is_finite() && b.is_finite())
        .map(|(a, b)| a - b)
        .collect();
    let spread = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!((0.007..0.014).contains(&spread), "{spread} m");
}

#[test]
fn a_robot_without_eyes_says_so() {
    let mut blind = config(1);
    blind.robot.sensors.lidar = None;
    blind.robot.sensors.camera = None;
    let mut robot = SimRobot::new(blind).unwrap();
    assert_eq!(
        robot.scan().unwrap_err(),
        RobotError::Absent {
            robot: "movo".to_owned(),
            what: "lidar"
        }
    );
    assert_eq!(
        robot.look().unwrap_err().to_string(),
        "robot `movo` has no camera"
    );
}
