//! Policies whose parameters are learned: networks trained by TD3, choices by bandits, movement primitives, which keep
//! the shape of one demonstration, and Gaussian networks; and the searches that improve the last two, PI²-CMA and the
//! natural policy gradient.
//!
//! Numbers in, numbers out: nothing here knows a robot or reads a clock, and random numbers come from seeded
//! generators. Only [`checkpoint`] touches files.

pub mod action;
mod adam;
pub mod bandit;
pub mod checkpoint;
pub mod dmp;
mod elementwise;
pub mod environment;
pub mod lwr;
pub mod mlp;
mod panels;
pub mod pi2;
pub mod policy_gradient;
pub mod replay;
pub mod td3;
