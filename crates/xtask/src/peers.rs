//! `cargo x bench peers NAME`: what Factotum does beside programs of others that do the same, in one run on one
//! machine; the comparison is printed as JSON.

mod cip;

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use serde_json::Value;

use crate::process;
use crate::workspace::Workspace;

/// What the comparison of movement primitives and policy search needs from PyPI.
const BOOTSTRAP_PACKAGES: [&str; 4] = [
    "movement_primitives==0.9.1",
    "numpy",
    "scipy",
    "pytransform3d",
];

pub(crate) fn run(workspace: &Workspace, arguments: &[String]) -> Result<()> {
    match arguments.split_first() {
        Some((name, rest)) if name == "bootstrap" => bootstrap(workspace, rest),
        Some((name, rest)) if name == "cip" => cip::run(workspace, rest),
        Some((name, _)) => bail!("there is no comparison `{name}`; there are: bootstrap, cip"),
        None => bail!("which comparison? There are: bootstrap, cip"),
    }
}

/// Movement primitives, their learning, and PI²-CMA on the via-point problem.
fn bootstrap(workspace: &Workspace, rest: &[String]) -> Result<()> {
    let of = ["--package", "factotum-learning"];
    let bench = [&["bench", "--no-run", "--bench", "primitives"], &of[..]].concat();
    let example = [&["build", "--release", "--example", "via_point"], &of[..]].concat();
    let (bench, example) = (built(workspace, &bench)?, built(workspace, &example)?);
    let python = python(workspace, "bootstrap", &BOOTSTRAP_PACKAGES)?;
    process::run(
        Command::new(python)
            .arg(workspace.path("experiments/policy-search/peers.py"))
            .args([bench, example])
            .args(rest),
    )
}

/// The program that a cargo command builds.
fn built(workspace: &Workspace, arguments: &[&str]) -> Result<PathBuf> {
    let mut command = workspace.cargo(arguments);
    let messages = process::capture(command.arg("--message-format=json-render-diagnostics"))?;
    let program = messages.lines().rev().find_map(program_of);
    program.with_context(|| format!("`cargo {}` built no program", arguments.join(" ")))
}

/// The program that one of cargo's messages names.
fn program_of(message: &str) -> Option<PathBuf> {
    let message: Value = serde_json::from_str(message).ok()?;
    Some(PathBuf::from(message["executable"].as_str()?))
}

/// Python with packages, in a folder of its own below `target`.
fn python(workspace: &Workspace, name: &str, packages: &[&str]) -> Result<PathBuf> {
    let folder = workspace.path("target/peers").join(name);
    let python = folder.join("bin/python");
    if !python.is_file() {
        process::run(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
    }
    // To stderr, since stdout is the comparison's.
    let said = process::capture(
        Command::new(&python)
            .args(["-m", "pip", "install", "--quiet"])
            .args(packages),
    )?;
    eprint!("{said}");
    Ok(python)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::program_of;

    #[test]
    fn the_program_is_in_cargos_message() {
        let message = r#"{"reason":"compiler-artifact","executable":"/a/via_point"}"#;
        assert_eq!(program_of(message), Some(PathBuf::from("/a/via_point")));
        assert_eq!(
            program_of(r#"{"reason":"compiler-artifact","executable":null}"#),
            None
        );
        assert_eq!(program_of("warning: nothing"), None);
    }
}
