use super::*;
use crate::test_arms;
use proptest::prelude::*;

fn limits(n: usize) -> Vec<JointLimit> {
    let velocities = [2.0, 1.0, 0.5, 3.0];
    (0..n)
        .map(|i| JointLimit {
            velocity: velocities[i],
            acceleration: 4.0,
            jerk: 60.0,
            ..test_arms::hinge(None, 1.0)
        })
        .collect()
}

fn names(n: usize) -> Vec<String> {
    (0..n).map(|i| format!("j{i}")).collect()
}

/// Largest velocity, acceleration and jerk of each joint, as shares of the limits, from fine differences.
fn worst_shares(motion: &TimedMotion, limits: &[JointLimit]) -> [f64; 3] {
    let n_steps = 4_000;
    let dt = motion.duration_secs() / f64::from(n_steps);
    let velocities: Vec<Vec<f64>> = (0..=n_steps)
        .map(|i| motion.at(f64::from(i) * dt).velocities)
        .collect();
    let mut worst = [0.0_f64; 3];
    for (j, limit) in limits.iter().enumerate() {
        let v: Vec<f64> = velocities.iter().map(|v| v[j]).collect();
        let a: Vec<f64> = v.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect();
        let jerk: Vec<f64> = a.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect();
        for (worst, (values, limit)) in worst.iter_mut().zip([
            (&v, limit.velocity),
            (&a, limit.acceleration),
            (&jerk, limit.jerk),
        ]) {
            let largest = values
                .iter()
                .fold(0.0_f64, |largest, value| largest.max(value.abs()));
            *worst = worst.max(largest / limit);
        }
    }
    worst
}

/// Distance of a point from a polyline.
fn distance_to_path(q: &[f64], path: &[Vec<f64>]) -> f64 {
    path.windows(2)
        .map(|pair| {
            let d: Vec<f64> = pair[1].iter().zip(&pair[0]).map(|(b, a)| b - a).collect();
            let length_squared: f64 = d.iter().map(|d| d * d).sum();
            let along: f64 = (0..q.len()).map(|i| (q[i] - pair[0][i]) * d[i]).sum();
            let t = if length_squared > 0.0 {
                (along / length_squared).clamp(0.0, 1.0)
            } else {
                0.0
            };
            (0..q.len())
                .map(|i| (q[i] - pair[0][i] - t * d[i]).powi(2))
                .sum::<f64>()
                .sqrt()
        })
        .fold(f64::INFINITY, f64::min)
}

fn paths() -> impl Strategy<Value = Vec<Vec<f64>>> {
    prop::collection::vec(prop::collection::vec(-2.0..2.0, 3), 2..8)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn limits_hold_everywhere_and_the_path_is_kept(path in paths(), speed_scale in 0.2..1.0) {
        let limits = limits(3);
        let options = TimingOptions { speed_scale, ..TimingOptions::default() };
        let motion = TimedMotion::new(&limits, &path, &options).unwrap();
        let scaled: Vec<JointLimit> = limits.iter().map(|limit| scaled(limit, speed_scale)).collect();
        let [v, a, j] = worst_shares(&motion, &scaled);
        // Differences across a change of phase are means of both sides, so they too are within the limits.
        prop_assert!(v <= 1.0 + 1e-6 && a <= 1.0 + 1e-4 && j <= 1.0 + 1e-2, "{v} {a} {j}");
        for i in 0..=200 {
            let point = motion.at(motion.duration_secs() * f64::from(i) / 200.0);
            let off = distance_to_path(&point.positions, &path);
            prop_assert!(off <= options.blend_deviation_rad + options.simplify_rad + 1e-9, "{off}");
        }
        let (start, end) = (motion.at(0.0), motion.at(motion.duration_secs()));
        let off = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        prop_assert!(off(&start.positions, &path[0]) < 1e-9);
        prop_assert!(off(&end.positions, &path[path.len() - 1]) < 1e-6);
        prop_assert!(off(&start.velocities, &[0.0; 3]) < 1e-9);
        prop_assert!(off(&end.velocities, &[0.0; 3]) < 1e-6);
    }

    #[test]
    fn the_sampled_trajectory_follows_the_motion(path in paths()) {
        let limits = limits(3);
        let options = TimingOptions::default();
        let motion = TimedMotion::new(&limits, &path, &options).unwrap();
        let trajectory = time_joint_path(&names(3), &limits, &path, &options).unwrap();
        prop_assert!((trajectory.duration_secs() - motion.duration_secs()).abs() < 1e-9);
        for i in 0..=500 {
            let time_secs = motion.duration_secs() * f64::from(i) / 500.0;
            let (a, b) = (trajectory.sample(time_secs), motion.at(time_secs));
            for (a, b) in a.positions.iter().zip(&b.positions) {
                prop_assert!((a - b).abs() < 1e-4);
            }
            for (velocity, limit) in a.velocities.iter().zip(&limits) {
                prop_assert!(velocity.abs() <= limit.velocity * 1.01);
            }
        }
    }

    #[test]
    fn slowing_down_stretches_time(path in paths(), speed_scale in 0.1..1.0) {
        let limits = limits(3);
        let full = TimedMotion::new(&limits, &path, &TimingOptions::default()).unwrap();
        let options = TimingOptions { speed_scale, ..TimingOptions::default() };
        let slow = TimedMotion::new(&limits, &path, &options).unwrap();
        let ratio = slow.duration_secs() * speed_scale / full.duration_secs();
        prop_assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
    }
}

#[test]
fn a_straight_line_takes_the_time_of_one_rest_to_rest_motion() {
    // 2 rad at 2 rad/s, 4 rad/s², 60 rad/s³: T = d/v + v/a + a/j.
    let motion = TimedMotion::new(
        &limits(1),
        &[vec![0.0], vec![0.7], vec![2.0]],
        &TimingOptions::default(),
    )
    .unwrap();
    assert!((motion.duration_secs() - (1.0 + 0.5 + 4.0 / 60.0)).abs() < 1e-6);
}

#[test]
fn a_blended_corner_is_faster_than_a_stop_and_a_repeated_waypoint_is_one() {
    let path = vec![vec![0.0, 0.0], vec![1.0, 0.2], vec![2.0, 0.0]];
    let mut with_stop = path.clone();
    with_stop.insert(1, path[1].clone());
    let time =
        |path: &[Vec<f64>]| TimedMotion::new(&limits(2), path, &TimingOptions::default()).unwrap();
    let (flowing, stopping) = (time(&path), time(&with_stop));
    assert!(flowing.duration_secs() < 0.9 * stopping.duration_secs());
    let passes = |motion: &TimedMotion| {
        (0..=10_000)
            .map(|i| {
                motion
                    .at(motion.duration_secs() * f64::from(i) / 1e4)
                    .positions
            })
            .any(|q| (q[0] - 1.0).hypot(q[1] - 0.2) < 1e-4)
    };
    assert!(passes(&stopping) && !passes(&flowing));
}

#[test]
fn a_dense_straight_path_costs_no_time() {
    let sparse = [vec![0.0, 0.0], vec![1.0, 0.5]];
    let dense: Vec<Vec<f64>> = (0..=200)
        .map(|i| vec![f64::from(i) / 200.0, f64::from(i) / 400.0])
        .collect();
    let time = |path: &[Vec<f64>]| {
        TimedMotion::new(&limits(2), path, &TimingOptions::default())
            .unwrap()
            .duration_secs()
    };
    assert!((time(&dense) - time(&sparse)).abs() < 1e-6);
}

#[test]
fn one_waypoint_is_a_rest() {
    let path = [vec![0.3, 0.4], vec![0.3, 0.4]];
    for path in [&path[..1], &path[..]] {
        let options = TimingOptions::default();
        let trajectory = time_joint_path(&names(2), &limits(2), path, &options).unwrap();
        assert_eq!(trajectory.points().len(), 1);
        assert_eq!(trajectory.end(), [0.3, 0.4]);
    }
}

#[test]
fn bad_paths_are_refused_by_name() {
    let time = |path: &[Vec<f64>], speed_scale: f64| {
        let options = TimingOptions {
            speed_scale,
            ..TimingOptions::default()
        };
        TimedMotion::new(&limits(2), path, &options)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        time(&[], 1.0),
        "number of waypoints is 0, expected at least one"
    );
    assert_eq!(
        time(&[vec![0.0]], 1.0),
        "waypoint has 1 values, expected 2, one per chain joint"
    );
    assert_eq!(
        time(&[vec![0.0, f64::NAN]], 1.0),
        "position in a waypoint is NaN, expected a finite number"
    );
    assert_eq!(
        time(&[vec![0.0, 0.0]], 1.5),
        "speed_scale is 1.5, expected in (0, 1]"
    );
}
