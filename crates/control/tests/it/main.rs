//! The control laws on small arms in physics, and as pure functions.
#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, which may panic like the tests themselves"
)]

mod barrier;
mod base_tracking;
mod gripper;
mod impedance;
mod joint_tracking;
mod safety;
mod snake;
mod tool_path;
mod torque_limit;
mod wrench_estimate;
