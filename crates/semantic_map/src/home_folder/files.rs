//! Documents as files: reading a folder, and replacing files so that a crash leaves the old one or the new one.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::time::SystemTime;

use factotum_descriptions::parse_toml;
use factotum_task_planning::pddl::write_domain;
use sha2::{Digest as _, Sha256};

use super::documents::{
    CLASSES, CLOUD, Documents, HOME, MAP, OBJECTS, class_document, map_metadata, object_document,
    toml_bytes,
};
use super::objects_file::ObjectsFile;
use crate::{Aosm, MapError};

/// The planning domain. It follows from the classes and is never read.
pub(crate) const DOMAIN: &str = "domain.pddl";

/// First line of `objects.toml`, which is written anew with each edit.
const OBJECTS_HEADER: &str =
    "# Changes made here are taken in when the home is opened; comments are not kept.\n\n";

/// The files of a home, by their path in the folder.
///
/// # Errors
/// [`MapError`] if a document has no place in a file.
pub(crate) fn render(
    dir: &Path,
    documents: &Documents,
    aosm: &Aosm,
) -> Result<BTreeMap<String, Vec<u8>>, MapError> {
    let path = dir.join(OBJECTS);
    let mut files = BTreeMap::new();
    let mut objects = Vec::new();
    for (name, bytes) in documents {
        if name.starts_with("objects/") {
            objects.push(parse_toml(&String::from_utf8_lossy(bytes), &path)?);
        } else {
            files.insert(name.clone(), bytes.clone());
        }
    }
    let mut text = OBJECTS_HEADER.as_bytes().to_vec();
    text.extend(toml_bytes(&path, &ObjectsFile { objects })?);
    files.insert(OBJECTS.to_owned(), text);
    files.insert(
        DOMAIN.to_owned(),
        write_domain(&aosm.domain()?).into_bytes(),
    );
    Ok(files)
}

/// Reads the documents of a folder.
///
/// # Errors
/// [`MapError`] naming the file that is missing or not of the wanted form. Whether the files agree with each other is
/// for [`assemble`](super::assemble) to say.
pub(crate) fn load(dir: &Path) -> Result<Documents, MapError> {
    let mut documents = Documents::new();
    for name in [HOME, MAP] {
        documents.insert(name.to_owned(), read_file(&dir.join(name))?);
    }
    let image = map_metadata(dir, &documents)?.image;
    documents.insert(
        image.to_string_lossy().into_owned(),
        read_file(&dir.join(&image))?,
    );
    if dir.join(CLOUD).exists() {
        documents.insert(CLOUD.to_owned(), read_file(&dir.join(CLOUD))?);
    }
    for name in class_files(dir)? {
        documents.insert(name.clone(), read_file(&dir.join(&name))?);
    }
    let path = dir.join(OBJECTS);
    let text = read_file(&path)?;
    let file: ObjectsFile = parse_toml(&String::from_utf8_lossy(&text), &path)?;
    for entry in file.objects {
        let bytes = toml_bytes(&path, &entry)?;
        if documents
            .insert(object_document(&entry.name), bytes)
            .is_some()
        {
            let problem = format!(
                "two objects are named `{}`, expected different names",
                entry.name
            );
            return Err(MapError::Home { path, problem });
        }
    }
    Ok(documents)
}

/// Documents of the files in the folders of the classes, in order. A folder is a class's if it has a `class.toml`.
///
/// # Errors
/// [`MapError::Io`] if a folder cannot be listed.
pub(crate) fn class_files(dir: &Path) -> Result<Vec<String>, MapError> {
    let classes = dir.join(CLASSES);
    if !classes.exists() {
        return Ok(Vec::new());
    }
    let mut names = Vec::new();
    for entry in std::fs::read_dir(&classes).map_err(io("read", &classes))? {
        let entry = entry.map_err(io("read", &classes))?;
        if entry.path().join("class.toml").is_file() {
            let class = entry.file_name().to_string_lossy().into_owned();
            let files = folder_files(&entry.path())?;
            names.extend(files.iter().map(|file| class_document(&class, file)));
        }
    }
    names.sort();
    Ok(names)
}

/// The files under a folder, by their path in it with `/` between the parts; hidden ones and links are left out.
///
/// # Errors
/// [`MapError::Io`] if a folder cannot be listed.
pub(super) fn folder_files(dir: &Path) -> Result<Vec<String>, MapError> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(dir).map_err(io("read", dir))? {
        let entry = entry.map_err(io("read", dir))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let kind = entry.file_type().map_err(io("read", &entry.path()))?;
        if name.starts_with('.') {
            continue;
        } else if kind.is_dir() {
            let inner = folder_files(&entry.path())?;
            files.extend(inner.iter().map(|file| format!("{name}/{file}")));
        } else if kind.is_file() {
            files.push(name);
        }
    }
    Ok(files)
}

/// The bytes of a file.
///
/// # Errors
/// [`MapError::Io`] naming the file.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, MapError> {
    std::fs::read(path).map_err(io("read", path))
}

/// Replaces a file: the new one reaches the disk under another name, then takes the old one's place.
///
/// # Errors
/// [`MapError::Io`] naming the file. The old file is whole then.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> Result<(), MapError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    make(folder)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let part = folder.join(format!(".{name}.part"));
    let write = || -> std::io::Result<()> {
        let mut file = File::create(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&part, path)?;
        sync_folder(folder)
    };
    write().map_err(|source| {
        // The half-written file may be gone already; the first error says more than this one could.
        std::fs::remove_file(&part).ok();
        MapError::Io {
            verb: "write",
            path: path.to_owned(),
            source,
        }
    })
}

/// Makes a folder, if there is none.
///
/// # Errors
/// [`MapError::Io`] naming the folder.
pub(crate) fn make(dir: &Path) -> Result<(), MapError> {
    std::fs::create_dir_all(dir).map_err(io("make", dir))
}

/// Gives a file that is whole its name.
///
/// # Errors
/// [`MapError::Io`] naming the file.
pub(crate) fn rename(part: &Path, path: &Path) -> Result<(), MapError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::rename(part, path)
        .and_then(|()| sync_folder(folder))
        .map_err(io("write", path))
}

/// Removes a file of the folder, if it is there, and the folders inside it that are empty then.
///
/// # Errors
/// [`MapError::Io`] naming the file.
pub(crate) fn remove(dir: &Path, file: &str) -> Result<(), MapError> {
    let path = dir.join(file);
    match std::fs::remove_file(&path) {
        Ok(()) => {}
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
        Err(error) => return Err(io("remove", &path)(error)),
    }
    let mut file = file;
    while let Some((folder, _)) = file.rsplit_once('/') {
        // A folder that still holds something is not empty, and stays.
        std::fs::remove_dir(dir.join(folder)).ok();
        file = folder;
    }
    Ok(())
}

/// Makes a rename in the folder last through a power cut.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> std::io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Only Unix opens folders as files.
#[cfg(not(unix))]
fn sync_folder(_folder: &Path) -> std::io::Result<()> {
    Ok(())
}

/// SHA-256 of a file's bytes.
pub(crate) fn digest(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}

/// Length and time of change: while they are the same, so is the file. Nothing if it is not there.
pub(crate) fn stamp(path: &Path) -> Option<(u64, SystemTime)> {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()?))
}

fn io(verb: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> MapError {
    let path = path.to_owned();
    move |source| MapError::Io { verb, path, source }
}
