//! Teaching: what a home is made of as far as a person may change it, and the changes that a page asks for.
//!
//! A page asks with an [`EditRequest`]; the studio's [`EditAnswer`] goes to that page alone. What an accepted edit made
//! of the home goes to all pages as a new [`Teaching`], before the answer. Whatever the page is held in (a mouse, a
//! headset), the edits are these.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

use crate::{Pose, Provenance, Shape};

/// Most characters of an edit's id.
pub const EDIT_ID_CHARS_MAX: usize = 64;

/// A home as it can be taught: replaced as a whole after each edit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Teaching {
    /// Why no edits are taken now; empty when they are.
    pub closed: String,
    /// Classes of the home, by name.
    pub classes: Vec<TaughtClass>,
    /// Objects of the home, by name.
    pub objects: Vec<TaughtObject>,
    /// Classes that are not in the home and can be taken into it as they are.
    pub catalogue: Vec<CatalogueClass>,
    /// The edit that [`Edit::Undo`] would undo, in words.
    pub undo: Option<String>,
    /// The edit that [`Edit::Redo`] would do again, in words.
    pub redo: Option<String>,
    /// The latest entries of the journal, the newest first.
    pub history: Vec<HistoryEntry>,
    /// Widest opening of the robot's gripper, in metres.
    pub aperture_max_m: f64,
}

/// An entry of the home's journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct HistoryEntry {
    /// Its number.
    pub entry: u32,
    /// What was done, in words.
    pub what: String,
    /// Who did it.
    pub author: String,
}

/// A class that can be taken into the home.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct CatalogueClass {
    /// Its name.
    pub name: String,
    /// One sentence for people.
    pub description: String,
}

/// A class, all of it given in its frame Λ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct TaughtClass {
    /// Name.
    pub name: String,
    /// One sentence for people.
    pub description: String,
    /// Where it comes from.
    pub provenance: Provenance,
    /// Number of the journal's entry that last changed it.
    pub revision: u32,
    /// Whether its objects can be carried away.
    pub movable: bool,
    /// The shape it was made of; nothing when its model is another one.
    pub form: Option<Form>,
    /// What it looks like.
    pub parts: Vec<ClassPart>,
    /// Its joints.
    pub joints: Vec<ClassJoint>,
    /// Named intervals of its joints.
    pub states: Vec<ClassState>,
    /// Ways to hold it.
    pub grasps: Vec<Grasp>,
    /// What can be done with it.
    pub actions: Vec<Action>,
}

/// Shapes of a class that move together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct ClassPart {
    /// Joints that move them, the outermost first.
    pub joints: Vec<String>,
    /// The shapes with all joints at zero; their poses are in Λ.
    pub shapes: Vec<Shape>,
}

/// A joint of a class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct ClassJoint {
    /// Name.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Direction of its axis in Λ.
    pub axis: [f64; 3],
    /// A point on its axis in Λ, in metres.
    pub origin: [f64; 3],
    /// Lower and upper limit, in radians or metres.
    pub range: [f64; 2],
}

/// Kinds of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Turns about its axis; positions are radians.
    Revolute,
    /// Slides along its axis; positions are metres.
    Prismatic,
}

/// A named interval of a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct ClassState {
    /// Name.
    pub name: String,
    /// The joint.
    pub joint: String,
    /// Lower and upper end, in radians or metres.
    pub range: [f64; 2],
}

/// An object of the home.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct TaughtObject {
    /// Name.
    pub name: String,
    /// Its class.
    pub class: String,
    /// World from object (Γ).
    pub pose: Pose,
    /// How it got into the map.
    pub provenance: Provenance,
    /// Number of the journal's entry that last changed it.
    pub revision: u32,
    /// Which of the page's colours it has for good, whatever objects come and go.
    pub colour_index: u32,
}

/// A shape that a class can be made of. Λ is in the middle of its foot, z up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Form {
    /// A cuboid.
    Box {
        /// Its edges along x, y and z, in metres.
        size_m: [f64; 3],
    },
    /// An upright cylinder.
    Cylinder {
        /// Diameter, in metres.
        diameter_m: f64,
        /// Height, in metres.
        height_m: f64,
    },
}

/// A way to hold an object: attribute "grasp".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Grasp {
    /// Name within the class.
    pub name: String,
    /// Λ from tool, the joints at zero: z is the direction of approach, x that in which the fingers close.
    pub object_from_tool: Pose,
    /// Opening of the gripper before it closes, in metres.
    pub aperture_m: f64,
    /// Part of the model that is held; the whole if absent.
    pub link: Option<String>,
    /// Whether it may be turned about Λ's z axis by any angle.
    pub yaw_symmetric: bool,
    /// Where it comes from. In an edit it counts for nothing: what a person puts is taught.
    pub provenance: Provenance,
}

/// Something that can be done with an object of a class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Action {
    /// Name within the class.
    pub name: String,
    /// Grasp to do it with; any of the class if absent.
    pub grasp: Option<String>,
    /// What moves.
    pub motion: ActionMotion,
    /// Where the base may stand for it; a default if absent.
    pub approach: Option<Approach>,
    /// Where it comes from. In an edit it counts for nothing: what a person puts is taught.
    pub provenance: Provenance,
}

/// What moves in an action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ActionMotion {
    /// A joint of the object.
    Joint {
        /// The joint.
        joint: String,
        /// Position where the action begins; anywhere if absent.
        initiation: Option<f64>,
        /// Position where it ends.
        termination: f64,
        /// Whether fingers hold it or push it.
        contact: Contact,
        /// Name of the state that holds afterwards. Where the class has no such state, one is made about the termination.
        effect: String,
    },
    /// The object as a whole, which is put into or onto another.
    PutInto {
        /// Class of the other.
        class: String,
        /// Λ of the other from Λ of this one at release.
        target_from_object: Pose,
        /// Where the base may stand to put it there; a default if absent.
        approach: Option<Approach>,
    },
}

/// How the gripper touches what it moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum Contact {
    /// Fingers closed around it.
    Grasp,
    /// Fingers shut, pushing.
    Push,
}

/// Where the base may stand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Approach {
    /// Nearest and farthest distance of the base from Λ on the floor, in metres.
    pub distance_m: [f64; 2],
}

/// A page's wish to change the home.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct EditRequest {
    /// A random name of the page's choice, at most [`EDIT_ID_CHARS_MAX`] characters. A request that was
    /// accepted and comes again, as after a lost connection or a new start of the studio, is not applied again: it gets
    /// the answer of the first.
    pub id: String,
    /// Revision of the class or object that the person saw when making the edit. If somebody has changed it since, the
    /// edit is refused. Absent: the edit is applied to whatever there is.
    pub base: Option<u32>,
    /// The change.
    pub edit: Edit,
}

/// A change of a home.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Edit {
    /// Make a class of a shape.
    MakeClass {
        /// Its name.
        name: String,
        /// The shape.
        form: Form,
        /// Whether its objects can be carried away.
        movable: bool,
    },
    /// Give a class that was made of a shape another one; what was taught of it stays.
    ReshapeClass {
        /// The class.
        name: String,
        /// The new shape.
        form: Form,
        /// Whether its objects can be carried away.
        movable: bool,
    },
    /// Take a class of the catalogue into the home.
    TakeClass {
        /// Its name.
        name: String,
    },
    /// Take a class, of which there is no object, out of the home.
    RemoveClass {
        /// Its name.
        name: String,
    },
    /// Teach a grasp, or change the one of that name.
    PutGrasp {
        /// The class.
        class: String,
        /// The grasp.
        grasp: Grasp,
    },
    /// Forget a grasp.
    RemoveGrasp {
        /// The class.
        class: String,
        /// Name of the grasp.
        name: String,
    },
    /// Teach an action, or change the one of that name.
    PutAction {
        /// The class.
        class: String,
        /// The action.
        action: Action,
    },
    /// Forget an action.
    RemoveAction {
        /// The class.
        class: String,
        /// Name of the action.
        name: String,
    },
    /// Put an object of a class into the map. The home names it, and the answer says how.
    AddObject {
        /// The class.
        class: String,
        /// World from object (Γ).
        pose: Pose,
    },
    /// Give an object another Γ.
    MoveObject {
        /// Its name.
        name: String,
        /// World from object (Γ).
        pose: Pose,
    },
    /// Give an object another name.
    RenameObject {
        /// Its name.
        name: String,
        /// The new one.
        to: String,
    },
    /// Take an object out of the map.
    RemoveObject {
        /// Its name.
        name: String,
    },
    /// Undo the last edit that holds, whoever made it and whenever.
    Undo,
    /// Do the last undone edit again.
    Redo,
}

impl Edit {
    /// Whether every number is one: JSON has no NaN, but other senders may have.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        match self {
            Self::MakeClass { form, .. } | Self::ReshapeClass { form, .. } => match form {
                Form::Box { size_m } => size_m.iter().all(|edge| edge.is_finite()),
                Form::Cylinder {
                    diameter_m,
                    height_m,
                } => diameter_m.is_finite() && height_m.is_finite(),
            },
            Self::PutGrasp { grasp, .. } => {
                grasp.object_from_tool.is_finite() && grasp.aperture_m.is_finite()
            }
            Self::PutAction { action, .. } => action.is_finite(),
            Self::AddObject { pose, .. } | Self::MoveObject { pose, .. } => pose.is_finite(),
            Self::TakeClass { .. }
            | Self::RemoveClass { .. }
            | Self::RemoveGrasp { .. }
            | Self::RemoveAction { .. }
            | Self::RenameObject { .. }
            | Self::RemoveObject { .. }
            | Self::Undo
            | Self::Redo => true,
        }
    }
}

impl Action {
    fn is_finite(&self) -> bool {
        let is_approach_finite = |approach: &Option<Approach>| {
            approach
                .iter()
                .flat_map(|approach| approach.distance_m)
                .all(f64::is_finite)
        };
        is_approach_finite(&self.approach)
            && match &self.motion {
                ActionMotion::Joint {
                    initiation,
                    termination,
                    ..
                } => termination.is_finite() && initiation.is_none_or(f64::is_finite),
                ActionMotion::PutInto {
                    target_from_object,
                    approach,
                    ..
                } => target_from_object.is_finite() && is_approach_finite(approach),
            }
    }
}

/// What became of an [`EditRequest`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct EditAnswer {
    /// The request's id.
    pub id: String,
    /// What became of it.
    pub outcome: EditOutcome,
}

/// What became of an edit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum EditOutcome {
    /// It is in the journal, and will outlive the studio.
    Accepted {
        /// Number of its entry; nothing when it changed nothing.
        entry: Option<u32>,
        /// Name of the class or object that was made or changed; of an undone or redone edit, its words.
        what: String,
    },
    /// Nothing has changed.
    Refused {
        /// Why: the thing, what was found and what was wanted.
        reason: String,
    },
}
