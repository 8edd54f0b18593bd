//! What the classes look like: the drawn shapes of their models, as the wire's plain data.

use factotum_descriptions::ObjectClass;
use factotum_physics::{Model, State};
use factotum_protocol as wire;

use crate::wire_view::{geometry_of, pose_of};

/// Geom groups above this are for collision only, by the convention of the models in `assets/`.
const GROUP_DRAWN_MAX: usize = 2;

/// The drawn shapes of a class with its joints at zero, in Λ, by what moves them; none if its model cannot be loaded.
pub(crate) fn parts_of(class: &ObjectClass) -> Vec<wire::ClassPart> {
    sampled(class).unwrap_or_default()
}

/// Names of the parts of a class's model; none if it cannot be loaded.
pub(crate) fn links_of(class: &ObjectClass) -> Vec<String> {
    let Ok(model) = Model::from_mjcf_file(&class.model) else {
        return Vec::new();
    };
    let bodies = model.bodies().skip(1);
    bodies
        .map(|body| model.body_name(body).to_owned())
        .collect()
}

fn sampled(class: &ObjectClass) -> Option<Vec<wire::ClassPart>> {
    let model = Model::from_mjcf_file(&class.model).ok()?;
    let mut state = State::new(&model).ok()?;
    state.forward().ok()?;
    let root = model.bodies().nth(1)?;
    let object_from_world = state.world_from_body(root).inverse();
    let mut parts: Vec<wire::ClassPart> = Vec::new();
    for body in model.bodies().skip(1) {
        let object_from_body = object_from_world * state.world_from_body(body);
        let drawn = model.geoms_of_body(body).into_iter().filter(|geom| {
            model.geom_rgba(*geom)[3] != 0.0 && model.geom_group(*geom) <= GROUP_DRAWN_MAX
        });
        let shapes: Vec<wire::Shape> = drawn
            .filter_map(|geom| {
                Some(wire::Shape {
                    geometry: geometry_of(&model.geom_shape(geom))?,
                    pose: pose_of(&(object_from_body * model.body_from_geom(geom))),
                    rgba: model.geom_rgba(geom),
                })
            })
            .collect();
        let mut joints: Vec<String> = Vec::new();
        let mut above = Some(body);
        while let Some(at) = above {
            let name = model.body_name(at);
            let moving = class.joints.iter().filter(|joint| joint.link == name);
            joints.extend(moving.map(|joint| joint.name.clone()));
            above = model.body_parent(at);
        }
        joints.reverse();
        match parts.iter_mut().find(|part| part.joints == joints) {
            Some(part) => part.shapes.extend(shapes),
            None => parts.push(wire::ClassPart { joints, shapes }),
        }
    }
    Some(parts)
}
