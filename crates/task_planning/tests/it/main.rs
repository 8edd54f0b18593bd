//! Tests of the crate from outside: real files, planners against each other, and laws.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod learned_files;
mod planners;
mod processes;
mod random_tasks;
mod tasks;
