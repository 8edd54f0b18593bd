//! Fetching a native library or program from the Python wheel that its makers publish.
//!
//! pip is told the Python version and platform that the wheel is for, so that any Python 3 can fetch it; the wheel is
//! checked against a SHA-256 written here, and unpacked by Python's own `zipfile`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use sha2::{Digest as _, Sha256};

use super::install_hint;
use crate::process;

/// One wheel of one package, for one platform.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wheel {
    /// `name==version`, as pip takes it.
    pub(super) requirement: &'static str,
    /// A version of Python that the wheel is for.
    pub(super) python: &'static str,
    /// Every platform tag in the wheel's name; older versions of pip know only the older tags.
    pub(super) platforms: &'static [&'static str],
    pub(super) sha256: &'static str,
}

/// Downloads the wheel, checks it and unpacks it into `folder`, which must exist.
pub(super) fn fetch_into(wheel: &Wheel, folder: &Path) -> Result<()> {
    let python = python_with_pip()?;
    let downloads = folder.join("download");
    fs::create_dir_all(&downloads)
        .with_context(|| format!("cannot create {}", downloads.display()))?;
    let mut pip = Command::new(&python);
    pip.args([
        "-m",
        "pip",
        "download",
        "--disable-pip-version-check",
        "--no-deps",
        "--only-binary=:all:",
    ]);
    pip.args(["--python-version", wheel.python, "--implementation", "cp"]);
    for platform in wheel.platforms {
        pip.args(["--platform", platform]);
    }
    process::run(pip.arg("--dest").arg(&downloads).arg(wheel.requirement)).with_context(|| {
        format!(
            "pip could not download {}; is the package index reachable?",
            wheel.requirement
        )
    })?;
    let file = only_wheel_in(&downloads)?;
    let found = sha256_of(&file)?;
    if found != wheel.sha256 {
        bail!(
            "{} has SHA-256 {found}, expected {}",
            file.display(),
            wheel.sha256
        );
    }
    process::capture(
        Command::new(&python)
            .args(["-m", "zipfile", "-e"])
            .arg(&file)
            .arg(folder),
    )?;
    fs::remove_dir_all(&downloads).with_context(|| format!("cannot remove {}", downloads.display()))
}

/// SHA-256 of a file, in lower-case hexadecimal digits.
pub(super) fn sha256_of(file: &Path) -> Result<String> {
    let bytes = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    Ok(sha256(&bytes))
}

pub(super) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Puts a finished folder in its place with one rename; what was there before goes.
pub(super) fn put_in_place(finished: &Path, place: &Path) -> Result<()> {
    let old = place.with_extension("old");
    if old.exists() {
        fs::remove_dir_all(&old).with_context(|| format!("cannot remove {}", old.display()))?;
    }
    if place.exists() {
        fs::rename(place, &old).with_context(|| format!("cannot move {} away", place.display()))?;
    }
    fs::rename(finished, place)
        .with_context(|| format!("cannot put {} in place", place.display()))?;
    if old.exists() {
        fs::remove_dir_all(&old).with_context(|| format!("cannot remove {}", old.display()))?;
    }
    Ok(())
}

/// A new, empty folder beside `place`, to be filled and then put in place.
pub(super) fn workshop(place: &Path) -> Result<PathBuf> {
    let folder = place.with_extension("partial");
    if folder.exists() {
        fs::remove_dir_all(&folder)
            .with_context(|| format!("cannot remove {}", folder.display()))?;
    }
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    Ok(folder)
}

fn python_with_pip() -> Result<PathBuf> {
    let python = process::find_on_path("python3").or_else(|| process::find_on_path("python"));
    let Some(python) = python else {
        bail!(
            "Python 3 is not installed; it fetches the wheel. To get it: {}",
            install_hint::pip()
        );
    };
    if process::capture(Command::new(&python).args(["-m", "pip", "--version"])).is_err() {
        bail!(
            "{} has no pip; it fetches the wheel. To get it: {}",
            python.display(),
            install_hint::pip()
        );
    }
    Ok(python)
}

fn only_wheel_in(folder: &Path) -> Result<PathBuf> {
    let entries =
        fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    let mut wheels = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "whl"));
    match (wheels.next(), wheels.next()) {
        (Some(wheel), None) => Ok(wheel),
        (None, _) => bail!("pip left no wheel in {}", folder.display()),
        (Some(_), Some(_)) => bail!("pip left more than one wheel in {}", folder.display()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sha256_of_the_empty_string_is_the_published_value() {
        // FIPS 180-4 test vector.
        assert_eq!(
            sha256(b""),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
        );
    }

    #[test]
    fn a_finished_folder_replaces_the_old_one_whole() {
        let dir = tempfile::tempdir().unwrap();
        let place = dir.path().join("library");
        fs::create_dir(&place).unwrap();
        fs::write(place.join("stale"), "").unwrap();
        let finished = workshop(&place).unwrap();
        fs::write(finished.join("fresh"), "").unwrap();
        put_in_place(&finished, &place).unwrap();
        assert!(place.join("fresh").exists());
        assert!(!place.join("stale").exists());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_interrupted_setup_leaves_nothing_in_the_workshop() {
        let dir = tempfile::tempdir().unwrap();
        let place = dir.path().join("library");
        fs::write(workshop(&place).unwrap().join("half"), "").unwrap();
        assert_eq!(fs::read_dir(workshop(&place).unwrap()).unwrap().count(), 0);
    }
}
