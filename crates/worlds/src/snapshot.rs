//! A world kept aside, to go on from exactly.

use factotum_physics::Snapshot;

use crate::WorldError;
use crate::sim_robot::{Live, Writer, visit};

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

    /// The snapshot as bytes for a file; [`SimRobot::read_snapshot`](crate::SimRobot::read_snapshot) reads them.
    ///
    /// # Errors
    /// [`WorldError::Snapshot`] while a motion is under way: a world is stored between motions.
    pub fn to_bytes(&self) -> Result<Vec<u8>, WorldError> {
        let mut writer = Writer::default();
        let mut physics = self.physics.values().to_vec();
        visit(&mut writer, &mut physics, &mut self.live.clone())
            .map_err(|reason| WorldError::Snapshot { reason })?;
        Ok(writer.0)
    }
}
