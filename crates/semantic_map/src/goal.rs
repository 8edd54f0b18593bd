//! What a person wants done, before it is known which objects there are.

use factotum_descriptions::{ActionKind, ObjectClass};
use factotum_task_planning::operator::Condition;

use crate::vocabulary::{IN, state_predicate};
use crate::{Aosm, MapError};

/// A chore: every object of a class is to be in some state or place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChoreGoal {
    /// Class of the objects.
    pub class: String,
    /// What is to hold for them.
    pub wanted: Wanted,
}

/// What is to hold for an object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wanted {
    /// It is in this state, e.g. `off`.
    State(String),
    /// It is in some object of this class, e.g. `bin`.
    In(String),
}

impl ChoreGoal {
    /// The classes of which at least one object must be known before the chore can be planned.
    pub fn classes(&self) -> Vec<&str> {
        match &self.wanted {
            Wanted::State(_) => vec![&self.class],
            Wanted::In(container) => vec![&self.class, container],
        }
    }

    /// The goal over the objects that have been found.
    ///
    /// # Errors
    /// [`MapError::NothingOfClass`] while no object of a class it speaks of is known, [`MapError::NotOfClass`] if the
    /// class has no such state.
    pub fn condition(&self, aosm: &Aosm) -> Result<Condition, MapError> {
        for name in self.classes() {
            aosm.class(name)?;
            if aosm.objects_of(name).next().is_none() {
                return Err(MapError::NothingOfClass {
                    class: name.to_owned(),
                    found: aosm.objects.keys().cloned().collect(),
                });
            }
        }
        if let Wanted::State(state) = &self.wanted {
            let class = aosm.class(&self.class)?;
            if class.state(state).is_none() {
                return Err(MapError::NotOfClass {
                    class: self.class.clone(),
                    what: "state",
                    name: state.clone(),
                    known: class
                        .states
                        .iter()
                        .map(|state| state.name.clone())
                        .collect(),
                });
            }
        }
        Ok(Condition::all(aosm.objects_of(&self.class).map(|object| {
            match &self.wanted {
                Wanted::State(state) => {
                    Condition::atom(state_predicate(&self.class, state), [object.name.as_str()])
                }
                Wanted::In(container) => Condition::Or(
                    aosm.objects_of(container)
                        .map(|container| {
                            Condition::atom(IN, [object.name.as_str(), container.name.as_str()])
                        })
                        .collect(),
                ),
            }
        })))
    }
}

impl ChoreGoal {
    /// The goal that an action of a class brings about.
    ///
    /// # Errors
    /// [`MapError::NotOfClass`] if the class has no such action.
    pub fn of_action(class: &ObjectClass, action: &str) -> Result<Self, MapError> {
        let spec = class.action(action).ok_or_else(|| MapError::NotOfClass {
            class: class.name.clone(),
            what: "action",
            name: action.to_owned(),
            known: class
                .actions
                .iter()
                .map(|action| action.name.clone())
                .collect(),
        })?;
        let wanted = match spec.kind {
            ActionKind::PickPlace => Wanted::In(spec.target_class.clone().unwrap_or_default()),
            ActionKind::Articulate => Wanted::State(spec.effect.clone().unwrap_or_default()),
        };
        Ok(Self {
            class: class.name.clone(),
            wanted,
        })
    }
}
