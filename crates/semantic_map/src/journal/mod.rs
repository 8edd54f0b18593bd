//! The journal of a home: every edit and every execution in order, in one SQLite file.
//!
//! An entry is one transaction, on disk when it returns (write-ahead log, `synchronous = FULL`). What an edit changed
//! is kept as the documents' contents before and after, so undo and redo need to know nothing of what an edit means.
//! Entries are only ever added: an undo is an entry too. Beside them the file holds the documents as they are now, and
//! the digest of each text file as it was last known to be on disk.
//!
//! The file is locked as long as it is open; the lock needs no shared memory, so the folder may lie on a network drive.

mod entry;
mod rows;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, ErrorCode, OpenFlags, Row, TransactionBehavior, params};

use crate::MapError;
use crate::edit::DocumentChanges;
use crate::home_folder::{self, Documents};

pub use entry::{By, Change, Entry, EntryKind, Execution, Remembered, Request};
use rows::{entry_of_row, kind_name, write_entry, write_files};

/// Name of the journal in the home folder.
pub(crate) const FILE: &str = "journal.sqlite";
/// Marks the file as ours ("Fact" in ASCII).
const APPLICATION_ID: i64 = 0x4661_6374;
/// Format of the tables.
const FORMAT: i64 = 1;
/// How long to wait for another process to let go of the file.
const LOCK_TIMEOUT: Duration = Duration::from_millis(200);

const TABLES: &str = "
    CREATE TABLE entries (
        id INTEGER PRIMARY KEY, when_secs REAL NOT NULL, author TEXT NOT NULL,
        kind TEXT NOT NULL, what TEXT NOT NULL, target INTEGER REFERENCES entries
    ) STRICT;
    CREATE TABLE executions (
        entry INTEGER PRIMARY KEY REFERENCES entries, action TEXT NOT NULL, args TEXT NOT NULL,
        outcome TEXT NOT NULL, robot_secs REAL NOT NULL
    ) STRICT;
    CREATE TABLE contents (id INTEGER PRIMARY KEY, bytes BLOB NOT NULL) STRICT;
    CREATE TABLE changes (
        entry INTEGER NOT NULL REFERENCES entries, document TEXT NOT NULL,
        before INTEGER REFERENCES contents, after INTEGER REFERENCES contents,
        PRIMARY KEY (entry, document)
    ) STRICT, WITHOUT ROWID;
    CREATE TABLE documents (name TEXT PRIMARY KEY, content INTEGER NOT NULL REFERENCES contents) STRICT, WITHOUT ROWID;
    CREATE TABLE files (path TEXT PRIMARY KEY, digest BLOB NOT NULL) STRICT, WITHOUT ROWID;
";

/// Requests whose entry is remembered. Journals of before get the table when they are opened.
const REQUESTS_TABLE: &str = "
    CREATE TABLE IF NOT EXISTS requests (
        id TEXT PRIMARY KEY, digest BLOB NOT NULL, entry INTEGER NOT NULL REFERENCES entries, answer TEXT NOT NULL
    ) STRICT;
    CREATE INDEX IF NOT EXISTS requests_by_entry ON requests (entry);
";

/// Digest by file, as last known to be on disk; none where the file is gone.
pub(crate) type FileDigests = BTreeMap<String, Option<[u8; 32]>>;

/// Entries that changed a document.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Revisions {
    pub(crate) first: i64,
    pub(crate) last: i64,
}

/// What to write with an entry.
pub(crate) struct NewEntry<'a> {
    pub(crate) kind: &'a EntryKind,
    pub(crate) by: By<'a>,
    pub(crate) when_secs: f64,
    pub(crate) changes: &'a DocumentChanges,
    pub(crate) files: &'a FileDigests,
}

/// The open journal of a home.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    connection: Connection,
    /// Edits that hold, oldest first.
    done: Vec<i64>,
    /// Edits that were undone, the one to redo next last.
    undone: Vec<i64>,
}

impl Journal {
    /// Makes the journal of a home that holds `documents`. It gets its name when it is whole.
    pub(crate) fn create(
        dir: &Path,
        documents: &Documents,
        author: &str,
        when_secs: f64,
    ) -> Result<Self, MapError> {
        let path = dir.join(FILE);
        let part_name = ".journal.sqlite.part";
        let part = dir.join(part_name);
        for leftover in [part_name, ".journal.sqlite.part-journal"] {
            home_folder::remove(dir, leftover)?;
        }
        let changes = documents
            .iter()
            .map(|(name, bytes)| (name.clone(), Some(bytes.clone())))
            .collect();
        let entry = NewEntry {
            kind: &EntryKind::Created,
            by: author.into(),
            when_secs,
            changes: &changes,
            files: &FileDigests::new(),
        };
        let build = || -> rusqlite::Result<()> {
            let mut connection = Connection::open(&part)?;
            connection.pragma_update(None, "synchronous", "FULL")?;
            connection.pragma_update(None, "application_id", APPLICATION_ID)?;
            connection.pragma_update(None, "user_version", FORMAT)?;
            let transaction = connection.transaction()?;
            transaction.execute_batch(TABLES)?;
            write_entry(&transaction, &entry)?;
            transaction.commit()?;
            connection.close().map_err(|(_, error)| error)
        };
        build().map_err(|source| explain(&path, source))?;
        home_folder::rename(&part, &path)?;
        Self::open(dir)
    }

    /// Opens the journal of a folder and checks that it is whole.
    pub(crate) fn open(dir: &Path) -> Result<Self, MapError> {
        let path = dir.join(FILE);
        let damaged = |found: String| MapError::JournalDamaged {
            path: path.clone(),
            found,
        };
        let failed = |source| explain(&path, source);
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(&path, flags).map_err(failed)?;
        let identify = || -> rusqlite::Result<(i64, i64)> {
            connection.busy_timeout(LOCK_TIMEOUT)?;
            connection.pragma_update(None, "locking_mode", "EXCLUSIVE")?;
            let number = |name| connection.pragma_query_value(None, name, |row| row.get(0));
            Ok((number("application_id")?, number("user_version")?))
        };
        let (application, format) = identify().map_err(failed)?;
        if application != APPLICATION_ID {
            return Err(damaged(format!(
                "application id {application:#x}, expected {APPLICATION_ID:#x}"
            )));
        }
        if format != FORMAT {
            let problem = format!("journal has format {format}, expected {FORMAT}");
            return Err(MapError::Home { path, problem });
        }
        let prepare = || -> rusqlite::Result<String> {
            connection.pragma_update(None, "journal_mode", "WAL")?;
            connection.pragma_update(None, "synchronous", "FULL")?;
            // The lock is taken by the first write, and kept.
            connection.execute_batch(&format!("BEGIN IMMEDIATE; {REQUESTS_TABLE} COMMIT;"))?;
            connection.pragma_query_value(None, "quick_check", |row| row.get(0))
        };
        let health = prepare().map_err(failed)?;
        if health != "ok" {
            return Err(damaged(health));
        }
        let mut journal = Self {
            path,
            connection,
            done: Vec::new(),
            undone: Vec::new(),
        };
        journal.find_edits()?;
        Ok(journal)
    }

    /// Goes through the entries to find which edits hold.
    fn find_edits(&mut self) -> Result<(), MapError> {
        let entries = self.query(
            "SELECT id, kind FROM entries ORDER BY id",
            params![],
            |row| Ok((row.get(0)?, row.get::<_, String>(1)?)),
        )?;
        for (id, kind) in entries {
            self.step(id, &kind);
        }
        Ok(())
    }

    fn step(&mut self, id: i64, kind: &str) {
        match kind {
            "edit" => {
                self.done.push(id);
                self.undone.clear();
            }
            "undo" => self.undone.extend(self.done.pop()),
            "redo" => self.done.extend(self.undone.pop()),
            _ => {}
        }
    }

    /// Adds an entry. It is on disk when this returns.
    pub(crate) fn append(&mut self, entry: &NewEntry<'_>) -> Result<i64, MapError> {
        let mut append = || -> rusqlite::Result<i64> {
            let transaction = self
                .connection
                .transaction_with_behavior(TransactionBehavior::Immediate)?;
            let id = write_entry(&transaction, entry)?;
            transaction.commit()?;
            Ok(id)
        };
        let id = append().map_err(|source| explain(&self.path, source))?;
        self.step(id, kind_name(entry.kind));
        Ok(id)
    }

    /// Notes what has become of the text files.
    pub(crate) fn confirm(&mut self, files: &FileDigests) -> Result<(), MapError> {
        let mut confirm = || -> rusqlite::Result<()> {
            let transaction = self.connection.transaction()?;
            write_files(&transaction, files)?;
            transaction.commit()
        };
        confirm().map_err(|source| explain(&self.path, source))
    }

    /// The edit that undo would undo.
    pub(crate) fn last_done(&self) -> Option<i64> {
        self.done.last().copied()
    }

    /// The edit that redo would do again.
    pub(crate) fn last_undone(&self) -> Option<i64> {
        self.undone.last().copied()
    }

    /// Number of the last entry.
    pub(crate) fn last_entry(&self) -> Result<i64, MapError> {
        let sql = "SELECT coalesce(max(id), 0) FROM entries";
        let found = self.query(sql, params![], |row| row.get(0))?;
        Ok(found.into_iter().next().unwrap_or_default())
    }

    /// An edit in a few words.
    pub(crate) fn what(&self, edit: i64) -> Result<String, MapError> {
        let sql = "SELECT what FROM entries WHERE id = ?1";
        let found = self.query(sql, params![edit], |row| row.get(0))?;
        Ok(found.into_iter().next().unwrap_or_default())
    }

    /// The documents as they are now.
    pub(crate) fn documents(&self) -> Result<Documents, MapError> {
        let sql = "SELECT name, bytes FROM documents JOIN contents ON contents.id = content";
        Ok(self
            .query(sql, params![], |row| Ok((row.get(0)?, row.get(1)?)))?
            .into_iter()
            .collect())
    }

    /// The digests of the text files as last known to be on disk.
    pub(crate) fn files(&self) -> Result<BTreeMap<String, [u8; 32]>, MapError> {
        let files = self.query("SELECT path, digest FROM files", params![], |row| {
            Ok((row.get(0)?, row.get(1)?))
        })?;
        Ok(files.into_iter().collect())
    }

    /// What an entry changed.
    pub(crate) fn changes(&self, entry: i64) -> Result<Vec<Change>, MapError> {
        let sql = "SELECT document, b.bytes, a.bytes FROM changes
                   LEFT JOIN contents b ON b.id = before LEFT JOIN contents a ON a.id = after
                   WHERE entry = ?1 ORDER BY document";
        self.query(sql, params![entry], |row| {
            Ok(Change {
                document: row.get(0)?,
                before: row.get(1)?,
                after: row.get(2)?,
            })
        })
    }

    /// First and last entry that changed a document, for every document there ever was.
    pub(crate) fn revisions(&self) -> Result<BTreeMap<String, Revisions>, MapError> {
        let sql = "SELECT document, min(entry), max(entry) FROM changes GROUP BY document";
        let found = self.query(sql, params![], |row| {
            let (first, last) = (row.get(1)?, row.get(2)?);
            Ok((row.get(0)?, Revisions { first, last }))
        })?;
        Ok(found.into_iter().collect())
    }

    /// An entry.
    pub(crate) fn entry(&self, id: i64) -> Result<Option<Entry>, MapError> {
        let sql =
            "SELECT id, when_secs, author, kind, what, target, action, args, outcome, robot_secs
                   FROM entries LEFT JOIN executions ON entry = id WHERE id = ?1";
        Ok(self.query(sql, params![id], entry_of_row)?.pop())
    }

    /// What became of a request, if it has been journaled and not been forgotten for newer ones.
    pub(crate) fn remembered(&self, id: &str) -> Result<Option<Remembered>, MapError> {
        let sql = "SELECT digest, entry, answer FROM requests WHERE id = ?1";
        let mut found = self.query(sql, params![id], |row| {
            Ok(Remembered {
                digest: row.get(0)?,
                entry: row.get(1)?,
                answer: row.get(2)?,
            })
        })?;
        Ok(found.pop())
    }

    /// The latest entries, the newest first.
    pub(crate) fn history(&self, limit: usize) -> Result<Vec<Entry>, MapError> {
        let sql =
            "SELECT id, when_secs, author, kind, what, target, action, args, outcome, robot_secs
                   FROM entries LEFT JOIN executions ON entry = id ORDER BY id DESC LIMIT ?1";
        self.query(
            sql,
            params![i64::try_from(limit).unwrap_or(i64::MAX)],
            entry_of_row,
        )
    }

    fn query<T>(
        &self,
        sql: &str,
        params: impl rusqlite::Params,
        read: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, MapError> {
        let query = || -> rusqlite::Result<Vec<T>> {
            self.connection
                .prepare_cached(sql)?
                .query_map(params, read)?
                .collect()
        };
        query().map_err(|source| explain(&self.path, source))
    }
}

/// Tells a journal that is in use or broken from one that cannot be read or written now.
fn explain(path: &Path, source: rusqlite::Error) -> MapError {
    let path = path.to_owned();
    match source.sqlite_error_code() {
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => MapError::InUse {
            path: path.parent().unwrap_or(Path::new("")).to_owned(),
        },
        Some(ErrorCode::NotADatabase | ErrorCode::DatabaseCorrupt) => MapError::JournalDamaged {
            path,
            found: source.to_string(),
        },
        _ => MapError::Journal { path, source },
    }
}
