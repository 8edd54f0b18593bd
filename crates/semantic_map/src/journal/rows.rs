//! Entries as rows of tables.

use factotum_task_planning::operator::GroundAction;
use rusqlite::{OptionalExtension as _, Row, Transaction, params};

use super::{Entry, EntryKind, Execution, FileDigests, NewEntry, Request};
use crate::home_folder;

/// Requests that are remembered: a page asks again within seconds, or minutes.
const REQUESTS_MAX: i64 = 1024;

/// Writes an entry with all that belongs to it, and answers its number.
pub(super) fn write_entry(
    transaction: &Transaction<'_>,
    entry: &NewEntry<'_>,
) -> rusqlite::Result<i64> {
    let (what, target) = match entry.kind {
        EntryKind::Created => (String::new(), None),
        EntryKind::Edit { what } => (what.clone(), None),
        EntryKind::Undo { edit, what } | EntryKind::Redo { edit, what } => {
            (what.clone(), Some(*edit))
        }
        EntryKind::Execution(execution) => (execution.step.to_string(), None),
    };
    transaction.prepare_cached("INSERT INTO entries (when_secs, author, kind, what, target) VALUES (?1, ?2, ?3, ?4, ?5)")?
        .execute(params![entry.when_secs, entry.by.author, kind_name(entry.kind), what, target])?;
    let id = transaction.last_insert_rowid();
    if let EntryKind::Execution(Execution {
        step,
        outcome,
        robot_secs,
    }) = entry.kind
    {
        transaction.execute(
            "INSERT INTO executions VALUES (?1, ?2, ?3, ?4, ?5)",
            params![id, step.name, step.args.join(" "), outcome, robot_secs],
        )?;
    }
    for (document, bytes) in entry.changes {
        write_change(transaction, id, document, bytes.as_deref())?;
    }
    if let Some(request) = &entry.by.request {
        write_request(transaction, id, request)?;
    }
    write_files(transaction, entry.files)?;
    Ok(id)
}

/// Remembers the request that made an entry, and forgets the oldest.
fn write_request(
    transaction: &Transaction<'_>,
    entry: i64,
    request: &Request<'_>,
) -> rusqlite::Result<()> {
    let digest = home_folder::digest(request.content);
    transaction
        .prepare_cached("INSERT OR REPLACE INTO requests VALUES (?1, ?2, ?3, ?4)")?
        .execute(params![request.id, digest, entry, request.answer])?;
    transaction
        .prepare_cached(
            "DELETE FROM requests WHERE entry <=
             (SELECT entry FROM requests ORDER BY entry DESC LIMIT 1 OFFSET ?1)",
        )?
        .execute(params![REQUESTS_MAX])?;
    Ok(())
}

/// Notes the digests of text files.
pub(super) fn write_files(
    transaction: &Transaction<'_>,
    files: &FileDigests,
) -> rusqlite::Result<()> {
    for (path, digest) in files {
        match digest {
            Some(digest) => transaction.execute(
                "INSERT OR REPLACE INTO files VALUES (?1, ?2)",
                params![path, digest],
            )?,
            None => transaction.execute("DELETE FROM files WHERE path = ?1", params![path])?,
        };
    }
    Ok(())
}

/// Writes what an entry does to one document, and the document.
fn write_change(
    transaction: &Transaction<'_>,
    entry: i64,
    document: &str,
    bytes: Option<&[u8]>,
) -> rusqlite::Result<()> {
    let before: Option<i64> = transaction
        .prepare_cached("SELECT content FROM documents WHERE name = ?1")?
        .query_row(params![document], |row| row.get(0))
        .optional()?;
    let after = match bytes {
        Some(bytes) => {
            transaction
                .prepare_cached("INSERT INTO contents (bytes) VALUES (?1)")?
                .execute(params![bytes])?;
            let content = transaction.last_insert_rowid();
            transaction
                .prepare_cached("INSERT OR REPLACE INTO documents VALUES (?1, ?2)")?
                .execute(params![document, content])?;
            Some(content)
        }
        None => {
            transaction.execute("DELETE FROM documents WHERE name = ?1", params![document])?;
            None
        }
    };
    transaction
        .prepare_cached("INSERT INTO changes VALUES (?1, ?2, ?3, ?4)")?
        .execute(params![entry, document, before, after])?;
    Ok(())
}

/// Name of a kind in the table.
pub(super) fn kind_name(kind: &EntryKind) -> &'static str {
    match kind {
        EntryKind::Created => "created",
        EntryKind::Edit { .. } => "edit",
        EntryKind::Undo { .. } => "undo",
        EntryKind::Redo { .. } => "redo",
        EntryKind::Execution(_) => "execution",
    }
}

/// Reads a row of entries joined with executions.
pub(super) fn entry_of_row(row: &Row<'_>) -> rusqlite::Result<Entry> {
    let what: String = row.get(4)?;
    let kind = match row.get::<_, String>(3)?.as_str() {
        "edit" => EntryKind::Edit { what },
        "undo" => EntryKind::Undo {
            edit: row.get(5)?,
            what,
        },
        "redo" => EntryKind::Redo {
            edit: row.get(5)?,
            what,
        },
        "execution" => {
            let args: String = row.get(7)?;
            let step = GroundAction::new(row.get::<_, String>(6)?, args.split_whitespace());
            EntryKind::Execution(Execution {
                step,
                outcome: row.get(8)?,
                robot_secs: row.get(9)?,
            })
        }
        _ => EntryKind::Created,
    };
    Ok(Entry {
        id: row.get(0)?,
        when_secs: row.get(1)?,
        author: row.get(2)?,
        kind,
    })
}
