//! `cargo x tidy`: the house rules that a machine can check.
//!
//! Each rule is a pure function from what it looks at to the violations it finds, and each has a test that shows it
//! finding one.

mod absence;
mod documents;
mod files;
mod floors;
mod rust_text;

use std::fmt;

use anyhow::{Result, bail};

use crate::workspace::Workspace;

/// One thing that breaks a house rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Violation {
    /// The file or crate.
    place: String,
    /// What is wrong and what is wanted.
    what: String,
}

impl Violation {
    fn new(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self {
            place: place.into(),
            what: what.into(),
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.what)
    }
}

/// A tracked text file.
#[derive(Debug, Clone)]
struct TextFile {
    /// Relative to the root, with forward slashes.
    path: String,
    text: String,
}

/// Checks every rule; an error lists what breaks them.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let crates = workspace.crates()?;
    let paths = workspace.files()?;
    let files: Vec<TextFile> = paths
        .iter()
        .filter_map(|path| {
            // A file that is not UTF-8 is an image or a mesh.
            let text = std::fs::read_to_string(workspace.path(path)).ok()?;
            Some(TextFile {
                path: path.clone(),
                text,
            })
        })
        .collect();
    let violations: Vec<Violation> = [
        floors::check(&crates),
        absence::check_imports(&crates),
        absence::check_sources(&files),
        documents::check_architecture(&crates, &paths, &files),
        documents::check_links(&paths, &files),
        files::check(&files),
    ]
    .concat();
    for (path, n_lines) in files::long(&files) {
        eprintln!("tidy: {path} has {n_lines} lines; is it two ideas?");
    }
    if !violations.is_empty() {
        let list: Vec<String> = violations
            .iter()
            .map(|violation| format!("  {violation}"))
            .collect();
        bail!(
            "the house rules are broken in {} places:\n{}",
            violations.len(),
            list.join("\n")
        );
    }
    eprintln!(
        "tidy: {} crates and {} files keep the house rules",
        crates.len(),
        paths.len()
    );
    Ok(())
}
