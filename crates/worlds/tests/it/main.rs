//! The simulated robot in the household.

mod fixture;
mod motions;
