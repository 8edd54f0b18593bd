//! Ground conditions in negation normal form.

use super::FactId;

/// A condition over facts, negations only at the leaves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Formula {
    True,
    False,
    /// The fact holds, or does not.
    Literal(FactId, bool),
    And(Vec<Formula>),
    Or(Vec<Formula>),
}

/// What is known of a fact in all reachable states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Known {
    Always,
    Never,
    Varies,
}

impl Formula {
    /// The conjunction, flattened; false as soon as one part is.
    pub(super) fn and(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut kept = Vec::new();
        for part in parts {
            match part {
                Self::True => {}
                Self::False => return Self::False,
                Self::And(inner) => kept.extend(inner),
                other => kept.push(other),
            }
        }
        match kept.len() {
            0 => Self::True,
            1 => kept.remove(0),
            _ => Self::And(kept),
        }
    }

    /// The disjunction, flattened; true as soon as one part is.
    pub(super) fn or(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut kept = Vec::new();
        for part in parts {
            match part {
                Self::False => {}
                Self::True => return Self::True,
                Self::Or(inner) => kept.extend(inner),
                other => kept.push(other),
            }
        }
        match kept.len() {
            0 => Self::False,
            1 => kept.remove(0),
            _ => Self::Or(kept),
        }
    }

    pub(super) fn negated(&self) -> Self {
        match self {
            Self::True => Self::False,
            Self::False => Self::True,
            Self::Literal(fact, positive) => Self::Literal(*fact, !positive),
            Self::And(parts) => Self::or(parts.iter().map(Self::negated)),
            Self::Or(parts) => Self::and(parts.iter().map(Self::negated)),
        }
    }

    /// The formula without the facts that always or never hold.
    pub(super) fn simplified(&self, known: &[Known]) -> Self {
        match self {
            Self::True | Self::False => self.clone(),
            Self::Literal(fact, positive) => match (known[*fact], positive) {
                (Known::Varies, _) => self.clone(),
                (Known::Always, true) | (Known::Never, false) => Self::True,
                (Known::Always, false) | (Known::Never, true) => Self::False,
            },
            Self::And(parts) => Self::and(parts.iter().map(|p| p.simplified(known))),
            Self::Or(parts) => Self::or(parts.iter().map(|p| p.simplified(known))),
        }
    }

    /// Whether the formula could hold, if each literal could hold on its own where `possible` says so.
    pub(super) fn is_possible(&self, possible: &impl Fn(FactId, bool) -> bool) -> bool {
        match self {
            Self::True => true,
            Self::False => false,
            Self::Literal(fact, positive) => possible(*fact, *positive),
            Self::And(parts) => parts.iter().all(|p| p.is_possible(possible)),
            Self::Or(parts) => parts.iter().any(|p| p.is_possible(possible)),
        }
    }

    /// Calls `visit` for every literal.
    pub(super) fn literals(&self, visit: &mut impl FnMut(FactId, bool)) {
        match self {
            Self::True | Self::False => {}
            Self::Literal(fact, positive) => visit(*fact, *positive),
            Self::And(parts) | Self::Or(parts) => {
                for part in parts {
                    part.literals(visit);
                }
            }
        }
    }
}
