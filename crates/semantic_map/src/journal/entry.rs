//! What a journal holds, as its readers see it.

use factotum_task_planning::operator::GroundAction;

use crate::home_folder;

/// An entry of a journal.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Number, rising from 1.
    pub id: i64,
    /// When, as the writer said: seconds since the epoch.
    pub when_secs: f64,
    /// Who or what made it, e.g. a person's name, `robot`, or `file` for a text file changed by hand.
    pub author: String,
    /// What it is.
    pub kind: EntryKind,
}

/// Who makes an entry, and the request by which it was asked for, if any.
#[derive(Debug, Clone, Copy)]
pub struct By<'a> {
    /// Who or what.
    pub author: &'a str,
    /// Remembered with the entry, in the same transaction.
    pub request: Option<Request<'a>>,
}

impl<'a> From<&'a str> for By<'a> {
    fn from(author: &'a str) -> Self {
        Self {
            author,
            request: None,
        }
    }
}

/// A request that may come again, as after a lost connection: whoever keeps the home looks it up with
/// [`Home::remembered`](crate::Home::remembered) before making it.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// Its name, which no other request has.
    pub id: &'a str,
    /// All that it says, to tell it from another of that name. See [`Remembered::is_of`].
    pub content: &'a [u8],
    /// What is answered, but for the number of the entry.
    pub answer: &'a str,
}

/// What became of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remembered {
    pub(super) digest: [u8; 32],
    /// Number of the entry that it made.
    pub entry: i64,
    /// What was answered.
    pub answer: String,
}

impl Remembered {
    /// Whether the request said this.
    pub fn is_of(&self, content: &[u8]) -> bool {
        self.digest == home_folder::digest(content)
    }
}

/// What an entry of a journal is.
#[derive(Debug, Clone, PartialEq)]
pub enum EntryKind {
    /// The home was made, or its folder was found without a journal.
    Created,
    /// The AOSM was changed.
    Edit {
        /// In a few words, e.g. `move bottle_1`.
        what: String,
    },
    /// An edit was undone.
    Undo {
        /// The edit's number.
        edit: i64,
        /// The edit, in a few words.
        what: String,
    },
    /// An edit that had been undone was done again.
    Redo {
        /// The edit's number.
        edit: i64,
        /// The edit, in a few words.
        what: String,
    },
    /// The robot executed a plan step. Undo skips it: the world does not go back.
    Execution(Execution),
}

impl std::fmt::Display for EntryKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Created => f.write_str("made"),
            Self::Edit { what } => f.write_str(what),
            Self::Undo { what, .. } => write!(f, "undo: {what}"),
            Self::Redo { what, .. } => write!(f, "redo: {what}"),
            Self::Execution(execution) => write!(f, "{}: {}", execution.step, execution.outcome),
        }
    }
}

/// An executed plan step.
#[derive(Debug, Clone, PartialEq)]
pub struct Execution {
    /// The step.
    pub step: GroundAction,
    /// How it ended, e.g. `done` or the reason of the failure.
    pub outcome: String,
    /// Time it took on the robot's clock, seconds.
    pub robot_secs: f64,
}

/// What an edit did to one document of the home.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// The document: a path in the home folder, or `objects/NAME` for an object's table of `objects.toml`.
    pub document: String,
    /// Its bytes before; none if it was not there.
    pub before: Option<Vec<u8>>,
    /// Its bytes after; none if it is not there.
    pub after: Option<Vec<u8>>,
}
