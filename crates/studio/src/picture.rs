//! The picture: what a page must know to show everything, each message once.
//!
//! Every message put into the picture gets the next revision number and replaces the one that it
//! overtakes. A reader that has seen revision r asks for all that is newer than r.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use axum::extract::ws::Utf8Bytes;
use factotum_protocol::{SceneSource, ServerMessage};
use tokio::sync::watch;

/// A message, rendered as JSON when it is first sent and never again.
#[derive(Debug)]
pub(crate) struct Frame {
    message: ServerMessage,
    json: OnceLock<Utf8Bytes>,
}

impl Frame {
    pub(crate) fn new(message: ServerMessage) -> Self {
        Self {
            message,
            json: OnceLock::new(),
        }
    }

    /// The message as JSON. Rendering cannot fail for the types of the protocol (no maps with
    /// other keys than strings); if it did, the frame would be empty and a page would ignore it.
    pub(crate) fn json(&self) -> Utf8Bytes {
        self.json
            .get_or_init(|| match serde_json::to_string(&self.message) {
                Ok(text) => text.into(),
                Err(error) => {
                    tracing::error!(%error, "message cannot be rendered");
                    Utf8Bytes::default()
                }
            })
            .clone()
    }
}

/// What a message overtakes: the message in the same slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Slot {
    Scene(SceneSource),
    State,
    Map,
    Aosm,
    Plan,
    BasePath,
    Status,
    Control,
    Done,
    Trainings,
    Teaching,
}

#[derive(Debug, Default)]
struct Content {
    revision: u64,
    latest: BTreeMap<Slot, (u64, Arc<Frame>)>,
    events: VecDeque<(u64, Arc<Frame>)>,
}

/// The picture, shared by the one who publishes and all connections.
#[derive(Debug)]
pub(crate) struct Picture {
    content: Mutex<Content>,
    revision: watch::Sender<u64>,
    events_max: usize,
}

impl Picture {
    /// An empty picture that keeps the last `events_max` events.
    pub(crate) fn new(events_max: usize) -> Self {
        Self {
            content: Mutex::default(),
            revision: watch::Sender::new(0),
            events_max,
        }
    }

    /// Puts a message in. Says why not when it is not one that belongs here.
    pub(crate) fn put(&self, message: ServerMessage) -> Result<(), &'static str> {
        let slot = match &message {
            ServerMessage::Hello(_) => return Err("the studio greets by itself"),
            ServerMessage::EditAnswer(_) => return Err("an answer is for one page alone"),
            ServerMessage::State(state) if !state.is_finite() => {
                return Err("state with a number that is not finite");
            }
            ServerMessage::Scene(scene) => Some(Slot::Scene(scene.source)),
            ServerMessage::State(_) => Some(Slot::State),
            ServerMessage::Map(_) => Some(Slot::Map),
            ServerMessage::Aosm(_) => Some(Slot::Aosm),
            ServerMessage::Plan(_) => Some(Slot::Plan),
            ServerMessage::BasePath(_) => Some(Slot::BasePath),
            ServerMessage::Status(_) => Some(Slot::Status),
            ServerMessage::Control(_) => Some(Slot::Control),
            ServerMessage::Done(_) => Some(Slot::Done),
            ServerMessage::Trainings(_) => Some(Slot::Trainings),
            ServerMessage::Teaching(_) => Some(Slot::Teaching),
            ServerMessage::Event(_) => None,
        };
        let frame = Arc::new(Frame::new(message));
        let revision = {
            let mut content = self.lock();
            content.revision += 1;
            let revision = content.revision;
            if let Some(slot) = slot {
                content.latest.insert(slot, (revision, frame));
            } else {
                content.events.push_back((revision, frame));
                while content.events.len() > self.events_max {
                    content.events.pop_front();
                }
            }
            revision
        };
        // Two publishers may come here in the other order: the number never goes back.
        self.revision.send_if_modified(|seen| {
            let newer = revision > *seen;
            *seen = revision.max(*seen);
            newer
        });
        Ok(())
    }

    /// All messages newer than `revision`, oldest first, and the revision they lead to.
    pub(crate) fn newer_than(&self, revision: u64) -> (u64, Vec<Arc<Frame>>) {
        let content = self.lock();
        let mut newer: Vec<(u64, Arc<Frame>)> = content
            .latest
            .values()
            .chain(&content.events)
            .filter(|(at, _)| *at > revision)
            .cloned()
            .collect();
        let latest = content.revision;
        drop(content);
        newer.sort_unstable_by_key(|(at, _)| *at);
        (latest, newer.into_iter().map(|(_, frame)| frame).collect())
    }

    /// Is told whenever there is something newer.
    pub(crate) fn watch(&self) -> watch::Receiver<u64> {
        self.revision.subscribe()
    }

    /// Nothing that holds this lock can panic half way, so a poisoned one is as good as new.
    fn lock(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use factotum_protocol::{BasePath, Event, EventLevel, PosePlanar, Scene, State};

    use super::*;

    fn event(text: &str) -> ServerMessage {
        ServerMessage::Event(Event {
            level: EventLevel::Info,
            text: text.to_owned(),
            time_secs: 0.0,
        })
    }

    fn state(time_secs: f64) -> ServerMessage {
        ServerMessage::State(State {
            time_secs,
            sim_speed: 1.0,
            base: PosePlanar {
                x: 0.0,
                y: 0.0,
                yaw: 0.0,
            },
            body_poses: Vec::new(),
            joints: Vec::new(),
        })
    }

    fn scene(source: SceneSource) -> ServerMessage {
        ServerMessage::Scene(Scene {
            source,
            bodies: Vec::new(),
        })
    }

    fn messages(picture: &Picture, revision: u64) -> Vec<ServerMessage> {
        let (_, frames) = picture.newer_than(revision);
        frames.iter().map(|frame| frame.message.clone()).collect()
    }

    #[test]
    fn a_message_overtakes_the_one_in_its_slot_only() {
        let picture = Picture::new(10);
        for message in [
            scene(SceneSource::Home),
            scene(SceneSource::Robot),
            state(1.0),
            event("first"),
            state(2.0),
            scene(SceneSource::Home),
        ] {
            picture.put(message).unwrap();
        }
        let expected = [
            scene(SceneSource::Robot),
            event("first"),
            state(2.0),
            scene(SceneSource::Home),
        ];
        assert_eq!(messages(&picture, 0), expected);
        assert_eq!(messages(&picture, 4), expected[2..]);
        assert_eq!(messages(&picture, 6), []);
    }

    #[test]
    fn only_the_last_events_are_kept() {
        let picture = Picture::new(2);
        for text in ["a", "b", "c"] {
            picture.put(event(text)).unwrap();
        }
        assert_eq!(messages(&picture, 0), [event("b"), event("c")]);
    }

    #[test]
    fn what_is_not_finite_or_not_ours_stays_out() {
        let picture = Picture::new(2);
        assert!(picture.put(state(f64::NAN)).is_err());
        let hello = factotum_protocol::Hello {
            version: 0,
            session: String::new(),
            client: String::new(),
            role: factotum_protocol::Role::View,
        };
        assert!(picture.put(ServerMessage::Hello(hello)).is_err());
        assert_eq!(messages(&picture, 0), []);
    }

    #[test]
    fn a_frame_is_rendered_once() {
        let frame = Frame::new(ServerMessage::BasePath(BasePath {
            points: vec![[0.5, 1.0]],
        }));
        assert_eq!(
            frame.json().as_str(),
            r#"{"type":"base_path","points":[[0.5,1.0]]}"#
        );
        assert_eq!(
            frame.json().as_str().as_ptr(),
            frame.json().as_str().as_ptr()
        );
    }
}
