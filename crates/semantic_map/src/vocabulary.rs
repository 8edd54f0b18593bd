//! The planning vocabulary of a map: its classes as types and operators, its objects and what is known of them as facts.
//!
//! Manipulation only. Where the base must stand is no part of it: by spatial independence (thesis Definition 5.3.1)
//! the navigation half of each precondition is kept apart, as the navigation symbols of the topological graph.

use std::collections::BTreeMap;

use factotum_descriptions::{ActionKind, ActionSpec, ObjectClass};
use factotum_task_planning::operator::{Condition, Domain, Operator, Problem};

use crate::{Aosm, Location, MapError};

/// The gripper holds nothing.
pub const HAND_EMPTY: &str = "hand-empty";
/// The gripper holds this object.
pub const HOLDING: &str = "holding";
/// The first object is in the second.
pub const IN: &str = "in";
/// Nothing holds this object.
pub const LOOSE: &str = "loose";
/// Operator that takes a movable object into the gripper.
pub const PICK: &str = "pick";
const MOVABLE: &str = "movable";

/// Names of types that the vocabulary has of itself, and no class can have.
pub(crate) const OWN_TYPES: [&str; 2] = ["object", MOVABLE];

/// Predicate of a named state of a class, e.g. `light_switch-off`.
pub(crate) fn state_predicate(class: &str, state: &str) -> String {
    format!("{class}-{state}")
}

/// Operator of an action: its own name, with the class appended where two classes have actions of one name.
pub(crate) fn operator_name(
    classes: &BTreeMap<String, ObjectClass>,
    class: &ObjectClass,
    action: &ActionSpec,
) -> String {
    let is_shared = action.name == PICK
        || classes
            .values()
            .any(|other| other.name != class.name && other.action(&action.name).is_some());
    if is_shared {
        format!("{}-{}", action.name, class.name)
    } else {
        action.name.clone()
    }
}

impl Aosm {
    /// The planning domain of the map's classes.
    ///
    /// # Errors
    /// [`MapError::Domain`] if a class or action has a name PDDL cannot write.
    pub fn domain(&self) -> Result<Domain, MapError> {
        let mut domain = Domain::builder("home")
            .object_type(MOVABLE, "object")
            .predicate(HAND_EMPTY, [])
            .predicate(HOLDING, [("o", MOVABLE)])
            .predicate(LOOSE, [("o", MOVABLE)])
            .predicate(IN, [("o", MOVABLE), ("c", "object")])
            .operator(
                Operator::builder(PICK)
                    .parameter("o", MOVABLE)
                    .requires(Condition::atom(HAND_EMPTY, []))
                    .requires(Condition::atom(LOOSE, ["?o"]))
                    .adds(HOLDING, ["?o"])
                    .deletes(HAND_EMPTY, [])
                    .deletes(LOOSE, ["?o"])
                    .build()?,
            );
        for class in self.classes.values() {
            domain =
                domain.object_type(&class.name, if class.movable { MOVABLE } else { "object" });
            for state in &class.states {
                domain = domain.predicate(
                    state_predicate(&class.name, &state.name),
                    [("o", class.name.as_str())],
                );
            }
        }
        for class in self.classes.values() {
            for action in &class.actions {
                let name = operator_name(&self.classes, class, action);
                domain = domain.operator(operator(name, class, action)?);
            }
        }
        Ok(domain.build()?)
    }

    /// The planning problem of reaching `goal` from what the map knows now.
    ///
    /// # Errors
    /// [`MapError::Domain`] if the goal speaks of an unknown predicate or object.
    pub fn problem(&self, domain: &Domain, goal: Condition) -> Result<Problem, MapError> {
        let mut problem = Problem::builder("chore").domain(domain.name()).goal(goal);
        if self.held().is_none() {
            problem = problem.fact(HAND_EMPTY, []);
        }
        for object in self.objects.values() {
            let name = object.name.as_str();
            problem = problem.object(name, &object.class);
            if self
                .classes
                .get(&object.class)
                .is_some_and(|class| class.movable)
            {
                problem = match &object.location {
                    Location::Loose => problem.fact(LOOSE, [name]),
                    Location::Held => problem.fact(HOLDING, [name]),
                    Location::In(container) => problem.fact(IN, [name, container.as_str()]),
                };
            }
            for state in self.states_of(object) {
                problem = problem.fact(state_predicate(&object.class, state), [name]);
            }
        }
        Ok(problem.build(domain)?)
    }
}

fn operator(name: String, class: &ObjectClass, action: &ActionSpec) -> Result<Operator, MapError> {
    let builder = Operator::builder(name).parameter("o", &class.name);
    let builder = match action.kind {
        ActionKind::PickPlace => builder
            .parameter("c", action.target_class.as_deref().unwrap_or("object"))
            .requires(Condition::atom(HOLDING, ["?o"]))
            .adds(IN, ["?o", "?c"])
            .adds(HAND_EMPTY, [])
            .deletes(HOLDING, ["?o"]),
        ActionKind::Articulate => {
            let effect = action.effect.as_deref().unwrap_or_default();
            let joint = action.joint.as_deref().unwrap_or_default();
            let others = class
                .states
                .iter()
                .filter(|state| state.joint == joint && state.name != effect);
            let builder = builder
                .requires(Condition::atom(HAND_EMPTY, []))
                .adds(state_predicate(&class.name, effect), ["?o"]);
            others.fold(builder, |builder, state| {
                builder.deletes(state_predicate(&class.name, &state.name), ["?o"])
            })
        }
    };
    Ok(builder.build()?)
}
