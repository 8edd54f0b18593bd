//! The two directions of the wire.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

use crate::{
    Aosm, BasePath, Control, Done, Drive, EditAnswer, EditRequest, Event, OccupancyMap, Plan, Role,
    Scene, State, Status, Teaching, Trainings,
};

/// From studio to page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ServerMessage {
    /// First message of every connection. The whole picture follows, so what the page showed
    /// before is forgotten.
    Hello(Hello),
    /// Bodies to draw.
    Scene(Scene),
    /// Where they are now.
    State(State),
    /// The occupancy grid.
    Map(OccupancyMap),
    /// Objects and navigation regions.
    Aosm(Aosm),
    /// The plan.
    Plan(Plan),
    /// Where the base is about to drive.
    BasePath(BasePath),
    /// What the robot is at.
    Status(Status),
    /// Whose commands it follows.
    Control(Control),
    /// Something happened.
    Event(Event),
    /// The job is over.
    Done(Done),
    /// Skills that are being learned, or were.
    Trainings(Trainings),
    /// The home as it can be taught.
    Teaching(Teaching),
    /// What became of an edit of this page.
    EditAnswer(EditAnswer),
}

/// Who is speaking.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Hello {
    /// The sender's [`VERSION`](crate::VERSION).
    pub version: u32,
    /// Random name of this run of the studio: a page that comes back to another one knows it.
    pub session: String,
    /// Name of this connection, as in [`Control::owner`].
    pub client: String,
    /// What the page may do.
    pub role: Role,
}

/// From page to studio.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ClientMessage {
    /// Hold still until [`Resume`](Self::Resume).
    Pause,
    /// Go on after a pause.
    Resume,
    /// Stop the job for good. Overrides every command that still waits.
    Stop,
    /// Drive the base. Sent over and over while a person's hand is on it, at most ten times a second; a page that falls
    /// silent lets the robot come to rest.
    Drive(Drive),
    /// The person has driven enough: the job ends, and keeps what it has.
    DriveDone,
    /// Change the home. Answered by an [`EditAnswer`].
    Edit(Box<EditRequest>),
}

impl ClientMessage {
    /// The least role that may send it. A stop is for everybody.
    #[must_use]
    pub fn role_needed(&self) -> Role {
        match self {
            Self::Stop => Role::View,
            Self::Edit(_) => Role::Teach,
            Self::Pause | Self::Resume | Self::Drive(_) | Self::DriveDone => Role::Execute,
        }
    }
}
