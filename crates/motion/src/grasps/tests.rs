use super::*;
use crate::ObstacleShape;
use factotum_geometry::cloud::PointCloud;
use nalgebra::{Point3, Unit};
use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

fn side_grasp(yaw_symmetric: bool) -> Grasp {
    Grasp {
        name: "side".to_owned(),
        xyz: [0.0, 0.0, 0.1],
        // Approach along the object's x axis, fingers closing along z.
        rpy: [0.0, std::f64::consts::FRAC_PI_2, 0.0],
        aperture_m: 0.08,
        link: None,
        yaw_symmetric,
        provenance: Default::default(),
    }
}

#[test]
fn a_symmetric_grasp_is_turned_evenly_and_another_is_not() {
    assert_eq!(expand_grasp(&side_grasp(false), 8).len(), 1);
    let all = expand_grasp(&side_grasp(true), 8);
    assert_eq!(all.len(), 8);
    assert_eq!(all[0].object_from_tcp, side_grasp(true).object_from_tcp());
    for (i, candidate) in all.iter().enumerate() {
        // All point at the axis, at the same height, from evenly spread sides.
        let approach = candidate.object_from_tcp.rotation * Vector3::z();
        let expected = TAU * i as f64 / 8.0;
        assert!((approach - Vector3::new(expected.cos(), expected.sin(), 0.0)).norm() < 1e-9);
        assert!((candidate.object_from_tcp.translation.z - 0.1).abs() < 1e-12);
    }
}

proptest! {
    #[test]
    fn the_pregrasp_is_behind_the_tool(xyz in prop::array::uniform3(-1.0..1.0), turn in prop::array::uniform3(-2.0..2.0), d in 0.0..0.3) {
        let grasp = Pose::new(Vector3::from(xyz), Vector3::from(turn));
        let before = pregrasp(&grasp, d);
        let in_grasp = grasp.inverse() * before;
        prop_assert!((in_grasp.translation.vector - Vector3::new(0.0, 0.0, -d)).norm() < 1e-9);
        let up = retreat(&grasp, d, 0.1);
        prop_assert!((up.translation.vector - before.translation.vector - Vector3::new(0.0, 0.0, 0.1)).norm() < 1e-9);
        let twice = with_fingers_swapped(&with_fingers_swapped(&grasp));
        prop_assert!(twice.rotation.angle_to(&grasp.rotation) < 1e-6);
    }
}

/// A standing cylinder of points with outward normals.
fn cylinder(radius_m: f64) -> PointCloud {
    let mut points = Vec::new();
    let mut normals = Vec::new();
    for i in 0..60 {
        for j in 0..40 {
            let angle = TAU * f64::from(i) / 60.0;
            let out = Vector3::new(angle.cos(), angle.sin(), 0.0);
            points.push(Point3::from(
                out * radius_m + Vector3::z() * (f64::from(j) * 0.005),
            ));
            normals.push(Unit::new_unchecked(out));
        }
    }
    PointCloud::with_normals(points, normals).unwrap()
}

#[test]
fn a_cylinder_is_grasped_across_its_axis() {
    let cloud = cylinder(0.025);
    let options = AntipodalOptions::default();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let grasps = antipodal_grasps(&cloud, &options, &mut rng);
    assert_eq!(grasps.len(), options.n_grasps);
    assert!(grasps.is_sorted_by(|a, b| a.score >= b.score));
    for grasp in &grasps {
        let closing = grasp.cloud_from_tcp.rotation * Vector3::x();
        let approach = grasp.cloud_from_tcp.rotation * Vector3::z();
        assert!(closing.z.abs() < 0.3, "closes across the axis: {closing}");
        assert!((grasp.width_m - 0.05).abs() < 0.005, "{}", grasp.width_m);
        assert!(grasp.score >= options.friction_angle_rad.cos());
        // Approached from outside: the tool frame lies on the approach line through the surface.
        let tcp = grasp.cloud_from_tcp.translation.vector;
        let outside = tcp - 0.1 * approach;
        assert!(outside.xy().norm() > 0.025, "{outside}");
    }
}

#[test]
fn what_is_too_wide_or_without_normals_gives_no_grasp() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let options = AntipodalOptions::default();
    assert!(antipodal_grasps(&cylinder(0.06), &options, &mut rng).is_empty());
    let bare = PointCloud::new(cylinder(0.02).points().to_vec());
    assert!(antipodal_grasps(&bare, &options, &mut rng).is_empty());
    assert!(antipodal_grasps(&PointCloud::new(vec![]), &options, &mut rng).is_empty());
}

/// A can of this radius, taken from the side on its axis.
fn can(radius_m: f64) -> ObstacleShape {
    ObstacleShape::Cylinder {
        radius_m,
        half_length_m: 0.15,
    }
}

/// Approach along the object's x axis and this much downwards, fingers closing along y.
fn from_above(slope_rad: f64) -> Grasp {
    use std::f64::consts::FRAC_PI_2;
    Grasp {
        rpy: [FRAC_PI_2 + slope_rad, 0.0, FRAC_PI_2],
        ..side_grasp(true)
    }
}

#[test]
fn a_hand_reaches_as_deep_as_its_palm_allows() {
    // From the Panda's tool frame it is 37.4 mm to the palm.
    let panda = crate::test_robots::load("panda");
    let grasp = from_above(0.0);
    let back_m = |radius_m: f64| {
        let fitted = fit_grasp(&panda, &can(radius_m), &grasp).unwrap()?;
        Some(grasp.xyz[0] - fitted.xyz[0])
    };
    assert_eq!(back_m(0.030), Some(0.0));
    assert!((back_m(0.037).unwrap() - 0.004).abs() < 1e-12);
    assert_eq!(back_m(0.045), None, "wider than the open hand");
}

#[test]
fn a_hand_that_would_push_with_its_palm_does_not_fit() {
    let steep = from_above(25_f64.to_radians());
    let fits = |robot: &str| {
        let robot = crate::test_robots::load(robot);
        fit_grasp(&robot, &can(0.0325), &steep).unwrap().is_some()
    };
    assert!(!fits("panda"));
    assert!(fits("jaco"), "its fingers are longer");
}
