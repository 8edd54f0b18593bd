//! Tests of the crate from outside: real recordings, learned from to plans.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod treasure_game;
