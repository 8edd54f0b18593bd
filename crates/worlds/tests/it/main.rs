//! The simulated robot in the household.
#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, which may panic like the tests themselves"
)]

mod determinism;
mod faults;
mod fixture;
mod judging;
mod motions;
mod picking;
mod refusals;
mod scenes;
mod senses;
mod task_models;
mod task_rigs;
