//! `objects.toml`: the objects of a home, one `[[objects]]` table each, in the order of their names.

use std::collections::BTreeMap;

use factotum_descriptions::Placement;
use serde::{Deserialize, Serialize};

use crate::{Location, MapObject, ObjectSource};

#[derive(Serialize, Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectsFile {
    #[serde(default)]
    pub(super) objects: Vec<ObjectEntry>,
}

/// An object as the file has it. Edits change entries rather than poses: numbers that an edit leaves alone keep
/// their digits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectEntry {
    pub(crate) name: String,
    pub(crate) class: String,
    pub(crate) xyz: [f64; 3],
    #[serde(default)]
    pub(crate) rpy: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    inside: Option<String>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    held: bool,
    #[serde(default)]
    source: SourceEntry,
    #[serde(default)]
    position_std_m: f64,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) joints: BTreeMap<String, f64>,
}

#[derive(Debug, Serialize, Deserialize, Default, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum SourceEntry {
    #[default]
    Given,
    Seen,
    Taught,
}

impl ObjectEntry {
    /// Puts the object elsewhere.
    pub(crate) fn set_location(&mut self, location: &Location) {
        self.held = *location == Location::Held;
        self.inside = match location {
            Location::In(container) => Some(container.clone()),
            Location::Loose | Location::Held => None,
        };
    }

    /// What is wrong with its numbers, if anything.
    pub(super) fn problem(&self) -> Option<String> {
        let mut numbers = self.xyz.iter().chain(&self.rpy).chain(self.joints.values());
        if let Some(number) = numbers.find(|number| !number.is_finite()) {
            return Some(format!("{number} found, expected a finite number"));
        }
        let std_m = self.position_std_m;
        let is_std = std_m.is_finite() && std_m >= 0.0;
        (!is_std).then(|| {
            format!("`position_std_m` is {std_m}, expected a number of metres, zero or more")
        })
    }

    pub(super) fn into_object(self) -> MapObject {
        MapObject {
            map_from_object: Placement {
                xyz: self.xyz,
                rpy: self.rpy,
            }
            .into(),
            location: match (self.inside, self.held) {
                (Some(container), _) => Location::In(container),
                (None, true) => Location::Held,
                (None, false) => Location::Loose,
            },
            source: match self.source {
                SourceEntry::Given => ObjectSource::Given,
                SourceEntry::Seen => ObjectSource::Seen,
                SourceEntry::Taught => ObjectSource::Taught,
            },
            name: self.name,
            class: self.class,
            joints: self.joints,
            position_std_m: self.position_std_m,
        }
    }
}

/// The object as the file has it.
pub(crate) fn entry_of(object: &MapObject) -> ObjectEntry {
    let Placement { xyz, rpy } = object.map_from_object.into();
    let mut entry = ObjectEntry {
        name: object.name.clone(),
        class: object.class.clone(),
        xyz,
        rpy,
        inside: None,
        held: false,
        source: match object.source {
            ObjectSource::Given => SourceEntry::Given,
            ObjectSource::Seen => SourceEntry::Seen,
            ObjectSource::Taught => SourceEntry::Taught,
        },
        position_std_m: object.position_std_m,
        joints: object.joints.clone(),
    };
    entry.set_location(&object.location);
    entry
}
