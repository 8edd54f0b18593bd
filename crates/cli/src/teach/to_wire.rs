//! Classes, objects and history of a home as the wire's plain data. The world of a page of a stored home is its map.

use factotum_descriptions::{
    ActionKind, ActionSpec, Approach, Contact, Form, Grasp, JointKind, ObjectClass, ObjectJoint,
};
use factotum_geometry::Pose;
use factotum_protocol as wire;
use factotum_semantic_map::{Entry, MapObject, ObjectSource};

use crate::wire_view::{pose_of, provenance_of};

/// A class that looks like this.
pub(super) fn class(
    class: &ObjectClass,
    revision: Option<i64>,
    parts: Vec<wire::ClassPart>,
) -> wire::TaughtClass {
    wire::TaughtClass {
        name: class.name.clone(),
        description: class.description.clone(),
        provenance: provenance_of(class.provenance),
        revision: number(revision),
        movable: class.movable,
        form: class.form.map(form),
        parts,
        joints: class.joints.iter().map(joint).collect(),
        states: class
            .states
            .iter()
            .map(|state| wire::ClassState {
                name: state.name.clone(),
                joint: state.joint.clone(),
                range: state.range,
            })
            .collect(),
        grasps: class.grasps.iter().map(grasp).collect(),
        actions: class.actions.iter().filter_map(action).collect(),
    }
}

/// An object of this rank.
pub(super) fn object(object: &MapObject, revision: Option<i64>, rank: usize) -> wire::TaughtObject {
    wire::TaughtObject {
        name: object.name.clone(),
        class: object.class.clone(),
        pose: pose_of(&object.map_from_object),
        provenance: match object.source {
            ObjectSource::Given => wire::Provenance::Given,
            ObjectSource::Seen => wire::Provenance::Learned,
            ObjectSource::Taught => wire::Provenance::Taught,
        },
        revision: number(revision),
        colour_index: rank as u32,
    }
}

/// An entry of the journal.
pub(super) fn entry(entry: &Entry) -> wire::HistoryEntry {
    wire::HistoryEntry {
        entry: number(Some(entry.id)),
        what: entry.kind.to_string(),
        author: entry.author.clone(),
    }
}

fn number(entry: Option<i64>) -> u32 {
    entry.and_then(|entry| entry.try_into().ok()).unwrap_or(0)
}

fn form(form: Form) -> wire::Form {
    match form {
        Form::Box { size_m } => wire::Form::Box { size_m },
        Form::Cylinder {
            diameter_m,
            height_m,
        } => wire::Form::Cylinder {
            diameter_m,
            height_m,
        },
    }
}

fn joint(joint: &ObjectJoint) -> wire::ClassJoint {
    wire::ClassJoint {
        name: joint.name.clone(),
        kind: match joint.kind {
            JointKind::Revolute => wire::JointKind::Revolute,
            JointKind::Prismatic => wire::JointKind::Prismatic,
        },
        axis: joint.axis,
        origin: joint.origin,
        range: joint.range,
    }
}

fn grasp(grasp: &Grasp) -> wire::Grasp {
    wire::Grasp {
        name: grasp.name.clone(),
        object_from_tool: pose_of(&grasp.object_from_tcp()),
        aperture_m: grasp.aperture_m,
        link: grasp.link.clone(),
        yaw_symmetric: grasp.yaw_symmetric,
        provenance: provenance_of(grasp.provenance),
    }
}

/// None for an action that lacks what its kind asks for, which no checked class has.
fn action(action: &ActionSpec) -> Option<wire::Action> {
    let motion = match action.kind {
        ActionKind::Articulate => wire::ActionMotion::Joint {
            joint: action.joint.clone()?,
            initiation: action.initiation,
            termination: action.termination?,
            contact: match action.contact {
                Contact::Grasp => wire::Contact::Grasp,
                Contact::Push => wire::Contact::Push,
            },
            effect: action.effect.clone()?,
        },
        ActionKind::PickPlace => wire::ActionMotion::PutInto {
            class: action.target_class.clone()?,
            target_from_object: pose_of(&Pose::from(action.place.unwrap_or_default())),
            approach: action.place_approach.map(approach),
        },
    };
    Some(wire::Action {
        name: action.name.clone(),
        grasp: action.grasp.clone(),
        motion,
        approach: action.approach.map(approach),
        provenance: provenance_of(action.provenance),
    })
}

fn approach(approach: Approach) -> wire::Approach {
    wire::Approach {
        distance_m: approach.distance_m,
    }
}
