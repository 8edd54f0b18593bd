//! The objects as the robot believes them to be, to be drawn over the home as it is.

use std::collections::BTreeMap;

use factotum_descriptions::ObjectClass;
use factotum_geometry::Pose2;
use factotum_geometry::frames::pose_from_planar;
use factotum_protocol as wire;
use factotum_semantic_map::{Aosm, Location};

use crate::class_look::parts_of;
use crate::wire_view::pose_of;

/// What the classes look like, to draw objects where they are believed to be.
#[derive(Debug, Default)]
pub(crate) struct BeliefScene {
    shapes: BTreeMap<String, Vec<wire::Shape>>,
}

impl BeliefScene {
    /// Samples the models of the classes; a class whose model cannot be loaded is not drawn.
    pub(crate) fn new<'a>(classes: impl Iterator<Item = &'a ObjectClass>) -> Self {
        Self::of_parts(classes.map(|class| (class.name.clone(), parts_of(class))))
    }

    /// The same of models that were sampled before, by name of the class.
    pub(crate) fn of_parts(parts: impl Iterator<Item = (String, Vec<wire::ClassPart>)>) -> Self {
        let flat = |parts: Vec<wire::ClassPart>| {
            let shapes = parts.into_iter().flat_map(|part| part.shapes);
            shapes.collect()
        };
        Self {
            shapes: parts.map(|(class, parts)| (class, flat(parts))).collect(),
        }
    }

    /// The scene of everything believed; what the gripper holds is drawn by the robot's own scene.
    pub(crate) fn scene(&self, aosm: &Aosm, world_from_map: &Pose2) -> wire::Scene {
        let world_from_map = pose_from_planar(world_from_map, 0.0);
        let bodies = aosm
            .objects
            .values()
            .filter(|object| object.location == Location::Loose)
            .map(|object| wire::Body {
                name: format!("believed {}", object.name),
                pose: pose_of(&(world_from_map * object.map_from_object)),
                shapes: self.shapes.get(&object.class).cloned().unwrap_or_default(),
            })
            .collect();
        wire::Scene {
            source: wire::SceneSource::Belief,
            bodies,
        }
    }
}
