//! Who has the robot: one page at a time, so that no two hands pull at it.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A page that has the robot and has commanded nothing for so long gives it up to one that does.
const LAPSE: Duration = Duration::from_secs(10);

/// The page that has the robot. The first that commands it has it, until it leaves or says nothing for [`LAPSE`] while
/// another commands.
#[derive(Debug, Default)]
pub(crate) struct Ownership {
    owner: Mutex<Option<Owner>>,
}

#[derive(Debug)]
struct Owner {
    client: String,
    heard: Instant,
}

impl Ownership {
    /// Gives a page the robot, if no other has it. Whether it did not have it before.
    pub(crate) fn take(&self, client: &str, now: Instant) -> Result<bool, String> {
        let mut owner = self.lock();
        let is_new = match owner.as_ref() {
            Some(other) if other.client != client => {
                let silent = now.saturating_duration_since(other.heard);
                if silent < LAPSE {
                    return Err(format!(
                        "page {} has the robot: it can be taken over when that page has left, or has commanded nothing \
                         for {} s; pause and stop work at any time",
                        other.client,
                        LAPSE.as_secs()
                    ));
                }
                true
            }
            Some(_) => false,
            None => true,
        };
        *owner = Some(Owner {
            client: client.to_owned(),
            heard: now,
        });
        Ok(is_new)
    }

    /// The page is gone. Whether it had the robot.
    pub(crate) fn leave(&self, client: &str) -> bool {
        let mut owner = self.lock();
        let had = owner.as_ref().is_some_and(|owner| owner.client == client);
        if had {
            *owner = None;
        }
        had
    }

    /// Nothing that holds this lock can panic half way, so a poisoned one is as good as new.
    fn lock(&self) -> MutexGuard<'_, Option<Owner>> {
        self.owner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_page_has_the_robot_until_it_leaves_or_falls_silent() {
        let (ownership, now) = (Ownership::default(), Instant::now());
        assert_eq!(ownership.take("ana", now), Ok(true));
        assert_eq!(ownership.take("ana", now + LAPSE / 2), Ok(false));
        let refused = ownership.take("ben", now + LAPSE).unwrap_err();
        assert!(refused.contains("page ana has the robot"), "{refused}");
        assert!(!ownership.leave("ben"));
        assert_eq!(ownership.take("ben", now + LAPSE / 2 + LAPSE), Ok(true));
        assert!(ownership.take("ana", now + 2 * LAPSE).is_err());
        assert!(!ownership.leave("ana"));
        assert!(ownership.leave("ben"));
        assert_eq!(ownership.take("ana", now + 2 * LAPSE), Ok(true));
    }
}
