use super::*;
use crate::test_arms;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

const OPTIONS: DescentOptions = DescentOptions {
    position_tol_m: 1e-5,
    rotation_tol_rad: 1e-5,
    iterations: 100,
    axis_free: false,
};

/// Share of reachable poses that descents with at most `restarts` random starts reach, and descents per pose.
fn success(
    arm: &test_arms::TestArm,
    n_poses: u64,
    restarts: usize,
    options: &DescentOptions,
) -> (f64, f64, f64) {
    let mut descender = Descender::new(&arm.chain, &arm.space);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut n_solved, mut n_descents, mut n_iterations) = (0, 0, 0);
    let mut q = vec![0.0; arm.chain.n()];
    for seed in 0..n_poses {
        let target = arm.chain.base_from_tcp(&test_arms::sample(arm, seed));
        for _ in 0..restarts {
            arm.space.sample_into(&mut rng, &mut q);
            n_descents += 1;
            let descent = descender.descend(&target, &mut q, options);
            n_iterations += descent.iterations;
            if descent.is_converged {
                // The claim is checked afresh, and so are the limits.
                let (linear, angular) =
                    residual(&arm.chain.base_from_tcp(&q), &target, options.axis_free);
                assert!(
                    linear.norm() <= options.position_tol_m
                        && angular.norm() <= options.rotation_tol_rad
                );
                assert!(arm.space.is_within_limits(&q));
                n_solved += 1;
                break;
            }
        }
    }
    let n = n_poses as f64;
    (
        n_solved as f64 / n,
        n_descents as f64 / n,
        n_iterations as f64 / n,
    )
}

#[test]
fn reachable_poses_are_reached() {
    for arm in test_arms::all() {
        let (share, n_descents, _) = success(&arm, 200, 60, &OPTIONS);
        assert!(
            share >= 0.995,
            "{share} of the poses reached, {n_descents} descents each"
        );
    }
}

#[test]
fn a_free_axis_is_reached_sooner() {
    let arm = test_arms::panda();
    let free = DescentOptions {
        axis_free: true,
        ..OPTIONS
    };
    let (share, n_descents, _) = success(&arm, 100, 60, &free);
    let (_, n_descents_full, _) = success(&arm, 100, 60, &OPTIONS);
    assert!(
        share >= 0.99 && n_descents < n_descents_full,
        "{share} {n_descents} {n_descents_full}"
    );
}

#[test]
fn an_unreachable_pose_is_not_claimed() {
    let arm = test_arms::panda();
    let mut descender = Descender::new(&arm.chain, &arm.space);
    let mut q = test_arms::sample(&arm, 1);
    let descent = descender.descend(&Pose::translation(3.0, 0.0, 0.5), &mut q, &OPTIONS);
    assert!(!descent.is_converged && descent.position_error_m > 1.5);
    assert!(arm.space.is_within_limits(&q));
}
