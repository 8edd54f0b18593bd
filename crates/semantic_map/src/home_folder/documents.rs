//! A home as named documents, and the AOSM they make.

use std::collections::BTreeMap;
use std::path::{Component, Path};

use factotum_descriptions::{DescriptionError, ObjectClass, parse_toml};
use factotum_geometry::cloud::PointCloud;
use factotum_geometry::cloud::ply::{PlyEncoding, format_ply, parse_ply};
use factotum_geometry::grid::OccupancyGrid;
use factotum_geometry::grid::map_server::{GrayImage, MapFileError, MapMetadata, StoredMap};
use factotum_task_planning::operator::Condition;
use serde::{Deserialize, Serialize};

use super::FORMAT;
use super::files::folder_files;
use super::objects_file::{ObjectEntry, entry_of};
use crate::{Aosm, Location, MapError, MapObject};

/// Bytes by document. A document is named by its path in the folder, with `/` between the parts; an object's is
/// `objects/NAME`.
pub(crate) type Documents = BTreeMap<String, Vec<u8>>;

/// Name and format of the home.
pub(crate) const HOME: &str = "home.toml";
/// Metadata of the grid; they name the image.
pub(crate) const MAP: &str = "map.yaml";
/// The point cloud.
pub(crate) const CLOUD: &str = "cloud.ply";
/// The objects' file.
pub(super) const OBJECTS: &str = "objects.toml";
/// Folder of the classes.
pub(super) const CLASSES: &str = "classes";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct HomeFile {
    format: u32,
    name: String,
}

/// Name of an object's document.
pub(crate) fn object_document(object: &str) -> String {
    format!("objects/{object}")
}

/// Whether the document is an object's.
pub(crate) fn is_object_document(document: &str) -> bool {
    document.starts_with("objects/")
}

/// Whether the document is of the map or the cloud, which cost more to read than all the others.
pub(crate) fn is_map_or_cloud(document: &str) -> bool {
    document != HOME && !is_object_document(document) && !document.starts_with(CLASSES)
}

/// The document of an object.
pub(crate) fn object_documents(entry: &ObjectEntry) -> Result<Documents, MapError> {
    let bytes = toml_bytes(Path::new(OBJECTS), entry)?;
    Ok(Documents::from([(object_document(&entry.name), bytes)]))
}

/// What the names of a class's documents begin with.
pub(crate) fn class_folder(class: &str) -> String {
    format!("{CLASSES}/{class}/")
}

/// Name of the document of a file of a class.
pub(crate) fn class_document(class: &str, file: &str) -> String {
    format!("{CLASSES}/{class}/{file}")
}

/// `value` as the text of a document; `path` is named by the error.
pub(super) fn toml_bytes<T: Serialize>(path: &Path, value: &T) -> Result<Vec<u8>, MapError> {
    let text = toml::to_string_pretty(value).map_err(|error| DescriptionError::Syntax {
        path: path.to_owned(),
        message: error.to_string(),
    })?;
    Ok(text.into_bytes())
}

/// The documents of an AOSM, its models read from where the classes say.
pub(crate) fn of_aosm(name: &str, aosm: &Aosm) -> Result<Documents, MapError> {
    let mut documents = home_document(name)?;
    documents.extend(map_documents(&StoredMap::from_grid(&aosm.grid, "map.pgm")));
    documents.extend(cloud_document(&aosm.cloud));
    for class in aosm.classes.values() {
        documents.extend(class_documents(class)?);
    }
    for object in aosm.objects.values() {
        documents.extend(object_documents(&entry_of(object))?);
    }
    Ok(documents)
}

/// The document that names the home.
pub(crate) fn home_document(name: &str) -> Result<Documents, MapError> {
    let bytes = toml_bytes(
        Path::new(HOME),
        &HomeFile {
            format: FORMAT,
            name: name.to_owned(),
        },
    )?;
    Ok(Documents::from([(HOME.to_owned(), bytes)]))
}

/// The two documents of a map.
pub(crate) fn map_documents(map: &StoredMap) -> Documents {
    let image = map.metadata.image.to_string_lossy().into_owned();
    Documents::from([
        (MAP.to_owned(), map.metadata.to_yaml().into_bytes()),
        (image, map.image.to_pgm()),
    ])
}

/// The document of a cloud; none for an empty one.
pub(crate) fn cloud_document(cloud: &PointCloud) -> Documents {
    let bytes = (!cloud.is_empty()).then(|| format_ply(cloud, PlyEncoding::BinaryLittleEndian));
    bytes
        .map(|bytes| (CLOUD.to_owned(), bytes))
        .into_iter()
        .collect()
}

/// The documents of a class: `class.toml`, the model beside it and, where the class comes from a folder of its own,
/// whatever else is in there (meshes, textures).
pub(crate) fn class_documents(class: &ObjectClass) -> Result<Documents, MapError> {
    let model = class
        .model
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    let folder = class.model.parent().unwrap_or(Path::new(""));
    let files = if folder.join("class.toml").is_file() {
        folder_files(folder)?
    } else {
        vec![model.to_string()]
    };
    let mut documents = Documents::new();
    for file in files {
        documents.insert(
            class_document(&class.name, &file),
            super::read_file(&folder.join(&file))?,
        );
    }
    documents.extend(class_text(class)?);
    Ok(documents)
}

/// The document `class.toml` of a class.
pub(crate) fn class_text(class: &ObjectClass) -> Result<Documents, MapError> {
    expect_plain(&class.model, "name", Path::new(&class.name))?;
    let model = class.model.file_name().unwrap_or_default();
    let text = toml_bytes(
        Path::new("class.toml"),
        &ObjectClass {
            model: model.into(),
            ..class.clone()
        },
    )?;
    let document = class_document(&class.name, "class.toml");
    Ok(Documents::from([(document, text)]))
}

/// The AOSM that documents make, and the home's name. `dir` is the folder they belong to: errors and models are named
/// by it. Where the map and the cloud are the same as in an AOSM at hand, they can be `kept` instead of read again.
///
/// # Errors
/// [`MapError`] naming the file that is missing or wrong, or that contradicts another one.
pub(crate) fn assemble(
    dir: &Path,
    documents: &Documents,
    kept: Option<(OccupancyGrid, PointCloud)>,
) -> Result<(String, Aosm), MapError> {
    let home: HomeFile = parse(dir, documents, HOME)?;
    if home.format != FORMAT {
        let problem = format!("format {} found, expected {FORMAT}", home.format);
        return Err(MapError::Home {
            path: dir.join(HOME),
            problem,
        });
    }
    let (grid, cloud) = match kept {
        Some(kept) => kept,
        None => (grid(dir, documents)?, cloud(dir, documents)?),
    };
    let mut aosm = Aosm::new(classes(dir, documents)?, grid);
    aosm.cloud = cloud;
    aosm.objects = objects(dir, documents)?
        .into_iter()
        .map(|object| (object.name.clone(), object))
        .collect();
    check(&aosm).map_err(|problem| MapError::Home {
        path: dir.join(OBJECTS),
        problem,
    })?;
    let domain = aosm.domain()?;
    aosm.problem(&domain, Condition::all([]))?;
    Ok((home.name, aosm))
}

/// The map as it is stored: pixels and metadata.
pub(crate) fn stored_map(dir: &Path, documents: &Documents) -> Result<StoredMap, MapError> {
    let metadata = map_metadata(dir, documents)?;
    let image = metadata.image.to_string_lossy().into_owned();
    let pixels = GrayImage::parse_pgm(bytes(dir, documents, &image)?).map_err(|source| {
        MapFileError::Image {
            path: dir.join(&image),
            source,
        }
    })?;
    Ok(StoredMap {
        metadata,
        image: pixels,
    })
}

/// What `map.yaml` says.
pub(super) fn map_metadata(dir: &Path, documents: &Documents) -> Result<MapMetadata, MapError> {
    let path = dir.join(MAP);
    let metadata = MapMetadata::parse(text(dir, documents, MAP)?).map_err(|source| {
        MapFileError::Metadata {
            path: path.clone(),
            source,
        }
    })?;
    expect_plain(&path, "image", &metadata.image)?;
    Ok(metadata)
}

/// The file that `key` of the file `path` names must lie beside it.
fn expect_plain(path: &Path, key: &str, named: &Path) -> Result<(), MapError> {
    let mut parts = named.components();
    if matches!(
        (parts.next(), parts.next()),
        (Some(Component::Normal(_)), None)
    ) {
        return Ok(());
    }
    let problem = format!(
        "`{key}` is `{}`, expected a name without folders",
        named.display()
    );
    Err(MapError::Home {
        path: path.to_owned(),
        problem,
    })
}

fn grid(dir: &Path, documents: &Documents) -> Result<OccupancyGrid, MapError> {
    let grid = stored_map(dir, documents)?.checked_grid();
    Ok(grid.map_err(|source| MapFileError::Grid {
        path: dir.join(MAP),
        source,
    })?)
}

fn cloud(dir: &Path, documents: &Documents) -> Result<PointCloud, MapError> {
    documents.get(CLOUD).map_or_else(
        || Ok(PointCloud::default()),
        |bytes| {
            parse_ply(bytes).map_err(|source| MapError::Cloud {
                path: dir.join(CLOUD),
                source,
            })
        },
    )
}

fn classes(dir: &Path, documents: &Documents) -> Result<Vec<ObjectClass>, MapError> {
    let mut classes = Vec::new();
    for document in documents.keys() {
        let [CLASSES, folder, "class.toml"] = document.split('/').collect::<Vec<_>>()[..] else {
            continue;
        };
        let path = dir.join(document);
        let class = ObjectClass::parse(text(dir, documents, document)?, &path)?;
        if class.name != folder {
            let problem = format!(
                "`name` is `{}`, expected the folder's name, `{folder}`",
                class.name
            );
            return Err(MapError::Home { path, problem });
        }
        let model = class
            .model
            .strip_prefix(dir.join(CLASSES).join(folder))
            .unwrap_or(&class.model);
        expect_plain(&path, "model", model)?;
        bytes(
            dir,
            documents,
            &class_document(folder, &model.to_string_lossy()),
        )?;
        classes.push(class);
    }
    Ok(classes)
}

fn objects(dir: &Path, documents: &Documents) -> Result<Vec<MapObject>, MapError> {
    let path = dir.join(OBJECTS);
    let names = documents.keys().filter(|name| is_object_document(name));
    names
        .map(|name| {
            let entry: ObjectEntry = parse_toml(text(dir, documents, name)?, &path)?;
            if let Some(problem) = entry.problem() {
                let problem = format!("object `{}`: {problem}", entry.name);
                return Err(MapError::Home {
                    path: path.clone(),
                    problem,
                });
            }
            Ok(entry.into_object())
        })
        .collect()
}

/// What contradicts itself among the objects, if anything: class, joints, and what is inside of what.
fn check(aosm: &Aosm) -> Result<(), String> {
    for object in aosm.objects.values() {
        let class = aosm
            .class(&object.class)
            .map_err(|error| format!("object `{}`: {error}", object.name))?;
        if let Some(joint) = object
            .joints
            .keys()
            .find(|joint| class.joint(joint).is_none())
        {
            let known = class
                .joints
                .iter()
                .map(|joint| joint.name.clone())
                .collect();
            let error = MapError::NotOfClass {
                class: class.name.clone(),
                what: "joint",
                name: joint.clone(),
                known,
            };
            return Err(format!("object `{}`: {error}", object.name));
        }
        let mut holder = object;
        while let Location::In(container) = &holder.location {
            holder = aosm
                .object(container)
                .map_err(|error| format!("object `{}` is inside: {error}", holder.name))?;
            if holder.name == object.name {
                return Err(format!("object `{}` is inside of itself", object.name));
            }
        }
    }
    Ok(())
}

fn parse<T: serde::de::DeserializeOwned>(
    dir: &Path,
    documents: &Documents,
    name: &str,
) -> Result<T, MapError> {
    Ok(parse_toml(text(dir, documents, name)?, &dir.join(name))?)
}

fn text<'a>(dir: &Path, documents: &'a Documents, name: &str) -> Result<&'a str, MapError> {
    std::str::from_utf8(bytes(dir, documents, name)?).map_err(|error| MapError::Home {
        path: dir.join(name),
        problem: format!(
            "byte {} found that is no text, expected UTF-8",
            error.valid_up_to()
        ),
    })
}

fn bytes<'a>(dir: &Path, documents: &'a Documents, name: &str) -> Result<&'a [u8], MapError> {
    documents
        .get(name)
        .map(Vec::as_slice)
        .ok_or_else(|| MapError::Home {
            path: dir.join(name),
            problem: "no such file, expected one".to_owned(),
        })
}
