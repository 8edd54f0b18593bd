//! Where the workspace is, what cargo knows about it, and which files belong to it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};
use serde_json::Value;

use crate::process;

/// The checked-out workspace.
#[derive(Debug, Clone)]
pub(crate) struct Workspace {
    root: PathBuf,
}

impl Workspace {
    /// The workspace that this program was built from.
    pub(crate) fn find() -> Result<Self> {
        let manifest_dir = std::env::var_os("CARGO_MANIFEST_DIR")
            .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
        let root = manifest_dir
            .ancestors()
            .nth(2)
            .with_context(|| format!("{} is not inside a workspace", manifest_dir.display()))?;
        Ok(Self {
            root: root.to_path_buf(),
        })
    }

    pub(crate) fn path(&self, relative: &str) -> PathBuf {
        self.root.join(relative)
    }

    /// The folder for what cargo cannot fetch; ignored by git.
    pub(crate) fn deps(&self) -> PathBuf {
        self.path(".deps")
    }

    /// A `cargo` command that runs in the workspace and finds MuJoCo's library at run time.
    pub(crate) fn cargo(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.args(arguments).current_dir(&self.root);
        self.set_library_path(&mut command);
        command
    }

    /// A script run by a Python program, with MuJoCo's library where our benchmarks find it.
    pub(crate) fn python(&self, program: &Path, script: &str) -> Command {
        let mut command = Command::new(program);
        command.arg(self.path(script)).current_dir(&self.root);
        self.set_library_path(&mut command);
        command
    }

    fn set_library_path(&self, command: &mut Command) {
        // The outer cargo set the library path to its own folders, which would hide the one of .cargo/config.toml.
        let mut library_path = vec![self.deps().join("mujoco/lib")];
        if let Some(inherited) = std::env::var_os("LD_LIBRARY_PATH") {
            library_path.extend(std::env::split_paths(&inherited));
        }
        library_path.dedup();
        if let Ok(joined) = std::env::join_paths(library_path) {
            command.env("LD_LIBRARY_PATH", joined);
        }
    }

    /// Every file that git tracks or would track, relative to the root, sorted.
    pub(crate) fn files(&self) -> Result<Vec<String>> {
        let listing = process::capture(
            Command::new("git")
                .args([
                    "ls-files",
                    "--cached",
                    "--others",
                    "--exclude-standard",
                    "-z",
                ])
                .current_dir(&self.root),
        )?;
        let files: BTreeSet<String> = listing
            .split('\0')
            .filter(|path| !path.is_empty() && self.root.join(path).is_file())
            .map(str::to_owned)
            .collect();
        Ok(files.into_iter().collect())
    }

    /// `cargo metadata`, with or without the dependencies of the workspace's own packages.
    pub(crate) fn metadata(&self, dependencies: Dependencies) -> Result<Value> {
        let mut arguments = vec!["metadata", "--format-version=1"];
        if dependencies == Dependencies::Direct {
            arguments.push("--no-deps");
        }
        let text = process::capture(&mut self.cargo(&arguments))?;
        serde_json::from_str(&text).context("`cargo metadata` printed something other than JSON")
    }

    /// The crates of the workspace and what each imports.
    pub(crate) fn crates(&self) -> Result<Vec<Crate>> {
        let metadata = self.metadata(Dependencies::Direct)?;
        let packages = metadata["packages"]
            .as_array()
            .context("`cargo metadata` lists no packages")?;
        let folder_of: BTreeMap<&str, String> = packages
            .iter()
            .filter_map(|package| Some((package["name"].as_str()?, folder(package)?)))
            .collect();
        Ok(packages
            .iter()
            .filter_map(|package| Crate::from_metadata(package, &folder_of))
            .collect())
    }
}

/// How much `cargo metadata` is asked to resolve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dependencies {
    /// Only what each manifest says.
    Direct,
    /// The whole resolved graph; cargo may fetch manifests for it.
    Resolved,
}

/// A crate of the workspace, by the name of its folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Crate {
    pub(crate) folder: String,
    /// Folders of the workspace crates it imports, in normal and build dependencies.
    pub(crate) imports: BTreeSet<String>,
    /// Folders of the workspace crates that only its tests, examples and benchmarks import.
    pub(crate) imports_for_tests: BTreeSet<String>,
}

impl Crate {
    fn from_metadata(package: &Value, folder_of: &BTreeMap<&str, String>) -> Option<Self> {
        let mut this = Self {
            folder: folder(package)?,
            imports: BTreeSet::new(),
            imports_for_tests: BTreeSet::new(),
        };
        for dependency in package["dependencies"].as_array()? {
            let Some(imported) = dependency["name"]
                .as_str()
                .and_then(|name| folder_of.get(name))
            else {
                continue;
            };
            let imports = match dependency["kind"].as_str() {
                Some("dev") => &mut this.imports_for_tests,
                _ => &mut this.imports,
            };
            imports.insert(imported.clone());
        }
        Some(this)
    }
}

fn folder(package: &Value) -> Option<String> {
    let manifest = Path::new(package["manifest_path"].as_str()?);
    Some(manifest.parent()?.file_name()?.to_str()?.to_owned())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn imports_are_split_by_kind_and_named_by_folder() {
        let package = json!({
            "name": "factotum-semantic-map",
            "manifest_path": "/x/crates/semantic_map/Cargo.toml",
            "dependencies": [
                {"name": "factotum-geometry", "kind": null},
                {"name": "factotum-worlds", "kind": "dev"},
                {"name": "serde", "kind": null},
            ],
        });
        let folder_of = BTreeMap::from([
            ("factotum-geometry", "geometry".to_owned()),
            ("factotum-worlds", "worlds".to_owned()),
        ]);
        let semantic_map = Crate::from_metadata(&package, &folder_of).unwrap();
        assert_eq!(semantic_map.folder, "semantic_map");
        assert_eq!(
            semantic_map.imports,
            BTreeSet::from(["geometry".to_owned()])
        );
        assert_eq!(
            semantic_map.imports_for_tests,
            BTreeSet::from(["worlds".to_owned()])
        );
    }
}
