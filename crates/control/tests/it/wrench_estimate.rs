//! The wrench on the tool is felt through the joints.

use factotum_control::joint_tracking::{JointGains, JointTarget, JointTracker};
use factotum_control::wrench_estimate::WrenchEstimate;
use nalgebra::{DVector, Vector3};

use crate::snake::{STEP_SECS, Snake, TORQUE_MAX_NM, bent};

#[test]
fn a_push_is_felt_in_size_and_direction() {
    let start = bent(7);
    let mut snake = Snake::new(7, &start);
    let mut tracker = JointTracker::new(JointGains::default(), &[TORQUE_MAX_NM; 7]);
    let mut estimate = WrenchEstimate::new(7);
    let target = JointTarget::at_rest(DVector::from_vec(start));
    let force = Vector3::new(5.0, -8.0, 3.0);
    let mut torques = snake.arm_state().bias;
    for i in 0..1000 {
        if i > 200 {
            snake.push_tool(force);
        }
        let arm = snake.arm_state();
        estimate.update(&arm, &torques, STEP_SECS).unwrap();
        if i == 200 {
            let felt = estimate.wrench(&arm);
            assert!(felt.norm() < 0.05, "felt {felt} with nothing there");
        }
        torques = tracker.torques(&arm, &target, STEP_SECS).unwrap();
        snake.step(&torques);
    }
    let arm = snake.arm_state();
    let felt = estimate.wrench(&arm);
    assert!(
        (felt.fixed_rows::<3>(0) - force).norm() < 0.05 * force.norm(),
        "{felt}"
    );
    assert!(felt.fixed_rows::<3>(3).norm() < 0.1, "{felt}");
}
