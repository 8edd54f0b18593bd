use super::*;
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;

prop_compose! {
    fn points(n: usize)(coordinates in prop::collection::vec(prop::array::uniform3(-2.0..2.0f64), n)) -> Vec<Point3<f64>> {
        coordinates.into_iter().map(Point3::from).collect()
    }
}

fn pose(v: [f64; 6]) -> Pose {
    Pose::new(
        Vector3::new(v[0], v[1], v[2]),
        Vector3::new(v[3], v[4], v[5]),
    )
}

proptest! {
    #[test]
    fn exact_pairs_give_back_the_motion(source in points(7), v in prop::array::uniform6(-1.7..1.7f64)) {
        let truth = pose(v);
        let target: Vec<_> = source.iter().map(|p| truth * p).collect();
        let found = align_points(&source, &target).unwrap();
        let error = found.target_from_source.inverse() * truth;
        prop_assert!(error.translation.vector.norm() < 1e-10 && error.rotation.angle() < 1e-7);
        prop_assert!(found.rms_m < 1e-10);
        prop_assert!((found.target_from_source.rotation.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12);
    }

    /// No small motion on top of the result lowers the cost: it is a minimum, also for mirrored and noisy data.
    #[test]
    fn the_result_is_a_local_optimum(source in points(6), target in points(6), v in prop::array::uniform6(-1e-3..1e-3f64)) {
        let cost = |t: &Pose| source.iter().zip(&target).map(|(s, q)| (t * s - q).norm_squared()).sum::<f64>();
        let best = align_points(&source, &target).unwrap().target_from_source;
        prop_assert!(cost(&best) <= cost(&(pose(v) * best)) + 1e-9);
    }

    #[test]
    fn planar_pairs_give_back_the_motion(
        coordinates in prop::collection::vec(prop::array::uniform2(-2.0..2.0f64), 2..6),
        x in -3.0..3.0f64, y in -3.0..3.0f64, yaw in -3.0..3.0f64
    ) {
        let source: Vec<_> = coordinates.into_iter().map(Point2::from).collect();
        let truth = Pose2::new(Vector2::new(x, y), yaw);
        let target: Vec<_> = source.iter().map(|p| truth * p).collect();
        prop_assume!((source[0] - source[1]).norm() > 1e-3);
        let found = align_points_2d(&source, &target).unwrap();
        let error = found.target_from_source.inverse() * truth;
        prop_assert!(error.translation.vector.norm() < 1e-9 && error.rotation.angle().abs() < 1e-9);
    }
}

#[test]
fn a_mirrored_triangle_still_gives_a_rotation() {
    let source = [
        Point3::origin(),
        Point3::new(1.0, 0.0, 0.0),
        Point3::new(0.0, 2.0, 0.0),
        Point3::new(0.0, 0.0, 3.0),
    ];
    let target = source.map(|p| Point3::new(-p.x, p.y, p.z));
    let found = align_points(&source, &target).unwrap();
    let det = found
        .target_from_source
        .rotation
        .to_rotation_matrix()
        .matrix()
        .determinant();
    assert!((det - 1.0).abs() < 1e-12);
    assert!(
        found.rms_m > 0.1,
        "a mirror image cannot fit: {}",
        found.rms_m
    );
}

#[test]
fn half_turns_and_planar_triangles_are_recovered() {
    let source = [
        Point3::origin(),
        Point3::new(1.0, 0.0, 0.0),
        Point3::new(0.0, 1.0, 0.0),
    ];
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        let truth = Pose::new(Vector3::new(0.1, 0.2, 0.3), axis * std::f64::consts::PI);
        let found = align_points(&source, &source.map(|p| truth * p)).unwrap();
        assert!(found.rms_m < 1e-12, "about {axis}: {}", found.rms_m);
    }
}

#[test]
fn the_worst_pair_is_named() {
    let source: Vec<_> = (0..8)
        .map(|i| Point3::new(f64::from(i % 2), f64::from(i / 2 % 2), f64::from(i / 4)))
        .collect();
    let mut target = source.clone();
    target[5].z += 0.2;
    let (pair, residual) = align_points(&source, &target)
        .unwrap()
        .worst_pair()
        .unwrap();
    assert_eq!(pair, 5);
    assert!(residual > 0.1);
}

#[test]
fn pairs_that_fix_nothing_are_refused() {
    let line: Vec<_> = (0..5)
        .map(|i| Point3::new(f64::from(i), 2.0 * f64::from(i), 1.0))
        .collect();
    let corner = [
        Point3::origin(),
        Point3::new(1.0, 0.0, 0.0),
        Point3::new(0.0, 1.0, 0.0),
    ];
    let error = align_points(&line, &line).unwrap_err();
    assert!(
        matches!(
            error,
            AlignmentError::Collinear {
                points: "source",
                ..
            }
        ),
        "{error}"
    );
    assert_eq!(
        align_points(&corner[..2], &corner[..2])
            .unwrap_err()
            .to_string(),
        "alignment from 2 pairs of points, expected at least 3"
    );
    assert_eq!(
        align_points(&corner, &corner[..2]).unwrap_err().to_string(),
        "alignment of 3 source points with 2 target points, expected as many of each"
    );
    assert_eq!(
        align_points(&[Point3::origin(); 4], &[Point3::origin(); 4]).unwrap_err(),
        AlignmentError::Coincident { points: "source" }
    );
    let mut broken = corner;
    broken[1].y = f64::NAN;
    assert_eq!(
        align_points(&corner, &broken).unwrap_err(),
        AlignmentError::NotFinite { pair: 1 }
    );
    let place = [Point2::new(3.0, 4.0); 3];
    assert_eq!(
        align_points_2d(&place, &place).unwrap_err(),
        AlignmentError::Coincident { points: "source" }
    );
}
