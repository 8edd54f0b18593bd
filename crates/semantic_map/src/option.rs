//! The options of a map: its actions, bound to objects, each with the object whose approach region must hold the base.

use std::f64::consts::TAU;

use factotum_descriptions::{ActionKind, ActionSpec, Approach};
use factotum_geometry::Pose;
use factotum_symbols::{ApproachRegion, NavigationSymbol};
use factotum_task_planning::operator::GroundAction;

use crate::vocabulary::{PICK, operator_name};
use crate::{Aosm, MapError};

/// Where the base may stand when an action says nothing: the distances of thesis 6.4, any direction.
pub const DEFAULT_APPROACH: Approach = Approach {
    distance_m: [0.8, 1.25],
    bearing_rad: [-std::f64::consts::PI, std::f64::consts::PI],
    facing_tolerance_rad: 0.3,
};

/// An option of the map, ready to be handed to a skill.
#[derive(Debug, Clone)]
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

/// A navigation symbol and the object at which it is grounded.
#[derive(Debug, Clone)]
pub struct NavigationAnchor {
    /// Γ of the object, flattened to the floor when poses are sampled.
    pub map_from_object: Pose,
    /// Where the base can stand, in the object's frame.
    pub symbol: NavigationSymbol,
}

impl NavigationAnchor {
    fn given(
        option: &str,
        class: &str,
        map_from_object: Pose,
        approach: Option<Approach>,
    ) -> Result<Self, MapError> {
        let approach = approach.unwrap_or(DEFAULT_APPROACH);
        let [from, to] = approach.bearing_rad;
        // A full turn written with a few digits may come out a little longer than one.
        let bearing_rad = [
            from,
            if to - from < TAU + 1e-3 {
                to.min(from + TAU)
            } else {
                to
            },
        ];
        let region = ApproachRegion::new(
            approach.distance_m,
            bearing_rad,
            approach.facing_tolerance_rad,
        )
        .map_err(|source| MapError::Approach {
            class: class.to_owned(),
            action: option.to_owned(),
            source,
        })?;
        Ok(Self {
            map_from_object,
            symbol: NavigationSymbol::given(option, class, region),
        })
    }
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
                anchor: NavigationAnchor::given(
                    &step.name,
                    &class.name,
                    object.map_from_object,
                    approach,
                )?,
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
                known: class
                    .actions
                    .iter()
                    .map(|action| action.name.clone())
                    .collect(),
            })?
            .clone();
        match action.kind {
            ActionKind::Articulate => Ok(OptionSpec {
                step: step.clone(),
                object: object.name.clone(),
                anchor: NavigationAnchor::given(
                    &step.name,
                    &class.name,
                    object.map_from_object,
                    action.approach,
                )?,
                kind: OptionKind::Articulate { action },
            }),
            ActionKind::PickPlace => {
                let target =
                    self.object(step.args.get(1).map(String::as_str).unwrap_or_default())?;
                Ok(OptionSpec {
                    step: step.clone(),
                    object: object.name.clone(),
                    anchor: NavigationAnchor::given(
                        &step.name,
                        &target.class,
                        target.map_from_object,
                        action.place_approach,
                    )?,
                    kind: OptionKind::Place {
                        target: target.name.clone(),
                        action,
                    },
                })
            }
        }
    }

    /// Every option of the map: its actions bound to its objects, in the order of their names.
    pub fn options(&self) -> Vec<OptionSpec> {
        let mut steps = Vec::new();
        for object in self.objects.values() {
            let Some(class) = self.classes.get(&object.class) else {
                continue;
            };
            if class.movable {
                steps.push(GroundAction::new(PICK, [&object.name]));
            }
            for action in &class.actions {
                let name = operator_name(&self.classes, class, action);
                match (action.kind, &action.target_class) {
                    (ActionKind::PickPlace, Some(target_class)) => {
                        for target in self.objects_of(target_class) {
                            steps.push(GroundAction::new(
                                name.clone(),
                                [&object.name, &target.name],
                            ));
                        }
                    }
                    _ => steps.push(GroundAction::new(name, [&object.name])),
                }
            }
        }
        steps
            .iter()
            .filter_map(|step| self.option(step).ok())
            .collect()
    }
}
