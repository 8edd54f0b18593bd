//! One page's connection.
//!
//! Two halves run side by side until either ends: one sends what is new in the picture, the other
//! takes commands. They wait for each other nowhere, so a page that reads slowly can still stop
//! the robot.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use factotum_protocol::{ClientMessage, EditOutcome, Event, EventLevel, Hello, ServerMessage};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use tokio::sync::mpsc;
use tokio::time::{Instant, timeout};

use crate::edits::AskedEdit;
use crate::picture::Frame;
use crate::server::Shared;

/// Shortest time between two looks at the picture: 60 a second is what a screen shows.
const SEND_PERIOD: Duration = Duration::from_millis(16);
/// A page that takes nothing for so long is gone.
const SEND_TIMEOUT: Duration = Duration::from_secs(20);
/// A page that is slow to hear that we leave will notice by itself.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(500);
/// A quiet connection is tried this often, so that one that broke is noticed.
const PING_PERIOD: Duration = Duration::from_secs(10);
/// Commands that a page may send in one [`COMMANDS_WINDOW`]: twice as many as one from which a robot is driven.
const COMMANDS_MAX: u32 = 40;
/// A page's command has some dozens of bytes, an edit some hundreds. What is larger is refused.
const COMMAND_BYTES_MAX: usize = 16 * 1024;
/// See [`COMMANDS_MAX`].
const COMMANDS_WINDOW: Duration = Duration::from_secs(2);
/// Answers to a page that may wait to be sent; more are dropped. As many as it may send commands.
const ANSWERS_MAX: usize = COMMANDS_MAX as usize;

/// Serves a page until it leaves, breaks a rule, or the studio shuts down.
pub(crate) async fn serve(socket: WebSocket, shared: &Shared) {
    let (sink, mut stream) = socket.split();
    let (answers, answers_to_send) = mpsc::channel(ANSWERS_MAX);
    let mut closing = shared.closing.subscribe();
    let mut sender = Sender { sink };
    let end = tokio::select! {
        end = sender.run(shared, answers_to_send) => end,
        end = receive(&mut stream, shared, answers) => end,
        _ = closing.wait_for(|closing| *closing) => End::Away,
    };
    sender.close(end).await;
    // A socket dropped with words of the page unread resets the connection, and the page may never
    // hear why it was closed: so they are read, and dropped, until the page has closed too.
    let rest = async { while let Some(Ok(_)) = stream.next().await {} };
    if timeout(CLOSE_TIMEOUT, rest).await.is_err() {
        tracing::debug!("page was slow to leave");
    }
}

/// How a connection ends.
#[derive(Clone, Copy, Debug)]
enum End {
    /// The page left or cannot be reached.
    Gone,
    /// The studio shuts down.
    Away,
    /// The page sent commands faster than any hand.
    TooFast,
    /// The page sent far more at once than any command has, or what is no message.
    Unreadable,
}

struct Sender {
    sink: SplitSink<WebSocket, Message>,
}

impl Sender {
    /// Greets, then sends whatever is new.
    async fn run(&mut self, shared: &Shared, mut answers: mpsc::Receiver<ServerMessage>) -> End {
        let hello = ServerMessage::Hello(Hello {
            version: factotum_protocol::VERSION,
            session: shared.session.clone(),
        });
        if self
            .send(Message::Text(Frame::new(hello).json()))
            .await
            .is_err()
        {
            return End::Gone;
        }
        let mut news = shared.picture.watch();
        // What was published before counts as news too.
        news.mark_changed();
        let mut revision = 0;
        loop {
            let frames: Vec<Arc<Frame>> = tokio::select! {
                changed = news.changed() => {
                    if changed.is_err() {
                        return End::Away;
                    }
                    let (latest, frames) = shared.picture.newer_than(revision);
                    revision = latest;
                    frames
                }
                Some(answer) = answers.recv() => {
                    // What was published before the answer is seen before it.
                    let (latest, mut frames) = shared.picture.newer_than(revision);
                    revision = latest;
                    frames.push(Arc::new(Frame::new(answer)));
                    frames
                }
                () = tokio::time::sleep(PING_PERIOD) => {
                    if self.send(Message::Ping(Default::default())).await.is_err() {
                        return End::Gone;
                    }
                    continue;
                }
            };
            let sent_at = Instant::now();
            for frame in frames {
                if self.send(Message::Text(frame.json())).await.is_err() {
                    return End::Gone;
                }
            }
            tokio::time::sleep_until(sent_at + SEND_PERIOD).await;
        }
    }

    async fn send(&mut self, message: Message) -> Result<(), ()> {
        match timeout(SEND_TIMEOUT, self.sink.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(()),
        }
    }

    async fn close(&mut self, end: End) {
        let frame = match end {
            End::Gone => None,
            End::Away => Some((close_code::AWAY, "factotum has ended")),
            End::TooFast => Some((close_code::POLICY, "too many commands")),
            End::Unreadable => Some((
                close_code::PROTOCOL,
                "a message is far too large or cannot be read",
            )),
        };
        let Some((code, reason)) = frame else { return };
        let message = Message::Close(Some(CloseFrame {
            code,
            reason: reason.into(),
        }));
        if timeout(CLOSE_TIMEOUT, self.sink.send(message))
            .await
            .is_err()
        {
            tracing::debug!("page was slow to take the close frame");
        }
    }
}

/// Takes commands; what cannot be taken is answered with an event for this page alone.
async fn receive(
    stream: &mut SplitStream<WebSocket>,
    shared: &Shared,
    answers: mpsc::Sender<ServerMessage>,
) -> End {
    let mut window_start = Instant::now();
    let mut n_commands = 0;
    while let Some(message) = stream.next().await {
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                tracing::warn!(%error, "message of a page cannot be read");
                return End::Unreadable;
            }
        };
        let problem = match message {
            Message::Text(text) => take(text.as_str(), shared, &answers).err(),
            Message::Binary(_) => Some("a binary message is not a command".to_owned()),
            Message::Close(_) => return End::Gone,
            Message::Ping(_) | Message::Pong(_) => None,
        };
        if window_start.elapsed() > COMMANDS_WINDOW {
            window_start = Instant::now();
            n_commands = 0;
        }
        n_commands += 1;
        if n_commands > COMMANDS_MAX {
            return End::TooFast;
        }
        if let Some(problem) = problem {
            tracing::warn!(problem, "command not taken");
            let answer = ServerMessage::Event(Event {
                level: EventLevel::Warning,
                text: problem,
                time_secs: 0.0,
            });
            if answers.try_send(answer).is_err() {
                tracing::debug!("page does not read its answers");
            }
        }
    }
    End::Gone
}

fn take(text: &str, shared: &Shared, answers: &mpsc::Sender<ServerMessage>) -> Result<(), String> {
    if text.len() > COMMAND_BYTES_MAX {
        return Err(format!(
            "a message of the page has {} bytes, expected at most {COMMAND_BYTES_MAX}",
            text.len()
        ));
    }
    let command: ClientMessage = serde_json::from_str(text)
        .map_err(|error| format!("a message of the page is not a command: {error}"))?;
    match command {
        ClientMessage::Drive(drive) => tracing::debug!(?drive, "velocity from a page"),
        ClientMessage::Edit(request) => {
            tracing::info!(?request, "edit from a page");
            match &shared.edits {
                Some(edits) => edits.push(*request, answers.clone()),
                None => AskedEdit::new(*request, answers.clone()).answer(EditOutcome::Refused {
                    reason:
                        "this page shows a robot at work; `factotum studio` shows a home to teach"
                            .to_owned(),
                }),
            }
            return Ok(());
        }
        _ => tracing::info!(?command, "command from a page"),
    }
    shared
        .commands
        .push(command)
        .map_err(|_full| "the command was not taken: the robot does not answer".to_owned())
}
