//! Running a planner as a child process under limits on wall time and memory.
//!
//! The child gets its own process group, so that whatever it starts ends with it. Memory is limited
//! through the shell's `ulimit -v`, which every descendant inherits. What the child prints goes to
//! files, so that a chatty planner cannot block on a full pipe.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::PlannerError;

/// Longest pause between two looks at the child.
const POLL_MAX: Duration = Duration::from_millis(20);

/// How much of the end of the child's output is kept for messages.
const TAIL_BYTES: u64 = 4096;

/// A program with its arguments.
#[derive(Debug)]
pub(super) struct Invocation<'a> {
    /// The planner's name, for messages.
    pub(super) planner: &'a str,
    /// The program.
    pub(super) program: &'a Path,
    /// Its arguments.
    pub(super) args: Vec<String>,
    /// Where it runs.
    pub(super) work_dir: &'a Path,
    /// Where its output may be written.
    pub(super) scratch_dir: &'a Path,
}

/// How a child ended.
#[derive(Debug)]
pub(super) enum Ended {
    /// By itself.
    Exited {
        /// Its exit status.
        status: ExitStatus,
        /// The end of what it printed.
        tail: String,
    },
    /// Killed when its time was over.
    TimedOut,
}

/// Runs the program until it ends or the deadline passes.
pub(super) fn run(
    invocation: &Invocation<'_>,
    deadline: Instant,
    memory_mib: u64,
) -> Result<Ended, PlannerError> {
    let log_path = invocation.scratch_dir.join("output.log");
    let io = |doing: String| {
        let planner = invocation.planner.to_owned();
        move |source| PlannerError::Io {
            planner,
            doing,
            source,
        }
    };
    let opening = || io(format!("opening {}", log_path.display()));
    let log = File::options()
        .create(true)
        .append(true)
        .read(true)
        .open(&log_path)
        .map_err(opening())?;
    let log_too = log.try_clone().map_err(opening())?;
    let mut child = limited(invocation, memory_mib)
        .stdin(Stdio::null())
        .stdout(log_too.try_clone().map_err(opening())?)
        .stderr(log_too)
        .spawn()
        .map_err(io(format!("starting {}", invocation.program.display())))?;
    let waiting = || io(format!("waiting for {}", invocation.program.display()));
    let status = match wait_until(&mut child, deadline) {
        Ok(Some(status)) => status,
        Ok(None) => {
            end_group(&mut child).map_err(waiting())?;
            return Ok(Ended::TimedOut);
        }
        Err(source) => {
            end_group(&mut child).map_err(waiting())?;
            return Err(waiting()(source));
        }
    };
    let tail = tail(log).map_err(io(format!("reading {}", log_path.display())))?;
    Ok(Ended::Exited { status, tail })
}

/// The program under a shell that limits its memory and then becomes it.
fn limited(invocation: &Invocation<'_>, memory_mib: u64) -> Command {
    let mut command = Command::new("/bin/sh");
    command
        .arg("-c")
        .arg(format!(
            "ulimit -v {} && exec \"$0\" \"$@\"",
            memory_mib.saturating_mul(1024)
        ))
        .arg(invocation.program)
        .args(&invocation.args)
        .current_dir(invocation.work_dir);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}

/// Waits for the child; `None` where the deadline passed first.
fn wait_until(child: &mut Child, deadline: Instant) -> std::io::Result<Option<ExitStatus>> {
    let mut pause = Duration::from_millis(1);
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Ok(None);
        }
        std::thread::sleep(pause.min(left));
        pause = (pause * 2).min(POLL_MAX);
    }
}

/// Kills the child with all it started, and collects it.
fn end_group(child: &mut Child) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use rustix::process::{Pid, Signal, kill_process_group};
        if let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
            kill_process_group(group, Signal::KILL)?;
        }
    }
    #[cfg(not(unix))]
    child.kill()?;
    child.wait().map(|_| ())
}

fn tail(mut log: File) -> std::io::Result<String> {
    let end = log.seek(SeekFrom::End(0))?;
    log.seek(SeekFrom::Start(end.saturating_sub(TAIL_BYTES)))?;
    let mut bytes = Vec::new();
    log.take(TAIL_BYTES).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).trim().to_owned())
}
