//! Where in a home each skill can run: for each object and action, the standing places from which it is feasible.
//!
//! A place is a cell of a grid on the floor with one of four headings. What is not listed as feasible is infeasible, so a
//! map answers every try. It is the truth about a home, to learn against; whoever learns is told of its own tries only.
//!
//! Maps are [read](ActionMap::read) from files, see [`file`](self::file), or made from a [generated kitchen](crate::kitchen).
//!
//! Frames: the world of the scene, right-handed, x forward, y left, z up; metres and radians. The yaw of an object is 0 where
//! it is not known.

mod file;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};

use factotum_geometry::Pose2;
use nalgebra::{Point2, Vector2};

pub use file::read_folder;

/// How far a cell may lie beside the grid, in cells: files carry six digits or more.
const OFF_GRID_MAX: f64 = 0.01;

/// Headings of a place.
const N_HEADINGS: usize = 4;

/// Why there is no action map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ActionMapError {
    /// A file or folder cannot be read.
    #[error("cannot read `{}`", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// A file is not JSON of the wanted form.
    #[error("`{}`: not an action map: {source}", file.display())]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Line, column, what was found and what was wanted.
        source: serde_json::Error,
    },
    /// A value is out of its range.
    #[error("`{}`: `{key}` is {found}, expected {wanted}", file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// Where in the file.
        key: String,
        /// What it says.
        found: String,
        /// What would be right.
        wanted: String,
    },
    /// An action is said to be feasible where nobody can stand.
    #[error(
        "`{}`: `{key}` is at ({}, {}), which is not among the {n_cells} cells of `reachable`",
        file.display(),
        found[0],
        found[1]
    )]
    UnknownCell {
        /// The file.
        file: PathBuf,
        /// Where in the file.
        key: String,
        /// The file's horizontal coordinates.
        found: [f64; 2],
        /// How many cells the map has.
        n_cells: usize,
    },
    /// A folder without maps.
    #[error("`{}` holds no action map, expected files `NAME.json`", folder.display())]
    NoMaps {
        /// The folder.
        folder: PathBuf,
    },
    /// Two maps of one scene.
    #[error("`{}` and `{}` are both of scene `{scene}`", first.display(), second.display())]
    Twice {
        /// The scene.
        scene: String,
        /// A file.
        first: PathBuf,
        /// Another.
        second: PathBuf,
    },
}

/// A standing place: an index, valid in its own map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StandingPlace(usize);

impl StandingPlace {
    /// Where it comes among the places of its map.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }
}

/// The cells of a grid on which a robot can stand.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cells {
    pub(crate) cell_m: f64,
    /// Their middles, in the world.
    middles: Vec<Point2<f64>>,
    /// Where each is on the grid.
    index: BTreeMap<[i64; 2], usize>,
}

impl Cells {
    /// An empty grid.
    pub(crate) fn new(cell_m: f64) -> Self {
        Self {
            cell_m,
            middles: Vec::new(),
            index: BTreeMap::new(),
        }
    }

    /// Adds a cell; `None` if it lies beside the grid of the first, or is there already.
    pub(crate) fn push(&mut self, middle: Point2<f64>) -> Option<()> {
        let key = match self.middles.first() {
            None => [0, 0],
            Some(first) => self.key(first, &middle)?,
        };
        if self.index.insert(key, self.middles.len()).is_some() {
            return None;
        }
        self.middles.push(middle);
        Some(())
    }

    /// The cell whose middle is here.
    fn at(&self, middle: &Point2<f64>) -> Option<usize> {
        let key = self.key(self.middles.first()?, middle)?;
        self.index.get(&key).copied()
    }

    fn key(&self, first: &Point2<f64>, middle: &Point2<f64>) -> Option<[i64; 2]> {
        let steps = (middle - first) / self.cell_m;
        let whole = steps.map(f64::round);
        ((steps - whole).amax() <= OFF_GRID_MAX).then(|| [whole.x as i64, whole.y as i64])
    }

    /// How many.
    pub(crate) fn len(&self) -> usize {
        self.middles.len()
    }

    /// The place on a cell with a heading of so many quarter turns.
    pub(crate) fn place(&self, middle: &Point2<f64>, n_quarters: usize) -> Option<StandingPlace> {
        let cell = self.at(middle)?;
        Some(StandingPlace(cell * N_HEADINGS + n_quarters % N_HEADINGS))
    }
}

/// An object of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapObject {
    /// Its name, one in its map.
    pub id: String,
    /// Its class, such as `Mug`.
    pub class: String,
    /// Where it stands, seen from above.
    pub world_from_object: Pose2,
    /// From where each action on it is feasible.
    pub feasible: BTreeMap<String, BTreeSet<StandingPlace>>,
}

/// Where in a home each skill can run.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionMap {
    scene: String,
    cells: Cells,
    objects: Vec<MapObject>,
}

impl ActionMap {
    pub(crate) fn new(scene: String, cells: Cells, mut objects: Vec<MapObject>) -> Self {
        objects.sort_by(|a, b| a.id.cmp(&b.id));
        Self {
            scene,
            cells,
            objects,
        }
    }

    /// Reads a map from a file.
    ///
    /// # Errors
    /// [`ActionMapError`] names file, key, what was found and what was wanted.
    pub fn read(file: &Path) -> Result<Self, ActionMapError> {
        file::read(file)
    }

    /// Name of the scene.
    #[must_use]
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// Length of a cell.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.cells.cell_m
    }

    /// The objects, by name.
    #[must_use]
    pub fn objects(&self) -> &[MapObject] {
        &self.objects
    }

    /// The first object of a class on which the action is feasible from somewhere.
    #[must_use]
    pub fn object_for(&self, action: &str, class: &str) -> Option<&MapObject> {
        self.objects.iter().find(|object| {
            let places = object.feasible.get(action);
            object.class == class && places.is_some_and(|places| !places.is_empty())
        })
    }

    /// All places, cell by cell.
    pub fn places(&self) -> impl Iterator<Item = StandingPlace> + use<> {
        (0..self.cells.len() * N_HEADINGS).map(StandingPlace)
    }

    /// The pose of the base at a place.
    ///
    /// # Panics
    /// If the place is of another map.
    #[must_use]
    pub fn world_from_base(&self, place: StandingPlace) -> Pose2 {
        let middle = self.cells.middles[place.0 / N_HEADINGS];
        let yaw = (place.0 % N_HEADINGS) as f64 * FRAC_PI_2;
        Pose2::new(Vector2::new(middle.x, middle.y), yaw)
    }

    /// How far the way is from a place to each other, metres along the grid, in the order of [`places`](Self::places);
    /// infinite where there is none. Turning is free.
    #[must_use]
    pub fn travel_m(&self, from: StandingPlace) -> Vec<f64> {
        let mut steps: Vec<Option<u32>> = vec![None; self.cells.len()];
        let keys: BTreeMap<usize, [i64; 2]> =
            self.cells.index.iter().map(|(k, c)| (*c, *k)).collect();
        let start = from.0 / N_HEADINGS;
        let mut open = VecDeque::from([(start, 0)]);
        steps[start] = Some(0);
        while let Some((cell, n)) = open.pop_front() {
            let [x, y] = keys[&cell];
            for key in [[x + 1, y], [x - 1, y], [x, y + 1], [x, y - 1]] {
                let next = self.cells.index.get(&key).copied();
                if let Some(next) = next.filter(|&next| steps[next].is_none()) {
                    steps[next] = Some(n + 1);
                    open.push_back((next, n + 1));
                }
            }
        }
        let metres = |n: Option<u32>| n.map_or(f64::INFINITY, |n| f64::from(n) * self.cell_m());
        steps
            .into_iter()
            .flat_map(|n| [metres(n); N_HEADINGS])
            .collect()
    }
}
