//! The shipped robots, for tests that need physics.

use std::path::Path;

use factotum_descriptions::RobotDescription;

use crate::robot::RobotModel;

/// A robot of `assets/robots`.
pub(crate) fn load(name: &str) -> RobotModel {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../assets/robots")
        .join(name);
    RobotModel::load(&RobotDescription::load(&dir).unwrap()).unwrap()
}
