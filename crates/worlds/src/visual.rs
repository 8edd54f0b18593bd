//! What the page draws: bodies and their shapes, and where they are.

use factotum_control::RobotState;
use factotum_geometry::Pose;
use factotum_physics::{BodyId, GeomId, GeomShape, Model, State};

use crate::assembly::Assembly;

/// Whose a body is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyGroup {
    /// The robot's.
    Robot,
    /// The home's structure and furniture.
    Home,
    /// An object of a known class.
    Object,
}

/// A body with something to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct VisualBody {
    /// Its name in the model.
    pub name: String,
    /// Whose it is.
    pub group: BodyGroup,
    /// What to draw.
    pub shapes: Vec<VisualShape>,
}

/// A coloured shape on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct VisualShape {
    /// The shape, metres.
    pub shape: GeomShape,
    /// Its pose in the body.
    pub body_from_shape: Pose,
    /// Its colour.
    pub rgba: [f32; 4],
}

/// The world at one instant, handed to an observer.
#[derive(Debug)]
pub struct WorldView<'a> {
    /// Simulated time, seconds.
    pub time_secs: f64,
    /// Poses of the bodies of [`SimRobot::visual_bodies`](crate::SimRobot::visual_bodies), in the same order.
    pub world_from_body: &'a [Pose],
    /// What the robot feels.
    pub state: &'a RobotState,
}

/// Geom groups above this are for collision only, by the convention of the models in `assets/`.
const GROUP_DRAWN_MAX: usize = 2;

/// The drawn bodies of a world, with their identifiers.
pub(crate) fn visual_bodies(
    model: &Model,
    group_of: impl Fn(BodyId) -> BodyGroup,
) -> Vec<(BodyId, VisualBody)> {
    model
        .bodies()
        .filter_map(|body| {
            let shapes: Vec<VisualShape> = model
                .geoms_of_body(body)
                .into_iter()
                .filter_map(|geom| visual_shape(model, geom))
                .collect();
            if shapes.is_empty() {
                return None;
            }
            let name = model.body_name(body).to_owned();
            let group = group_of(body);
            Some((
                body,
                VisualBody {
                    name,
                    group,
                    shapes,
                },
            ))
        })
        .collect()
}

fn visual_shape(model: &Model, geom: GeomId) -> Option<VisualShape> {
    let rgba = model.geom_rgba(geom);
    let seen = rgba[3] > 0.0 && model.geom_group(geom) <= GROUP_DRAWN_MAX;
    seen.then(|| VisualShape {
        shape: model.geom_shape(geom),
        body_from_shape: model.body_from_geom(geom),
        rgba,
    })
}

/// Whose a body of a home is.
pub(crate) fn group_of(assembly: &Assembly, body: BodyId) -> BodyGroup {
    let model = &assembly.model;
    if assembly.robot.bodies.contains(&body) {
        return BodyGroup::Robot;
    }
    let name = model.body_name(body);
    let of_object = assembly.objects.iter().any(|object| {
        name.strip_prefix(&object.name)
            .is_some_and(|rest| rest.starts_with('/'))
    });
    if of_object {
        BodyGroup::Object
    } else {
        BodyGroup::Home
    }
}

/// Poses of bodies, in order.
pub(crate) fn poses(state: &State, bodies: &[BodyId]) -> Vec<Pose> {
    bodies
        .iter()
        .map(|&body| state.world_from_body(body))
        .collect()
}
