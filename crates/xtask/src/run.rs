//! `cargo x run`: the main job from a fresh clone in one command.

use std::process::ExitCode;

use anyhow::{Context as _, Result};

use crate::setup::{self, Wanted};
use crate::workspace::Workspace;

/// Builds `factotum` and starts its `run` command; its exit code is passed on.
pub(crate) fn run(workspace: &Workspace, arguments: &[String]) -> Result<ExitCode> {
    setup::run(workspace, Wanted::TO_RUN)?;
    let status = workspace
        .cargo(&[
            "run",
            "--release",
            "--package",
            "factotum-cli",
            "--bin",
            "factotum",
            "--",
            "run",
        ])
        .args(arguments)
        .status()
        .context("cannot start cargo")?;
    Ok(status
        .code()
        .and_then(|code| u8::try_from(code).ok())
        .map_or(ExitCode::FAILURE, ExitCode::from))
}
