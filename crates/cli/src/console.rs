//! What goes to the terminal: one answer on standard output, messages on standard error.

use std::io::{ErrorKind, IsTerminal as _, Write as _};
use std::time::{Duration, SystemTime};

use anyhow::Context as _;
use factotum_experiments::utc::UtcTime;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// The answer of a command, as its exit code tells it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Answer {
    /// Done.
    Yes,
    /// Ran, with a negative answer.
    No,
}

impl From<bool> for Answer {
    fn from(is_yes: bool) -> Self {
        if is_yes { Self::Yes } else { Self::No }
    }
}

/// Bad input or usage: exit code 2.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct UsageError(pub(crate) String);

/// Marks an error as the user's to mend.
pub(crate) fn usage(error: impl std::fmt::Display) -> anyhow::Error {
    UsageError(error.to_string()).into()
}

/// The time of day. The one place where it is asked: everything below is told the time.
#[expect(
    clippy::disallowed_methods,
    reason = "names and manifests of folders carry the date"
)]
pub(crate) fn now() -> UtcTime {
    UtcTime::from(SystemTime::now())
}

/// The terminal, or what stands in for one.
#[derive(Debug)]
pub(crate) struct Console {
    is_json: bool,
    is_quiet: bool,
    bar: ProgressBar,
}

impl Console {
    pub(crate) fn new(is_json: bool, is_quiet: bool) -> Self {
        let is_plain = std::env::var_os("NO_COLOR").is_some()
            || std::env::var("TERM").is_ok_and(|term| term == "dumb");
        let bar = if is_quiet || is_plain || !std::io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            ProgressBar::new_spinner()
        };
        bar.set_style(
            ProgressStyle::with_template("{spinner} {elapsed} {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_spinner()),
        );
        Self {
            is_json,
            is_quiet,
            bar,
        }
    }

    /// What is going on right now; replaced by the next.
    pub(crate) fn progress(&self, text: impl Into<String>) {
        if !self.bar.is_hidden() {
            self.bar.enable_steady_tick(Duration::from_millis(120));
            self.bar.set_message(text.into());
        }
    }

    /// A message for people.
    pub(crate) fn say(&self, text: impl std::fmt::Display) {
        if !self.is_quiet {
            self.bar.suspend(|| tell(&text));
        }
    }

    /// An error with its causes.
    pub(crate) fn error(&self, error: &anyhow::Error) {
        self.bar.finish_and_clear();
        tell(&format_args!("error: {error:#}"));
    }

    /// The answer: as JSON with `--json`, else as `text`.
    pub(crate) fn answer<T: Serialize>(
        &self,
        json: &T,
        text: impl FnOnce() -> String,
    ) -> anyhow::Result<()> {
        self.bar.finish_and_clear();
        let answer = if self.is_json {
            serde_json::to_string_pretty(json)?
        } else {
            text().trim_end().to_owned()
        };
        match writeln!(std::io::stdout(), "{answer}") {
            // Whoever read it has heard enough, as `head` does.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            written => written.context("cannot write the answer to standard output"),
        }
    }
}

/// Writes a message to standard error; if nobody reads it, there is nobody to tell.
pub(crate) fn tell(text: &dyn std::fmt::Display) {
    writeln!(std::io::stderr(), "{text}").ok();
}
