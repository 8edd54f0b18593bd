//! The hand on a robot that is driven from the page: between the one who hears the page and the one who drives.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use factotum_agent::{Driver, Steer};
use factotum_control::RobotState;
use factotum_protocol as wire;
use nalgebra::Vector3;

/// A page that has said nothing for so long has let go: it speaks ten times a second while a hand is on it.
const LET_GO: Duration = Duration::from_millis(400);

/// What the hand last wished; clones are the same hand.
#[derive(Debug, Clone, Default)]
pub(crate) struct Hand(Arc<Mutex<Wished>>);

#[derive(Debug, Default)]
struct Wished {
    /// The newest velocity, and when it came.
    velocity: Option<(Instant, wire::Drive)>,
    is_done: bool,
}

impl Hand {
    /// The page wishes a velocity.
    pub(crate) fn hear(&self, drive: wire::Drive, heard: Instant) {
        self.lock().velocity = Some((heard, drive));
    }

    /// The page wishes the drive to end.
    pub(crate) fn finish(&self) {
        self.lock().is_done = true;
    }

    fn steer_at(&self, now: Instant) -> Steer {
        let wished = self.lock();
        if wished.is_done {
            return Steer::Done;
        }
        let held = wished
            .velocity
            .filter(|(heard, _)| now.saturating_duration_since(*heard) < LET_GO);
        Steer::Drive(held.map_or_else(Vector3::zeros, |(_, drive)| {
            Vector3::new(drive.forward, drive.left, drive.turn)
        }))
    }

    /// Nothing that holds this lock can panic half way, so a poisoned one is as good as new.
    fn lock(&self) -> MutexGuard<'_, Wished> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Driver for Hand {
    fn steer(&mut self, _state: &RobotState) -> Steer {
        self.steer_at(Instant::now())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wish_holds_until_the_page_falls_silent() {
        let (hand, began) = (Hand::default(), Instant::now());
        let rest = Steer::Drive(Vector3::zeros());
        assert_eq!(hand.steer_at(began), rest);
        let drive = wire::Drive {
            forward: 1.0,
            left: -0.5,
            turn: 0.25,
        };
        hand.hear(drive, began);
        let wished = Steer::Drive(Vector3::new(1.0, -0.5, 0.25));
        assert_eq!(hand.steer_at(began + LET_GO / 2), wished);
        assert_eq!(hand.steer_at(began + LET_GO), rest);
        hand.hear(drive, began + LET_GO);
        assert_eq!(hand.steer_at(began + LET_GO), wished);
        hand.clone().finish();
        assert_eq!(hand.steer_at(began + LET_GO), Steer::Done);
    }
}
