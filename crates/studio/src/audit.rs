//! Who did what: a line of JSON for each pairing, command, edit and refusal, in files that do not grow for ever.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use factotum_protocol::{Edit, EditOutcome, Role};
use serde::Serialize;

/// A file that has grown beyond this is put aside.
const FILE_BYTES_MAX: u64 = 1 << 20;
/// Files that were put aside and are kept.
const OLD_FILES_MAX: u32 = 4;
/// Refusals that are written in one [`REFUSALS_WINDOW`], so that nobody can push the rest out by being refused.
const REFUSALS_MAX: u32 = 60;
/// See [`REFUSALS_MAX`].
const REFUSALS_WINDOW: Duration = Duration::from_secs(60);

/// Time since the epoch by the machine's clock; none before it.
#[expect(
    clippy::disallowed_methods,
    reason = "who did what when, and how old a certificate is, are of this world's time"
)]
pub(crate) fn since_epoch() -> Duration {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default()
}

/// What a line is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Kind {
    /// A browser was let in.
    Pairing,
    /// A command was taken.
    Command,
    /// An edit was accepted.
    Edit,
    /// A request, a command or an edit was not.
    Refusal,
}

/// A line of the log.
#[derive(Debug, Serialize)]
pub(crate) struct Line<'a> {
    kind: Kind,
    /// What the page may do; none for one that was not let in.
    #[serde(skip_serializing_if = "Option::is_none")]
    role: Option<Role>,
    /// The page, or the browser that was let in.
    #[serde(skip_serializing_if = "str::is_empty")]
    client: &'a str,
    /// Where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    peer: Option<IpAddr>,
    /// The command, or why something was refused.
    #[serde(skip_serializing_if = "str::is_empty")]
    what: &'a str,
    /// Id of an edit.
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    edit: Option<&'a Edit>,
    #[serde(skip_serializing_if = "Option::is_none")]
    outcome: Option<&'a EditOutcome>,
}

impl<'a> Line<'a> {
    pub(crate) fn new(kind: Kind, what: &'a str) -> Self {
        Self {
            kind,
            role: None,
            client: "",
            peer: None,
            what,
            id: None,
            edit: None,
            outcome: None,
        }
    }

    pub(crate) fn of(self, client: &'a str, role: Role) -> Self {
        Self {
            role: Some(role),
            client,
            ..self
        }
    }

    pub(crate) fn from(self, peer: IpAddr) -> Self {
        Self {
            peer: Some(peer),
            ..self
        }
    }

    /// For what became of an edit.
    pub(crate) fn of_edit(id: &'a str, edit: &'a Edit, outcome: &'a EditOutcome) -> Self {
        let kind = match outcome {
            EditOutcome::Accepted { .. } => Kind::Edit,
            EditOutcome::Refused { .. } => Kind::Refusal,
        };
        Self {
            id: Some(id),
            edit: Some(edit),
            outcome: Some(outcome),
            ..Self::new(kind, "")
        }
    }
}

#[derive(Serialize)]
struct Dated<'a> {
    /// Seconds since the epoch, to the millisecond.
    unix_secs: f64,
    #[serde(flatten)]
    line: &'a Line<'a>,
    /// Refusals before this line that were not written.
    #[serde(skip_serializing_if = "is_zero")]
    refusals_left_out: u32,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
fn is_zero(number: &u32) -> bool {
    *number == 0
}

/// The log of one studio; a studio without a file keeps none.
#[derive(Debug)]
pub(crate) struct Audit {
    log: Option<Mutex<Log>>,
}

#[derive(Debug)]
struct Log {
    path: PathBuf,
    file: Option<File>,
    n_bytes: u64,
    is_in_trouble: bool,
    window_start: Instant,
    n_refusals: u32,
    left_out: u32,
}

impl Audit {
    /// Goes on with the log in a file, if one is given.
    pub(crate) fn new(path: Option<PathBuf>) -> Self {
        let log = |path| {
            Mutex::new(Log {
                path,
                file: None,
                n_bytes: 0,
                is_in_trouble: false,
                window_start: Instant::now(),
                n_refusals: 0,
                left_out: 0,
            })
        };
        Self { log: path.map(log) }
    }

    /// Writes a line. What goes wrong in writing stops nothing; it is said once.
    pub(crate) fn note(&self, line: &Line<'_>) {
        let Some(log) = &self.log else { return };
        let mut log = log.lock().unwrap_or_else(PoisonError::into_inner);
        if !log.has_room_for(line, Instant::now()) {
            return;
        }
        let result = log.write(line, since_epoch());
        if let Err(error) = &result
            && !log.is_in_trouble
        {
            tracing::warn!(path = %log.path.display(), %error, "who does what cannot be written down");
        }
        log.is_in_trouble = result.is_err();
    }
}

impl Log {
    fn has_room_for(&mut self, line: &Line<'_>, now: Instant) -> bool {
        if line.kind != Kind::Refusal {
            return true;
        }
        if now.saturating_duration_since(self.window_start) > REFUSALS_WINDOW {
            (self.window_start, self.n_refusals) = (now, 0);
        }
        self.n_refusals += 1;
        let has_room = self.n_refusals <= REFUSALS_MAX;
        self.left_out += u32::from(!has_room);
        has_room
    }

    fn write(&mut self, line: &Line<'_>, since: Duration) -> std::io::Result<()> {
        let dated = Dated {
            unix_secs: since.as_millis() as f64 / 1000.0,
            line,
            refusals_left_out: self.left_out,
        };
        let mut text = serde_json::to_string(&dated)?;
        text.push('\n');
        let mut file = match self.file.take() {
            Some(file) => file,
            None => self.open()?,
        };
        if self.n_bytes > 0 && self.n_bytes + text.len() as u64 > FILE_BYTES_MAX {
            drop(file);
            self.put_aside()?;
            file = self.open()?;
        }
        // One call, so that a line is whole or not there.
        file.write_all(text.as_bytes())?;
        self.n_bytes += text.len() as u64;
        self.file = Some(file);
        self.left_out = 0;
        Ok(())
    }

    fn open(&mut self) -> std::io::Result<File> {
        let mut options = OpenOptions::new();
        options.create(true).append(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let mut file = options.open(&self.path)?;
        self.n_bytes = file.metadata()?.len();
        if self.n_bytes > 0 && !ends_with_newline(&self.path)? {
            // A crash or a full disk has cut the last line short.
            file.write_all(b"\n")?;
            self.n_bytes += 1;
        }
        Ok(file)
    }

    /// Gives the file the number 1, and each older one the next; the oldest goes.
    fn put_aside(&self) -> std::io::Result<()> {
        for number in (1..OLD_FILES_MAX).rev() {
            rename_if_there(&aside(&self.path, number), &aside(&self.path, number + 1))?;
        }
        rename_if_there(&self.path, &aside(&self.path, 1))
    }
}

/// `audit.jsonl` put aside as number 2 is `audit.2.jsonl`.
fn aside(path: &Path, number: u32) -> PathBuf {
    path.with_extension(format!("{number}.jsonl"))
}

fn rename_if_there(from: &Path, to: &Path) -> std::io::Result<()> {
    match std::fs::rename(from, to) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

fn ends_with_newline(path: &Path) -> std::io::Result<bool> {
    use std::io::{Read as _, Seek as _, SeekFrom};
    let mut file = File::open(path)?;
    file.seek(SeekFrom::End(-1))?;
    let mut last = [0];
    file.read_exact(&mut last)?;
    Ok(last == *b"\n")
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    fn lines(path: &Path) -> Vec<Value> {
        let text = std::fs::read_to_string(path).unwrap();
        text.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }

    #[test]
    fn a_line_says_when_who_and_what() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("audit.jsonl");
        let audit = Audit::new(Some(path.clone()));
        audit.note(
            &Line::new(Kind::Pairing, "")
                .of("3f2a9c", Role::Teach)
                .from(IpAddr::from([10, 0, 0, 7])),
        );
        let outcome = EditOutcome::Accepted {
            entry: Some(8),
            what: "bottle_1".to_owned(),
        };
        audit.note(&Line::of_edit("5eed", &Edit::Undo, &outcome).of("3f2a9c-1", Role::Teach));
        let found = lines(&path);
        assert!(found[0]["unix_secs"].as_f64().unwrap() > 1.7e9);
        assert_eq!(found[0]["kind"], "pairing");
        assert_eq!(found[0]["peer"], "10.0.0.7");
        assert_eq!(found[1]["role"], "teach");
        assert_eq!(found[1]["client"], "3f2a9c-1");
        assert_eq!(found[1]["id"], "5eed");
        assert_eq!(found[1]["edit"]["kind"], "undo");
        assert_eq!(found[1]["outcome"]["entry"], 8);
    }

    #[test]
    fn files_are_put_aside_and_the_oldest_goes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("audit.jsonl");
        let long = "x".repeat(100_000);
        let mut n_written = 0;
        // Two runs: the second goes on where the first ended.
        for _ in 0..2 {
            let audit = Audit::new(Some(path.clone()));
            for _ in 0..40 {
                audit.note(&Line::new(Kind::Command, &long));
                n_written += 1;
            }
        }
        let mut names: Vec<_> = std::fs::read_dir(dir.path())
            .unwrap()
            .map(|entry| entry.unwrap())
            .collect();
        names.sort_by_key(std::fs::DirEntry::file_name);
        assert_eq!(names.len() as u32, 1 + OLD_FILES_MAX);
        let mut n_kept = 0;
        for entry in names {
            assert!(entry.metadata().unwrap().len() <= FILE_BYTES_MAX);
            n_kept += lines(&entry.path()).len();
        }
        assert!((40..n_written).contains(&n_kept), "{n_kept} of {n_written}");
    }

    #[test]
    fn refusals_push_nothing_else_out() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("audit.jsonl");
        let audit = Audit::new(Some(path.clone()));
        for _ in 0..1000 {
            audit.note(&Line::new(Kind::Refusal, "no"));
        }
        audit.note(&Line::new(Kind::Command, "pause"));
        let found = lines(&path);
        assert_eq!(found.len() as u32, REFUSALS_MAX + 1);
        assert_eq!(
            found.last().unwrap()["refusals_left_out"],
            1000 - REFUSALS_MAX
        );
    }

    #[test]
    fn a_line_cut_short_spoils_no_other() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("audit.jsonl");
        std::fs::write(&path, r#"{"unix_secs":1,"ki"#).unwrap();
        Audit::new(Some(path.clone())).note(&Line::new(Kind::Command, "stop"));
        let text = std::fs::read_to_string(&path).unwrap();
        let last: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
        assert_eq!(last["what"], "stop");
    }

    #[test]
    fn where_nothing_can_be_written_work_goes_on() {
        let dir = tempfile::tempdir().unwrap();
        let audit = Audit::new(Some(dir.path().join("missing/audit.jsonl")));
        audit.note(&Line::new(Kind::Command, "stop"));
        std::fs::create_dir(dir.path().join("missing")).unwrap();
        audit.note(&Line::new(Kind::Command, "stop"));
        assert_eq!(lines(&dir.path().join("missing/audit.jsonl")).len(), 1);
    }
}
