//! `cargo x run`: the main job from a fresh clone in one command.

use std::convert::Infallible;
use std::os::unix::process::CommandExt as _;

use anyhow::{Context as _, Result};

use crate::setup::{self, Wanted};
use crate::workspace::Workspace;

/// Builds `factotum` and becomes its `run` command, so that Ctrl-C and the exit code are its own.
pub(crate) fn run(workspace: &Workspace, arguments: &[String]) -> Result<Infallible> {
    setup::run(workspace, Wanted::TO_RUN)?;
    let error = workspace
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
        .exec();
    Err(error).context("cannot start cargo")
}
