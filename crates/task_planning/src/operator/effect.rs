//! What an operator changes: effects, their probabilistic outcomes, and what they cost.

use super::condition::{AtomPattern, Condition, TypedName};

/// One change of the state: the atom becomes true or false, perhaps only for some objects or under a condition.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Effect {
    /// Variables the effect ranges over (`forall`); empty for a plain effect.
    pub forall: Vec<TypedName>,
    /// The effect happens only where this held before the action (`when`).
    pub when: Condition,
    /// The atom that changes.
    pub atom: AtomPattern,
    /// True adds the atom, false deletes it.
    pub adds: bool,
}

impl Effect {
    /// The atom becomes true.
    pub fn add(atom: AtomPattern) -> Self {
        Self {
            forall: Vec::new(),
            when: Condition::always(),
            atom,
            adds: true,
        }
    }

    /// The atom becomes false.
    pub fn delete(atom: AtomPattern) -> Self {
        Self {
            adds: false,
            ..Self::add(atom)
        }
    }

    /// The same effect, only where the condition held before the action.
    pub fn when(self, condition: Condition) -> Self {
        Self {
            when: condition,
            ..self
        }
    }

    /// Whether it happens always and for one binding only.
    pub fn is_plain(&self) -> bool {
        self.forall.is_empty() && self.when.is_always()
    }
}

/// What an outcome costs; never negative.
#[derive(Debug, Clone, PartialEq, PartialOrd)]
pub enum Cost {
    /// The same for every binding.
    Constant(f64),
    /// Read from the problem's function values, such as `(distance ?from ?to)`.
    Function(AtomPattern),
}

impl Default for Cost {
    fn default() -> Self {
        Self::Constant(0.0)
    }
}

impl Cost {
    /// Whether nothing is paid.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Constant(value) if *value == 0.0)
    }
}

/// One way an operator may turn out.
#[derive(Debug, Clone, PartialEq, PartialOrd)]
pub struct Outcome {
    /// How likely it is, in (0, 1]; the outcomes of an operator sum to 1.
    pub probability: f64,
    /// What it changes. Where one atom is both deleted and added, the add wins, as in PDDL.
    pub effects: Vec<Effect>,
    /// What it costs.
    pub cost: Cost,
}

impl Outcome {
    /// The only outcome of a deterministic operator, so far without effect or cost.
    pub fn certain() -> Self {
        Self {
            probability: 1.0,
            effects: Vec::new(),
            cost: Cost::default(),
        }
    }
}
