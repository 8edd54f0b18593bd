//! Policies whose parameters are learned: so far movement primitives, which keep the shape of one demonstration.
//!
//! Numbers in, numbers out: nothing here knows a robot, reads a clock or draws a random number.

pub mod dmp;
