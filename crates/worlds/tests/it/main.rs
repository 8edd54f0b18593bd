//! The simulated robot in the household.

mod determinism;
mod faults;
mod fixture;
mod judging;
mod motions;
mod picking;
mod refusals;
mod remote;
mod scenes;
mod senses;
