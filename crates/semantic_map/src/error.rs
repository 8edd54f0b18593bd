//! What can be wrong with a semantic map.

use std::path::PathBuf;

use factotum_descriptions::{DescriptionError, FormError};
use factotum_geometry::cloud::ply::PlyError;
use factotum_geometry::grid::map_server::MapFileError;
use factotum_symbols::ApproachRegionError;
use factotum_task_planning::operator::OperatorError;

use crate::Thing;

/// Why a semantic map cannot answer, be read or be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// No class of that name.
    #[error("object class `{name}` is not in the map; known: {}", list(known))]
    NoClass {
        /// Name asked for.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// No object of that name.
    #[error("object `{name}` is not in the map; known: {}", list(known))]
    NoObject {
        /// Name asked for.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// A goal speaks of a class of which no object has been found.
    #[error("no {class} has been found in this home; found: {}", list(found))]
    NothingOfClass {
        /// The class.
        class: String,
        /// Objects there are.
        found: Vec<String>,
    },
    /// An action asks for a state, joint or grasp that its class does not have.
    #[error("class `{class}` has no {what} `{name}`; it has: {}", list(known))]
    NotOfClass {
        /// The class.
        class: String,
        /// Kind of thing.
        what: &'static str,
        /// Name asked for.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// An approach region that is none.
    #[error("approach of `{action}` of class `{class}`")]
    Approach {
        /// The class.
        class: String,
        /// The action.
        action: String,
        /// What is wrong with it.
        source: ApproachRegionError,
    },
    /// The classes do not make a planning domain.
    #[error("the classes make no planning domain: {0}")]
    Domain(#[from] OperatorError),
    /// A file of a home folder could not be read or written.
    #[error("cannot {verb} `{}`: {source}", path.display())]
    Io {
        /// What was tried.
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// A TOML file of a home folder is wrong.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// A class is to be made of a shape that is none.
    #[error(transparent)]
    Form(#[from] FormError),
    /// Somebody has changed a thing since the state on which an edit was made.
    #[error(
        "{thing} was changed meanwhile: {what}, by {author} (entry {found} of the journal, the edit was made on {wanted}); \
         look at it again and repeat the edit"
    )]
    ChangedMeanwhile {
        /// The class or object.
        thing: Thing,
        /// What the last change of it was.
        what: String,
        /// Who made it.
        author: String,
        /// Its revision.
        found: i64,
        /// The revision on which the edit was made.
        wanted: i64,
    },
    /// The map files of a home folder are wrong.
    #[error(transparent)]
    Map(#[from] MapFileError),
    /// The point cloud of a home folder is wrong.
    #[error("point cloud `{}`: {source}", path.display())]
    Cloud {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: PlyError,
    },
    /// A home folder contradicts itself.
    #[error("home folder `{}`: {problem}", path.display())]
    Home {
        /// The folder or file.
        path: PathBuf,
        /// What was found and what was wanted.
        problem: String,
    },
    /// The journal of a home cannot be read or written.
    #[error("journal `{}`: {source}", path.display())]
    Journal {
        /// The journal file.
        path: PathBuf,
        /// The database's word.
        source: rusqlite::Error,
    },
    /// The journal of a home is broken. The text files are whole all the same.
    #[error(
        "journal `{}` is damaged ({found}); the home's text files do not need it: move it away to go on without its history",
        path.display()
    )]
    JournalDamaged {
        /// The journal file.
        path: PathBuf,
        /// What was found.
        found: String,
    },
    /// The journal of a home has no entry of that number.
    #[error("journal `{}` has no entry {entry}; its last is {last}", path.display())]
    NoEntry {
        /// The journal file.
        path: PathBuf,
        /// Number asked for.
        entry: i64,
        /// Number of its last entry.
        last: i64,
    },
    /// Another process has the home open.
    #[error("home folder `{}` is open in another process; close it there first", path.display())]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// A new home was to be made where something is.
    #[error("`{}` is there already, expected a folder without a home", path.display())]
    Exists {
        /// The file that is there.
        path: PathBuf,
    },
}

fn list(names: &[String]) -> String {
    if names.is_empty() {
        "nothing".to_owned()
    } else {
        format!("`{}`", names.join("`, `"))
    }
}
