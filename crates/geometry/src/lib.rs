//! Frames, poses, occupancy grids, point clouds and their registration: the ground floor of Factotum.
//!
//! Frames and units: SI and radians; right-handed axes, x forward, y left, z up (ROS REP-103).
//! `world_from_object` reads "pose of object in world", so that compositions read
//! `world_from_tcp = world_from_base * base_from_tcp`.
//!
//! | module | holds |
//! |---|---|
//! | [`frames`] | quaternion orders, roll-pitch-yaw, planar poses, camera and headset axes |
//! | [`sensing`] | what a planar lidar and a depth camera deliver |
//! | [`grid`] | occupancy grids: mapping, distances, frontiers, overlap, ROS map files |
//! | [`cloud`] | point clouds with normals, down-sampling, PLY files |
//! | [`alignment`] | rigid alignment of paired points |
//! | [`icp`] | registration of unpaired clouds |

pub mod alignment;
pub mod cloud;
pub mod frames;
pub mod grid;
pub mod icp;
pub mod sensing;

/// Position and orientation in space; `world_from_object: Pose` is the pose of the object in the world.
pub type Pose = nalgebra::Isometry3<f64>;

/// Position and heading in the plane.
pub type Pose2 = nalgebra::Isometry2<f64>;
