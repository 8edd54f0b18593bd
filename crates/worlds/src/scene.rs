//! A home as checked data: its fixed structure, where its objects may stand, where the robot starts, and the chores.
//!
//! `scene.toml` is read here; `assets/scenes/household` is the worked example. Object classes are read from
//! `../../objects/CLASS/class.toml`, or from the folder that `objects_dir` names.
//!
//! Everything random about a home is drawn from one generator by [`HomeScene::draw`], so a seed names a home.
//! Poses are in the world frame of the scene: x east, y north, z up, metres and radians.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use factotum_descriptions::{ObjectClass, Placement, nearest_name, read_toml};
use factotum_geometry::{Pose, Pose2};
use nalgebra::Vector2;
use rand::{Rng, RngExt as _};
use serde::Deserialize;

use crate::WorldError;
use crate::random::symmetric;

/// A home.
#[derive(Debug, Clone, PartialEq)]
pub struct HomeScene {
    name: String,
    description: String,
    path: PathBuf,
    structure: PathBuf,
    bounds: Bounds,
    start: StartRegion,
    classes: BTreeMap<String, ObjectClass>,
    objects: Vec<SceneObject>,
    chores: Vec<Chore>,
}

/// A box along the world's axes, metres.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Smallest x, y, z.
    pub min: [f64; 3],
    /// Largest x, y, z.
    pub max: [f64; 3],
}

/// Where the robot's base may start; drawn uniformly.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartRegion {
    /// Interval of x, metres.
    pub x: [f64; 2],
    /// Interval of y, metres.
    pub y: [f64; 2],
    /// Interval of the heading, radians.
    pub yaw: [f64; 2],
}

/// An object of the home and where it may stand.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneObject {
    /// Name within the scene.
    pub name: String,
    /// Its class.
    pub class: String,
    /// Geom of the structure that carries it.
    #[serde(default)]
    pub on: String,
    /// Where it may be; one is drawn with equal chances.
    pub places: Vec<Place>,
    /// First positions of its joints, uniform in an interval; zero if absent.
    #[serde(default)]
    pub joints: BTreeMap<String, [f64; 2]>,
}

/// A pose with a spread; every coordinate is uniform within plus or minus its spread.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Position of Λ in the world, metres.
    pub xyz: [f64; 3],
    /// Fixed-axis roll, pitch, yaw of Λ in the world, radians.
    #[serde(default)]
    pub rpy: [f64; 3],
    /// Spread of the position, metres.
    #[serde(default)]
    pub spread_xyz: [f64; 3],
    /// Spread of the yaw, radians.
    #[serde(default)]
    pub spread_yaw: f64,
}

/// A chore: an action of a class, and how the judge tells that it was achieved.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chore {
    /// Name on the command line.
    pub name: String,
    /// One sentence for people.
    #[serde(default)]
    pub description: String,
    /// Class whose action is to be achieved.
    pub class: String,
    /// Action of that class.
    pub action: String,
    /// Whether it is done only when it is asked for by name.
    #[serde(default)]
    pub on_request: bool,
    /// What the judge measures.
    pub judge: Criterion,
}

/// What physics must say for a chore to be achieved.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Criterion {
    /// An object's centre of mass is inside a box in another object's Λ, at rest, and nothing of the robot touches it.
    Inside {
        /// The object.
        object: String,
        /// The object that should hold it.
        container: String,
        /// Smallest coordinates in the container's Λ, metres.
        min: [f64; 3],
        /// Largest coordinates in the container's Λ, metres.
        max: [f64; 3],
        /// Largest speed of the object that counts as rest.
        speed_max_m_per_s: f64,
    },
    /// A joint of an object is at rest in the interval of a state of its class.
    Joint {
        /// The object.
        object: String,
        /// The joint.
        joint: String,
        /// The state.
        state: String,
        /// Largest speed of the joint that counts as rest.
        speed_max_rad_per_s: f64,
    },
}

/// One draw of a home: where everything is at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The robot's base.
    pub world_from_base: Pose2,
    /// The objects, in the order of the scene.
    pub objects: Vec<PlacedObject>,
}

/// An object at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedObject {
    /// Its name.
    pub name: String,
    /// Its class.
    pub class: String,
    /// Pose of its Λ.
    pub world_from_object: Pose,
    /// Positions of its joints, rad or m.
    pub joints: BTreeMap<String, f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScene {
    name: String,
    #[serde(default)]
    description: String,
    structure: PathBuf,
    #[serde(default = "default_objects_dir")]
    objects_dir: PathBuf,
    bounds: Bounds,
    robot_start: StartRegion,
    #[serde(default)]
    objects: Vec<SceneObject>,
    #[serde(default)]
    chores: Vec<Chore>,
}

fn default_objects_dir() -> PathBuf {
    PathBuf::from("../../objects")
}

/// The classes of the objects, and those that the chores speak of: a robot knows what a bin is in a home without one.
fn load_classes(
    dir: &Path,
    objects: &[SceneObject],
    chores: &[Chore],
) -> Result<BTreeMap<String, ObjectClass>, WorldError> {
    let mut classes: BTreeMap<String, ObjectClass> = BTreeMap::new();
    let load = |name: &str, classes: &mut BTreeMap<String, ObjectClass>| {
        if !classes.contains_key(name) {
            classes.insert(name.to_owned(), ObjectClass::load(&dir.join(name))?);
        }
        Ok::<(), WorldError>(())
    };
    for object in objects {
        load(&object.class, &mut classes)?;
    }
    for chore in chores {
        // A name of no class is told with those there are, when the chores are checked.
        if dir.join(&chore.class).join("class.toml").is_file() {
            load(&chore.class, &mut classes)?;
        }
        let action = classes
            .get(&chore.class)
            .and_then(|class| class.action(&chore.action));
        if let Some(target) = action.and_then(|action| action.target_class.clone()) {
            load(&target, &mut classes)?;
        }
    }
    Ok(classes)
}

impl HomeScene {
    /// Reads `DIR/scene.toml` (or the file itself, if `path` names one) and the classes it uses.
    ///
    /// # Errors
    /// [`WorldError::Description`] if a file cannot be read or has an unknown key, [`WorldError::Value`] if the scene
    /// contradicts itself or a class.
    pub fn load(path: &Path) -> Result<Self, WorldError> {
        let file = if path.is_dir() {
            path.join("scene.toml")
        } else {
            path.to_owned()
        };
        let raw: RawScene = read_toml(&file)?;
        let dir = file.parent().map(Path::to_owned).unwrap_or_default();
        let classes = load_classes(&dir.join(&raw.objects_dir), &raw.objects, &raw.chores)?;
        let scene = Self {
            name: raw.name,
            description: raw.description,
            structure: dir.join(&raw.structure),
            path: file,
            bounds: raw.bounds,
            start: raw.robot_start,
            classes,
            objects: raw.objects,
            chores: raw.chores,
        };
        scene.check()?;
        Ok(scene)
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// One sentence for people.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Model of the fixed structure.
    pub fn structure(&self) -> &Path {
        &self.structure
    }

    /// The smallest box that holds the home.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The classes of its objects, by name.
    pub fn classes(&self) -> &BTreeMap<String, ObjectClass> {
        &self.classes
    }

    /// Its objects.
    pub fn objects(&self) -> &[SceneObject] {
        &self.objects
    }

    /// What there is to do.
    pub fn chores(&self) -> &[Chore] {
        &self.chores
    }

    /// The chore of that name.
    ///
    /// # Errors
    /// [`WorldError::UnknownName`], listing the chores there are.
    pub fn chore(&self, name: &str) -> Result<&Chore, WorldError> {
        self.chores
            .iter()
            .find(|chore| chore.name == name)
            .ok_or_else(|| WorldError::UnknownName {
                kind: "chore",
                name: name.to_owned(),
                scene: self.name.clone(),
                available: self.chores.iter().map(|chore| chore.name.clone()).collect(),
            })
    }

    /// The same home without the objects of a class; its chores stay, and cannot be achieved if they need one.
    #[must_use]
    pub fn without_class(mut self, class: &str) -> Self {
        self.objects.retain(|object| object.class != class);
        self
    }

    /// The same home with the robot starting at a pose.
    #[must_use]
    pub fn with_start(mut self, world_from_base: Pose2) -> Self {
        let (place, yaw) = (
            world_from_base.translation,
            world_from_base.rotation.angle(),
        );
        self.start = StartRegion {
            x: [place.x; 2],
            y: [place.y; 2],
            yaw: [yaw; 2],
        };
        self
    }

    /// Draws where everything is.
    pub fn draw(&self, rng: &mut impl Rng) -> Placed {
        let start = &self.start;
        // One draw per interval, whatever its width, so that another start does not move the objects.
        let mut uniform = |[low, high]: [f64; 2]| low + (high - low) * rng.random_range(0.0..1.0);
        let (x, y) = (uniform(start.x), uniform(start.y));
        let world_from_base = Pose2::new(Vector2::new(x, y), uniform(start.yaw));
        let objects = self.objects.iter().map(|object| object.draw(rng)).collect();
        Placed {
            world_from_base,
            objects,
        }
    }

    fn check(&self) -> Result<(), WorldError> {
        let start = &self.start;
        for (field, [low, high]) in [("x", start.x), ("y", start.y), ("yaw", start.yaw)] {
            self.check_interval(&format!("robot_start.{field}"), [low, high])?;
        }
        for axis in 0..3 {
            let (low, high) = (self.bounds.min[axis], self.bounds.max[axis]);
            self.check_interval(&format!("bounds[{axis}]"), [low, high])?;
        }
        for (i, object) in self.objects.iter().enumerate() {
            let field = |key: &str| format!("objects.{}.{key}", object.name);
            if self.objects[..i]
                .iter()
                .any(|other| other.name == object.name)
            {
                return self.bad(&field("name"), "used twice", "a name of its own");
            }
            if object.places.is_empty() {
                return self.bad(&field("places"), "empty", "at least one place");
            }
            let class = &self.classes[&object.class];
            let joints = class.joints.iter().map(|joint| joint.name.as_str());
            for (joint, interval) in &object.joints {
                let known: Vec<&str> = joints.clone().collect();
                self.check_name(&field(&format!("joints.{joint}")), joint, &known)?;
                self.check_interval(&field(&format!("joints.{joint}")), *interval)?;
            }
        }
        self.chores
            .iter()
            .try_for_each(|chore| self.check_chore(chore))
    }

    fn check_chore(&self, chore: &Chore) -> Result<(), WorldError> {
        let field = |key: &str| format!("chores.{}.{key}", chore.name);
        let classes: Vec<&str> = self.classes.keys().map(String::as_str).collect();
        self.check_name(&field("class"), &chore.class, &classes)?;
        let class = &self.classes[&chore.class];
        let actions: Vec<&str> = class
            .actions
            .iter()
            .map(|action| action.name.as_str())
            .collect();
        self.check_name(&field("action"), &chore.action, &actions)?;
        let spec = class.action(&chore.action);
        let target = spec.and_then(|action| action.target_class.as_deref());
        match &chore.judge {
            Criterion::Inside {
                object, container, ..
            } => {
                self.check_object(&field("judge.object"), object, Some(&chore.class))?;
                self.check_object(&field("judge.container"), container, target)
            }
            Criterion::Joint {
                object,
                joint,
                state,
                ..
            } => {
                self.check_object(&field("judge.object"), object, Some(&chore.class))?;
                let class_name = self
                    .objects
                    .iter()
                    .find(|candidate| candidate.name == *object)
                    .map_or(&chore.class, |found| &found.class);
                let class = &self.classes[class_name];
                let joints: Vec<&str> = class
                    .joints
                    .iter()
                    .map(|joint| joint.name.as_str())
                    .collect();
                self.check_name(&field("judge.joint"), joint, &joints)?;
                let states: Vec<&str> = class
                    .states
                    .iter()
                    .filter(|candidate| candidate.joint == *joint)
                    .map(|state| state.name.as_str())
                    .collect();
                self.check_name(&field("judge.state"), state, &states)
            }
        }
    }

    /// An object that a judge looks at. A home without any object of its class has none to name: the chore cannot be
    /// achieved there, which is for the judge to say.
    fn check_object(&self, field: &str, name: &str, class: Option<&str>) -> Result<(), WorldError> {
        let is_lacking =
            class.is_some_and(|class| self.objects.iter().all(|object| object.class != class));
        let objects: Vec<&str> = self
            .objects
            .iter()
            .map(|object| object.name.as_str())
            .collect();
        if is_lacking {
            return Ok(());
        }
        self.check_name(field, name, &objects)
    }

    fn check_interval(&self, field: &str, [low, high]: [f64; 2]) -> Result<(), WorldError> {
        if low.is_finite() && high.is_finite() && low <= high {
            return Ok(());
        }
        self.bad(
            field,
            &format!("[{low}, {high}]"),
            "two numbers, the smaller first",
        )
    }

    fn check_name(&self, field: &str, name: &str, known: &[&str]) -> Result<(), WorldError> {
        if known.contains(&name) {
            return Ok(());
        }
        let nearest = nearest_name(name, known.iter().copied())
            .map(|nearest| format!("; did you mean `{nearest}`?"))
            .unwrap_or_default();
        self.bad(
            field,
            &format!("`{name}`"),
            &format!("one of `{}`{nearest}", known.join("`, `")),
        )
    }

    fn bad(&self, field: &str, found: &str, wanted: &str) -> Result<(), WorldError> {
        Err(WorldError::Value {
            path: self.path.clone(),
            field: field.to_owned(),
            found: found.to_owned(),
            wanted: wanted.to_owned(),
        })
    }
}

impl SceneObject {
    fn draw(&self, rng: &mut impl Rng) -> PlacedObject {
        let place = &self.places[rng.random_range(0..self.places.len())];
        let mut xyz = place.xyz;
        for (value, spread) in xyz.iter_mut().zip(place.spread_xyz) {
            *value += symmetric(rng, spread);
        }
        let [roll, pitch, yaw] = place.rpy;
        let rpy = [roll, pitch, yaw + symmetric(rng, place.spread_yaw)];
        let joints = self
            .joints
            .iter()
            .map(|(joint, [low, high])| {
                let middle = (low + high) / 2.0;
                (joint.clone(), middle + symmetric(rng, (high - low) / 2.0))
            })
            .collect();
        PlacedObject {
            name: self.name.clone(),
            class: self.class.clone(),
            world_from_object: Placement { xyz, rpy }.into(),
            joints,
        }
    }
}
