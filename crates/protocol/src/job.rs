//! The job as a whole: what it is at, what happened, how it ended.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

/// What the robot is at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Status {
    /// The goal, in words.
    pub goal: String,
    /// What is being done for it.
    pub activity: Activity,
    /// Whether the job waits for a `resume`.
    pub paused: bool,
    /// Whether a person drives: the job takes `drive` and `drive_done`.
    pub takes_driving: bool,
}

/// Phase of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum Activity {
    /// Models are being loaded.
    Starting,
    /// The robot looks around and builds its map.
    Exploring,
    /// It looks for a plan.
    Planning,
    /// It carries out the plan.
    Acting,
    /// A person stopped the job; it takes no more commands.
    Stopped,
    /// The job is over, see [`Done`].
    Finished,
}

/// Something that happened, for people to read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// How much it matters.
    pub level: EventLevel,
    /// One sentence.
    pub text: String,
    /// Simulated time at which it happened, in seconds.
    pub time_secs: f64,
}

/// How much an event matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum EventLevel {
    /// Good to know.
    Info,
    /// Something did not go as expected, and the job goes on.
    Warning,
    /// Something failed.
    Error,
}

/// The job is over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Done {
    /// The judge's word on whether the goal is achieved.
    pub achieved: bool,
    /// What was done, and why not when it was not: a sentence or two.
    pub summary: String,
}
