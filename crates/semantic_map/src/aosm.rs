//! ⟨C, O, M, A⟩: classes, objects, grid, and the actions the classes afford.

use std::collections::BTreeMap;

use factotum_descriptions::ObjectClass;
use factotum_geometry::Pose;
use factotum_geometry::cloud::PointCloud;
use factotum_geometry::grid::OccupancyGrid;

use crate::MapError;

/// An Action-Oriented Semantic Map. It may be partial: the robot acts on what it has found so far (thesis Fig. 5.2).
#[derive(Debug, Clone, PartialEq)]
pub struct Aosm {
    /// C, by name.
    pub classes: BTreeMap<String, ObjectClass>,
    /// O, by name.
    pub objects: BTreeMap<String, MapObject>,
    /// M.
    pub grid: OccupancyGrid,
    /// What the camera has seen of the home, in the map frame; empty if nothing was kept.
    pub cloud: PointCloud,
}

/// An object of a home: an instance of a class, with its Γ.
#[derive(Debug, Clone, PartialEq)]
pub struct MapObject {
    /// Name in this home, e.g. `bottle_1`.
    pub name: String,
    /// Name of its class.
    pub class: String,
    /// Γ: pose of Λ in the map.
    pub map_from_object: Pose,
    /// Joint positions, rad or m, by joint name.
    pub joints: BTreeMap<String, f64>,
    /// Where it is kept.
    pub location: Location,
    /// How it got into the map.
    pub source: ObjectSource,
    /// Standard deviation of its position, metres.
    pub position_std_m: f64,
}

/// What holds an object.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Location {
    /// Nothing: it stands or hangs where Γ says.
    #[default]
    Loose,
    /// The robot's gripper.
    Held,
    /// Another object, by name.
    In(String),
}

/// How an object got into the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ObjectSource {
    /// Shipped with the home.
    #[default]
    Given,
    /// Seen by the robot.
    Seen,
    /// Placed by a person.
    Taught,
}

impl Aosm {
    /// A map of classes and nothing else.
    pub fn new(classes: impl IntoIterator<Item = ObjectClass>, grid: OccupancyGrid) -> Self {
        let classes = classes
            .into_iter()
            .map(|class| (class.name.clone(), class))
            .collect();
        Self {
            classes,
            objects: BTreeMap::new(),
            grid,
            cloud: PointCloud::default(),
        }
    }

    /// The class of that name.
    ///
    /// # Errors
    /// [`MapError::NoClass`], with the names there are.
    pub fn class(&self, name: &str) -> Result<&ObjectClass, MapError> {
        self.classes.get(name).ok_or_else(|| MapError::NoClass {
            name: name.to_owned(),
            known: self.classes.keys().cloned().collect(),
        })
    }

    /// The object of that name.
    ///
    /// # Errors
    /// [`MapError::NoObject`], with the names there are.
    pub fn object(&self, name: &str) -> Result<&MapObject, MapError> {
        self.objects.get(name).ok_or_else(|| self.no_object(name))
    }

    /// The object of that name, to be changed.
    ///
    /// # Errors
    /// [`MapError::NoObject`], with the names there are.
    pub fn object_mut(&mut self, name: &str) -> Result<&mut MapObject, MapError> {
        let missing = self.no_object(name);
        self.objects.get_mut(name).ok_or(missing)
    }

    fn no_object(&self, name: &str) -> MapError {
        MapError::NoObject {
            name: name.to_owned(),
            known: self.objects.keys().cloned().collect(),
        }
    }

    /// The class of an object.
    ///
    /// # Errors
    /// [`MapError::NoObject`] or [`MapError::NoClass`].
    pub fn class_of(&self, object: &str) -> Result<&ObjectClass, MapError> {
        self.class(&self.object(object)?.class)
    }

    /// The objects of a class, by name.
    pub fn objects_of<'a>(&'a self, class: &'a str) -> impl Iterator<Item = &'a MapObject> {
        self.objects
            .values()
            .filter(move |object| object.class == class)
    }

    /// The object in the gripper, if any.
    pub fn held(&self) -> Option<&MapObject> {
        self.objects
            .values()
            .find(|object| object.location == Location::Held)
    }

    /// The first free name of `class_1`, `class_2`, ... for a new object of `class`.
    pub fn free_name(&self, class: &str) -> String {
        (1..)
            .map(|number| format!("{class}_{number}"))
            .find(|name| !self.objects.contains_key(name))
            .unwrap_or_else(|| class.to_owned())
    }

    /// Puts an object of `class` into the map under its [`free_name`](Self::free_name), and returns the name.
    ///
    /// # Errors
    /// [`MapError::NoClass`] if the class is unknown.
    pub fn add_object(
        &mut self,
        class: &str,
        map_from_object: Pose,
        source: ObjectSource,
        position_std_m: f64,
    ) -> Result<String, MapError> {
        self.class(class)?;
        let name = self.free_name(class);
        let object = MapObject {
            name: name.clone(),
            class: class.to_owned(),
            map_from_object,
            joints: BTreeMap::new(),
            location: Location::Loose,
            source,
            position_std_m,
        };
        self.objects.insert(name.clone(), object);
        Ok(name)
    }

    /// Forgets what may have changed while nobody looked: in which states things are, and the objects that were held or
    /// put into others, which no look can confirm. Where the others stand is from now on a guess.
    pub fn begin_day(&mut self) {
        /// How far an object may have been pushed overnight, metres.
        const GUESS_STD_M: f64 = 0.05;
        self.objects
            .retain(|_, object| object.location == Location::Loose);
        for object in self.objects.values_mut() {
            object.joints.clear();
            object.position_std_m = object.position_std_m.max(GUESS_STD_M);
        }
    }

    /// The state names that hold for an object, from its joint positions.
    pub fn states_of(&self, object: &MapObject) -> Vec<&str> {
        let Some(class) = self.classes.get(&object.class) else {
            return Vec::new();
        };
        object
            .joints
            .iter()
            .filter_map(|(joint, position)| class.state_at(joint, *position))
            .map(|state| state.name.as_str())
            .collect()
    }
}
