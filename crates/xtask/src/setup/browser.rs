//! A Chromium for the page's tests: found, or installed where the set-up runs as root with apt-get.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use super::{Outcome, install_hint};
use crate::process;

const PROGRAMS: [&str; 5] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
];
const MAC_APPLICATIONS: [&str; 2] = [
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
];

pub(super) fn ensure() -> Outcome {
    if let Some(browser) = find() {
        return Outcome::Found(browser.display().to_string());
    }
    if may_install()
        && let Err(error) = install()
    {
        eprintln!("setup: browser: {error:#}");
    }
    find().map_or_else(
        || Outcome::Missing {
            leaves_out: "the browser tests of the page skip".to_owned(),
            get: install_hint::chromium(),
        },
        |browser| Outcome::Fetched(format!("{} installed", browser.display())),
    )
}

/// The browser that `CHROMIUM` names, else the first on the search path, in the usual place, or in Playwright's store.
pub(super) fn find() -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM")
        .map(PathBuf::from)
        .filter(|path| path.is_file());
    named
        .or_else(|| {
            PROGRAMS
                .iter()
                .find_map(|program| process::find_on_path(program))
        })
        .or_else(|| {
            MAC_APPLICATIONS
                .iter()
                .map(PathBuf::from)
                .find(|path| path.is_file())
        })
        .or_else(|| in_playwright_store(Path::new(&std::env::var_os("HOME")?)))
}

/// The newest Chromium that Playwright has downloaded for this user.
fn in_playwright_store(home: &Path) -> Option<PathBuf> {
    let store = home.join(".cache/ms-playwright");
    let mut versions: Vec<PathBuf> = std::fs::read_dir(store)
        .ok()?
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            path.file_name()
                .and_then(|n| n.to_str())
                .is_some_and(|n| n.starts_with("chromium-"))
        })
        .collect();
    versions.sort();
    versions.iter().rev().find_map(|version| {
        ["chrome-linux/chrome", "chrome-linux64/chrome"]
            .iter()
            .map(|p| version.join(p))
            .find(|path| path.is_file())
    })
}

fn may_install() -> bool {
    let root = process::capture(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0");
    root && process::find_on_path("apt-get").is_some()
}

fn install() -> Result<()> {
    process::run(Command::new("apt-get").args(["update", "-q"]))?;
    process::run(
        Command::new("apt-get")
            .args(["install", "-q", "-y", "--no-install-recommends", "chromium"])
            .env("DEBIAN_FRONTEND", "noninteractive"),
    )
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn playwrights_newest_chromium_is_found() {
        let home = tempfile::tempdir().unwrap();
        for version in ["chromium-1091", "chromium-1155", "firefox-1471"] {
            let folder = home
                .path()
                .join(".cache/ms-playwright")
                .join(version)
                .join("chrome-linux");
            fs::create_dir_all(&folder).unwrap();
            fs::write(folder.join("chrome"), "").unwrap();
        }
        let found = in_playwright_store(home.path()).unwrap();
        assert!(
            found.to_string_lossy().contains("chromium-1155"),
            "{}",
            found.display()
        );
    }

    #[test]
    fn no_store_is_no_browser() {
        let home = tempfile::tempdir().unwrap();
        assert_eq!(in_playwright_store(home.path()), None);
    }
}
