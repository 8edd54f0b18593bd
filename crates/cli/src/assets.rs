//! Finding the shipped models: `assets/` beside the sources, beside the program, or where the user says.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::console::usage;

/// The assets folder.
///
/// Looked for in `FACTOTUM_ASSETS`, in the working directory, above the program (a build tree) and beside it.
pub(crate) fn dir() -> anyhow::Result<PathBuf> {
    if let Some(dir) = std::env::var_os("FACTOTUM_ASSETS") {
        let dir = PathBuf::from(dir);
        return if is_assets(&dir) {
            Ok(dir)
        } else {
            Err(usage(format!(
                "FACTOTUM_ASSETS is `{}`, which has no folder `robots`",
                dir.display()
            )))
        };
    }
    let program = std::env::current_exe().ok();
    let beside = program
        .iter()
        .flat_map(|program| program.ancestors().skip(1))
        .take(4);
    std::iter::once(Path::new(".")).chain(beside)
        .map(|dir| dir.join("assets"))
        .find(|dir| is_assets(dir))
        .ok_or_else(|| usage("no folder `assets` in the working directory or near the program; set FACTOTUM_ASSETS to it"))
}

fn is_assets(dir: &Path) -> bool {
    dir.join("robots").is_dir()
}

/// A robot: a folder with `robot.toml`, or the name of a shipped one.
pub(crate) fn robot(name: &Path) -> anyhow::Result<PathBuf> {
    find(name, "robots", "robot.toml", "robot")
}

/// A scene: a folder with `scene.toml`, or the name of a shipped one.
pub(crate) fn scene(name: &Path) -> anyhow::Result<PathBuf> {
    find(name, "scenes", "scene.toml", "scene")
}

/// A learned skill: a folder with `skill.toml`, or the name of a shipped one.
pub(crate) fn skill(name: &Path) -> anyhow::Result<PathBuf> {
    find(name, "skills", "skill.toml", "skill")
}

/// The skill folders in a folder, or the shipped ones, by name.
pub(crate) fn skills(shelf: Option<&Path>) -> anyhow::Result<Vec<PathBuf>> {
    let shelf = match shelf {
        Some(given) if given.is_dir() => given.to_owned(),
        Some(given) => {
            return Err(usage(format!(
                "--skills is `{}`, expected a folder",
                given.display()
            )));
        }
        None => dir()?.join("skills"),
    };
    let names = shipped_names(&shelf, |path| {
        let is_skill = path.join("skill.toml").is_file();
        is_skill.then(|| path.file_name()).flatten()
    });
    Ok(names.into_iter().map(|name| shelf.join(name)).collect())
}

/// The folders of the shipped object classes, by name.
pub(crate) fn object_classes() -> anyhow::Result<Vec<(String, PathBuf)>> {
    let shelf = dir()?.join("objects");
    let names = shipped_names(&shelf, |path| {
        let is_class = path.join("class.toml").is_file();
        is_class.then(|| path.file_name()).flatten()
    });
    let with_folder = |name: String| {
        let folder = shelf.join(&name);
        (name, folder)
    };
    Ok(names.into_iter().map(with_folder).collect())
}

/// A task file: itself, or that of a shipped task.
pub(crate) fn task(name: &Path) -> anyhow::Result<PathBuf> {
    if name.is_file() {
        return Ok(name.to_owned());
    }
    let shelf = dir()?.join("tasks");
    let shipped = shelf.join(name).with_extension("toml");
    if shipped.is_file() {
        return Ok(shipped);
    }
    let known = shipped_names(&shelf, |path| {
        let is_task = path
            .extension()
            .is_some_and(|extension| extension == "toml");
        is_task.then(|| path.file_stem()).flatten()
    });
    Err(usage(format!(
        "task `{}` is neither a task file nor shipped; shipped: {}",
        name.display(),
        known.join(", ")
    )))
}

/// How a task is kept in a skill folder: a shipped one by its name, so that the folder can move; another by its place.
pub(crate) fn task_name(name: &Path) -> anyhow::Result<PathBuf> {
    task(name)?;
    if name.is_file() {
        return Ok(std::path::absolute(name)?);
    }
    Ok(name.to_owned())
}

fn find(name: &Path, kind: &str, file: &str, noun: &str) -> anyhow::Result<PathBuf> {
    if name.join(file).is_file() || name.is_file() {
        return Ok(name.to_owned());
    }
    let shelf = dir()?.join(kind);
    let shipped = shelf.join(name);
    if shipped.join(file).is_file() {
        return Ok(shipped);
    }
    let known = shipped_names(&shelf, |path| {
        path.join(file)
            .is_file()
            .then(|| path.file_name())
            .flatten()
    });
    Err(usage(format!(
        "{noun} `{}` is neither a folder with `{file}` nor shipped; shipped: {}",
        name.display(),
        known.join(", ")
    )))
}

/// The names that `name_of` gives the entries of a folder, in order.
fn shipped_names(shelf: &Path, name_of: impl Fn(&Path) -> Option<&OsStr>) -> Vec<String> {
    let entries = std::fs::read_dir(shelf).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .filter_map(|entry| Some(name_of(&entry.path())?.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    names
}
