use super::*;
use approx::assert_abs_diff_eq;
use std::f64::consts::FRAC_PI_2;

fn scan(ranges_m: Vec<f64>) -> LaserScan {
    LaserScan {
        angle_min_rad: 0.0,
        angle_step_rad: FRAC_PI_2,
        ranges_m,
        range_min_m: 0.1,
        range_max_m: 5.0,
        base_from_lidar: Pose2::new(nalgebra::Vector2::new(0.2, 0.0), FRAC_PI_2),
    }
}

#[test]
fn rays_start_at_the_lidar_and_turn_counter_clockwise() {
    let hits = scan(vec![1.0, 2.0]).hits_in_base();
    assert_abs_diff_eq!(hits[0], Point2::new(0.2, 1.0), epsilon = 1e-12);
    assert_abs_diff_eq!(hits[1], Point2::new(-1.8, 0.0), epsilon = 1e-12);
}

#[test]
fn unusable_readings_are_dropped_and_missing_returns_reach_the_range() {
    let scan = scan(vec![f64::NAN, 0.05, -1.0, f64::INFINITY, 5.0, 4.9]);
    let rays: Vec<ScanRay> = scan.rays().collect();
    assert_eq!(
        rays.iter().map(|ray| ray.is_hit).collect::<Vec<_>>(),
        [false, false, true]
    );
    let length = |ray: &ScanRay| (ray.end_in_base - scan.origin_in_base()).norm();
    assert_abs_diff_eq!(length(&rays[0]), 5.0, epsilon = 1e-12);
}

fn frame() -> DepthFrame {
    DepthFrame {
        width: 4,
        height: 3,
        fx: 2.0,
        fy: 4.0,
        cx: 1.5,
        cy: 1.0,
        depth_m: vec![2.0; 12],
        labels: vec![0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 2, 2],
        label_classes: vec!["bottle".to_owned(), "bin".to_owned()],
        base_from_optical: Pose::translation(0.0, 0.0, 1.0),
    }
}

#[test]
fn pixels_project_back_through_the_pinhole() {
    let frame = frame();
    assert_abs_diff_eq!(
        frame.point_in_optical(3, 2).unwrap(),
        Point3::new(1.5, 0.5, 2.0),
        epsilon = 1e-12
    );
    assert_eq!(frame.point_in_optical(4, 0), None);
    assert_eq!(frame.point_in_optical(0, 3), None);
    let bottle = frame.cloud_in_base(|label| label == 1);
    assert_eq!(bottle.len(), 4);
    assert!(bottle.points().iter().all(|p| (p.z - 3.0).abs() < 1e-12));
}

#[test]
fn depths_that_were_not_measured_give_no_point() {
    let mut frame = frame();
    for (pixel, depth) in [f32::NAN, 0.0, -1.0, f32::INFINITY].into_iter().enumerate() {
        frame.depth_m[pixel] = depth;
    }
    assert_eq!(frame.cloud_in_base(|_| true).len(), 8);
}

#[test]
fn contradictory_frames_are_refused_by_name() {
    assert_eq!(frame().check(), Ok(()));
    assert_eq!(
        DepthFrame {
            labels: Vec::new(),
            ..frame()
        }
        .check(),
        Ok(())
    );
    let message = |frame: DepthFrame| frame.check().unwrap_err().to_string();
    assert_eq!(
        message(DepthFrame {
            depth_m: vec![1.0; 5],
            ..frame()
        }),
        "depth frame `depth_m` has 5 pixels, expected 4 x 3 = 12"
    );
    assert_eq!(
        message(DepthFrame {
            label_classes: vec!["bottle".to_owned()],
            ..frame()
        }),
        "depth frame has label 2 at pixel 10, but names 1 classes"
    );
    assert!(message(DepthFrame { fx: 0.0, ..frame() }).contains("focal lengths (0, 4)"));
}
