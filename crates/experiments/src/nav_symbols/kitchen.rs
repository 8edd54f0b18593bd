//! The coffee plan, and what a kitchen says to each of its steps.

use std::collections::BTreeSet;

use factotum_geometry::Pose2;
use factotum_symbols::navigation_learner::SkillOnClass;
use factotum_worlds::action_map::{ActionMap, StandingPlace};

/// A step of the plan: a skill on the object of a class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Its name.
    pub name: &'static str,
    /// The action that an action map knows it by.
    pub action: &'static str,
    /// The class of its object.
    pub class: &'static str,
    /// The skill and the class, as indices.
    pub on: SkillOnClass,
}

const fn step(
    name: &'static str,
    action: &'static str,
    class: &'static str,
    skill: usize,
    class_idx: usize,
) -> Step {
    Step {
        name,
        action,
        class,
        on: SkillOnClass {
            skill,
            class: class_idx,
        },
    }
}

/// Coffee in four steps (dissertation 5.4). Whether coffee can be made is whether the machine can be switched on.
pub const COFFEE: [Step; 4] = [
    step("PickUp(Mug)", "PickupObject", "Mug", 0, 0),
    step(
        "ToggleOn(CoffeeMachine)",
        "ToggleObjectOn",
        "CoffeeMachine",
        1,
        1,
    ),
    step(
        "PutIn(Mug, CoffeeMachine)",
        "PutObject",
        "CoffeeMachine",
        2,
        1,
    ),
    step(
        "MakeCoffee(CoffeeMachine)",
        "ToggleObjectOn",
        "CoffeeMachine",
        3,
        1,
    ),
];

/// Classes of objects in the plan.
pub(super) const N_CLASSES: usize = 2;

/// What a kitchen says to a step.
#[derive(Debug, Clone)]
pub(super) struct Site {
    /// Where the object stands.
    pub(super) world_from_object: Pose2,
    /// From where the step succeeds.
    pub(super) feasible: BTreeSet<StandingPlace>,
}

/// A kitchen in which the plan can be carried out.
#[derive(Debug, Clone)]
pub struct Kitchen {
    map: ActionMap,
    /// For each step.
    sites: Vec<Site>,
}

impl Kitchen {
    /// The kitchen of a map.
    ///
    /// # Errors
    /// The first step that cannot succeed anywhere in it.
    pub fn new(map: ActionMap) -> Result<Self, Step> {
        let sites = COFFEE
            .iter()
            .map(|step| {
                let object = map.object_for(step.action, step.class).ok_or(*step)?;
                Ok(Site {
                    world_from_object: object.world_from_object,
                    feasible: object.feasible[step.action].clone(),
                })
            })
            .collect::<Result<_, Step>>()?;
        Ok(Self { map, sites })
    }

    /// Its map.
    #[must_use]
    pub fn map(&self) -> &ActionMap {
        &self.map
    }

    /// What it says to a step.
    pub(super) fn site(&self, step: usize) -> &Site {
        &self.sites[step]
    }
}
