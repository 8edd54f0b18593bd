//! Tests of the physics room.
#![expect(clippy::print_stdout, reason = "a test that is skipped says why")]

mod basics;
mod hostile;
mod models;
mod motion;
mod scenes;
mod sensors;
mod urdf;
