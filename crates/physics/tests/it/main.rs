//! Tests of the physics room.

mod basics;
mod scenes;
