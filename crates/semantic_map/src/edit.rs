//! Edits of a home: what a person or the robot can change, each as changes of documents.

use std::collections::BTreeMap;
use std::path::Path;

use factotum_descriptions::{ActionSpec, Form, Grasp, ObjectClass, Placement, parse_toml};
use factotum_geometry::Pose;
use factotum_geometry::cloud::PointCloud;
use factotum_geometry::grid::OccupancyGrid;
use factotum_geometry::grid::map_server::StoredMap;

use crate::home_folder::{
    CLOUD, Documents, HOME, ObjectEntry, class_document, class_documents, class_folder, class_text,
    cloud_document, entry_of, home_document, map_documents, object_document, object_documents,
    stored_map,
};
use crate::vocabulary::OWN_TYPES;
use crate::{Aosm, Location, MapError, MapObject};

/// A change of a home, to be journaled and undone as one.
#[derive(Debug, Clone, PartialEq)]
pub enum Edit {
    /// Put a new object into the map.
    AddObject(MapObject),
    /// Take an object out of the map.
    RemoveObject {
        /// Its name.
        name: String,
    },
    /// Give an object another Γ.
    MoveObject {
        /// Its name.
        name: String,
        /// The new Γ.
        map_from_object: Pose,
    },
    /// Set joint positions of an object; joints not named stay.
    SetJoints {
        /// Its name.
        name: String,
        /// Positions, rad or m, by joint name.
        joints: BTreeMap<String, f64>,
    },
    /// Say what holds an object.
    SetLocation {
        /// Its name.
        name: String,
        /// What holds it now.
        location: Location,
    },
    /// Give an object another name. What is inside of it stays inside.
    Rename {
        /// Its name.
        name: String,
        /// The new name.
        to: String,
    },
    /// Make a class of a shape.
    MakeClass {
        /// Its name.
        name: String,
        /// The shape.
        form: Form,
        /// Whether its objects can be carried away.
        movable: bool,
    },
    /// Give a class that was made of a shape another one. What was taught of it stays.
    ReshapeClass {
        /// Its name.
        name: String,
        /// The new shape.
        form: Form,
        /// Whether its objects can be carried away.
        movable: bool,
    },
    /// Teach a class a grasp, or change the one of that name.
    PutGrasp {
        /// The class.
        class: String,
        /// The grasp.
        grasp: Grasp,
    },
    /// Forget a grasp of a class.
    RemoveGrasp {
        /// The class.
        class: String,
        /// Name of the grasp.
        name: String,
    },
    /// Teach a class an action, or change the one of that name.
    PutAction {
        /// The class.
        class: String,
        /// The action.
        action: Box<ActionSpec>,
    },
    /// Forget an action of a class.
    RemoveAction {
        /// The class.
        class: String,
        /// Name of the action.
        name: String,
    },
    /// Add a class, or change the one of that name. The model is copied from where the class says it is.
    PutClass(Box<ObjectClass>),
    /// Take a class, of which there is no object, out of the map.
    RemoveClass {
        /// Its name.
        name: String,
    },
    /// Replace the grid. One of the same size keeps the stored map's thresholds, and the pixels that still say the same.
    SetMap(OccupancyGrid),
    /// Replace the point cloud.
    SetCloud(PointCloud),
    /// Replace everything, as after an exploration.
    SetAll(Box<Aosm>),
    /// Give the home another name.
    SetHomeName(String),
}

/// A class or an object of a home: what people change, and what two of them may change at once.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Thing {
    /// A class, with all that is known of it.
    Class(String),
    /// An object.
    Object(String),
}

impl Thing {
    /// Whether a document is part of it.
    pub(crate) fn has(&self, document: &str) -> bool {
        match self {
            Self::Class(name) => document.starts_with(&class_folder(name)),
            Self::Object(name) => document == object_document(name),
        }
    }
}

impl std::fmt::Display for Thing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Class(name) => write!(f, "class `{name}`"),
            Self::Object(name) => write!(f, "object `{name}`"),
        }
    }
}

/// New bytes by document; none where the document goes.
pub(crate) type DocumentChanges = BTreeMap<String, Option<Vec<u8>>>;

/// The changes that make one set of documents into another.
pub(crate) fn difference(before: &Documents, after: &Documents) -> DocumentChanges {
    let removed = before
        .keys()
        .filter(|name| !after.contains_key(*name))
        .map(|name| (name.clone(), None));
    let put = after
        .iter()
        .filter(|(name, bytes)| before.get(*name) != Some(*bytes));
    removed
        .chain(put.map(|(name, bytes)| (name.clone(), Some(bytes.clone()))))
        .collect()
}

impl Edit {
    /// One line for the history, e.g. `move bottle_1`.
    pub fn summary(&self) -> String {
        match self {
            Self::AddObject(object) => format!("add {}", object.name),
            Self::RemoveObject { name } => format!("remove {name}"),
            Self::MoveObject { name, .. } => format!("move {name}"),
            Self::SetJoints { name, .. } => format!("set joints of {name}"),
            Self::SetLocation {
                name,
                location: Location::Loose,
            } => format!("put {name} down"),
            Self::SetLocation {
                name,
                location: Location::Held,
            } => format!("take {name}"),
            Self::SetLocation {
                name,
                location: Location::In(container),
            } => format!("put {name} in {container}"),
            Self::Rename { name, to } => format!("rename {name} to {to}"),
            Self::MakeClass { name, .. } => format!("make class {name}"),
            Self::ReshapeClass { name, .. } => format!("reshape class {name}"),
            Self::PutGrasp { class, grasp } => format!("teach grasp {} of {class}", grasp.name),
            Self::RemoveGrasp { class, name } => format!("forget grasp {name} of {class}"),
            Self::PutAction { class, action } => format!("teach {} of {class}", action.name),
            Self::RemoveAction { class, name } => format!("forget {name} of {class}"),
            Self::PutClass(class) => format!("put class {}", class.name),
            Self::RemoveClass { name } => format!("remove class {name}"),
            Self::SetMap(_) => "replace the map".to_owned(),
            Self::SetCloud(_) => "replace the point cloud".to_owned(),
            Self::SetAll(_) => "replace everything".to_owned(),
            Self::SetHomeName(name) => format!("name the home {name}"),
        }
    }

    /// The class or object that it changes, as far as it is one.
    pub fn thing(&self) -> Option<Thing> {
        Some(match self {
            Self::AddObject(object) => Thing::Object(object.name.clone()),
            Self::RemoveObject { name }
            | Self::MoveObject { name, .. }
            | Self::SetJoints { name, .. }
            | Self::SetLocation { name, .. }
            | Self::Rename { name, .. } => Thing::Object(name.clone()),
            Self::MakeClass { name, .. }
            | Self::ReshapeClass { name, .. }
            | Self::RemoveClass { name }
            | Self::PutGrasp { class: name, .. }
            | Self::RemoveGrasp { class: name, .. }
            | Self::PutAction { class: name, .. }
            | Self::RemoveAction { class: name, .. } => Thing::Class(name.clone()),
            Self::PutClass(class) => Thing::Class(class.name.clone()),
            Self::SetMap(_) | Self::SetCloud(_) | Self::SetAll(_) | Self::SetHomeName(_) => {
                return None;
            }
        })
    }

    /// What the edit does to the documents of `home`. Whether the result makes sense is checked where it is assembled.
    pub(crate) fn changes(&self, home: &HomeView<'_>) -> Result<DocumentChanges, MapError> {
        match self {
            Self::AddObject(object) => {
                if home.aosm.objects.contains_key(&object.name) {
                    return Err(home.name_taken(&object.name));
                }
                Ok(put(object_documents(&entry_of(object))?))
            }
            Self::RemoveObject { name } => {
                home.aosm.object(name)?;
                Ok(DocumentChanges::from([(object_document(name), None)]))
            }
            Self::MoveObject {
                name,
                map_from_object,
            } => home.change_entry(name, |entry| {
                let Placement { xyz, rpy } = (*map_from_object).into();
                (entry.xyz, entry.rpy) = (xyz, rpy);
            }),
            Self::SetJoints { name, joints } => {
                home.change_entry(name, |entry| entry.joints.extend(joints.clone()))
            }
            Self::SetLocation { name, location } => {
                home.change_entry(name, |entry| entry.set_location(location))
            }
            Self::Rename { name, to } => home.rename(name, to),
            Self::MakeClass {
                name,
                form,
                movable,
            } => home.make_class(name, *form, *movable),
            Self::ReshapeClass {
                name,
                form,
                movable,
            } => home.reshape_class(name, *form, *movable),
            Self::PutGrasp { class, grasp } => home.change_class(class, |class, _| {
                class.put_grasp(grasp.clone());
                Ok(())
            }),
            Self::RemoveGrasp { class, name } => home.change_class(class, |class, _| {
                let known = class.grasps.iter().map(|grasp| grasp.name.clone());
                let missing = not_of_class(class, "grasp", name, known.collect());
                class.remove_grasp(name).then_some(()).ok_or(missing)
            }),
            Self::PutAction { class, action } => home.change_class(class, |class, file| {
                Ok(class.put_action(action.as_ref().clone(), file)?)
            }),
            Self::RemoveAction { class, name } => home.change_class(class, |class, _| {
                let known = class.actions.iter().map(|action| action.name.clone());
                let missing = not_of_class(class, "action", name, known.collect());
                class.remove_action(name).then_some(()).ok_or(missing)
            }),
            Self::PutClass(class) => {
                let mut changes = home.without_class(&class.name);
                changes.extend(put(class_documents(class)?));
                Ok(changes)
            }
            Self::RemoveClass { name } => {
                home.aosm.class(name)?;
                Ok(home.without_class(name))
            }
            Self::SetMap(grid) => Ok(put(home.map(grid)?)),
            Self::SetCloud(cloud) => {
                let mut changes = DocumentChanges::from([(CLOUD.to_owned(), None)]);
                changes.extend(put(cloud_document(cloud)));
                Ok(changes)
            }
            Self::SetAll(aosm) => home.all_changes(aosm),
            Self::SetHomeName(name) => Ok(put(home_document(name)?)),
        }
    }
}

/// A home as it is before an edit.
#[derive(Debug)]
pub(crate) struct HomeView<'a> {
    pub(crate) dir: &'a Path,
    pub(crate) aosm: &'a Aosm,
    pub(crate) documents: &'a Documents,
}

impl HomeView<'_> {
    fn name_taken(&self, name: &str) -> MapError {
        MapError::Home {
            path: self.dir.to_owned(),
            problem: format!("an object is named `{name}` already, expected a new name"),
        }
    }

    fn entry(&self, object: &str) -> Result<ObjectEntry, MapError> {
        self.aosm.object(object)?;
        let bytes = self
            .documents
            .get(&object_document(object))
            .map(Vec::as_slice)
            .unwrap_or_default();
        Ok(parse_toml(
            &String::from_utf8_lossy(bytes),
            &self.dir.join("objects.toml"),
        )?)
    }

    fn change_entry(
        &self,
        object: &str,
        change: impl FnOnce(&mut ObjectEntry),
    ) -> Result<DocumentChanges, MapError> {
        let mut entry = self.entry(object)?;
        change(&mut entry);
        Ok(put(object_documents(&entry)?))
    }

    fn rename(&self, name: &str, to: &str) -> Result<DocumentChanges, MapError> {
        if self.aosm.objects.contains_key(to) {
            return Err(self.name_taken(to));
        }
        let mut entry = self.entry(name)?;
        to.clone_into(&mut entry.name);
        let mut changes = put(object_documents(&entry)?);
        changes.insert(object_document(name), None);
        for inside in self
            .aosm
            .objects
            .values()
            .filter(|object| object.location == Location::In(name.to_owned()))
        {
            let location = Location::In(to.to_owned());
            changes.extend(self.change_entry(&inside.name, |entry| entry.set_location(&location))?);
        }
        Ok(changes)
    }

    fn make_class(
        &self,
        name: &str,
        form: Form,
        movable: bool,
    ) -> Result<DocumentChanges, MapError> {
        let path = self.dir.join(class_document(name, "class.toml"));
        if self.aosm.classes.contains_key(name) || OWN_TYPES.contains(&name) {
            return Err(MapError::Home {
                path,
                problem: format!("a class is named `{name}` already, expected a new name"),
            });
        }
        let (class, model) = ObjectClass::of_form(name, form, movable)?;
        let mut documents = class_text(&class)?;
        let model_document = class_document(name, &class.model.to_string_lossy());
        documents.insert(model_document, model.into_bytes());
        Ok(put(documents))
    }

    fn reshape_class(
        &self,
        name: &str,
        form: Form,
        movable: bool,
    ) -> Result<DocumentChanges, MapError> {
        let (new, model) = ObjectClass::of_form(name, form, movable)?;
        let mut changes = self.change_class(name, |class, file| {
            if class.form.is_none() {
                return Err(MapError::Home {
                    path: file.to_owned(),
                    problem: format!(
                        "class `{name}` has a model of its own, expected one made of a shape"
                    ),
                });
            }
            (class.form, class.movable) = (new.form, new.movable);
            class.yaw_symmetric = new.yaw_symmetric;
            Ok(())
        })?;
        let model_document = class_document(name, &new.model.to_string_lossy());
        changes.insert(model_document, Some(model.into_bytes()));
        Ok(changes)
    }

    /// Changes what a class's `class.toml` says; its model stays.
    fn change_class(
        &self,
        name: &str,
        change: impl FnOnce(&mut ObjectClass, &Path) -> Result<(), MapError>,
    ) -> Result<DocumentChanges, MapError> {
        let mut class = self.aosm.class(name)?.clone();
        let file = self.dir.join(class_document(name, "class.toml"));
        change(&mut class, &file)?;
        class.check(&file)?;
        Ok(put(class_text(&class)?))
    }

    fn without_class(&self, class: &str) -> DocumentChanges {
        let folder = class_folder(class);
        let of_class = self
            .documents
            .keys()
            .filter(|name| name.starts_with(&folder));
        of_class.map(|name| (name.clone(), None)).collect()
    }

    /// The documents of a grid, as near to the stored map as can be.
    fn map(&self, grid: &OccupancyGrid) -> Result<Documents, MapError> {
        let mut map = stored_map(self.dir, self.documents)?;
        if map.update(grid).is_err() {
            // Another size: nothing of the old pixels can be kept.
            map = StoredMap::from_grid(grid, map.metadata.image);
        }
        Ok(map_documents(&map))
    }

    /// What makes the home hold `aosm`. What is the same in both keeps its digits and a person's comments.
    fn all_changes(&self, aosm: &Aosm) -> Result<DocumentChanges, MapError> {
        let mut after = self.kept(|document| document == HOME);
        after.extend(self.map(&aosm.grid)?);
        after.extend(cloud_document(&aosm.cloud));
        for class in aosm.classes.values() {
            let is_same = self.aosm.classes.get(&class.name) == Some(class);
            let folder = class_folder(&class.name);
            after.extend(if is_same {
                self.kept(|document| document.starts_with(&folder))
            } else {
                class_documents(class)?
            });
        }
        for object in aosm.objects.values() {
            let is_same = self.aosm.objects.get(&object.name) == Some(object);
            let document = object_document(&object.name);
            after.extend(if is_same {
                self.kept(|kept| kept == document)
            } else {
                object_documents(&entry_of(object))?
            });
        }
        Ok(difference(self.documents, &after))
    }

    /// The documents of the home for which `is_kept` holds.
    fn kept(&self, is_kept: impl Fn(&str) -> bool) -> Documents {
        let kept = self.documents.iter().filter(|(name, _)| is_kept(name));
        kept.map(|(name, bytes)| (name.clone(), bytes.clone()))
            .collect()
    }
}

fn not_of_class(
    class: &ObjectClass,
    what: &'static str,
    name: &str,
    known: Vec<String>,
) -> MapError {
    MapError::NotOfClass {
        class: class.name.clone(),
        what,
        name: name.to_owned(),
        known,
    }
}

/// The changes that put documents where others or none were.
fn put(documents: Documents) -> DocumentChanges {
    documents
        .into_iter()
        .map(|(name, bytes)| (name, Some(bytes)))
        .collect()
}
