//! What the robot makes of its sensors: where it is, what the home looks like, which objects stand where
//! and how far their joints are turned. Ground truth never enters here.
//!
//! | module | turns | into |
//! |---|---|---|
//! | [`scan_match`] | a lidar scan and a map | the robot's pose, near a guess |
//! | [`slam`] | odometry and scans | a map and the pose in it |
//! | [`localise`] | a scan and a stored map | the pose without a guess, or "lost" |
//! | [`detect`] | a segmented depth image and class models | object poses |
//! | [`object_tracker`] | detections over time | objects in the map |
//! | [`visibility`] | a depth image and an object's pose | whether it should be seen, and is |
//! | [`class_surface`] | a class's model τ | what detection and joint estimation compare with |
//! | [`articulation`] | points of an articulated object | its joint position |
//! | [`home_cloud`] | depth images | the home's point cloud |
//!
//! Frames: `map` is the map's, `odom` the drifting frame of wheel odometry, `base` the robot's (REP-105).

pub mod articulation;
pub mod class_surface;
pub mod detect;
pub mod home_cloud;
mod likelihood;
pub mod localise;
pub mod object_tracker;
mod pose_search;
pub mod scan_match;
pub mod slam;
pub mod visibility;

pub use factotum_geometry::sensing;

#[cfg(test)]
mod test_home;
#[cfg(test)]
mod test_scene;
