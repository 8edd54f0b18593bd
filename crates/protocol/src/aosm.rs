//! The Action-Oriented Semantic Map as the page shows it.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

use crate::{Pose, PosePlanar};

/// Object classes, objects, grounded navigation symbols and the topological graph between them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Aosm {
    /// Object classes.
    pub classes: Vec<ObjectClass>,
    /// Objects of these classes in the home.
    pub objects: Vec<AosmObject>,
    /// Navigation symbols grounded in this home.
    pub regions: Vec<NavigationRegion>,
    /// Edges of the topological graph: regions between which the base can drive.
    pub edges: Vec<AosmEdge>,
}

/// A class of objects and what can be done with them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct ObjectClass {
    /// Name.
    pub name: String,
    /// Names of its actions.
    pub actions: Vec<String>,
    /// Where the class comes from.
    pub provenance: Provenance,
}

/// Where an abstraction comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum Provenance {
    /// Learned by the robot.
    Learned,
    /// Taught by a person.
    Taught,
    /// Given by the program or its data.
    Given,
}

/// An object of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct AosmObject {
    /// Name.
    pub name: String,
    /// Name of its class.
    pub class: String,
    /// World from object (Γ), as the robot believes it.
    pub pose: Pose,
    /// What is known of its state, in words, such as `on` or `in bin`; empty when nothing is.
    pub state: String,
}

/// Where the base can stand to run an option: a navigation symbol grounded in this home.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct NavigationRegion {
    /// Name of the region, unique in the map.
    pub name: String,
    /// The option it is for, in words.
    pub option: String,
    /// The object the option acts on.
    pub object: String,
    /// Which of the page's colours it has; the page cycles through them when they run out.
    pub colour_index: u32,
    /// Base poses `[x, y, yaw]` from which the option can start, in metres and radians.
    pub poses: Vec<[f64; 3]>,
}

impl NavigationRegion {
    /// The poses as such.
    pub fn base_poses(&self) -> impl Iterator<Item = PosePlanar> + '_ {
        self.poses
            .iter()
            .map(|&[x, y, yaw]| PosePlanar { x, y, yaw })
    }
}

/// A drivable way between two regions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct AosmEdge {
    /// Name of the region it starts from.
    pub from: String,
    /// Name of the region it ends in.
    pub to: String,
    /// Length of the path, in metres.
    pub length_m: f64,
}
