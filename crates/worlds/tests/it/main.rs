//! The simulated robot in the household.

mod determinism;
mod faults;
mod fixture;
mod judging;
mod motions;
mod picking;
mod refusals;
mod scenes;
mod senses;
