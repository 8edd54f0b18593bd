use super::*;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Sides of a 4 x 3 x 2.5 m room with a cupboard in it, sampled at random, seen from inside.
fn room(n: usize, noise_m: f64, seed: u64) -> PointCloud {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let size = Vector3::new(4.0, 3.0, 2.5);
    let points = (0..n)
        .map(|i| {
            let uv = Vector3::from_fn(|_, _| rng.random_range(0.0..1.0));
            let noise =
                Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0) * noise_m * 3f64.sqrt());
            let p = match i % 6 {
                0 => Vector3::new(uv.x, uv.y, 0.0).component_mul(&size),
                1 => Vector3::new(uv.x, 0.0, uv.z).component_mul(&size),
                2 => Vector3::new(0.0, uv.y, uv.z).component_mul(&size),
                3 => Vector3::new(1.0, uv.y, uv.z).component_mul(&size),
                4 => Vector3::new(1.0 + uv.x, 2.4, uv.z * 1.8),
                _ => Vector3::new(1.0, 2.4 + 0.6 * uv.y, uv.z * 1.8),
            };
            Point3::from(p + noise)
        })
        .collect();
    PointCloud::new(points)
        .with_estimated_normals(12, &Point3::new(2.0, 1.2, 1.2))
        .unwrap()
}

fn offset() -> Pose {
    Pose::new(
        Vector3::new(0.15, -0.10, 0.05),
        Vector3::new(0.05, -0.06, 0.11),
    )
}

fn errors(found: &Pose, truth: &Pose) -> (f64, f64) {
    let error = found.inverse() * truth;
    (error.translation.vector.norm(), error.rotation.angle())
}

#[test]
fn clean_data_register_far_below_a_millimetre() {
    let target = IcpTarget::new(&room(12_000, 0.0, 1)).unwrap();
    let truth = offset().inverse();
    let source: Vec<_> = room(3_000, 0.0, 2)
        .points()
        .iter()
        .map(|p| truth.inverse() * p)
        .collect();
    let result = target
        .register(&source, &Pose::identity(), &IcpParams::default())
        .unwrap();
    let (apart_m, turned_rad) = errors(&result.target_from_source, &truth);
    assert!(
        apart_m < 1e-4 && turned_rad < 1e-4,
        "{apart_m} m, {turned_rad} rad, {result:?}"
    );
    assert!(result.is_converged() && result.n_unconstrained == 0 && result.fitness > 0.999);
}

#[test]
fn noisy_data_register_below_a_millimetre() {
    let target = IcpTarget::new(&room(26_000, 0.004, 3)).unwrap();
    let truth = offset();
    let source: Vec<_> = room(8_000, 0.004, 4)
        .points()
        .iter()
        .map(|p| truth.inverse() * p)
        .collect();
    let result = target
        .register(&source, &Pose::identity(), &IcpParams::default())
        .unwrap();
    let (apart_m, turned_rad) = errors(&result.target_from_source, &truth);
    assert!(
        apart_m < 1e-3 && turned_rad < 1e-3,
        "{apart_m} m, {turned_rad} rad, {result:?}"
    );
}

#[test]
fn outliers_are_trimmed() {
    let target = IcpTarget::new(&room(12_000, 0.002, 5)).unwrap();
    let truth = offset();
    let mut source: Vec<_> = room(3_000, 0.002, 6)
        .points()
        .iter()
        .map(|p| truth.inverse() * p)
        .collect();
    // A person stands in the room: a blob of points that the target does not have.
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    source.extend((0..600).map(|_| {
        Point3::new(2.5, 0.6, 0.4) + Vector3::from_fn(|_, _| rng.random_range(-0.3..0.3))
    }));
    let params = IcpParams {
        keep_ratio: 0.8,
        pair_distance_max_m: 0.4,
        ..IcpParams::default()
    };
    let result = target
        .register(&source, &Pose::identity(), &params)
        .unwrap();
    let (apart_m, turned_rad) = errors(&result.target_from_source, &truth);
    assert!(
        apart_m < 3e-3 && turned_rad < 3e-3,
        "{apart_m} m, {turned_rad} rad"
    );
}

#[test]
fn a_flat_plane_fixes_three_directions_and_keeps_the_guess_along_the_others() {
    let grid = |n: i32, step: f64| -> Vec<Point3<f64>> {
        (0..n * n)
            .map(|i| Point3::new(f64::from(i % n) * step, f64::from(i / n) * step, 0.0))
            .collect()
    };
    let points = grid(40, 0.05);
    let normals = vec![Vector3::z_axis(); points.len()];
    let target = IcpTarget::new(&PointCloud::with_normals(points, normals).unwrap()).unwrap();
    let source: Vec<_> = grid(20, 0.03)
        .iter()
        .map(|p| p + Vector3::new(0.5, 0.5, 0.02))
        .collect();
    let result = target
        .register(&source, &Pose::identity(), &IcpParams::default())
        .unwrap();
    assert_eq!(result.n_unconstrained, 3);
    let t = result.target_from_source.translation.vector;
    assert!(
        (t.z + 0.02).abs() < 1e-9 && t.x.abs() < 1e-9 && t.y.abs() < 1e-9,
        "{t}"
    );
}

#[test]
fn an_upright_cylinder_leaves_turn_and_height_open() {
    let points: Vec<_> = (0..2000)
        .map(|i| {
            let (angle, z) = (f64::from(i % 100) * 0.0628, f64::from(i / 100) * 0.01);
            Point3::new(0.04 * angle.cos(), 0.04 * angle.sin(), z)
        })
        .collect();
    let normals = points
        .iter()
        .map(|p| Unit::new_normalize(Vector3::new(p.x, p.y, 0.0)))
        .collect();
    let target =
        IcpTarget::new(&PointCloud::with_normals(points.clone(), normals).unwrap()).unwrap();
    let source: Vec<_> = points
        .iter()
        .step_by(3)
        .map(|p| p + Vector3::new(0.005, -0.003, 0.0))
        .collect();
    let result = target
        .register(&source, &Pose::identity(), &IcpParams::default())
        .unwrap();
    let t = result.target_from_source.translation.vector;
    assert_eq!(result.n_unconstrained, 2);
    assert!(
        (t.x + 0.005).abs() < 1e-3 && (t.y - 0.003).abs() < 1e-3,
        "{t}"
    );
}

#[test]
fn the_iteration_cap_is_reported() {
    let target = IcpTarget::new(&room(4_000, 0.0, 8)).unwrap();
    let source: Vec<_> = room(1_000, 0.0, 9)
        .points()
        .iter()
        .map(|p| offset() * p)
        .collect();
    let params = IcpParams {
        n_iterations_max: 1,
        ..IcpParams::default()
    };
    let result = target
        .register(&source, &Pose::identity(), &params)
        .unwrap();
    assert_eq!(
        (result.stop, result.n_iterations),
        (IcpStop::IterationCap, 1)
    );
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let run = || {
        let target = IcpTarget::new(&room(2_000, 0.003, 10)).unwrap();
        let source = room(500, 0.003, 11);
        target
            .register(source.points(), &offset(), &IcpParams::default())
            .unwrap()
    };
    assert_eq!(run(), run());
}

#[test]
fn clouds_that_cannot_be_registered_are_named() {
    let cloud = room(600, 0.0, 12);
    let target = IcpTarget::new(&cloud).unwrap();
    let params = IcpParams::default();
    let message = |source: &[Point3<f64>]| {
        target
            .register(source, &Pose::identity(), &params)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        message(&cloud.points()[..4]),
        "registration source has 4 points, expected at least 10"
    );
    let far: Vec<_> = cloud
        .points()
        .iter()
        .map(|p| p + Vector3::new(90.0, 0.0, 0.0))
        .collect();
    assert_eq!(
        message(&far),
        "0 pairs of points within 0.5 m at iteration 0, expected at least 10"
    );
    let mut broken = cloud.points().to_vec();
    broken[7].z = f64::NAN;
    assert_eq!(
        message(&broken),
        "registration source has a coordinate that is not finite at point 7"
    );
    let bare = PointCloud::new(cloud.points().to_vec());
    assert!(matches!(
        IcpTarget::new(&bare),
        Err(IcpError::NoNormals { n_points: 600 })
    ));
    assert!(matches!(
        IcpTarget::new(&PointCloud::default()),
        Err(IcpError::TooFewPoints { .. })
    ));
    // All source points in one place: nothing to turn about, and still no NaN.
    let one_place = vec![Point3::new(0.0, 1.0, 1.0); 20];
    let result = target
        .register(&one_place, &Pose::identity(), &params)
        .unwrap();
    assert!(
        result
            .target_from_source
            .translation
            .vector
            .iter()
            .all(|v| v.is_finite())
            && result.n_unconstrained >= 3
    );
}

#[test]
fn held_rotations_stay_and_are_not_counted_as_unconstrained() {
    let target = IcpTarget::new(&room(6_000, 0.0, 13)).unwrap();
    let truth = Pose::new(Vector3::new(0.1, -0.05, 0.03), Vector3::z() * 0.08);
    let source: Vec<_> = room(2_000, 0.0, 14)
        .points()
        .iter()
        .map(|p| truth.inverse() * p)
        .collect();
    let run = |freedom| {
        target
            .register(
                &source,
                &Pose::identity(),
                &IcpParams {
                    freedom,
                    ..IcpParams::default()
                },
            )
            .unwrap()
    };
    let upright = run(IcpFreedom::Upright);
    let (apart_m, turned_rad) = errors(&upright.target_from_source, &truth);
    assert!(
        apart_m < 1e-4 && turned_rad < 1e-4 && upright.n_unconstrained == 0,
        "{upright:?}"
    );
    let axis = upright.target_from_source.rotation * Vector3::z();
    assert!((axis - Vector3::z()).norm() < 1e-9);
    let shifted = run(IcpFreedom::Translation);
    assert!(shifted.target_from_source.rotation.angle() < 1e-9 && shifted.n_unconstrained == 0);
}
