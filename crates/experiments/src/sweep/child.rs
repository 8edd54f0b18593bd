//! One command in a child process.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{StopWish, SweepError};

/// As much of a child's messages as is kept, from the end.
const MESSAGES_BYTES_MAX: usize = 2_000;

/// How often a child is asked whether it has ended: short beside the runs that sweeps are for.
const ASK_AGAIN: Duration = Duration::from_millis(20);

/// Starts children of one program, and ends them when it is urgent.
#[derive(Debug, Clone, Copy)]
pub struct Launcher<'a> {
    /// The program.
    pub program: &'a Path,
    /// A folder on whose disk what they print can lie until they end.
    pub folder: &'a Path,
    /// The wish to stop.
    pub stop: &'a StopWish,
    /// An empty file that children have as standard input. A lock on it lasts until the last of them has ended, even if
    /// whoever started them is killed.
    pub lock: Option<&'a File>,
}

/// How a child ended.
#[derive(Debug, Clone, PartialEq)]
pub struct ChildEnd {
    /// Its exit code; nothing when a signal ended it.
    pub exit_code: Option<i32>,
    /// Whether somebody else ended it, by a signal that programs do not raise themselves.
    pub is_from_outside: bool,
    /// How long it took, seconds.
    pub wall_secs: f64,
    /// The JSON document it printed; nothing when it printed none.
    pub output: Option<Value>,
    /// The end of its messages, kept when it did not succeed.
    pub messages: String,
}

impl Launcher<'_> {
    /// Runs the program with these arguments; nothing when an urgent stop ended it.
    ///
    /// # Errors
    /// [`SweepError`] when it cannot be started or followed.
    pub fn run(&self, arguments: &[String]) -> Result<Option<ChildEnd>, SweepError> {
        let follow = |source| SweepError::Follow {
            command: arguments.join(" "),
            source,
        };
        let begun = Instant::now();
        // Files and not pipes: nobody need read while the child writes. They have no names, so none is left behind.
        let mut stdout = tempfile::tempfile_in(self.folder).map_err(follow)?;
        let mut stderr = tempfile::tempfile_in(self.folder).map_err(follow)?;
        let lock = self.lock.map(File::try_clone).transpose().map_err(follow)?;
        let mut command = Command::new(self.program);
        command
            .args(arguments)
            .stdin(lock.map_or_else(Stdio::null, Stdio::from))
            .stdout(stdout.try_clone().map_err(follow)?)
            .stderr(stderr.try_clone().map_err(follow)?);
        // A terminal sends Ctrl-C to the whole group of the program in front: a child in it would be interrupted too.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|source| SweepError::Start {
            program: self.program.to_path_buf(),
            source,
        })?;
        let Some(status) = end_of(&mut child, self.stop).map_err(follow)? else {
            return Ok(None);
        };
        let wall_secs = begun.elapsed().as_secs_f64();
        let stdout = read_from_start(&mut stdout).map_err(follow)?;
        let stderr = read_from_start(&mut stderr).map_err(follow)?;
        let messages = &stderr[stderr.len().saturating_sub(MESSAGES_BYTES_MAX)..];
        Ok(Some(ChildEnd {
            exit_code: status.code(),
            is_from_outside: is_from_outside(status),
            wall_secs,
            output: serde_json::from_slice(&stdout).ok(),
            messages: if status.success() {
                String::new()
            } else {
                String::from_utf8_lossy(messages).into_owned()
            },
        }))
    }
}

/// Whether SIGHUP, SIGINT, SIGKILL or SIGTERM (POSIX: 1, 2, 9, 15) ended it.
#[cfg(unix)]
fn is_from_outside(status: ExitStatus) -> bool {
    let signal = std::os::unix::process::ExitStatusExt::signal(&status);
    matches!(signal, Some(1 | 2 | 9 | 15))
}

#[cfg(not(unix))]
fn is_from_outside(_: ExitStatus) -> bool {
    false
}

/// Waits for the child's own end; an urgent stop ends it, and then there is no status.
fn end_of(child: &mut Child, stop: &StopWish) -> io::Result<Option<ExitStatus>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if stop.is_urgent() {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(ASK_AGAIN);
    }
}

fn read_from_start(file: &mut File) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}
