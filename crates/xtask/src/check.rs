//! `cargo x check`: all that CI looks at besides the tests.

use anyhow::{Result, bail};

use crate::setup::{self, Wanted};
use crate::workspace::Workspace;
use crate::{codegen, licences, process, tidy};

/// Runs every check, the quick ones first, and fails at the end naming those that failed.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let checks: [(&str, Check); 5] = [
        ("format", |workspace| {
            process::run(&mut workspace.cargo(&["fmt", "--all", "--check"]))
        }),
        ("tidy", tidy::run),
        ("licences", licences::run),
        ("lints", lints),
        ("codegen", |workspace| {
            codegen::run(workspace, &["--check".to_owned()])
        }),
    ];
    let mut failed = Vec::new();
    for (name, check) in checks {
        if let Err(error) = check(workspace) {
            eprintln!("{name}: {error:#}");
            failed.push(name);
        }
    }
    if !failed.is_empty() {
        bail!("these checks failed: {}", failed.join(", "));
    }
    eprintln!("every check passed");
    Ok(())
}

type Check = fn(&Workspace) -> Result<()>;

fn lints(workspace: &Workspace) -> Result<()> {
    setup::run(workspace, Wanted::TO_BUILD)?;
    process::run(&mut workspace.cargo(&[
        "clippy",
        "--workspace",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ]))
}
