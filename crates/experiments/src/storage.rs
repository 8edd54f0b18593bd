//! Writing files so that a full disk or a crash loses nothing that was accepted.
//!
//! A whole file is written beside its place, synced and then renamed into it: readers see the old file or the new one.
//! A line is appended in one write; when that fails part of the way, the file is cut back to its whole lines.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A file that could not be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StorageError {
    /// There is no room left.
    #[error(
        "no space left on the disk of `{folder}` while writing `{file}`; what was written before is kept",
        folder = folder.display(),
        file = file.display()
    )]
    DiskFull {
        /// The file that could not be written.
        file: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// It could not be written for another reason.
    #[error("cannot write `{}`", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It could not be read.
    #[error("cannot read `{}`", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl StorageError {
    /// The error of writing a file, with a full disk told from the rest.
    #[must_use]
    pub fn writing(file: &Path, source: io::Error) -> Self {
        match source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::DiskFull {
                file: file.to_path_buf(),
                folder: file.parent().unwrap_or(Path::new(".")).to_path_buf(),
            },
            _ => Self::Write {
                file: file.to_path_buf(),
                source,
            },
        }
    }

    /// The error of reading a file.
    #[must_use]
    pub fn reading(file: &Path, source: io::Error) -> Self {
        Self::Read {
            file: file.to_path_buf(),
            source,
        }
    }
}

/// Writes a whole file, or leaves the old one as it was.
///
/// # Errors
/// [`StorageError`] when the file cannot be written; the unfinished copy is removed.
pub fn write_atomically(file: &Path, bytes: &[u8]) -> Result<(), StorageError> {
    let unfinished = unfinished_copy(file);
    let written = File::create(&unfinished)
        .and_then(|mut copy| {
            copy.write_all(bytes)?;
            copy.sync_all()
        })
        .and_then(|()| fs::rename(&unfinished, file));
    written.map_err(|error| {
        // The error of the write is the one to tell; a copy that stays behind is overwritten by the next write.
        drop(fs::remove_file(&unfinished));
        StorageError::writing(file, error)
    })
}

/// Appends one line to a file of lines, making the file if there is none.
///
/// # Errors
/// [`StorageError`] when the line cannot be written whole; the lines before it stay.
pub fn append_line(file: &Path, line: &str) -> Result<(), StorageError> {
    let failed = |error| StorageError::writing(file, error);
    let mut lines = OpenOptions::new()
        .append(true)
        .create(true)
        .open(file)
        .map_err(failed)?;
    let length_before = lines.metadata().map_err(failed)?.len();
    lines
        .write_all(format!("{line}\n").as_bytes())
        .and_then(|()| lines.sync_data())
        .map_err(|error| {
            // Half a line would spoil the file for its readers; nothing more can be done if this fails too.
            drop(lines.set_len(length_before));
            failed(error)
        })
}

/// Drops a last line that a crash cut short, so that the next line appended stands alone.
///
/// # Errors
/// [`StorageError`] when the file cannot be read or cut. A file that is not there has whole lines.
pub fn keep_whole_lines(file: &Path) -> Result<(), StorageError> {
    let bytes = match fs::read(file) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(StorageError::reading(file, error)),
    };
    let whole = bytes
        .iter()
        .rposition(|&byte| byte == b'\n')
        .map_or(0, |last| last + 1);
    if whole < bytes.len() {
        let cut = OpenOptions::new()
            .write(true)
            .open(file)
            .and_then(|lines| lines.set_len(whole as u64));
        cut.map_err(|error| StorageError::writing(file, error))?;
    }
    Ok(())
}

fn unfinished_copy(file: &Path) -> PathBuf {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    file.with_file_name(format!(".{name}.unfinished"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("report.html");
        write_atomically(&file, b"first").unwrap();
        write_atomically(&file, b"second").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"second");
        assert_eq!(
            fs::read_dir(dir.path()).unwrap().count(),
            1,
            "no copy stays behind"
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_leaves_the_old_file_and_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("report.html");
        write_atomically(&file, b"old").unwrap();
        // Linux's /dev/full takes nothing and says that the disk is full.
        std::os::unix::fs::symlink("/dev/full", unfinished_copy(&file)).unwrap();
        let error = write_atomically(&file, b"new").unwrap_err();
        assert!(matches!(error, StorageError::DiskFull { .. }), "{error:?}");
        let message = error.to_string();
        assert!(
            message.contains("report.html") && message.contains(&*dir.path().to_string_lossy()),
            "{message}"
        );
        assert_eq!(fs::read(&file).unwrap(), b"old");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_line_on_a_full_disk_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("results.jsonl");
        std::os::unix::fs::symlink("/dev/full", &file).unwrap();
        let error = append_line(&file, "{}").unwrap_err();
        assert!(matches!(error, StorageError::DiskFull { .. }), "{error:?}");
    }

    #[test]
    fn lines_are_appended_and_a_cut_one_is_dropped() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("results.jsonl");
        keep_whole_lines(&file).unwrap();
        append_line(&file, "one").unwrap();
        fs::write(&file, "one\ntw").unwrap();
        keep_whole_lines(&file).unwrap();
        append_line(&file, "two").unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "one\ntwo\n");
    }

    #[test]
    fn a_folder_that_is_not_there_is_another_error() {
        let error = write_atomically(Path::new("no/such/folder/file"), b"").unwrap_err();
        assert!(matches!(error, StorageError::Write { .. }), "{error:?}");
    }
}
