//! The home folder: an AOSM as files that people can read and diff.
//!
//! ```text
//! home.toml           name and format of the folder
//! map.yaml, map.pgm   the grid M, as ROS map_server writes it
//! classes/NAME/       a class: class.toml and its model τ
//! objects.toml        the objects O with their poses Γ
//! domain.pddl         the planning domain, for people and other planners; written, never read
//! ```
//!
//! Each file is replaced by a rename, so a crash leaves the old one or the new one.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use factotum_descriptions::{ObjectClass, Placement, read_toml, write_toml};
use factotum_geometry::grid::map_server::StoredMap;
use factotum_task_planning::pddl::write_domain;
use serde::{Deserialize, Serialize};

use crate::{Aosm, Location, MapError, MapObject, ObjectSource};

/// Format of the folder that this version writes and reads.
pub const FORMAT: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct HomeFile {
    format: u32,
    name: String,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct ObjectsFile {
    #[serde(default)]
    objects: Vec<ObjectEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectEntry {
    name: String,
    class: String,
    xyz: [f64; 3],
    #[serde(default)]
    rpy: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    inside: Option<String>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    held: bool,
    #[serde(default)]
    source: SourceEntry,
    #[serde(default)]
    position_std_m: f64,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    joints: BTreeMap<String, f64>,
}

#[derive(Serialize, Deserialize, Default, Clone, Copy)]
#[serde(rename_all = "snake_case")]
enum SourceEntry {
    #[default]
    Given,
    Seen,
    Taught,
}

/// Writes an AOSM into a folder, making the folder if there is none.
///
/// # Errors
/// [`MapError`] naming the file that could not be written. What was there before is whole.
pub fn write(dir: &Path, name: &str, aosm: &Aosm) -> Result<(), MapError> {
    make_dir(dir)?;
    for class in aosm.classes.values() {
        write_class(&dir.join("classes").join(&class.name), class)?;
    }
    StoredMap::from_grid(&aosm.grid, "map.pgm")
        .write(&dir.join("map.yaml"))
        .map_err(|error| MapError::Grid(error.to_string()))?;
    let objects = aosm.objects.values().map(entry_of).collect();
    write_toml(&dir.join("objects.toml"), &ObjectsFile { objects })?;
    let domain = write_domain(&aosm.domain()?);
    std::fs::write(dir.join("domain.pddl"), domain).map_err(io("write", dir.join("domain.pddl")))?;
    write_toml(&dir.join("home.toml"), &HomeFile { format: FORMAT, name: name.to_owned() })?;
    Ok(())
}

/// Reads the AOSM of a folder, and the home's name.
///
/// # Errors
/// [`MapError`] naming the file that is missing or wrong, what was found and what was wanted.
pub fn read(dir: &Path) -> Result<(String, Aosm), MapError> {
    let home: HomeFile = read_toml(&dir.join("home.toml"))?;
    if home.format != FORMAT {
        return Err(MapError::Home {
            path: dir.join("home.toml"),
            problem: format!("format {} found, expected {FORMAT}", home.format),
        });
    }
    let grid = StoredMap::read(&dir.join("map.yaml"))
        .map_err(|error| MapError::Grid(error.to_string()))?
        .checked_grid()
        .map_err(|error| MapError::Grid(error.to_string()))?;
    let mut aosm = Aosm::new(read_classes(&dir.join("classes"))?, grid);
    let path = dir.join("objects.toml");
    let file: ObjectsFile = read_toml(&path)?;
    for entry in file.objects {
        aosm.class(&entry.class).map_err(|error| MapError::Home {
            path: path.clone(),
            problem: format!("object `{}`: {error}", entry.name),
        })?;
        let object = object_of(entry);
        if let Some(twin) = aosm.objects.insert(object.name.clone(), object) {
            let problem = format!("two objects are named `{}`, expected different names", twin.name);
            return Err(MapError::Home { path, problem });
        }
    }
    for object in aosm.objects.values() {
        if let Location::In(container) = &object.location {
            aosm.object(container).map_err(|error| MapError::Home {
                path: path.clone(),
                problem: format!("object `{}` is inside: {error}", object.name),
            })?;
        }
    }
    Ok((home.name, aosm))
}

fn entry_of(object: &MapObject) -> ObjectEntry {
    let Placement { xyz, rpy } = object.map_from_object.into();
    ObjectEntry {
        name: object.name.clone(),
        class: object.class.clone(),
        xyz,
        rpy,
        inside: match &object.location {
            Location::In(container) => Some(container.clone()),
            Location::Loose | Location::Held => None,
        },
        held: object.location == Location::Held,
        source: match object.source {
            ObjectSource::Given => SourceEntry::Given,
            ObjectSource::Seen => SourceEntry::Seen,
            ObjectSource::Taught => SourceEntry::Taught,
        },
        position_std_m: object.position_std_m,
        joints: object.joints.clone(),
    }
}

fn object_of(entry: ObjectEntry) -> MapObject {
    MapObject {
        map_from_object: Placement { xyz: entry.xyz, rpy: entry.rpy }.into(),
        location: match (entry.inside, entry.held) {
            (Some(container), _) => Location::In(container),
            (None, true) => Location::Held,
            (None, false) => Location::Loose,
        },
        source: match entry.source {
            SourceEntry::Given => ObjectSource::Given,
            SourceEntry::Seen => ObjectSource::Seen,
            SourceEntry::Taught => ObjectSource::Taught,
        },
        name: entry.name,
        class: entry.class,
        joints: entry.joints,
        position_std_m: entry.position_std_m,
    }
}

fn read_classes(dir: &Path) -> Result<Vec<ObjectClass>, MapError> {
    let entries = std::fs::read_dir(dir).map_err(io("read", dir.to_owned()))?;
    let mut dirs = Vec::new();
    for entry in entries {
        let path = entry.map_err(io("read", dir.to_owned()))?.path();
        if path.join("class.toml").is_file() {
            dirs.push(path);
        }
    }
    dirs.sort();
    dirs.iter().map(|dir| Ok(ObjectClass::load(dir)?)).collect()
}

/// Copies the class's model beside its `class.toml`, unless it is there already.
fn write_class(dir: &Path, class: &ObjectClass) -> Result<(), MapError> {
    make_dir(dir)?;
    let file_name = class.model.file_name().map(PathBuf::from).unwrap_or_else(|| PathBuf::from("model.xml"));
    let model = dir.join(&file_name);
    let is_same = class.model.canonicalize().ok().zip(model.canonicalize().ok()).is_some_and(|(a, b)| a == b);
    if !is_same {
        std::fs::copy(&class.model, &model).map_err(io("copy", class.model.clone()))?;
    }
    write_toml(&dir.join("class.toml"), &ObjectClass { model: file_name, ..class.clone() })?;
    Ok(())
}

fn make_dir(dir: &Path) -> Result<(), MapError> {
    std::fs::create_dir_all(dir).map_err(io("make", dir.to_owned()))
}

fn io(verb: &'static str, path: PathBuf) -> impl FnOnce(std::io::Error) -> MapError {
    move |source| MapError::Io { verb, path, source }
}
