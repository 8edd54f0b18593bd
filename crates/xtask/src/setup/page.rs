//! The page: its npm packages and its build in `web/dist`, which the `studio` crate serves.
//!
//! Both steps are stamped with a hash of what they read, so that a second set-up does neither.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};
use sha2::{Digest as _, Sha256};

use super::wheel::sha256;
use super::{Outcome, install_hint};
use crate::process;
use crate::workspace::Workspace;

/// Vite, which builds the page, needs this Node.js.
pub(super) const NODE_MAJOR_MIN: u32 = 20;

/// Sees to `web/node_modules` and `web/dist`. Without Node.js the page is left out; a page that does not build is an
/// error.
pub(super) fn ensure(workspace: &Workspace) -> Result<Outcome> {
    let web = workspace.path("web");
    if !web.join("package.json").is_file() {
        return Ok(Outcome::Found("there is none to build".to_owned()));
    }
    if node().is_none() {
        return Ok(Outcome::Missing {
            leaves_out: "the page is not built; everything runs with --headless".to_owned(),
            get: install_hint::node(),
        });
    }
    let installed = install_packages(workspace, &web)?;
    let built = build(workspace, &web)?;
    Ok(if installed || built {
        Outcome::Fetched("built into web/dist".to_owned())
    } else {
        Outcome::Found("web/dist is up to date".to_owned())
    })
}

/// The `npm` to use, if it and a Node.js recent enough are installed.
pub(crate) fn node() -> Option<PathBuf> {
    let npm = process::find_on_path("npm")?;
    let version = process::capture(Command::new("node").arg("--version")).ok()?;
    (major(&version)? >= NODE_MAJOR_MIN).then_some(npm)
}

/// The first number of a version such as `v20.20.2`.
fn major(version: &str) -> Option<u32> {
    version
        .trim()
        .trim_start_matches('v')
        .split('.')
        .next()?
        .parse()
        .ok()
}

fn install_packages(workspace: &Workspace, web: &Path) -> Result<bool> {
    let lock = web.join("package-lock.json");
    let wanted =
        sha256(&fs::read(&lock).with_context(|| format!("cannot read {}", lock.display()))?);
    let stamp = Stamp::of(workspace, "page-packages");
    if web.join("node_modules").is_dir() && stamp.says(&wanted) {
        return Ok(false);
    }
    process::run(
        Command::new("npm")
            .args(["ci", "--no-audit", "--no-fund"])
            .current_dir(web),
    )
    .context("cannot install the page's packages")?;
    stamp.write(&wanted)?;
    Ok(true)
}

fn build(workspace: &Workspace, web: &Path) -> Result<bool> {
    let mut sources = Sha256::new();
    for file in workspace
        .files()?
        .iter()
        .filter(|file| file.starts_with("web/") && !file.starts_with("web/tests/"))
    {
        let bytes =
            fs::read(workspace.path(file)).with_context(|| format!("cannot read {file}"))?;
        sources.update(format!("{file}\0{}\0", bytes.len()));
        sources.update(&bytes);
    }
    let wanted: String = sources
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let stamp = Stamp::of(workspace, "page-build");
    if web.join("dist/index.html").is_file() && stamp.says(&wanted) {
        return Ok(false);
    }
    process::run(Command::new("npm").args(["run", "build"]).current_dir(web))
        .context("the page does not build")?;
    stamp.write(&wanted)?;
    Ok(true)
}

/// A file that says from which input a step was last done.
struct Stamp(PathBuf);

impl Stamp {
    fn of(workspace: &Workspace, step: &str) -> Self {
        Self(workspace.deps().join(format!("{step}.sha256")))
    }

    fn says(&self, hash: &str) -> bool {
        fs::read_to_string(&self.0).is_ok_and(|text| text.trim() == hash)
    }

    fn write(&self, hash: &str) -> Result<()> {
        fs::write(&self.0, format!("{hash}\n"))
            .with_context(|| format!("cannot write {}", self.0.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_major_version_is_read() {
        assert_eq!(major("v20.20.2\n"), Some(20));
        assert_eq!(major("not a version"), None);
    }

    #[test]
    fn a_stamp_says_only_what_was_written() {
        let dir = tempfile::tempdir().unwrap();
        let stamp = Stamp(dir.path().join("step.sha256"));
        assert!(!stamp.says("abc"));
        stamp.write("abc").unwrap();
        assert!(stamp.says("abc"));
        assert!(!stamp.says("abd"));
    }
}
