//! The home folder: an AOSM as files that people can read and diff.
//!
//! ```text
//! home.toml           name and format of the folder
//! map.yaml, map.pgm   the grid M, as ROS map_server writes it
//! cloud.ply           the 3-D point cloud, in the map frame; absent if nothing was kept
//! classes/NAME/       a class: class.toml and its model τ
//! objects.toml        the objects O with their poses Γ
//! domain.pddl         the planning domain, for people and other planners; written, never read
//! journal.sqlite      every edit and execution, kept by [`Home`](crate::Home); not touched here
//! ```
//!
//! A home is held in memory as documents: the bytes of each file, but for `objects.toml`, which is cut into one
//! document an object so that the journal can say which object an edit changed. Each file is replaced by a rename
//! after it has reached the disk, so a crash leaves the old one or the new one.

mod documents;
mod files;
mod objects_file;

use std::path::Path;

use crate::{Aosm, MapError};

pub(crate) use documents::{
    CLOUD, Documents, HOME, assemble, class_document, class_documents, class_folder, class_text,
    cloud_document, home_document, is_map_or_cloud, is_object_document, map_documents,
    object_document, object_documents, of_aosm, stored_map,
};
pub(crate) use files::{
    DOMAIN, class_files, digest, load, make, read_file, remove, rename, render, replace, stamp,
};
pub(crate) use objects_file::{ObjectEntry, entry_of};

/// Format of the folder that this version writes and reads.
pub const FORMAT: u32 = 1;

/// Writes an AOSM into a folder, making the folder if there is none.
///
/// # Errors
/// [`MapError`] naming the file that could not be written. What was there before is whole.
pub fn write(dir: &Path, name: &str, aosm: &Aosm) -> Result<(), MapError> {
    let documents = of_aosm(name, aosm)?;
    let (_, aosm) = assemble(dir, &documents, None)?;
    for (path, bytes) in render(dir, &documents, &aosm)? {
        replace(&dir.join(path), &bytes)?;
    }
    Ok(())
}

/// Reads the AOSM of a folder, and the home's name.
///
/// # Errors
/// [`MapError`] naming the file that is missing or wrong, what was found and what was wanted.
pub fn read(dir: &Path) -> Result<(String, Aosm), MapError> {
    assemble(dir, &load(dir)?, None)
}
