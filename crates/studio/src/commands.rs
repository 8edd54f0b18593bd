//! The page's commands on their way to the job.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use factotum_protocol::ClientMessage;

/// Commands that may wait for the job. It looks many times a second, so more than a few mean that
/// it has gone.
const WAITING_MAX: usize = 64;

/// The waiting commands, in order. Clones share them: each command is handed out once.
///
/// A stop takes the place of every command before it, and is never refused. A velocity takes the place of those before
/// it: what a hand wished a moment ago is of no use.
#[derive(Clone, Debug, Default)]
pub struct Commands {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<VecDeque<ClientMessage>>,
    arrived: Condvar,
}

/// The command was not taken, since too many wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct QueueFull;

impl Commands {
    /// The next command, if one waits.
    #[must_use]
    pub fn try_next(&self) -> Option<ClientMessage> {
        self.lock().pop_front()
    }

    /// The next command; waits for it at most for `timeout`.
    #[must_use]
    pub fn next_within(&self, timeout: Duration) -> Option<ClientMessage> {
        let waiting = self.lock();
        let (mut waiting, _) = self
            .shared
            .arrived
            .wait_timeout_while(waiting, timeout, |waiting| waiting.is_empty())
            .unwrap_or_else(PoisonError::into_inner);
        waiting.pop_front()
    }

    pub(crate) fn push(&self, command: ClientMessage) -> Result<(), QueueFull> {
        let mut waiting = self.lock();
        if matches!(command, ClientMessage::Drive(_)) {
            waiting.retain(|other| !matches!(other, ClientMessage::Drive(_)));
        }
        if command == ClientMessage::Stop {
            waiting.clear();
        } else if waiting.len() >= WAITING_MAX {
            return Err(QueueFull);
        }
        waiting.push_back(command);
        drop(waiting);
        self.shared.arrived.notify_one();
        Ok(())
    }

    /// Nothing that holds this lock can panic half way, so a poisoned one is as good as new.
    fn lock(&self) -> MutexGuard<'_, VecDeque<ClientMessage>> {
        self.shared
            .waiting
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use factotum_protocol::Drive;

    use super::*;

    #[test]
    fn commands_come_out_in_order_and_once() {
        let commands = Commands::default();
        commands.push(ClientMessage::Pause).unwrap();
        commands.push(ClientMessage::Resume).unwrap();
        assert_eq!(commands.clone().try_next(), Some(ClientMessage::Pause));
        assert_eq!(commands.try_next(), Some(ClientMessage::Resume));
        assert_eq!(commands.try_next(), None);
    }

    #[test]
    fn a_full_queue_refuses_all_but_a_stop_which_empties_it() {
        let commands = Commands::default();
        for _ in 0..WAITING_MAX {
            commands.push(ClientMessage::Pause).unwrap();
        }
        assert_eq!(commands.push(ClientMessage::Resume), Err(QueueFull));
        assert_eq!(commands.push(ClientMessage::Stop), Ok(()));
        assert_eq!(commands.try_next(), Some(ClientMessage::Stop));
        assert_eq!(commands.try_next(), None);
    }

    #[test]
    fn of_velocities_only_the_latest_waits() {
        let ahead = |forward| {
            ClientMessage::Drive(Drive {
                forward,
                ..Drive::default()
            })
        };
        let commands = Commands::default();
        commands.push(ahead(0.1)).unwrap();
        commands.push(ClientMessage::Pause).unwrap();
        for hundredths in 0..=3 * WAITING_MAX {
            commands.push(ahead(hundredths as f64 / 200.0)).unwrap();
        }
        commands.push(ClientMessage::DriveDone).unwrap();
        assert_eq!(commands.try_next(), Some(ClientMessage::Pause));
        assert_eq!(commands.try_next(), Some(ahead(0.96)));
        assert_eq!(commands.try_next(), Some(ClientMessage::DriveDone));
        assert_eq!(commands.try_next(), None);
    }

    #[test]
    fn waiting_ends_with_the_timeout_or_the_command() {
        let commands = Commands::default();
        assert_eq!(commands.next_within(Duration::from_millis(1)), None);
        let sender = commands.clone();
        let thread = std::thread::Builder::new()
            .name("sender".to_owned())
            .spawn(move || sender.push(ClientMessage::Pause))
            .unwrap();
        assert_eq!(
            commands.next_within(Duration::from_secs(10)),
            Some(ClientMessage::Pause)
        );
        thread.join().unwrap().unwrap();
    }
}
