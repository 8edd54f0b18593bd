//! The studio seen from outside: real HTTP requests and real WebSockets on loopback.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod client;

mod access;
mod commands;
mod edits;
mod fuzz;
mod lan;
mod picture;
mod start;
