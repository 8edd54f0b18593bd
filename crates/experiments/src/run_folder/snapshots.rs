//! Snapshots of a run under way: whole files in a folder of their own, of which the last few are kept.
//!
//! A file is `NNNN.snapshot`, numbered in the order of saving: the SHA-256 of its content, then the content. One that is
//! cut short or changed is told by its digest; the one before it is still there. What a content means is for whoever
//! runs to say.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};
use thiserror::Error;

use crate::storage::{self, StorageError};

/// Name of the folder of snapshots in a run folder.
pub const SNAPSHOTS_NAME: &str = "snapshots";
/// Snapshots kept: the newest, and two to fall back to.
pub const N_SNAPSHOTS_KEPT: usize = 3;

const EXTENSION: &str = "snapshot";
const DIGEST_LEN: usize = 32;

/// A snapshot that cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Its file could not be read.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// Its file is not as it was saved.
    #[error("snapshot `{}` is damaged: {found}", file.display())]
    Damaged {
        /// The file.
        file: PathBuf,
        /// What was found and what was wanted.
        found: String,
    },
}

/// The snapshots of a run.
#[derive(Debug, Clone)]
pub struct Snapshots {
    folder: PathBuf,
}

impl Snapshots {
    pub(super) fn of_run(run_folder: &Path) -> Self {
        Self {
            folder: run_folder.join(SNAPSHOTS_NAME),
        }
    }

    /// Saves a snapshot, and then lets go of those that are too old.
    ///
    /// # Errors
    /// [`StorageError`] when it cannot be written; those before it are kept then.
    pub fn save(&self, content: &[u8]) -> Result<PathBuf, StorageError> {
        fs::create_dir_all(&self.folder)
            .map_err(|error| StorageError::writing(&self.folder, error))?;
        let older = self.numbers()?;
        let file = self.file(older.last().map_or(1, |last| last + 1));
        let mut bytes = Sha256::digest(content).to_vec();
        bytes.extend_from_slice(content);
        storage::write_atomically(&file, &bytes)?;
        let n_spent = (older.len() + 1).saturating_sub(N_SNAPSHOTS_KEPT);
        for number in older.into_iter().take(n_spent) {
            let spent = self.file(number);
            fs::remove_file(&spent).map_err(|error| StorageError::writing(&spent, error))?;
        }
        Ok(file)
    }

    /// The newest snapshot that `read` can make something of, if there is one, and what is wrong with those after it.
    ///
    /// # Errors
    /// [`StorageError`] when the folder cannot be listed.
    pub fn newest<T>(
        &self,
        read: impl Fn(&[u8]) -> Result<T, String>,
    ) -> Result<(Option<T>, Vec<SnapshotError>), StorageError> {
        let mut problems = Vec::new();
        for number in self.numbers()?.into_iter().rev() {
            match self.content(number, &read) {
                Ok(content) => return Ok((Some(content), problems)),
                Err(problem) => problems.push(problem),
            }
        }
        Ok((None, problems))
    }

    fn content<T>(
        &self,
        number: u32,
        read: impl Fn(&[u8]) -> Result<T, String>,
    ) -> Result<T, SnapshotError> {
        let file = self.file(number);
        let bytes = fs::read(&file).map_err(|error| StorageError::reading(&file, error))?;
        let damaged = |found| SnapshotError::Damaged {
            file: file.clone(),
            found,
        };
        match bytes.split_first_chunk::<DIGEST_LEN>() {
            None => Err(damaged(format!(
                "{} bytes, expected at least {DIGEST_LEN}",
                bytes.len()
            ))),
            Some((digest, content)) if *digest != *Sha256::digest(content) => {
                Err(damaged(format!(
                    "its {} bytes do not have the digest it begins with",
                    content.len()
                )))
            }
            Some((_, content)) => read(content).map_err(damaged),
        }
    }

    /// Numbers of the snapshots there are, the oldest first.
    fn numbers(&self) -> Result<Vec<u32>, StorageError> {
        let entries = match fs::read_dir(&self.folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(StorageError::reading(&self.folder, error)),
        };
        let mut numbers = Vec::new();
        for entry in entries {
            let entry = entry.map_err(|error| StorageError::reading(&self.folder, error))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let number = name
                .split_once('.')
                .filter(|(_, extension)| *extension == EXTENSION)
                .and_then(|(number, _)| number.parse::<u32>().ok());
            numbers.extend(number);
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    fn file(&self, number: u32) -> PathBuf {
        self.folder.join(format!("{number:04}.{EXTENSION}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> Result<String, String> {
        String::from_utf8(bytes.to_vec()).map_err(|error| error.to_string())
    }

    fn saved(contents: &[&str]) -> (tempfile::TempDir, Snapshots, Vec<PathBuf>) {
        let dir = tempfile::tempdir().unwrap();
        let snapshots = Snapshots::of_run(dir.path());
        let files = contents
            .iter()
            .map(|content| snapshots.save(content.as_bytes()).unwrap())
            .collect();
        (dir, snapshots, files)
    }

    #[test]
    fn the_newest_is_read_and_only_the_last_few_are_kept() {
        let (_dir, snapshots, files) = saved(&["one", "two", "three", "four", "five"]);
        let (newest, problems) = snapshots.newest(text).unwrap();
        assert_eq!(newest.as_deref(), Some("five"));
        assert!(problems.is_empty(), "{problems:?}");
        let kept: Vec<bool> = files.iter().map(|file| file.exists()).collect();
        assert_eq!(kept, [false, false, true, true, true]);
    }

    #[test]
    fn without_snapshots_there_is_none() {
        let (_dir, snapshots, _) = saved(&[]);
        let (newest, problems) = snapshots.newest(text).unwrap();
        assert!(newest.is_none() && problems.is_empty());
    }

    #[test]
    fn a_damaged_one_is_named_and_the_one_before_it_read() {
        let (_dir, snapshots, files) = saved(&["one", "two", "three"]);
        let whole = fs::read(&files[2]).unwrap();
        let spoilt = |bytes: &[u8]| {
            fs::write(&files[2], bytes).unwrap();
            snapshots.newest(text).unwrap()
        };
        for cut in 0..whole.len() {
            let (newest, problems) = spoilt(&whole[..cut]);
            assert_eq!(newest.as_deref(), Some("two"), "cut to {cut} bytes");
            assert!(
                problems[0]
                    .to_string()
                    .contains("0003.snapshot` is damaged"),
                "{problems:?}"
            );
        }
        for place in 0..whole.len() {
            let mut changed = whole.clone();
            changed[place] ^= 0x10;
            assert_eq!(spoilt(&changed).0.as_deref(), Some("two"), "byte {place}");
        }
        fs::write(&files[1], b"").unwrap();
        let (newest, problems) = snapshots.newest(text).unwrap();
        assert_eq!((newest.as_deref(), problems.len()), (Some("one"), 2));
    }

    #[test]
    fn one_that_makes_no_sense_is_passed_over() {
        let (_dir, snapshots, _) = saved(&["one", "two"]);
        let refuse_two = |bytes: &[u8]| match bytes {
            b"two" => Err("of a later version".to_owned()),
            other => text(other),
        };
        let (newest, problems) = snapshots.newest(refuse_two).unwrap();
        assert_eq!(newest.as_deref(), Some("one"));
        assert!(
            problems[0].to_string().ends_with("of a later version"),
            "{problems:?}"
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn on_a_full_disk_those_before_are_kept() {
        let (dir, snapshots, _) = saved(&["one", "two", "three"]);
        let unfinished = dir.path().join("snapshots/.0004.snapshot.unfinished");
        std::os::unix::fs::symlink("/dev/full", unfinished).unwrap();
        let error = snapshots.save(b"four").unwrap_err();
        assert!(matches!(error, StorageError::DiskFull { .. }), "{error:?}");
        assert!(error.to_string().contains("0004.snapshot"), "{error}");
        assert_eq!(snapshots.newest(text).unwrap().0.as_deref(), Some("three"));
    }
}
