//! The pages' edits as edits of a home.
//!
//! What a page cannot say of an action or a class, and what was known of it before, is kept: bearings of an approach, a
//! demonstration.

use std::collections::BTreeMap;
use std::path::PathBuf;

use factotum_descriptions::{
    ActionKind, ActionSpec, Approach, Contact, Demonstration, Form, Grasp, JointKind, ObjectClass,
    Placement, Provenance,
};
use factotum_geometry::Pose;
use factotum_geometry::frames::quat_from_xyzw;
use factotum_geometry::grid::OccupancyGrid;
use factotum_protocol as wire;
use factotum_semantic_map::{Aosm, DEFAULT_APPROACH, Edit, Location, MapObject, ObjectSource};
use nalgebra::{Point2, Translation3};

use crate::class_look::links_of;

/// Most characters of a name: it also names files.
const NAME_CHARS_MAX: usize = 48;
/// Nothing of a class is farther from its Λ, metres.
const REACH_MAX_M: f64 = 10.0;
/// How far outside the map an object may be put: what stands in a doorway, or behind a wall that was seen from one side,
/// metres.
const BEYOND_MAP_MAX_M: f64 = 1.0;
/// Lowest and highest place of an object over the map's floor, metres: a cellar stair, and a hall.
const HEIGHTS_M: [f64; 2] = [-3.0, 10.0];
/// How far a push may be aimed beyond where its joint stops, as a share of the joint's range.
const PUSH_BEYOND_STOP_MAX: f64 = 0.25;
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
            grasp: grasp_of(grasp, aosm.class(class).map_err(|error| error.to_string())?)?,
        },
        wire::Edit::RemoveGrasp { class, name } => Edit::RemoveGrasp {
            class: class.clone(),
            name: name.clone(),
        },
        wire::Edit::PutAction { class, action } => {
            let of_class = aosm.class(class).map_err(|error| error.to_string())?;
            Edit::PutAction {
                class: class.clone(),
                action: Box::new(action_of(action, of_class)?),
            }
        }
        wire::Edit::RemoveAction { class, name } => Edit::RemoveAction {
            class: class.clone(),
            name: name.clone(),
        },
        wire::Edit::AddObject { class, pose } => Edit::AddObject(MapObject {
            name: aosm.free_name(class),
            class: class.clone(),
            map_from_object: place_of(&format!("new {class}"), pose, &aosm.grid)?,
            joints: BTreeMap::new(),
            location: Location::Loose,
            source: ObjectSource::Taught,
            position_std_m: PLACED_STD_M,
        }),
        wire::Edit::MoveObject { name, pose } => Edit::MoveObject {
            name: name.clone(),
            map_from_object: place_of(name, pose, &aosm.grid)?,
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

fn grasp_of(grasp: &wire::Grasp, class: &ObjectClass) -> Result<Grasp, String> {
    let aperture_m = grasp.aperture_m;
    if !(0.0..=1.0).contains(&aperture_m) {
        return Err(format!(
            "opening of grasp `{}` is {aperture_m} m, expected 0 to 1 m",
            grasp.name
        ));
    }
    if let Some(link) = &grasp.link {
        let links = links_of(class);
        if !links.contains(link) {
            return Err(format!(
                "grasp `{}` holds the link `{link}`, expected one of `{}`, the links of `{}`",
                grasp.name,
                links.join("`, `"),
                class.name
            ));
        }
    }
    let whose = format!("grasp `{}` of `{}`", grasp.name, class.name);
    let Placement { xyz, rpy } = pose_from(&whose, &grasp.object_from_tool)?.into();
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

/// The action as the page says it, and for the rest as it was before.
fn action_of(action: &wire::Action, class: &ObjectClass) -> Result<ActionSpec, String> {
    let before = class.action(&action.name);
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
            let ends = [
                ("initiation", *initiation),
                ("termination", Some(*termination)),
            ];
            for (end, position) in ends {
                check_position(class, &action.name, joint, end, position, *contact)?;
            }
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
            place: Some(
                pose_from(
                    &format!("the release of action `{}`", action.name),
                    target_from_object,
                )?
                .into(),
            ),
            place_approach: region(
                approach.as_ref(),
                before.and_then(|spec| spec.place_approach),
            )?,
            ..bare
        },
    })
}

/// Whether a joint can be there. A joint that the class does not have is named where the class is checked.
fn check_position(
    class: &ObjectClass,
    action: &str,
    joint: &str,
    end: &str,
    position: Option<f64>,
    contact: wire::Contact,
) -> Result<(), String> {
    let (Some(position), Some(joint)) = (position, class.joint(joint)) else {
        return Ok(());
    };
    let [lower, upper] = joint.range;
    let beyond = match contact {
        wire::Contact::Grasp => 1e-6,
        wire::Contact::Push => PUSH_BEYOND_STOP_MAX * (upper - lower),
    };
    if (lower - beyond..=upper + beyond).contains(&position) {
        return Ok(());
    }
    let unit = match joint.kind {
        JointKind::Revolute => "rad",
        JointKind::Prismatic => "m",
    };
    Err(format!(
        "{end} of action `{action}` is {position} {unit}, expected {lower} to {upper} {unit}, the range of joint `{}` of \
         `{}`",
        joint.name, class.name
    ))
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

/// Γ of an object that is to be where the map is.
fn place_of(object: &str, pose: &wire::Pose, grid: &OccupancyGrid) -> Result<Pose, String> {
    let whose = format!("object `{object}`");
    let found = pose_of(&whose, pose)?;
    let at = found.translation.vector;
    let corner = Point2::new(grid.width() as f64, grid.height() as f64) * grid.resolution_m();
    let grid_from_map = grid.world_from_grid().inverse();
    let inside = grid_from_map * Point2::new(at.x, at.y);
    let is_on_map =
        |value: f64, edge: f64| (-BEYOND_MAP_MAX_M..=edge + BEYOND_MAP_MAX_M).contains(&value);
    if !is_on_map(inside.x, corner.x) || !is_on_map(inside.y, corner.y) {
        return Err(format!(
            "{whose} is at ({:.2}, {:.2}) m, expected at most {BEYOND_MAP_MAX_M} m outside the map, which is {:.1} m by \
             {:.1} m",
            at.x, at.y, corner.x, corner.y
        ));
    }
    let [lowest, highest] = HEIGHTS_M;
    if !(lowest..=highest).contains(&at.z) {
        return Err(format!(
            "{whose} is at a height of {:.2} m, expected {lowest} to {highest} m over the floor",
            at.z
        ));
    }
    Ok(found)
}

/// A pose in Λ.
fn pose_from(whose: &str, pose: &wire::Pose) -> Result<Pose, String> {
    let [x, y, z] = pose.position;
    if pose.position.iter().any(|at| at.abs() > REACH_MAX_M) {
        return Err(format!(
            "{whose} is at ({x}, {y}, {z}) m, expected at most {REACH_MAX_M} m each way"
        ));
    }
    pose_of(whose, pose)
}

fn pose_of(whose: &str, pose: &wire::Pose) -> Result<Pose, String> {
    let [x, y, z] = pose.position;
    if !pose.is_finite() {
        return Err(format!(
            "{whose} has the pose ({x}, {y}, {z}) m, {:?}, expected finite numbers",
            pose.orientation_xyzw
        ));
    }
    let squares = pose.orientation_xyzw.iter().map(|part| part * part);
    let length = squares.sum::<f64>().sqrt();
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        return Err(format!(
            "{whose} is turned by a quaternion of length {length}, expected 1"
        ));
    }
    let rotation = quat_from_xyzw(pose.orientation_xyzw).map_err(|error| error.to_string())?;
    Ok(Pose::from_parts(Translation3::new(x, y, z), rotation))
}
