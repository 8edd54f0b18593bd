//! The objects as the robot believes them to be, to be drawn over the home as it is.

use std::collections::BTreeMap;

use factotum_descriptions::ObjectClass;
use factotum_geometry::Pose2;
use factotum_geometry::frames::pose_from_planar;
use factotum_physics::{Model, State};
use factotum_protocol as wire;
use factotum_semantic_map::{Aosm, Location};

use crate::wire_view::{geometry_of, pose_of};

/// Geom groups above this are for collision only, by the convention of the models in `assets/`.
const GROUP_DRAWN_MAX: usize = 2;

/// What the classes look like, to draw objects where they are believed to be.
#[derive(Debug, Default)]
pub(crate) struct BeliefScene {
    shapes: BTreeMap<String, Vec<wire::Shape>>,
}

impl BeliefScene {
    /// Samples the models of the classes; a class whose model cannot be loaded is not drawn.
    pub(crate) fn new<'a>(classes: impl Iterator<Item = &'a ObjectClass>) -> Self {
        let shapes = classes
            .map(|class| (class.name.clone(), shapes_of(class).unwrap_or_default()))
            .collect();
        Self { shapes }
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

/// The drawn shapes of a class with its joints at zero, in Λ.
fn shapes_of(class: &ObjectClass) -> Option<Vec<wire::Shape>> {
    let model = Model::from_mjcf_file(&class.model).ok()?;
    let mut state = State::new(&model).ok()?;
    state.forward().ok()?;
    let root = model.bodies().nth(1)?;
    let object_from_world = state.world_from_body(root).inverse();
    let mut shapes = Vec::new();
    for body in model.bodies().skip(1) {
        let object_from_body = object_from_world * state.world_from_body(body);
        for geom in model.geoms_of_body(body) {
            let rgba = model.geom_rgba(geom);
            if rgba[3] == 0.0 || model.geom_group(geom) > GROUP_DRAWN_MAX {
                continue;
            }
            shapes.push(wire::Shape {
                geometry: geometry_of(&model.geom_shape(geom))?,
                pose: pose_of(&(object_from_body * model.body_from_geom(geom))),
                rgba,
            });
        }
    }
    Some(shapes)
}
