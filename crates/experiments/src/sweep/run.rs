//! One run of a sweep's command, in a child process.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::{RunResult, StopWish, Sweep, SweepError};

/// As much of a child's messages as is kept, from the end.
const MESSAGES_BYTES_MAX: usize = 2_000;

/// How often a child is asked whether it has ended: short beside the runs that sweeps are for.
const ASK_AGAIN: Duration = Duration::from_millis(20);

/// Runs the command with a seed; nothing when an urgent stop ended it.
pub(super) fn run_one(
    sweep: &Sweep,
    seed: u64,
    stop: &StopWish,
) -> Result<Option<RunResult>, SweepError> {
    let follow = |source| SweepError::Follow { seed, source };
    let begun = Instant::now();
    // Files and not pipes: nobody need read while the child writes. They have no names, so none is left behind.
    let mut stdout = tempfile::tempfile_in(&sweep.folder).map_err(follow)?;
    let mut stderr = tempfile::tempfile_in(&sweep.folder).map_err(follow)?;
    let mut command = Command::new(&sweep.program);
    command
        .args(&sweep.arguments)
        .args(["--seed", &seed.to_string()])
        .stdin(Stdio::null())
        .stdout(stdout.try_clone().map_err(follow)?)
        .stderr(stderr.try_clone().map_err(follow)?);
    // A terminal sends Ctrl-C to the whole group of the program in front: a child in it would be interrupted as well.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command.spawn().map_err(|source| SweepError::Start {
        program: sweep.program.clone(),
        source,
    })?;
    let Some(status) = end_of(&mut child, stop).map_err(follow)? else {
        return Ok(None);
    };
    let wall_secs = begun.elapsed().as_secs_f64();
    let stdout = read_from_start(&mut stdout).map_err(follow)?;
    let stderr = read_from_start(&mut stderr).map_err(follow)?;
    let messages = &stderr[stderr.len().saturating_sub(MESSAGES_BYTES_MAX)..];
    Ok(Some(RunResult {
        seed,
        exit_code: status.code(),
        wall_secs,
        output: serde_json::from_slice(&stdout).ok(),
        messages: if status.success() {
            String::new()
        } else {
            String::from_utf8_lossy(messages).into_owned()
        },
    }))
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
