//! One page's connection.
//!
//! Two halves run side by side until either ends: one sends what is new in the picture, the other
//! takes commands. They wait for each other nowhere, so a page that reads slowly can still stop
//! the robot.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use factotum_protocol::{
    ClientMessage, Control, Drive, EDIT_ID_CHARS_MAX, EditAnswer, EditOutcome, EditRequest, Event,
    EventLevel, Hello, Role, ServerMessage,
};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use tokio::sync::mpsc;
use tokio::time::{Instant, timeout, timeout_at};

use crate::access::Visitor;
use crate::audit::{Kind, Line};
use crate::edits::{AskedEdit, Asker};
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

/// A page that drives says so ten times a second. One that has not for so long has let go, or is gone: the robot comes to
/// rest.
const HEARTBEAT: Duration = Duration::from_secs(1);

/// A page, by its connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Client {
    pub(crate) name: String,
    pub(crate) role: Role,
}

/// Serves a page until it leaves, breaks a rule, or the studio shuts down.
pub(crate) async fn serve(socket: WebSocket, shared: &Shared, visitor: Visitor) {
    let (sink, mut stream) = socket.split();
    let (answers, answers_to_send) = mpsc::channel(ANSWERS_MAX);
    let mut closing = shared.closing.subscribe();
    let client = Client {
        name: shared.client_name(&visitor.name),
        role: visitor.role,
    };
    let mut sender = Sender { sink };
    let mut receiver = Receiver {
        shared,
        asker: Asker {
            client: client.clone(),
            answers,
            audit: Arc::clone(&shared.audit),
        },
        driving_until: None,
    };
    let end = tokio::select! {
        end = sender.run(shared, client, answers_to_send) => end,
        end = receiver.run(&mut stream) => end,
        _ = closing.wait_for(|closing| *closing) => End::Away,
    };
    receiver.leave();
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
    async fn run(
        &mut self,
        shared: &Shared,
        client: Client,
        mut answers: mpsc::Receiver<ServerMessage>,
    ) -> End {
        let hello = ServerMessage::Hello(Hello {
            version: factotum_protocol::VERSION,
            session: shared.session.clone(),
            client: client.name,
            role: client.role,
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
struct Receiver<'a> {
    shared: &'a Shared,
    asker: Asker,
    /// While the page drives: when it counts as silent.
    driving_until: Option<Instant>,
}

impl Receiver<'_> {
    async fn run(&mut self, stream: &mut SplitStream<WebSocket>) -> End {
        let mut window_start = Instant::now();
        let mut n_commands = 0;
        loop {
            let next = match self.driving_until {
                None => stream.next().await,
                Some(until) => match timeout_at(until, stream.next()).await {
                    Ok(next) => next,
                    Err(_) => {
                        self.bring_to_rest("the page that drives has fallen silent");
                        continue;
                    }
                },
            };
            let problem = match next {
                Some(Ok(Message::Text(text))) => self.take(text.as_str()).err(),
                Some(Ok(Message::Binary(_))) => {
                    Some("a binary message is not a command".to_owned())
                }
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => None,
                Some(Ok(Message::Close(_))) | None => return End::Gone,
                Some(Err(error)) => {
                    tracing::warn!(%error, "message of a page cannot be read");
                    return End::Unreadable;
                }
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
                self.complain(problem);
            }
        }
    }

    fn complain(&self, problem: String) {
        tracing::warn!(problem, "command not taken");
        self.note(Kind::Refusal, &problem);
        if self.asker.answers.try_send(warning(problem)).is_err() {
            tracing::debug!("page does not read its answers");
        }
    }

    fn note(&self, kind: Kind, what: &str) {
        let Client { name, role } = &self.asker.client;
        self.shared
            .audit
            .note(&Line::new(kind, what).of(name, *role));
    }

    fn take(&mut self, text: &str) -> Result<(), String> {
        if text.len() > COMMAND_BYTES_MAX {
            return Err(format!(
                "a message of the page has {} bytes, expected at most {COMMAND_BYTES_MAX}",
                text.len()
            ));
        }
        let command: ClientMessage = match serde_json::from_str(text) {
            Ok(command) => command,
            Err(error) => {
                let Some((id, what)) = edit_meant(text) else {
                    return Err(format!("a message of the page is not a command: {error}"));
                };
                self.refuse_unread(id, format!("{what} cannot be read: {error}"));
                return Ok(());
            }
        };
        let wanted = command.role_needed();
        let role = self.asker.client.role;
        let is_allowed = role >= wanted;
        let too_little = || {
            format!(
                "this page was opened to {}; it takes a link to {} for that, which the terminal shows",
                role.name(),
                wanted.name()
            )
        };
        match command {
            ClientMessage::Edit(request) if is_allowed => self.ask(*request),
            ClientMessage::Edit(request) => {
                let reason = too_little();
                AskedEdit::new(*request, self.asker.clone())
                    .answer(EditOutcome::Refused { reason });
            }
            _ if !is_allowed => return Err(too_little()),
            ClientMessage::Drive(drive) => self.drive(drive)?,
            ClientMessage::Stop | ClientMessage::Pause => self.command(command)?,
            ClientMessage::Resume | ClientMessage::DriveDone => {
                self.own()?;
                self.command(command)?;
            }
        }
        Ok(())
    }

    /// An edit that cannot be read is answered as an edit, since its page waits for that.
    fn refuse_unread(&self, id: String, reason: String) {
        tracing::warn!(reason, "edit not taken");
        self.note(Kind::Refusal, &reason);
        let answer = ServerMessage::EditAnswer(EditAnswer {
            id,
            outcome: EditOutcome::Refused { reason },
        });
        if self.asker.answers.try_send(answer).is_err() {
            tracing::debug!("page does not read its answers");
        }
    }

    fn ask(&self, request: EditRequest) {
        tracing::info!(?request, "edit from a page");
        match &self.shared.edits {
            Some(edits) => edits.push(request, self.asker.clone()),
            None => {
                let reason =
                    "this page shows a robot at work; `factotum studio` shows a home to teach"
                        .to_owned();
                AskedEdit::new(request, self.asker.clone()).answer(EditOutcome::Refused { reason });
            }
        }
    }

    /// Makes sure that this page, and no other, has the robot.
    fn own(&self) -> Result<(), String> {
        let name = &self.asker.client.name;
        let now = std::time::Instant::now();
        if self.shared.ownership.take(name, now)? {
            self.show_owner(Some(name.clone()));
        }
        Ok(())
    }

    fn drive(&mut self, drive: Drive) -> Result<(), String> {
        self.own()?;
        let is_moving = drive != Drive::default();
        self.push(ClientMessage::Drive(drive))?;
        // Ten lines a second would say no more than the first and the last.
        if is_moving != self.driving_until.is_some() {
            let what = if is_moving { "drive" } else { "drive: let go" };
            self.note(Kind::Command, what);
        }
        self.driving_until = is_moving.then(|| Instant::now() + HEARTBEAT);
        Ok(())
    }

    fn command(&self, command: ClientMessage) -> Result<(), String> {
        tracing::info!(?command, "command from a page");
        let what = match &command {
            ClientMessage::Pause => "pause",
            ClientMessage::Resume => "resume",
            ClientMessage::Stop => "stop",
            ClientMessage::DriveDone => "drive done",
            ClientMessage::Drive(_) | ClientMessage::Edit(_) => "",
        };
        self.push(command)?;
        self.note(Kind::Command, what);
        Ok(())
    }

    fn push(&self, command: ClientMessage) -> Result<(), String> {
        self.shared
            .commands
            .push(command)
            .map_err(|_full| "the command was not taken: the robot does not answer".to_owned())
    }

    /// Nobody's hand is on the robot any more.
    fn bring_to_rest(&mut self, why: &str) {
        self.driving_until = None;
        if self.push(ClientMessage::Drive(Drive::default())).is_err() {
            tracing::warn!("the robot does not answer");
        }
        self.note(Kind::Command, why);
        self.show(warning(format!("{why}: the robot comes to rest")));
    }

    fn leave(&mut self) {
        if self.driving_until.is_some() {
            self.bring_to_rest("the page that drives is gone");
        }
        if self.shared.ownership.leave(&self.asker.client.name) {
            self.show_owner(None);
        }
    }

    fn show_owner(&self, owner: Option<String>) {
        self.show(ServerMessage::Control(Control { owner }));
    }

    fn show(&self, message: ServerMessage) {
        if let Err(reason) = self.shared.picture.put(message) {
            tracing::warn!(reason, "message not published");
        }
    }
}

/// Id and words of what was meant to be an edit, as far as it can be read.
fn edit_meant(text: &str) -> Option<(String, String)> {
    let value: serde_json::Value = serde_json::from_str(text).ok()?;
    let text_of = |value: &serde_json::Value| value.as_str().map(str::to_owned);
    if value.get("type")? != "edit" {
        return None;
    }
    let id = text_of(value.get("id")?).filter(|id| id.chars().count() <= EDIT_ID_CHARS_MAX)?;
    let edit = value.get("edit");
    let word = |key| edit.and_then(|edit| text_of(edit.get(key)?));
    let kind = word("kind").map_or_else(|| "the edit".to_owned(), |kind| format!("edit `{kind}`"));
    let thing = word("name").or_else(|| word("class"));
    let what = thing.map_or_else(|| kind.clone(), |thing| format!("{kind} of `{thing}`"));
    Some((id, what))
}

fn warning(text: String) -> ServerMessage {
    ServerMessage::Event(Event {
        level: EventLevel::Warning,
        text,
        time_secs: 0.0,
    })
}
