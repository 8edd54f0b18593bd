//! A home that is kept: the AOSM, its folder of text files and its journal, in step.
//!
//! The journal is the truth. An edit is first a transaction of the journal, and only then new text files; whatever
//! stops the process in between, [`Home::open`] brings the files up to the journal. It tells a file that a crash left
//! behind from one that a person changed by the digest of what was last written: a file with any other digest has been
//! changed outside, and is taken in as an edit by `file`, or refused by name if it makes no sense.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::edit::{DocumentChanges, Edit, HomeView, Thing, difference};
use crate::home_folder::{
    self, CLOUD, DOMAIN, Documents, HOME, is_object_document, object_document,
};
use crate::journal::{
    self, By, Change, Entry, EntryKind, Execution, FileDigests, Journal, NewEntry, Remembered,
    Revisions,
};
use crate::{Aosm, MapError};

/// Author of edits that were made in the text files.
const FILE_AUTHOR: &str = "file";

/// An open home folder. One process at a time may have it open; others can [`home_folder::read`] it.
///
/// Times are given by the caller in seconds since the epoch: nothing here reads a clock.
#[derive(Debug)]
pub struct Home {
    dir: PathBuf,
    name: String,
    aosm: Aosm,
    documents: Documents,
    journal: Journal,
    /// First and last entry that changed a document, those that are gone included.
    revisions: BTreeMap<String, Revisions>,
    /// The text files as they should be.
    wanted: BTreeMap<String, WantedFile>,
    /// The text files as they are.
    files: BTreeMap<String, KnownFile>,
    /// What has become of the text files since the journal last heard of them.
    unconfirmed: FileDigests,
    unwritten: Option<MapError>,
}

/// A text file as the journal wants it. The digest is kept, for the map and the cloud are large and change seldom.
#[derive(Debug, PartialEq)]
struct WantedFile {
    bytes: Vec<u8>,
    digest: [u8; 32],
}

/// A text file as it was last known to be.
#[derive(Debug, Clone, Copy, PartialEq)]
struct KnownFile {
    digest: [u8; 32],
    /// Length and time of change; none until it has been looked at.
    stamp: Option<(u64, SystemTime)>,
}

/// Which way an edit is gone through.
#[derive(Debug, Clone, Copy)]
enum Direction {
    /// To what was before it.
    Back,
    /// To what it made.
    Again,
}

/// A home folder in order, as [`Home::check`] found it.
#[derive(Debug)]
pub struct HomeCheck {
    /// Name of the home.
    pub name: String,
    /// What the text files say.
    pub aosm: Aosm,
    /// Entries of the journal; none where there is no journal yet.
    pub n_entries: Option<i64>,
    /// Documents that are not in the text files as they are in the journal: a person changed them, or a crash left them
    /// behind. [`Home::open`] brings them together.
    pub changed: Vec<String>,
}

impl Home {
    /// Makes a home folder of an AOSM. Files that are in the folder and belong to no home stay.
    ///
    /// # Errors
    /// [`MapError::Exists`] if there is a home already, [`MapError`] naming what contradicts itself in the AOSM or what
    /// could not be written.
    pub fn create(dir: &Path, name: &str, aosm: &Aosm, when_secs: f64) -> Result<Self, MapError> {
        for file in [HOME, journal::FILE] {
            let path = dir.join(file);
            if path.exists() {
                return Err(MapError::Exists { path });
            }
        }
        let documents = home_folder::of_aosm(name, aosm)?;
        let (name, aosm) = home_folder::assemble(dir, &documents, None)?;
        home_folder::make(dir)?;
        let journal = Journal::create(dir, &documents, "home", when_secs)?;
        let mut home = Self::new(dir, name, aosm, documents, journal)?;
        home.write_files(&BTreeSet::new())?;
        Ok(home)
    }

    /// Opens a home folder, and mends what a crash or a person left: text files that lag behind the journal are written
    /// again, text files that were changed are taken in as an edit at `when_secs`. A folder without a journal gets one.
    ///
    /// # Errors
    /// [`MapError::InUse`] if another process has it open, [`MapError::JournalDamaged`] if the journal is broken, and
    /// [`MapError`] naming the file, what was found and what was wanted if a text file makes no sense; nothing is
    /// changed then.
    pub fn open(dir: &Path, when_secs: f64) -> Result<Self, MapError> {
        if !dir.join(journal::FILE).exists() {
            let documents = home_folder::load(dir)?;
            home_folder::assemble(dir, &documents, None)?;
            drop(Journal::create(dir, &documents, FILE_AUTHOR, when_secs)?);
        }
        let journal = Journal::open(dir)?;
        let documents = journal.documents()?;
        let (name, aosm) = home_folder::assemble(dir, &documents, None)?;
        let mut home = Self::new(dir, name, aosm, documents, journal)?;
        home.take_in(when_secs)?;
        Ok(home)
    }

    /// Checks a home folder and changes nothing in it: that its text files make sense, and that its journal is whole.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn check(dir: &Path) -> Result<HomeCheck, MapError> {
        let on_disk = home_folder::load(dir)?;
        let (name, aosm) = home_folder::assemble(dir, &on_disk, None)?;
        let (mut n_entries, mut changed) = (None, Vec::new());
        if dir.join(journal::FILE).exists() {
            let journal = Journal::open(dir)?;
            let kept = journal.documents()?;
            home_folder::assemble(dir, &kept, None)?;
            n_entries = Some(journal.last_entry()?);
            let names: BTreeSet<&String> = kept.keys().chain(on_disk.keys()).collect();
            changed = names
                .into_iter()
                .filter(|name| kept.get(*name) != on_disk.get(*name))
                .cloned()
                .collect();
        }
        Ok(HomeCheck {
            name,
            aosm,
            n_entries,
            changed,
        })
    }

    fn new(
        dir: &Path,
        name: String,
        aosm: Aosm,
        documents: Documents,
        journal: Journal,
    ) -> Result<Self, MapError> {
        let known = |(path, digest)| {
            (
                path,
                KnownFile {
                    digest,
                    stamp: None,
                },
            )
        };
        let files = journal.files()?.into_iter().map(known).collect();
        let wanted = wanted_files(dir, &documents, &aosm, &BTreeMap::new())?;
        let (unconfirmed, unwritten) = (FileDigests::new(), None);
        let revisions = journal.revisions()?;
        Ok(Self {
            dir: dir.to_owned(),
            name,
            aosm,
            documents,
            journal,
            revisions,
            wanted,
            files,
            unconfirmed,
            unwritten,
        })
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Name of the home.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The map as it is now.
    pub fn aosm(&self) -> &Aosm {
        &self.aosm
    }

    /// Why the text files lag behind the journal, if they do: a full disk, for example. Nothing is lost; the next edit
    /// and the next [`Home::open`] try again.
    pub fn unwritten(&self) -> Option<&MapError> {
        self.unwritten.as_ref()
    }

    /// Number of the journal's entry that last changed a class or object; none if there never was one of that name.
    pub fn revision(&self, thing: &Thing) -> Option<i64> {
        let of_thing = self
            .revisions
            .iter()
            .filter(|(document, _)| thing.has(document));
        of_thing.map(|(_, revisions)| revisions.last).max()
    }

    /// How many objects were put into the map before this one, those that are gone included: a number that stays with
    /// the object whatever others come and go. None if there never was an object of that name.
    pub fn object_rank(&self, name: &str) -> Option<usize> {
        let document = object_document(name);
        let first = self.revisions.get(&document)?.first;
        let mut objects: Vec<(i64, &String)> = self
            .revisions
            .iter()
            .filter(|(other, _)| is_object_document(other))
            .map(|(other, revisions)| (revisions.first, other))
            .collect();
        objects.sort_unstable();
        objects.binary_search(&(first, &document)).ok()
    }

    /// Makes an edit as [`Home::edit`] does, unless somebody has changed the class or object since the state on which
    /// the edit was made: that of its revision `base`.
    ///
    /// # Errors
    /// [`MapError::ChangedMeanwhile`] then; else as [`Home::edit`].
    pub fn edit_on<'a>(
        &mut self,
        base: i64,
        edit: &Edit,
        by: impl Into<By<'a>>,
        when_secs: f64,
    ) -> Result<Option<i64>, MapError> {
        // What a person has changed in the text files counts as well.
        self.take_in(when_secs)?;
        if let Some(thing) = edit.thing()
            && let Some(found) = self.revision(&thing)
            && found != base
        {
            let last = self.journal.entry(found)?;
            return Err(MapError::ChangedMeanwhile {
                thing,
                what: last
                    .as_ref()
                    .map_or_else(String::new, |entry| entry.kind.to_string()),
                author: last.map_or_else(String::new, |entry| entry.author),
                found,
                wanted: base,
            });
        }
        self.edit(edit, by, when_secs)
    }

    /// What became of a request that made an entry of the journal, in this process or before; none if it made none, or
    /// was forgotten for 1024 newer ones.
    ///
    /// # Errors
    /// [`MapError::Journal`] if the journal cannot be read.
    pub fn remembered(&self, request_id: &str) -> Result<Option<Remembered>, MapError> {
        self.journal.remembered(request_id)
    }

    /// Makes an edit. When this returns, it will outlive the process. The answer is the number of its journal entry, or
    /// nothing if it changes nothing.
    ///
    /// # Errors
    /// [`MapError`] if the edit speaks of what is not there or would make the map contradict itself, if a text file was
    /// changed meanwhile and makes no sense, or if the journal cannot be written. Nothing has changed then.
    pub fn edit<'a>(
        &mut self,
        edit: &Edit,
        by: impl Into<By<'a>>,
        when_secs: f64,
    ) -> Result<Option<i64>, MapError> {
        self.take_in(when_secs)?;
        let view = HomeView {
            dir: &self.dir,
            aosm: &self.aosm,
            documents: &self.documents,
        };
        let changes = edit.changes(&view)?;
        self.commit(
            &EntryKind::Edit {
                what: edit.summary(),
            },
            by.into(),
            when_secs,
            changes,
        )
    }

    /// Undoes the last edit that holds, whoever made it. The answer is its summary, or nothing if there is none.
    ///
    /// # Errors
    /// As [`Home::edit`].
    pub fn undo<'a>(
        &mut self,
        by: impl Into<By<'a>>,
        when_secs: f64,
    ) -> Result<Option<String>, MapError> {
        self.take_in(when_secs)?;
        let edit = self.journal.last_done();
        edit.map(|edit| self.revisit(edit, Direction::Back, by.into(), when_secs))
            .transpose()
    }

    /// Does the last undone edit again, unless there has been another edit since. The answer is its summary, or nothing
    /// if there is none.
    ///
    /// # Errors
    /// As [`Home::edit`].
    pub fn redo<'a>(
        &mut self,
        by: impl Into<By<'a>>,
        when_secs: f64,
    ) -> Result<Option<String>, MapError> {
        self.take_in(when_secs)?;
        let edit = self.journal.last_undone();
        edit.map(|edit| self.revisit(edit, Direction::Again, by.into(), when_secs))
            .transpose()
    }

    /// Takes one side of an edit for what holds.
    fn revisit(
        &mut self,
        edit: i64,
        direction: Direction,
        by: By<'_>,
        when_secs: f64,
    ) -> Result<String, MapError> {
        let what = self.journal.what(edit)?;
        let summary = what.clone();
        let changes = self.journal.changes(edit)?.into_iter();
        let (kind, changes) = match direction {
            Direction::Back => (
                EntryKind::Undo { edit, what },
                changes
                    .map(|change| (change.document, change.before))
                    .collect(),
            ),
            Direction::Again => (
                EntryKind::Redo { edit, what },
                changes
                    .map(|change| (change.document, change.after))
                    .collect(),
            ),
        };
        self.commit(&kind, by, when_secs, changes)?;
        Ok(summary)
    }

    /// Makes the home hold again what it held after the journal's entry `entry`. What came later stays in the history,
    /// and this is an edit like others: it can be undone. The answer is its number, or nothing if it changes nothing.
    ///
    /// # Errors
    /// As [`Home::edit`], and [`MapError::NoEntry`] if the journal has no such entry.
    pub fn return_to(
        &mut self,
        entry: i64,
        author: &str,
        when_secs: f64,
    ) -> Result<Option<i64>, MapError> {
        self.take_in(when_secs)?;
        let last = self.journal.last_entry()?;
        if !(1..=last).contains(&entry) {
            return Err(MapError::NoEntry {
                path: self.dir.join(journal::FILE),
                entry,
                last,
            });
        }
        let mut changes = DocumentChanges::new();
        for later in (entry + 1..=last).rev() {
            let before = self.journal.changes(later)?.into_iter();
            changes.extend(before.map(|change| (change.document, change.before)));
        }
        let what = format!("return to entry {entry}");
        self.commit(&EntryKind::Edit { what }, author.into(), when_secs, changes)
    }

    /// Number of the journal's last entry.
    ///
    /// # Errors
    /// [`MapError::Journal`] if the journal cannot be read.
    pub fn last_entry(&self) -> Result<i64, MapError> {
        self.journal.last_entry()
    }

    /// The edit to undo and the edit to do again, in words.
    ///
    /// # Errors
    /// [`MapError::Journal`] if the journal cannot be read.
    pub fn undo_redo(&self) -> Result<[Option<String>; 2], MapError> {
        let what = |edit: Option<i64>| edit.map(|edit| self.journal.what(edit)).transpose();
        Ok([
            what(self.journal.last_done())?,
            what(self.journal.last_undone())?,
        ])
    }

    /// Notes an executed plan step and answers the number of its entry. What it changed in the map is an edit of its own.
    ///
    /// # Errors
    /// [`MapError::Journal`] if the journal cannot be written.
    pub fn record_execution(
        &mut self,
        execution: &Execution,
        author: &str,
        when_secs: f64,
    ) -> Result<i64, MapError> {
        self.append(
            &EntryKind::Execution(execution.clone()),
            author.into(),
            when_secs,
            &DocumentChanges::new(),
        )
    }

    /// The latest entries of the journal, the newest first.
    ///
    /// # Errors
    /// [`MapError::Journal`] if the journal cannot be read.
    pub fn history(&self, limit: usize) -> Result<Vec<Entry>, MapError> {
        self.journal.history(limit)
    }

    /// What an entry of the journal changed, by document.
    ///
    /// # Errors
    /// [`MapError::Journal`] if the journal cannot be read.
    pub fn changes(&self, entry: i64) -> Result<Vec<Change>, MapError> {
        self.journal.changes(entry)
    }

    /// Checks the changes, journals them, and only then lets them be seen.
    fn commit(
        &mut self,
        kind: &EntryKind,
        by: By<'_>,
        when_secs: f64,
        mut changes: DocumentChanges,
    ) -> Result<Option<i64>, MapError> {
        changes.retain(|name, bytes| self.documents.get(name) != bytes.as_ref());
        if changes.is_empty() {
            return Ok(None);
        }
        let mut documents = self.documents.clone();
        for (name, bytes) in &changes {
            match bytes {
                Some(bytes) => documents.insert(name.clone(), bytes.clone()),
                None => documents.remove(name),
            };
        }
        let is_kept = !changes
            .keys()
            .any(|name| home_folder::is_map_or_cloud(name));
        let kept = is_kept.then(|| (self.aosm.grid.clone(), self.aosm.cloud.clone()));
        let (name, aosm) = home_folder::assemble(&self.dir, &documents, kept)?;
        let wanted = wanted_files(&self.dir, &documents, &aosm, &self.wanted)?;
        let id = self.append(kind, by, when_secs, &changes)?;
        for document in changes.into_keys() {
            let revisions = self.revisions.entry(document);
            revisions
                .and_modify(|revisions| revisions.last = id)
                .or_insert(Revisions {
                    first: id,
                    last: id,
                });
        }
        (self.name, self.aosm, self.documents, self.wanted) = (name, aosm, documents, wanted);
        self.unwritten = self.write_files(&BTreeSet::new()).err();
        Ok(Some(id))
    }

    fn append(
        &mut self,
        kind: &EntryKind,
        by: By<'_>,
        when_secs: f64,
        changes: &DocumentChanges,
    ) -> Result<i64, MapError> {
        let id = self.journal.append(&NewEntry {
            kind,
            by,
            when_secs,
            changes,
            files: &self.unconfirmed,
        })?;
        self.unconfirmed.clear();
        Ok(id)
    }

    /// Takes in what was changed in the text files, after writing those that a crash left behind.
    fn take_in(&mut self, when_secs: f64) -> Result<(), MapError> {
        let outside = self.files_changed_outside()?;
        if outside.is_empty() {
            self.unwritten = self.write_files(&outside).err();
            return Ok(());
        }
        self.write_files(&outside)?;
        let changes = difference(&self.documents, &home_folder::load(&self.dir)?);
        let names: Vec<&str> = outside.iter().map(String::as_str).collect();
        let what = format!("change {} by hand", names.join(", "));
        self.commit(
            &EntryKind::Edit { what },
            FILE_AUTHOR.into(),
            when_secs,
            changes,
        )?;
        Ok(())
    }

    /// Text files that are neither what the journal says nor what was last written.
    fn files_changed_outside(&mut self) -> Result<BTreeSet<String>, MapError> {
        let mut paths: BTreeSet<String> = self
            .wanted
            .keys()
            .chain(self.files.keys())
            .cloned()
            .collect();
        paths.extend(home_folder::class_files(&self.dir)?);
        paths.insert(CLOUD.to_owned());
        let mut outside = BTreeSet::new();
        for path in paths {
            let file = self.dir.join(&path);
            let known = self.files.get(&path).copied();
            let stamp = home_folder::stamp(&file);
            if stamp.is_none() {
                self.know(path, None);
                continue;
            }
            if known.is_some_and(|known| known.stamp == stamp) {
                continue;
            }
            let bytes = home_folder::read_file(&file)?;
            let digest = home_folder::digest(&bytes);
            let is_ours = self
                .wanted
                .get(&path)
                .is_some_and(|wanted| wanted.digest == digest)
                || known.is_some_and(|known| known.digest == digest);
            if is_ours || path == DOMAIN {
                self.know(path, Some(digest));
            } else {
                outside.insert(path);
            }
        }
        Ok(outside)
    }

    /// Brings the text files up to the journal, but for those that were changed `outside`.
    fn write_files(&mut self, outside: &BTreeSet<String>) -> Result<(), MapError> {
        let digest_of = |path: &String| self.files.get(path).map(|known| known.digest);
        let is_lagging =
            |(path, wanted): &(&String, &WantedFile)| digest_of(path) != Some(wanted.digest);
        let lagging: Vec<String> = self
            .wanted
            .iter()
            .filter(is_lagging)
            .map(|(path, _)| path.clone())
            .collect();
        let is_gone = |path: &&String| !self.wanted.contains_key(*path);
        let gone: Vec<String> = self.files.keys().filter(is_gone).cloned().collect();
        for path in lagging {
            if let Some(wanted) = self.wanted.get(&path).filter(|_| !outside.contains(&path)) {
                home_folder::replace(&self.dir.join(&path), &wanted.bytes)?;
                self.know(path, Some(wanted.digest));
            }
        }
        for path in gone {
            if !outside.contains(&path) {
                home_folder::remove(&self.dir, &path)?;
                self.know(path, None);
            }
        }
        Ok(())
    }

    /// Remembers what a text file holds; nothing if it is gone.
    fn know(&mut self, path: String, digest: Option<[u8; 32]>) {
        let before = match digest {
            Some(digest) => {
                let stamp = home_folder::stamp(&self.dir.join(&path));
                self.files.insert(path.clone(), KnownFile { digest, stamp })
            }
            None => self.files.remove(&path),
        };
        if before.map(|known| known.digest) != digest {
            self.unconfirmed.insert(path, digest);
        }
    }
}

/// The text files of a home. Digests of files that are the same `before` are taken from there.
fn wanted_files(
    dir: &Path,
    documents: &Documents,
    aosm: &Aosm,
    before: &BTreeMap<String, WantedFile>,
) -> Result<BTreeMap<String, WantedFile>, MapError> {
    let files = home_folder::render(dir, documents, aosm)?.into_iter();
    let wanted = files.map(|(path, bytes)| {
        let same = before.get(&path).filter(|before| before.bytes == bytes);
        let digest = same.map_or_else(|| home_folder::digest(&bytes), |same| same.digest);
        (path, WantedFile { bytes, digest })
    });
    Ok(wanted.collect())
}

impl Drop for Home {
    /// Tells the journal which text files are up to date, so that one that a person sets back later is seen as changed.
    fn drop(&mut self) {
        if !self.unconfirmed.is_empty() {
            // Not confirming costs no data, and there is no one to tell.
            self.journal.confirm(&self.unconfirmed).ok();
        }
    }
}
