//! The pages' edits on their way to whoever keeps the home, and the answers on their way back.
//!
//! Edits are handed out in the order in which they arrive, whichever page they are of: that is the order in which they
//! are applied.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use factotum_protocol::{EDIT_ID_CHARS_MAX, EditAnswer, EditOutcome, EditRequest, ServerMessage};
use tokio::sync::mpsc;

use crate::audit::{Audit, Line};
use crate::connection::Client;

/// Edits that may wait. A home takes hundreds a second, so more than a few mean that its disk has gone.
const WAITING_MAX: usize = 256;

/// The waiting edits, in order. Clones share them: each edit is handed out once.
#[derive(Clone, Debug, Default)]
pub struct Edits {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<VecDeque<AskedEdit>>,
    arrived: Condvar,
}

/// An edit that a page asks for, to be answered.
#[derive(Debug)]
pub struct AskedEdit {
    request: EditRequest,
    asker: Asker,
}

/// The page that asks.
#[derive(Clone, Debug)]
pub(crate) struct Asker {
    pub(crate) client: Client,
    pub(crate) answers: mpsc::Sender<ServerMessage>,
    pub(crate) audit: Arc<Audit>,
}

impl AskedEdit {
    pub(crate) fn new(request: EditRequest, asker: Asker) -> Self {
        Self { request, asker }
    }

    /// What is asked for.
    #[must_use]
    pub fn request(&self) -> &EditRequest {
        &self.request
    }

    /// Tells the page that asked, and no other, what has become of its edit. What the edit made of the home is to be
    /// published before. A page that is gone hears nothing; it may ask again under the same id.
    pub fn answer(self, outcome: EditOutcome) {
        let Asker {
            client,
            answers,
            audit,
        } = self.asker;
        let line = Line::of_edit(&self.request.id, &self.request.edit, &outcome);
        audit.note(&line.of(&client.name, client.role));
        let answer = ServerMessage::EditAnswer(EditAnswer {
            id: self.request.id,
            outcome,
        });
        if answers.try_send(answer).is_err() {
            tracing::debug!("a page does not hear what became of its edit");
        }
    }
}

impl Edits {
    /// The next edit; waits for it at most for `timeout`.
    #[must_use]
    pub fn next_within(&self, timeout: Duration) -> Option<AskedEdit> {
        let waiting = self.lock();
        let (mut waiting, _) = self
            .shared
            .arrived
            .wait_timeout_while(waiting, timeout, |waiting| waiting.is_empty())
            .unwrap_or_else(PoisonError::into_inner);
        waiting.pop_front()
    }

    /// Lets an edit wait. One that nobody could apply is answered at once.
    pub(crate) fn push(&self, request: EditRequest, asker: Asker) {
        let asked = AskedEdit::new(request, asker);
        let reason = problem_of(&asked.request).or_else(|| {
            (self.lock().len() >= WAITING_MAX)
                .then(|| format!("{WAITING_MAX} edits wait already; the home does not take them"))
        });
        match reason {
            Some(reason) => asked.answer(EditOutcome::Refused { reason }),
            None => {
                self.lock().push_back(asked);
                self.shared.arrived.notify_one();
            }
        }
    }

    /// Nothing that holds this lock can panic half way, so a poisoned one is as good as new.
    fn lock(&self) -> MutexGuard<'_, VecDeque<AskedEdit>> {
        self.shared
            .waiting
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

fn problem_of(request: &EditRequest) -> Option<String> {
    let n_chars = request.id.chars().count();
    if !(1..=EDIT_ID_CHARS_MAX).contains(&n_chars) {
        return Some(format!(
            "the edit's id has {n_chars} characters, expected 1 to {EDIT_ID_CHARS_MAX}"
        ));
    }
    (!request.edit.is_finite())
        .then(|| "the edit holds a number that is not finite, expected finite ones".to_owned())
}

#[cfg(test)]
mod tests {
    use factotum_protocol::{Edit, Pose, Role};

    use super::*;

    fn request(id: &str, x: f64) -> EditRequest {
        EditRequest {
            id: id.to_owned(),
            base: None,
            edit: Edit::MoveObject {
                name: "bottle_1".to_owned(),
                pose: Pose::from_position_yaw([x, 0.0, 0.0], 0.0),
            },
        }
    }

    fn asker() -> (Asker, mpsc::Receiver<ServerMessage>) {
        let (answers, heard) = mpsc::channel(1);
        let asker = Asker {
            client: Client {
                name: "ana-1".to_owned(),
                role: Role::Teach,
            },
            answers,
            audit: Arc::new(Audit::new(None)),
        };
        (asker, heard)
    }

    fn refusal(answers: &mut mpsc::Receiver<ServerMessage>) -> Option<String> {
        match answers.try_recv() {
            Ok(ServerMessage::EditAnswer(EditAnswer {
                outcome: EditOutcome::Refused { reason },
                ..
            })) => Some(reason),
            _ => None,
        }
    }

    #[test]
    fn edits_come_out_in_order_and_once() {
        let edits = Edits::default();
        let (asker, _heard) = asker();
        for id in ["a", "b"] {
            edits.push(request(id, 0.0), asker.clone());
        }
        let next = |edits: &Edits| {
            let asked = edits.next_within(Duration::ZERO)?;
            Some(asked.request().id.clone())
        };
        assert_eq!(next(&edits.clone()), Some("a".to_owned()));
        assert_eq!(next(&edits), Some("b".to_owned()));
        assert_eq!(next(&edits), None);
    }

    #[test]
    fn what_nobody_could_apply_is_answered_at_once() {
        let edits = Edits::default();
        let (asker, mut heard) = asker();
        for (request, wanted) in [
            (request("", 0.0), "0 characters"),
            (request(&"x".repeat(65), 0.0), "65 characters"),
            (request("a", f64::NAN), "not finite"),
            (request("a", f64::INFINITY), "not finite"),
        ] {
            edits.push(request, asker.clone());
            let reason = refusal(&mut heard).unwrap();
            assert!(reason.contains(wanted), "{reason}");
        }
        assert!(edits.next_within(Duration::ZERO).is_none());
    }

    #[test]
    fn more_than_can_wait_are_refused() {
        let edits = Edits::default();
        let (asker, mut heard) = asker();
        for number in 0..WAITING_MAX {
            edits.push(request(&number.to_string(), 0.0), asker.clone());
        }
        assert_eq!(refusal(&mut heard), None);
        edits.push(request("one more", 0.0), asker);
        assert!(refusal(&mut heard).unwrap().contains("wait already"));
    }
}
