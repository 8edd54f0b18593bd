//! An object class: local frame Λ, kinematic model τ, attributes α and the actions it affords (thesis 6.2.1).
//!
//! Everything spatial is given in Λ, the frame of the model's root body, so that it holds for every object of the
//! class wherever it stands (Γ, the pose of Λ in the map, belongs to the object and lives in the AOSM).

use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::{DescriptionError, Form, Placement, Provenance, parse_toml, read_toml};

/// A class of objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectClass {
    /// Name, used in plans.
    pub name: String,
    /// One sentence for people.
    #[serde(default)]
    pub description: String,
    /// Model τ: MJCF with one root body at Λ. Relative to `class.toml` in the file.
    pub model: PathBuf,
    /// Where it comes from.
    #[serde(default, skip_serializing_if = "Provenance::is_given")]
    pub provenance: Provenance,
    /// The shape that the model was made of, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub form: Option<Form>,
    /// Whether it can be carried away (a free body).
    #[serde(default)]
    pub movable: bool,
    /// Whether turning it about its own z axis changes nothing.
    #[serde(default)]
    pub yaw_symmetric: bool,
    /// Whether Λ lies on the floor wherever it stands, as of a door or a cabinet; not of what may stand on a table.
    #[serde(default)]
    pub on_floor: bool,
    /// Its joints.
    #[serde(default)]
    pub joints: Vec<ObjectJoint>,
    /// Named intervals of joint positions.
    #[serde(default)]
    pub states: Vec<StateInterval>,
    /// Attribute "grasp".
    #[serde(default)]
    pub grasps: Vec<Grasp>,
    /// High-level actions.
    #[serde(default)]
    pub actions: Vec<ActionSpec>,
}

/// How a link of an object moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectJoint {
    /// Joint name in the model.
    pub name: String,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// Axis in Λ at joint position zero; need not be of unit length.
    pub axis: [f64; 3],
    /// A point on the axis in Λ, metres.
    #[serde(default)]
    pub origin: [f64; 3],
    /// Lower and upper limit, rad or m.
    pub range: [f64; 2],
    /// Body of the model that it moves.
    pub link: String,
}

/// Kinds of object joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Turns about its axis.
    Revolute,
    /// Slides along its axis.
    Prismatic,
}

impl ObjectJoint {
    /// Motion of the link, in Λ, from joint position `from` to joint position `to`.
    ///
    /// A point `p` of the link, given in Λ when the joint is at `from`, is at `motion(from, to) * p` when it is at `to`.
    pub fn motion(&self, from: f64, to: f64) -> Isometry3<f64> {
        let axis = Unit::new_normalize(Vector3::from(self.axis));
        let delta = to - from;
        match self.kind {
            JointKind::Prismatic => Isometry3::from_parts(
                Translation3::from(axis.into_inner() * delta),
                UnitQuaternion::identity(),
            ),
            JointKind::Revolute => {
                let origin = Translation3::from(Vector3::from(self.origin));
                origin * UnitQuaternion::from_axis_angle(&axis, delta) * origin.inverse()
            }
        }
    }
}

/// A named interval of a joint, e.g. `off`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateInterval {
    /// Name, used in plans.
    pub name: String,
    /// Joint.
    pub joint: String,
    /// Lower and upper end, rad or m.
    pub range: [f64; 2],
    /// Where it comes from.
    #[serde(default, skip_serializing_if = "Provenance::is_given")]
    pub provenance: Provenance,
}

/// A way to hold the object, in Λ with all its joints at zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grasp {
    /// Name within the class.
    pub name: String,
    /// Tool frame in Λ (z approach, x closing direction), metres.
    #[serde(default)]
    pub xyz: [f64; 3],
    /// Tool frame in Λ, fixed-axis roll, pitch, yaw, radians.
    #[serde(default)]
    pub rpy: [f64; 3],
    /// Opening of the gripper before it closes, metres.
    pub aperture_m: f64,
    /// Link that is held; the root if absent.
    pub link: Option<String>,
    /// Whether the grasp may be turned about Λ's z axis by any angle.
    #[serde(default)]
    pub yaw_symmetric: bool,
    /// Where it comes from.
    #[serde(default, skip_serializing_if = "Provenance::is_given")]
    pub provenance: Provenance,
}

impl Grasp {
    /// Tool frame in Λ.
    pub fn object_from_tcp(&self) -> Isometry3<f64> {
        Placement {
            xyz: self.xyz,
            rpy: self.rpy,
        }
        .into()
    }
}

/// What kind of motion an action is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActionKind {
    /// Pick the object up and release it at a pose relative to another object.
    PickPlace,
    /// Move a joint of the object from an initiation to a termination position.
    Articulate,
}

/// How the gripper touches the object while it moves it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Contact {
    /// Fingers closed around it.
    #[default]
    Grasp,
    /// Fingers shut, pushing.
    Push,
}

/// Where the base may stand for an action: the given navigation symbol (thesis 6.4: 0.8 to 1.25 m).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Approach {
    /// Nearest and farthest distance of the base from Λ, metres on the floor.
    pub distance_m: [f64; 2],
    /// Interval of the direction from Λ to the base, in Λ, radians about z.
    pub bearing_rad: [f64; 2],
    /// How far the base may be turned away from Λ, radians.
    #[serde(default = "facing_tolerance")]
    pub facing_tolerance_rad: f64,
}

/// Wide enough to choose from, narrow enough that the camera keeps the object in view.
fn facing_tolerance() -> f64 {
    0.3
}

/// A motion of the tool, shown once (thesis 6.3.1): what is learned from it leads from wherever the joint is to where the
/// action ends, in the same shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Demonstration {
    /// Time from one pose to the next, seconds.
    pub step_secs: f64,
    /// Tool frame in Λ, at least [`Demonstration::N_POSES_MIN`] times: from the action's grasp with the joint at its
    /// initiation to where the tool was when the joint was at its termination.
    pub object_from_tcp: Vec<Placement>,
}

impl Demonstration {
    /// Fewest poses that a motion can be learned from.
    pub const N_POSES_MIN: usize = 15;

    fn check(&self, file: &Path, field: &str) -> Result<(), DescriptionError> {
        let bad = |key: &str, found: String, wanted: String| {
            Err(DescriptionError::Value {
                path: file.to_owned(),
                field: format!("{field}.{key}"),
                found,
                wanted,
            })
        };
        let step_secs = self.step_secs;
        if !(step_secs > 0.0 && step_secs.is_finite()) {
            let wanted = "a positive number of seconds".to_owned();
            return bad("step_secs", step_secs.to_string(), wanted);
        }
        let n_poses = self.object_from_tcp.len();
        if n_poses < Self::N_POSES_MIN {
            let wanted = format!("at least {}", Self::N_POSES_MIN);
            return bad("object_from_tcp", format!("{n_poses} poses"), wanted);
        }
        let is_finite = |pose: &Placement| {
            pose.xyz
                .iter()
                .chain(&pose.rpy)
                .all(|value| value.is_finite())
        };
        match self
            .object_from_tcp
            .iter()
            .position(|pose| !is_finite(pose))
        {
            None => Ok(()),
            Some(index) => {
                let found = format!("{:?}", self.object_from_tcp[index]);
                let wanted = "finite numbers".to_owned();
                bad(&format!("object_from_tcp[{index}]"), found, wanted)
            }
        }
    }
}

/// A high-level action on an object (thesis 6.2.1): an option whose parts are all given in Λ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActionSpec {
    /// Name, used in plans.
    pub name: String,
    /// Kind of motion.
    pub kind: ActionKind,
    /// Joint to move, for [`ActionKind::Articulate`].
    pub joint: Option<String>,
    /// Joint position where the action begins.
    pub initiation: Option<f64>,
    /// Joint position where it ends.
    pub termination: Option<f64>,
    /// Name of the grasp; any of the class if absent.
    pub grasp: Option<String>,
    /// Holding or pushing.
    #[serde(default)]
    pub contact: Contact,
    /// State that holds afterwards, one of the class's [`StateInterval`] names, for [`ActionKind::Articulate`].
    pub effect: Option<String>,
    /// How the tool is to move, for [`ActionKind::Articulate`]; along with the joint if absent.
    pub demonstration: Option<Demonstration>,
    /// Class of the object to put it in or on, for [`ActionKind::PickPlace`].
    pub target_class: Option<String>,
    /// Pose of this object's Λ in the target's Λ at release, for [`ActionKind::PickPlace`].
    pub place: Option<Placement>,
    /// Where the base may stand; a default region if absent.
    pub approach: Option<Approach>,
    /// Where the base may stand, relative to the target, to put it down.
    pub place_approach: Option<Approach>,
    /// Where it comes from.
    #[serde(default, skip_serializing_if = "Provenance::is_given")]
    pub provenance: Provenance,
}

impl ObjectClass {
    /// Reads `DIR/class.toml` (or the file itself, if `path` names one).
    ///
    /// # Errors
    /// [`DescriptionError`] if the file cannot be read, has an unknown key, or names a joint, state or grasp that the
    /// class does not have.
    pub fn load(path: &Path) -> Result<Self, DescriptionError> {
        let file = if path.is_dir() {
            path.join("class.toml")
        } else {
            path.to_owned()
        };
        read_toml::<Self>(&file)?.checked(&file)
    }

    /// Reads the text of a `class.toml`; `file` is where it lies or would lie, for errors and the model's path.
    ///
    /// # Errors
    /// Those of [`ObjectClass::load`], but for a file that cannot be read.
    pub fn parse(text: &str, file: &Path) -> Result<Self, DescriptionError> {
        parse_toml::<Self>(text, file)?.checked(file)
    }

    /// Whether everything that it names is there and every number is one; `file` is where it lies or would lie.
    ///
    /// # Errors
    /// Those of [`ObjectClass::load`], but for a file that cannot be read.
    pub fn check(&self, file: &Path) -> Result<(), DescriptionError> {
        self.check_numbers(file)?;
        self.check_names(file)
    }

    fn checked(mut self, file: &Path) -> Result<Self, DescriptionError> {
        self.check(file)?;
        self.model = file.parent().unwrap_or(Path::new("")).join(&self.model);
        Ok(self)
    }

    /// The joint of that name.
    pub fn joint(&self, name: &str) -> Option<&ObjectJoint> {
        self.joints.iter().find(|joint| joint.name == name)
    }

    /// The action of that name.
    pub fn action(&self, name: &str) -> Option<&ActionSpec> {
        self.actions.iter().find(|action| action.name == name)
    }

    /// The state of that name.
    pub fn state(&self, name: &str) -> Option<&StateInterval> {
        self.states.iter().find(|state| state.name == name)
    }

    /// The state that a joint position falls in, if any.
    pub fn state_at(&self, joint: &str, position: f64) -> Option<&StateInterval> {
        self.states.iter().find(|state| {
            state.joint == joint && (state.range[0]..=state.range[1]).contains(&position)
        })
    }

    fn check_numbers(&self, file: &Path) -> Result<(), DescriptionError> {
        let mut numbers: Vec<(String, f64)> = Vec::new();
        for grasp in &self.grasps {
            let field = |key: &str| format!("grasps.{}.{key}", grasp.name);
            numbers.extend(grasp.xyz.map(|value| (field("xyz"), value)));
            numbers.extend(grasp.rpy.map(|value| (field("rpy"), value)));
            numbers.push((field("aperture_m"), grasp.aperture_m));
        }
        for state in &self.states {
            let field = format!("states.{}.range", state.name);
            numbers.extend(state.range.map(|value| (field.clone(), value)));
        }
        for action in &self.actions {
            let field = |key: &str| format!("actions.{}.{key}", action.name);
            numbers.extend(action.initiation.map(|value| (field("initiation"), value)));
            let termination = action.termination;
            numbers.extend(termination.map(|value| (field("termination"), value)));
            if let Some(pose) = &action.place {
                let values = pose.xyz.iter().chain(&pose.rpy);
                numbers.extend(values.map(|value| (field("place"), *value)));
            }
        }
        match numbers.into_iter().find(|(_, value)| !value.is_finite()) {
            None => Ok(()),
            Some((field, value)) => Err(DescriptionError::Value {
                path: file.to_owned(),
                field,
                found: value.to_string(),
                wanted: "a finite number".to_owned(),
            }),
        }
    }

    fn check_names(&self, file: &Path) -> Result<(), DescriptionError> {
        let unknown = |field: String, found: &str, known: Vec<&str>| {
            Err(DescriptionError::Value {
                path: file.to_owned(),
                field,
                found: format!("`{found}`"),
                wanted: if known.is_empty() {
                    "absent: the class has none".to_owned()
                } else {
                    format!("one of `{}`", known.join("`, `"))
                },
            })
        };
        let joints: Vec<&str> = self
            .joints
            .iter()
            .map(|joint| joint.name.as_str())
            .collect();
        let states: Vec<&str> = self
            .states
            .iter()
            .map(|state| state.name.as_str())
            .collect();
        let grasps: Vec<&str> = self
            .grasps
            .iter()
            .map(|grasp| grasp.name.as_str())
            .collect();
        for joint in &self.joints {
            if Vector3::from(joint.axis).norm() < 1e-9 {
                return Err(DescriptionError::Value {
                    path: file.to_owned(),
                    field: format!("joints.{}.axis", joint.name),
                    found: "zero".to_owned(),
                    wanted: "a direction".to_owned(),
                });
            }
        }
        for state in &self.states {
            if !joints.contains(&state.joint.as_str()) {
                return unknown(format!("states.{}.joint", state.name), &state.joint, joints);
            }
        }
        for action in &self.actions {
            let field = |key: &str| format!("actions.{}.{key}", action.name);
            let absent = |key: &str, wanted: &str| {
                Err(DescriptionError::Value {
                    path: file.to_owned(),
                    field: field(key),
                    found: "absent".to_owned(),
                    wanted: wanted.to_owned(),
                })
            };
            if let Some(grasp) = &action.grasp
                && !grasps.contains(&grasp.as_str())
            {
                return unknown(field("grasp"), grasp, grasps);
            }
            match action.kind {
                ActionKind::Articulate => {
                    match &action.joint {
                        None => return absent("joint", "the joint to move"),
                        Some(joint) if !joints.contains(&joint.as_str()) => {
                            return unknown(field("joint"), joint, joints);
                        }
                        Some(_) => {}
                    }
                    if action.termination.is_none() {
                        return absent("termination", "the joint position where the action ends");
                    }
                    if let Some(shown) = &action.demonstration {
                        if action.grasp.is_none() {
                            return absent("grasp", "the grasp with which it was demonstrated");
                        }
                        shown.check(file, &field("demonstration"))?;
                    }
                    match &action.effect {
                        None => return absent("effect", "the state that holds afterwards"),
                        Some(effect) if !states.contains(&effect.as_str()) => {
                            return unknown(field("effect"), effect, states);
                        }
                        Some(_) => {}
                    }
                }
                ActionKind::PickPlace => {
                    if action.target_class.is_none() {
                        return absent("target_class", "the class to put it in");
                    }
                    if !self.movable {
                        return Err(DescriptionError::Value {
                            path: file.to_owned(),
                            field: field("kind"),
                            found: "`pick_place`, of a class that is not movable".to_owned(),
                            wanted: "`articulate`, or `movable = true`".to_owned(),
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use proptest::prelude::*;

    fn hinge() -> ObjectJoint {
        ObjectJoint {
            name: "hinge".to_owned(),
            kind: JointKind::Revolute,
            axis: [0.0, 0.0, 2.0],
            origin: [1.0, 0.0, 0.0],
            range: [0.0, 1.6],
            link: "door".to_owned(),
        }
    }

    #[test]
    fn a_hinge_turns_points_about_its_origin() {
        let moved = hinge().motion(0.0, std::f64::consts::FRAC_PI_2) * Point3::new(2.0, 0.0, 0.5);
        assert!((moved - Point3::new(1.0, 1.0, 0.5)).norm() < 1e-12);
    }

    proptest! {
        #[test]
        fn motions_compose(a in -1.0..1.0, b in -1.0..1.0, c in -1.0..1.0) {
            let joint = hinge();
            let direct = joint.motion(a, c);
            let in_two = joint.motion(b, c) * joint.motion(a, b);
            prop_assert!((direct.translation.vector - in_two.translation.vector).norm() < 1e-9);
            prop_assert!(direct.rotation.angle_to(&in_two.rotation) < 1e-6);
        }
    }

    #[test]
    fn a_demonstration_that_nothing_can_be_learned_from_is_refused() {
        let check = |step_secs: f64, n_poses: usize, wanted: &str| {
            let poses = "{ xyz = [0.1, 0.0, 0.2] }, ".repeat(n_poses);
            let text = format!(
                r#"
                name = "lever"
                model = "model.xml"
                joints = [{{ name = "handle", kind = "revolute", axis = [0, 0, 1], range = [0, 1], link = "lever" }}]
                states = [{{ name = "closed", joint = "handle", range = [-0.1, 0.1] }}]
                grasps = [{{ name = "top", aperture_m = 0.08 }}]
                [[actions]]
                name = "close"
                kind = "articulate"
                joint = "handle"
                termination = 0.0
                effect = "closed"
                grasp = "top"
                demonstration = {{ step_secs = {step_secs:?}, object_from_tcp = [{poses}] }}
                "#
            );
            let error = match ObjectClass::parse(&text, Path::new("class.toml")) {
                Ok(_) => String::new(),
                Err(error) => error.to_string(),
            };
            assert_eq!(error, wanted);
        };
        check(0.1, 15, "");
        check(
            0.1,
            4,
            "`class.toml`: `actions.close.demonstration.object_from_tcp` is 4 poses, expected at least 15",
        );
        check(
            0.0,
            15,
            "`class.toml`: `actions.close.demonstration.step_secs` is 0, expected a positive number of seconds",
        );
    }

    #[test]
    fn an_action_on_an_absent_joint_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("class.toml");
        std::fs::write(
            &path,
            r#"
name = "switch"
model = "model.xml"
[[joints]]
name = "toggle"
kind = "revolute"
axis = [0, 1, 0]
range = [-0.3, 0.3]
link = "lever"
[[actions]]
name = "turn_off"
kind = "articulate"
joint = "togle"
termination = -0.3
effect = "off"
"#,
        )
        .unwrap();
        let error = ObjectClass::load(dir.path()).unwrap_err().to_string();
        insta::assert_snapshot!(error.replace(&path.display().to_string(), "class.toml"),
            @"`class.toml`: `actions.turn_off.joint` is `togle`, expected one of `toggle`");
    }
}
