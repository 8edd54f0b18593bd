//! The options of a map: its actions, bound to objects, each with the object whose approach region must hold the base.

use factotum_descriptions::{ActionKind, ActionSpec, Approach};
use factotum_task_planning::operator::GroundAction;

use crate::vocabulary::{PICK, operator_name};
use crate::{Aosm, MapError};

/// Where the base may stand when an action says nothing: the distances of thesis 6.4, any direction.
pub const DEFAULT_APPROACH: Approach = Approach {
    distance_m: [0.8, 1.25],
    bearing_rad: [-std::f64::consts::PI, std::f64::consts::PI],
    facing_rad: 0.0,
};

/// An option of the map, ready to be handed to a skill.
#[derive(Debug, Clone, PartialEq)]
pub struct OptionSpec {
    /// The plan step it comes from.
    pub step: GroundAction,
    /// Object it acts on.
    pub object: String,
    /// What to do with it.
    pub kind: OptionKind,
    /// Where the base must be: the grounds of its navigation symbol.
    pub anchor: NavigationAnchor,
}

/// What an option does.
#[derive(Debug, Clone, PartialEq)]
pub enum OptionKind {
    /// Take the object into the gripper.
    Pick,
    /// Release the held object at the action's place pose in the target's Λ.
    Place {
        /// The action of the held object's class.
        action: ActionSpec,
        /// The object to put it in or on.
        target: String,
    },
    /// Move a joint of the object.
    Articulate {
        /// The action of the object's class.
        action: ActionSpec,
    },
}

/// A navigation symbol before sampling: an approach region in the frame of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NavigationAnchor {
    /// Γ of the object, flattened to the floor when the region is sampled.
    pub map_from_object: factotum_geometry::Pose,
    /// The region.
    pub approach: Approach,
}

impl Aosm {
    /// Binds a plan step to the map.
    ///
    /// # Errors
    /// [`MapError::NoObject`] if an argument is not in the map, [`MapError::NotOfClass`] if the class has no such action.
    pub fn option(&self, step: &GroundAction) -> Result<OptionSpec, MapError> {
        let name = step.args.first().map(String::as_str).unwrap_or_default();
        let object = self.object(name)?;
        let class = self.class(&object.class)?;
        if step.name == PICK {
            let approach = class
                .actions
                .iter()
                .find(|action| action.kind == ActionKind::PickPlace)
                .and_then(|action| action.approach);
            return Ok(OptionSpec {
                step: step.clone(),
                object: object.name.clone(),
                kind: OptionKind::Pick,
                anchor: NavigationAnchor {
                    map_from_object: object.map_from_object,
                    approach: approach.unwrap_or(DEFAULT_APPROACH),
                },
            });
        }
        let action = class
            .actions
            .iter()
            .find(|action| operator_name(&self.classes, class, action) == step.name)
            .ok_or_else(|| MapError::NotOfClass {
                class: class.name.clone(),
                what: "action",
                name: step.name.clone(),
                known: class.actions.iter().map(|action| action.name.clone()).collect(),
            })?
            .clone();
        match action.kind {
            ActionKind::Articulate => Ok(OptionSpec {
                step: step.clone(),
                object: object.name.clone(),
                anchor: NavigationAnchor {
                    map_from_object: object.map_from_object,
                    approach: action.approach.unwrap_or(DEFAULT_APPROACH),
                },
                kind: OptionKind::Articulate { action },
            }),
            ActionKind::PickPlace => {
                let target = self.object(step.args.get(1).map(String::as_str).unwrap_or_default())?;
                Ok(OptionSpec {
                    step: step.clone(),
                    object: object.name.clone(),
                    anchor: NavigationAnchor {
                        map_from_object: target.map_from_object,
                        approach: action.place_approach.unwrap_or(DEFAULT_APPROACH),
                    },
                    kind: OptionKind::Place { target: target.name.clone(), action },
                })
            }
        }
    }

    /// Every option of the map: its actions bound to its objects, in the order of their names.
    pub fn options(&self) -> Vec<OptionSpec> {
        let mut steps = Vec::new();
        for object in self.objects.values() {
            let Some(class) = self.classes.get(&object.class) else { continue };
            if class.movable {
                steps.push(GroundAction::new(PICK, [&object.name]));
            }
            for action in &class.actions {
                let name = operator_name(&self.classes, class, action);
                match (action.kind, &action.target_class) {
                    (ActionKind::PickPlace, Some(target_class)) => {
                        for target in self.objects_of(target_class) {
                            steps.push(GroundAction::new(name.clone(), [&object.name, &target.name]));
                        }
                    }
                    _ => steps.push(GroundAction::new(name, [&object.name])),
                }
            }
        }
        steps.iter().filter_map(|step| self.option(step).ok()).collect()
    }
}
