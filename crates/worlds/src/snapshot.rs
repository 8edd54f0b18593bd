//! A world kept aside, to go on from exactly.

use factotum_physics::Snapshot;

use crate::sim_robot::Live;

/// Everything that changes in a world: physics, controllers, senses, random streams and the fault.
///
/// A world made from the same configuration and restored from it goes on with the same bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldSnapshot {
    pub(crate) physics: Snapshot,
    pub(crate) live: Live,
}

impl WorldSnapshot {
    /// Simulated time, seconds.
    pub fn time_secs(&self) -> f64 {
        self.physics.time_secs()
    }
}
