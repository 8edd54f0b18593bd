//! The folder in which a run leaves what it did.
//!
//! | file | holds |
//! |---|---|
//! | `manifest.json` | what was run, when, with which seed, and how it ended |
//! | `report.html` | the [report](crate::report) |
//! | `recording.mcap` | the [recording](crate::recording); `recording-2.mcap`, ... of what came after a resume |
//! | `snapshots/` | the last few [snapshots](Snapshots), to go on from after a crash |
//!
//! Whoever runs adds its own files with [`RunFolder::write`] and [`RunFolder::append_line`].

mod snapshots;

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::storage::{self, StorageError};
use crate::utc::UtcTime;

pub use snapshots::{N_SNAPSHOTS_KEPT, SNAPSHOTS_NAME, SnapshotError, Snapshots};

/// Name of the manifest in a run folder.
pub const MANIFEST_NAME: &str = "manifest.json";
/// Name of the report in a run folder.
pub const REPORT_NAME: &str = "report.html";
/// Name of the first recording in a run folder.
pub const RECORDING_NAME: &str = "recording.mcap";

/// A run folder that could not be made or opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunFolderError {
    /// A file in it could not be written or read.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// The place is taken by something that is not an empty folder.
    #[error("`{}` is not empty; give a new folder, or open it to go on with its run", folder.display())]
    NotEmpty {
        /// The folder.
        folder: PathBuf,
    },
    /// The manifest says something else than a manifest should.
    #[error("`{}` is not the manifest of a run", file.display())]
    Manifest {
        /// The file.
        file: PathBuf,
        /// What is wrong in it.
        source: serde_json::Error,
    },
}

/// What was run, and how it ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The program and its version.
    pub program: String,
    /// The exact command.
    pub command: Vec<String>,
    /// Name of the scene or home.
    pub scene: String,
    /// The seed that everything random came from.
    pub seed: u64,
    /// When it began, ISO 8601 in UTC.
    pub started: String,
    /// When it ended; nothing while it runs or after a crash.
    pub ended: Option<String>,
    /// Its exit code; nothing while it runs or after a crash.
    pub exit_code: Option<u8>,
    /// What it was asked for, by option of the command line: what it takes to go on with it.
    #[serde(default)]
    pub options: BTreeMap<String, String>,
    /// Whether it was stopped on request, before its end.
    #[serde(default)]
    pub stopped: bool,
    /// How often it was gone on with after a crash or a stop.
    #[serde(default)]
    pub resumed: u32,
}

impl Manifest {
    /// The manifest of a run that begins.
    #[must_use]
    pub fn begin(
        program: &str,
        command: Vec<String>,
        scene: &str,
        seed: u64,
        started: UtcTime,
    ) -> Self {
        Self {
            program: program.to_owned(),
            command,
            scene: scene.to_owned(),
            seed,
            started: started.to_string(),
            ended: None,
            exit_code: None,
            options: BTreeMap::new(),
            stopped: false,
            resumed: 0,
        }
    }
}

/// A folder for one run.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    manifest: Manifest,
}

impl RunFolder {
    /// Makes `<parent>/<UTC date>-<scene>-<seed>`, with `-2`, `-3`, ... added when there is one already.
    ///
    /// # Errors
    /// [`RunFolderError`] when no folder can be made there.
    pub fn create_in(
        parent: &Path,
        started: UtcTime,
        manifest: Manifest,
    ) -> Result<Self, RunFolderError> {
        make_dir_all(parent)?;
        let name = format!(
            "{}-{}-{}",
            started.date(),
            file_name_of(&manifest.scene),
            manifest.seed
        );
        let mut number = 1_u32;
        loop {
            let path = parent.join(if number == 1 {
                name.clone()
            } else {
                format!("{name}-{number}")
            });
            match fs::create_dir(&path) {
                Ok(()) => return Self::begin(path, manifest),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
                Err(error) => return Err(StorageError::writing(&path, error).into()),
            }
        }
    }

    /// Makes a run folder of the folder given, which is new or empty.
    ///
    /// # Errors
    /// [`RunFolderError`] when the folder holds something or cannot be made.
    pub fn create_at(path: &Path, manifest: Manifest) -> Result<Self, RunFolderError> {
        make_dir_all(path)?;
        let mut entries = fs::read_dir(path).map_err(|error| StorageError::reading(path, error))?;
        if entries.next().is_some() {
            return Err(RunFolderError::NotEmpty {
                folder: path.to_path_buf(),
            });
        }
        Self::begin(path.to_path_buf(), manifest)
    }

    /// Opens the folder of an earlier run, to read it or to go on with it.
    ///
    /// # Errors
    /// [`RunFolderError`] when it has no readable manifest.
    pub fn open(path: &Path) -> Result<Self, RunFolderError> {
        let file = path.join(MANIFEST_NAME);
        let text =
            fs::read_to_string(&file).map_err(|error| StorageError::reading(&file, error))?;
        let manifest = serde_json::from_str(&text)
            .map_err(|source| RunFolderError::Manifest { file, source })?;
        Ok(Self {
            path: path.to_path_buf(),
            manifest,
        })
    }

    fn begin(path: PathBuf, manifest: Manifest) -> Result<Self, RunFolderError> {
        let this = Self { path, manifest };
        this.write_json(MANIFEST_NAME, &this.manifest)?;
        Ok(this)
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its manifest.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Place of a file in it.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes a whole file, or leaves the old one as it was.
    ///
    /// # Errors
    /// [`StorageError`] when it cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StorageError> {
        storage::write_atomically(&self.file(name), bytes)
    }

    /// Writes a whole file of JSON, indented for people.
    ///
    /// # Errors
    /// [`StorageError`] when it cannot be written.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), StorageError> {
        let file = self.file(name);
        let mut text = serde_json::to_vec_pretty(value)
            .map_err(|error| StorageError::writing(&file, error.into()))?;
        text.push(b'\n');
        storage::write_atomically(&file, &text)
    }

    /// Appends one line to a file of lines.
    ///
    /// # Errors
    /// [`StorageError`] when it cannot be written; the lines before it stay.
    pub fn append_line(&self, name: &str, line: &str) -> Result<(), StorageError> {
        storage::append_line(&self.file(name), line)
    }

    /// Its snapshots.
    #[must_use]
    pub fn snapshots(&self) -> Snapshots {
        Snapshots::of_run(&self.path)
    }

    /// Place of the next recording: a recording of what came before a crash stays.
    #[must_use]
    pub fn next_recording(&self) -> PathBuf {
        let mut file = self.file(RECORDING_NAME);
        let mut number = 2;
        while file.exists() {
            file = self.file(&RECORDING_NAME.replace('.', &format!("-{number}.")));
            number += 1;
        }
        file
    }

    /// Writes into the manifest that the run goes on.
    ///
    /// # Errors
    /// [`StorageError`] when it cannot be written.
    pub fn resume(&mut self) -> Result<(), StorageError> {
        self.manifest.ended = None;
        self.manifest.exit_code = None;
        self.manifest.stopped = false;
        self.manifest.resumed += 1;
        self.write_json(MANIFEST_NAME, &self.manifest)
    }

    /// Writes into the manifest how the run ended, and whether it was stopped on request.
    ///
    /// # Errors
    /// [`StorageError`] when it cannot be written.
    pub fn finish(
        &mut self,
        ended: UtcTime,
        exit_code: u8,
        is_stopped: bool,
    ) -> Result<(), StorageError> {
        self.manifest.ended = Some(ended.to_string());
        self.manifest.exit_code = Some(exit_code);
        self.manifest.stopped = is_stopped;
        self.write_json(MANIFEST_NAME, &self.manifest)
    }
}

fn make_dir_all(path: &Path) -> Result<(), StorageError> {
    fs::create_dir_all(path).map_err(|error| StorageError::writing(path, error))
}

/// The words with everything but letters, digits, `_` and `.` made `-`, so that they can be part of a file name.
fn file_name_of(words: &str) -> String {
    words
        .chars()
        .map(|c| {
            if c.is_alphanumeric() || matches!(c, '_' | '.') {
                c
            } else {
                '-'
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn started() -> UtcTime {
        UtcTime::from_unix_secs(1_735_689_599)
    }

    fn manifest() -> Manifest {
        let command = ["factotum", "run", "--seed", "7"]
            .map(str::to_owned)
            .to_vec();
        Manifest::begin("factotum 0.1.0", command, "household", 7, started())
    }

    #[test]
    fn folders_are_named_by_date_scene_and_seed() {
        let dir = tempfile::tempdir().unwrap();
        let runs = dir.path().join("runs");
        let first = RunFolder::create_in(&runs, started(), manifest()).unwrap();
        let second = RunFolder::create_in(&runs, started(), manifest()).unwrap();
        assert_eq!(first.path(), runs.join("2024-12-31-household-7"));
        assert_eq!(second.path(), runs.join("2024-12-31-household-7-2"));
    }

    #[test]
    fn a_scene_cannot_lead_out_of_the_runs() {
        let dir = tempfile::tempdir().unwrap();
        let escaping = Manifest {
            scene: "../../elsewhere".to_owned(),
            ..manifest()
        };
        let folder = RunFolder::create_in(dir.path(), started(), escaping).unwrap();
        assert_eq!(folder.path().parent(), Some(dir.path()));
    }

    #[test]
    fn the_manifest_says_how_the_run_ended() {
        let dir = tempfile::tempdir().unwrap();
        let mut folder = RunFolder::create_at(&dir.path().join("out"), manifest()).unwrap();
        let crashed = RunFolder::open(folder.path()).unwrap();
        assert_eq!(crashed.manifest().exit_code, None);
        folder
            .finish(UtcTime::from_unix_secs(1_735_689_660), 1, true)
            .unwrap();
        let finished = RunFolder::open(folder.path()).unwrap();
        assert_eq!(finished.manifest(), folder.manifest());
        assert_eq!(
            finished.manifest().ended.as_deref(),
            Some("2025-01-01T00:01:00Z")
        );
        assert_eq!(finished.manifest().exit_code, Some(1));
        assert!(finished.manifest().stopped);
    }

    #[test]
    fn a_run_that_goes_on_has_not_ended_and_records_anew() {
        let dir = tempfile::tempdir().unwrap();
        let mut folder = RunFolder::create_at(&dir.path().join("out"), manifest()).unwrap();
        for name in ["recording.mcap", "recording-2.mcap", "recording-3.mcap"] {
            assert_eq!(folder.next_recording(), folder.file(name));
            folder.write(name, b"recorded").unwrap();
        }
        let ended = UtcTime::from_unix_secs(1_735_689_660);
        folder.finish(ended, 1, true).unwrap();
        folder.resume().unwrap();
        let again = RunFolder::open(folder.path()).unwrap();
        let begun = Manifest {
            resumed: 1,
            ..manifest()
        };
        assert_eq!(again.manifest(), &begun);
    }

    #[test]
    fn a_manifest_of_before_there_were_resumes_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let text = r#"{"program": "factotum 0.1.0", "command": [], "scene": "household", "seed": 7,
            "started": "2024-12-31T23:59:59Z", "ended": null, "exit_code": null}"#;
        fs::write(dir.path().join(MANIFEST_NAME), text).unwrap();
        let folder = RunFolder::open(dir.path()).unwrap();
        assert!(folder.manifest().options.is_empty());
    }

    #[test]
    fn a_folder_in_use_is_not_taken() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("thesis.txt"), "years of work").unwrap();
        let error = RunFolder::create_at(dir.path(), manifest()).unwrap_err();
        assert!(
            matches!(error, RunFolderError::NotEmpty { .. }),
            "{error:?}"
        );
    }

    #[test]
    fn a_broken_manifest_is_named() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join(MANIFEST_NAME), "{\"seed\": ").unwrap();
        let error = RunFolder::open(dir.path()).unwrap_err();
        assert!(error.to_string().contains(MANIFEST_NAME), "{error}");
        let error = RunFolder::open(&dir.path().join("nowhere")).unwrap_err();
        assert!(
            matches!(error, RunFolderError::Storage(StorageError::Read { .. })),
            "{error:?}"
        );
    }
}
