//! `cargo x setup`: fetches what cargo cannot, into `.deps/`, and says what is missing and how to get it.
//!
//! Every part is idempotent: it looks first, does nothing when all is right, and puts a finished folder in place by
//! one rename, so an interrupted set-up leaves nothing half done. Only MuJoCo's library is needed to build; without
//! any of the others Factotum builds and runs, and the report says what is then left out.

mod browser;
mod fast_downward;
mod install_hint;
mod models;
mod mujoco;
mod page;
mod wheel;

use std::fs::File;
use std::path::PathBuf;

use anyhow::{Context as _, Result};

pub(crate) use page::node;

use crate::workspace::Workspace;

/// Which optional parts a command needs. MuJoCo's library is always seen to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wanted {
    page: bool,
    browser: bool,
    fast_downward: bool,
    /// Other makers' robot models.
    models: bool,
    /// Whether to say as well what was already there.
    full_report: bool,
}

impl Wanted {
    pub(crate) const TO_BUILD: Self = Self {
        page: false,
        browser: false,
        fast_downward: false,
        models: false,
        full_report: false,
    };
    pub(crate) const MODELS: Self = Self {
        models: true,
        full_report: true,
        ..Self::TO_BUILD
    };
    pub(crate) const TO_RUN: Self = Self {
        page: true,
        ..Self::TO_BUILD
    };
    pub(crate) const TO_TEST: Self = Self {
        page: true,
        browser: true,
        fast_downward: true,
        models: true,
        full_report: false,
    };
    pub(crate) const EVERYTHING: Self = Self {
        full_report: true,
        ..Self::TO_TEST
    };
}

/// What became of one part of the set-up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It was there and right.
    Found(String),
    /// It was fetched or built now.
    Fetched(String),
    /// It cannot be had here; `leaves_out` is what will not work, `get` how to get it.
    Missing { leaves_out: String, get: String },
}

/// Sees to every wanted part; an error means that Factotum cannot be built.
pub(crate) fn run(workspace: &Workspace, wanted: Wanted) -> Result<()> {
    let _lock = lock(workspace)?;
    let tell = |part: &str, outcome: &Outcome| {
        if wanted.full_report || !matches!(outcome, Outcome::Found(_)) {
            report(part, outcome);
        }
    };
    tell("MuJoCo", &mujoco::ensure(workspace)?);
    if wanted.page {
        tell("page", &page::ensure(workspace)?);
    }
    if wanted.browser {
        tell("browser", &browser::ensure());
    }
    if wanted.fast_downward {
        tell("Fast Downward", &fast_downward::ensure(workspace));
    }
    if wanted.models {
        tell("robot models", &models::ensure(workspace));
    }
    Ok(())
}

/// The browser for the page's tests, if this machine has one.
pub(crate) fn chromium() -> Option<PathBuf> {
    browser::find()
}

/// Two set-ups at once would fetch everything twice; the second waits here and then finds it all in place.
fn lock(workspace: &Workspace) -> Result<File> {
    let folder = workspace.deps();
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot create {}", folder.display()))?;
    let path = folder.join("setup.lock");
    let file = File::create(&path).with_context(|| format!("cannot create {}", path.display()))?;
    file.lock()
        .with_context(|| format!("cannot lock {}", path.display()))?;
    Ok(file)
}

fn report(part: &str, outcome: &Outcome) {
    match outcome {
        Outcome::Found(what) => eprintln!("setup: {part}: {what}"),
        Outcome::Fetched(what) => eprintln!("setup: {part}: ready, {what}"),
        Outcome::Missing { leaves_out, get } => {
            eprintln!("setup: {part}: not found; without it {leaves_out}");
            eprintln!("setup: {part}: to get it: {get}");
        }
    }
}
