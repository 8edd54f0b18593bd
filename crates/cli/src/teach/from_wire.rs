//! The pages' edits as edits of a home.
//!
//! What a page cannot say of an action or a class, and what was known of it before, is kept: bearings of an approach, a
//! demonstration.

use std::collections::BTreeMap;
use std::path::PathBuf;

use factotum_descriptions::{
    ActionKind, ActionSpec, Approach, Contact, Demonstration, Form, Grasp, ObjectClass, Placement,
    Provenance,
};
use factotum_geometry::Pose;
use factotum_geometry::frames::quat_from_xyzw;
use factotum_protocol as wire;
use factotum_semantic_map::{Aosm, DEFAULT_APPROACH, Edit, Location, MapObject, ObjectSource};
use nalgebra::Translation3;

/// Most characters of a name: it also names files.
const NAME_CHARS_MAX: usize = 48;
/// No home is larger, metres.
const COORDINATE_MAX_M: f64 = 1000.0;
/// How far the length of a quaternion may be from 1: a few digits.
const QUATERNION_TOLERANCE: f64 = 1e-3;
/// How far from where a person has put it an object may be, metres.
const PLACED_STD_M: f64 = 0.02;

/// The edit of a home that a page asks for; a sentence says why there is none. Undo and redo are none.
pub(super) fn edit_of(
    edit: &wire::Edit,
    aosm: &Aosm,
    catalogue: &BTreeMap<String, PathBuf>,
) -> Result<Edit, String> {
    Ok(match edit {
        wire::Edit::MakeClass {
            name,
            form,
            movable,
        } => Edit::MakeClass {
            name: named("class", name)?,
            form: form_of(form),
            movable: *movable,
        },
        wire::Edit::ReshapeClass {
            name,
            form,
            movable,
        } => Edit::ReshapeClass {
            name: name.clone(),
            form: form_of(form),
            movable: *movable,
        },
        wire::Edit::TakeClass { name } => {
            if aosm.classes.contains_key(name) {
                return Err(format!("class `{name}` is in the home already"));
            }
            let folder = catalogue.get(name).ok_or_else(|| {
                let known: Vec<&str> = catalogue.keys().map(String::as_str).collect();
                format!(
                    "class `{name}` is not in the catalogue; it has: `{}`",
                    known.join("`, `")
                )
            })?;
            let class = ObjectClass::load(folder).map_err(|error| error.to_string())?;
            Edit::PutClass(Box::new(class))
        }
        wire::Edit::RemoveClass { name } => Edit::RemoveClass { name: name.clone() },
        wire::Edit::PutGrasp { class, grasp } => Edit::PutGrasp {
            class: class.clone(),
            grasp: grasp_of(grasp)?,
        },
        wire::Edit::RemoveGrasp { class, name } => Edit::RemoveGrasp {
            class: class.clone(),
            name: name.clone(),
        },
        wire::Edit::PutAction { class, action } => {
            let of_class = aosm.class(class).map_err(|error| error.to_string())?;
            Edit::PutAction {
                class: class.clone(),
                action: Box::new(action_of(action, of_class.action(&action.name))?),
            }
        }
        wire::Edit::RemoveAction { class, name } => Edit::RemoveAction {
            class: class.clone(),
            name: name.clone(),
        },
        wire::Edit::AddObject { class, pose } => Edit::AddObject(MapObject {
            name: aosm.free_name(class),
            class: class.clone(),
            map_from_object: pose_from(pose)?,
            joints: BTreeMap::new(),
            location: Location::Loose,
            source: ObjectSource::Taught,
            position_std_m: PLACED_STD_M,
        }),
        wire::Edit::MoveObject { name, pose } => Edit::MoveObject {
            name: name.clone(),
            map_from_object: pose_from(pose)?,
        },
        wire::Edit::RenameObject { name, to } => Edit::Rename {
            name: name.clone(),
            to: named("object", to)?,
        },
        wire::Edit::RemoveObject { name } => Edit::RemoveObject { name: name.clone() },
        wire::Edit::Undo | wire::Edit::Redo => {
            return Err("undo and redo are no edits of their own".to_owned());
        }
    })
}

/// A name that plans and folders can carry.
fn named(what: &str, name: &str) -> Result<String, String> {
    let is_part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
    let starts_well = name.starts_with(|c: char| c.is_ascii_lowercase());
    if starts_well && name.chars().all(is_part) && name.len() <= NAME_CHARS_MAX {
        return Ok(name.to_owned());
    }
    Err(format!(
        "{what} name `{name}` found, expected 1 to {NAME_CHARS_MAX} of the letters a to z, digits, `_` and `-`, \
         a letter first"
    ))
}

fn form_of(form: &wire::Form) -> Form {
    match *form {
        wire::Form::Box { size_m } => Form::Box { size_m },
        wire::Form::Cylinder {
            diameter_m,
            height_m,
        } => Form::Cylinder {
            diameter_m,
            height_m,
        },
    }
}

fn grasp_of(grasp: &wire::Grasp) -> Result<Grasp, String> {
    let aperture_m = grasp.aperture_m;
    if !(0.0..=1.0).contains(&aperture_m) {
        return Err(format!(
            "opening of grasp `{}` is {aperture_m} m, expected 0 to 1 m",
            grasp.name
        ));
    }
    let Placement { xyz, rpy } = pose_from(&grasp.object_from_tool)?.into();
    Ok(Grasp {
        name: named("grasp", &grasp.name)?,
        xyz,
        rpy,
        aperture_m,
        link: grasp.link.clone(),
        yaw_symmetric: grasp.yaw_symmetric,
        provenance: Provenance::Taught,
    })
}

/// The action as the page says it, and for the rest as it was `before`.
fn action_of(action: &wire::Action, before: Option<&ActionSpec>) -> Result<ActionSpec, String> {
    let bare = ActionSpec {
        name: named("action", &action.name)?,
        kind: ActionKind::PickPlace,
        joint: None,
        initiation: None,
        termination: None,
        grasp: action.grasp.clone(),
        contact: Contact::default(),
        effect: None,
        demonstration: None,
        target_class: None,
        place: None,
        approach: region(
            action.approach.as_ref(),
            before.and_then(|spec| spec.approach),
        )?,
        place_approach: None,
        provenance: Provenance::Taught,
    };
    Ok(match &action.motion {
        wire::ActionMotion::Joint {
            joint,
            initiation,
            termination,
            contact,
            effect,
        } => {
            let spec = ActionSpec {
                kind: ActionKind::Articulate,
                joint: Some(joint.clone()),
                initiation: *initiation,
                termination: Some(*termination),
                contact: match contact {
                    wire::Contact::Grasp => Contact::Grasp,
                    wire::Contact::Push => Contact::Push,
                },
                effect: Some(named("state", effect)?),
                ..bare
            };
            ActionSpec {
                demonstration: still_shown(&spec, before),
                ..spec
            }
        }
        wire::ActionMotion::PutInto {
            class,
            target_from_object,
            approach,
        } => ActionSpec {
            target_class: Some(class.clone()),
            place: Some(pose_from(target_from_object)?.into()),
            place_approach: region(
                approach.as_ref(),
                before.and_then(|spec| spec.place_approach),
            )?,
            ..bare
        },
    })
}

/// What was shown of the action before, if it still leads from the same grasp and position to the same.
fn still_shown(action: &ActionSpec, before: Option<&ActionSpec>) -> Option<Demonstration> {
    let ends = |spec: &ActionSpec| {
        (
            spec.grasp.clone(),
            spec.joint.clone(),
            spec.initiation,
            spec.termination,
        )
    };
    let same = before.filter(|before| ends(before) == ends(action));
    same.and_then(|before| before.demonstration.clone())
}

/// A region of these distances, with the directions of the one before.
fn region(
    approach: Option<&wire::Approach>,
    before: Option<Approach>,
) -> Result<Option<Approach>, String> {
    let Some(&wire::Approach { distance_m }) = approach else {
        return Ok(None);
    };
    let [near, far] = distance_m;
    if !(0.0 < near && near < far && far <= 5.0) {
        return Err(format!(
            "the base is to stand {near} to {far} m away, expected two rising distances up to 5 m"
        ));
    }
    Ok(Some(Approach {
        distance_m,
        ..before.unwrap_or(DEFAULT_APPROACH)
    }))
}

fn pose_from(pose: &wire::Pose) -> Result<Pose, String> {
    let [x, y, z] = pose.position;
    if pose.position.iter().any(|at| at.abs() > COORDINATE_MAX_M) {
        return Err(format!(
            "position ({x}, {y}, {z}) m found, expected at most {COORDINATE_MAX_M} m each way"
        ));
    }
    let squares = pose.orientation_xyzw.iter().map(|part| part * part);
    let length = squares.sum::<f64>().sqrt();
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        return Err(format!(
            "orientation is a quaternion of length {length}, expected 1"
        ));
    }
    let rotation = quat_from_xyzw(pose.orientation_xyzw).map_err(|error| error.to_string())?;
    Ok(Pose::from_parts(Translation3::new(x, y, z), rotation))
}
