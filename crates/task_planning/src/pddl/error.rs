//! What is wrong with a PDDL text, and where.

use crate::operator::OperatorError;

/// A place in a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl std::fmt::Display for Position {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

/// Why a PDDL text was refused.
///
/// The context lists what was being read, innermost first.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PddlError {
    /// The text does not follow the grammar.
    #[error("{at}: expected {expected}, got {got}{}", stacked(context))]
    Syntax {
        /// Where.
        at: Position,
        /// What the grammar wants here.
        expected: String,
        /// What is there.
        got: String,
        /// What was being read.
        context: Vec<String>,
    },
    /// The text uses a part of PDDL that is not supported.
    #[error("{at}: {what} is not supported; {hint}{}", stacked(context))]
    Unsupported {
        /// Where.
        at: Position,
        /// The construct.
        what: String,
        /// What to write instead.
        hint: String,
        /// What was being read.
        context: Vec<String>,
    },
    /// The text is grammatical, and says something impossible.
    #[error("{at}: {source}{}", stacked(context))]
    Invalid {
        /// Where the faulty declaration begins.
        at: Position,
        /// What is wrong.
        source: Box<OperatorError>,
        /// What was being read.
        context: Vec<String>,
    },
}

impl PddlError {
    pub(super) fn syntax(
        at: Position,
        expected: impl Into<String>,
        got: impl Into<String>,
    ) -> Self {
        Self::Syntax {
            at,
            expected: expected.into(),
            got: got.into(),
            context: Vec::new(),
        }
    }

    pub(super) fn unsupported(
        at: Position,
        what: impl Into<String>,
        hint: impl Into<String>,
    ) -> Self {
        Self::Unsupported {
            at,
            what: what.into(),
            hint: hint.into(),
            context: Vec::new(),
        }
    }

    pub(super) fn invalid(at: Position, source: OperatorError) -> Self {
        Self::Invalid {
            at,
            source: Box::new(source),
            context: Vec::new(),
        }
    }

    /// Where the fault is.
    pub fn position(&self) -> Position {
        match self {
            Self::Syntax { at, .. } | Self::Unsupported { at, .. } | Self::Invalid { at, .. } => {
                *at
            }
        }
    }

    fn within(mut self, what: String) -> Self {
        match &mut self {
            Self::Syntax { context, .. }
            | Self::Unsupported { context, .. }
            | Self::Invalid { context, .. } => context.push(what),
        }
        self
    }
}

/// Adds what was being read to an error on its way out.
pub(super) trait Within {
    /// Pushes a line onto the error's context.
    fn within(self, what: impl FnOnce() -> String) -> Self;
}

impl<T> Within for Result<T, PddlError> {
    fn within(self, what: impl FnOnce() -> String) -> Self {
        self.map_err(|error| error.within(what()))
    }
}

fn stacked(context: &[String]) -> String {
    context
        .iter()
        .map(|line| format!("\n  while reading {line}"))
        .collect()
}
