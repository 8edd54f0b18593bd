//! Action maps as JSON files.
//!
//! ```text
//! {"scene": NAME, "grid": metres, "reachable": [[x, y, z], ...],
//!  "actions": {"CLASS|x|y|z": {ACTION: [[x, y, z, heading], ...], ...}, ...}}
//! ```
//!
//! Axes are Unity's, left-handed, y up; headings are degrees about y, clockwise from above, 0 along z. They are turned
//! into ours here and nowhere else ([`factotum_geometry::frames::point_from_unity`]). The name of an object says its class
//! and where it stands; parts after a fourth bar name a part of it.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use factotum_geometry::Pose2;
use factotum_geometry::frames::{point_from_unity, yaw_from_unity};
use nalgebra::{Point3, Vector2};
use serde::Deserialize;

use super::{ActionMap, ActionMapError, Cells, MapObject, StandingPlace};

/// How far a heading may be from a quarter turn, rad.
const HEADING_TOLERANCE_RAD: f64 = 1e-3;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMap {
    scene: String,
    grid: f64,
    reachable: Vec<[f64; 3]>,
    actions: BTreeMap<String, BTreeMap<String, Vec<[f64; 4]>>>,
}

/// Where a scene comes among others: the words and numbers of its name, then the name.
type SceneKey = (Vec<(String, u64)>, String);

/// Reads all maps of a folder, files `NAME.json`, sorted by scene, numbers in names by their value.
///
/// # Errors
/// [`ActionMapError`] when one cannot be read, two are of the same scene, or there is none.
pub fn read_folder(folder: &Path) -> Result<Vec<ActionMap>, ActionMapError> {
    let failed = |source| ActionMapError::Read {
        path: folder.to_path_buf(),
        source,
    };
    let mut maps: BTreeMap<SceneKey, (PathBuf, ActionMap)> = BTreeMap::new();
    let entries = std::fs::read_dir(folder).map_err(failed)?;
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()
        .map_err(failed)?;
    files.retain(|file| {
        file.extension()
            .is_some_and(|extension| extension == "json")
    });
    files.sort();
    for second in files {
        let map = read(&second)?;
        let key = (words_and_numbers(&map.scene), map.scene.clone());
        if let Some((first, map)) = maps.get(&key) {
            return Err(ActionMapError::Twice {
                scene: map.scene.clone(),
                first: first.clone(),
                second,
            });
        }
        maps.insert(key, (second, map));
    }
    if maps.is_empty() {
        return Err(ActionMapError::NoMaps {
            folder: folder.to_path_buf(),
        });
    }
    Ok(maps.into_values().map(|(_, map)| map).collect())
}

/// `FloorPlan10` as `FloorPlan`, 10, so that it comes after `FloorPlan9`.
fn words_and_numbers(name: &str) -> Vec<(String, u64)> {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let n_word = rest
            .find(|c: char| c.is_ascii_digit())
            .unwrap_or(rest.len());
        let (word, after) = rest.split_at(n_word);
        let n_number = after
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(after.len());
        let (number, after) = after.split_at(n_number);
        parts.push((word.to_owned(), number.parse().unwrap_or(0)));
        rest = after;
    }
    parts
}

/// Reads a map from a file.
pub(super) fn read(file: &Path) -> Result<ActionMap, ActionMapError> {
    let text = std::fs::read_to_string(file).map_err(|source| ActionMapError::Read {
        path: file.to_path_buf(),
        source,
    })?;
    let raw: RawMap = serde_json::from_str(&text).map_err(|source| ActionMapError::Syntax {
        file: file.to_path_buf(),
        source,
    })?;
    let file = At { file };
    let cells = cells(&raw, &file)?;
    let objects = raw
        .actions
        .iter()
        .map(|(id, actions)| object(id, actions, &cells, &file))
        .collect::<Result<_, _>>()?;
    Ok(ActionMap::new(raw.scene, cells, objects))
}

/// The file, for errors.
struct At<'a> {
    file: &'a Path,
}

impl At<'_> {
    fn value(&self, key: String, found: impl Display, wanted: &str) -> ActionMapError {
        ActionMapError::Value {
            file: self.file.to_path_buf(),
            key,
            found: found.to_string(),
            wanted: wanted.to_owned(),
        }
    }
}

fn cells(raw: &RawMap, file: &At<'_>) -> Result<Cells, ActionMapError> {
    if !(raw.grid.is_finite() && raw.grid > 0.0) {
        return Err(file.value("grid".to_owned(), raw.grid, "metres above 0"));
    }
    if raw.reachable.is_empty() {
        return Err(file.value("reachable".to_owned(), "empty", "at least one cell"));
    }
    let mut cells = Cells::new(raw.grid);
    for (i, &[x, y, z]) in raw.reachable.iter().enumerate() {
        cells
            .push(point_from_unity([x, y, z]).xy())
            .ok_or_else(|| {
                let found = format!("({x}, {y}, {z})");
                let wanted = "a cell that is not there yet, whole steps of `grid` from the first";
                file.value(format!("reachable[{i}]"), found, wanted)
            })?;
    }
    Ok(cells)
}

fn object(
    id: &str,
    actions: &BTreeMap<String, Vec<[f64; 4]>>,
    cells: &Cells,
    file: &At<'_>,
) -> Result<MapObject, ActionMapError> {
    let (class, position) = class_and_position(id).ok_or_else(|| {
        let wanted = "`CLASS|x|y|z` with numbers in metres";
        file.value("actions".to_owned(), format!("`{id}`"), wanted)
    })?;
    let mut feasible = BTreeMap::new();
    for (action, poses) in actions {
        let mut places = BTreeSet::new();
        for (i, pose) in poses.iter().enumerate() {
            let key = || format!("actions.{id}.{action}[{i}]");
            places.insert(place(pose, cells, key, file)?);
        }
        feasible.insert(action.clone(), places);
    }
    Ok(MapObject {
        id: id.to_owned(),
        class: class.to_owned(),
        world_from_object: Pose2::new(Vector2::new(position.x, position.y), 0.0),
        feasible,
    })
}

/// `Mug|-01.76|+00.90|-00.62`.
fn class_and_position(id: &str) -> Option<(&str, Point3<f64>)> {
    let mut parts = id.split('|');
    let class = parts.next().filter(|class| !class.is_empty())?;
    let mut number = || parts.next()?.parse().ok().filter(|x: &f64| x.is_finite());
    Some((class, point_from_unity([number()?, number()?, number()?])))
}

fn place(
    &[x, y, z, heading_deg]: &[f64; 4],
    cells: &Cells,
    key: impl Fn() -> String,
    file: &At<'_>,
) -> Result<StandingPlace, ActionMapError> {
    let quarters = yaw_from_unity(heading_deg.to_radians()) / FRAC_PI_2;
    let whole = quarters.round();
    let off_rad = (quarters - whole).abs() * FRAC_PI_2;
    if off_rad.is_nan() || off_rad > HEADING_TOLERANCE_RAD {
        let wanted = "a heading of 0, 90, 180 or 270 degrees";
        return Err(file.value(key(), heading_deg, wanted));
    }
    let n_quarters = whole.rem_euclid(4.0) as usize;
    let middle = point_from_unity([x, y, z]).xy();
    cells
        .place(&middle, n_quarters)
        .ok_or_else(|| ActionMapError::UnknownCell {
            file: file.file.to_path_buf(),
            key: key(),
            found: [x, z],
            n_cells: cells.len(),
        })
}
