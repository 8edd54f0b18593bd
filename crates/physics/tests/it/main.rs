//! Tests of the physics room.

mod basics;
mod models;
mod motion;
mod scenes;
mod sensors;
mod urdf;
