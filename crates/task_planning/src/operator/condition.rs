//! Conditions over predicates: preconditions, goals, and the conditions of conditional effects.

use std::collections::{BTreeMap, BTreeSet};

use super::plan::Atom;

/// A name with its type, as in `?m - mug` or `kitchen - room`. The root type is [`OBJECT`].
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TypedName {
    /// The name; a variable's name comes without its `?`.
    pub name: String,
    /// The name of its type.
    pub type_name: String,
}

/// The type every other type descends from.
pub const OBJECT: &str = "object";

impl TypedName {
    /// A name of the given type.
    pub fn new(name: impl Into<String>, type_name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            type_name: type_name.into(),
        }
    }
}

/// An argument of a predicate inside an operator or goal: a variable or a named object.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Term {
    /// A variable, named without its `?`.
    Variable(String),
    /// An object or domain constant.
    Object(String),
}

impl From<&str> for Term {
    /// `"?m"` is the variable `m`; anything else names an object.
    fn from(text: &str) -> Self {
        match text.strip_prefix('?') {
            Some(variable) => Self::Variable(variable.to_owned()),
            None => Self::Object(text.to_owned()),
        }
    }
}

impl Term {
    /// The object bound to a variable, or the term itself.
    pub(crate) fn substitute(&self, binding: &Binding) -> Self {
        match self {
            Self::Variable(name) => match binding.get(name) {
                Some(object) => Self::Object(object.clone()),
                None => self.clone(),
            },
            Self::Object(_) => self.clone(),
        }
    }
}

impl std::fmt::Display for Term {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Variable(name) => write!(f, "?{name}"),
            Self::Object(name) => f.write_str(name),
        }
    }
}

/// A predicate (or function) applied to terms, such as `(on ?m table)`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AtomPattern {
    /// Name of the predicate or function.
    pub symbol: String,
    /// Its arguments.
    pub terms: Vec<Term>,
}

impl AtomPattern {
    /// The symbol applied to the terms; see `Term::from` for how text becomes a term.
    pub fn new<'a>(symbol: impl Into<String>, terms: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            symbol: symbol.into(),
            terms: terms.into_iter().map(Term::from).collect(),
        }
    }

    /// The pattern with variables replaced by the objects bound to them.
    pub(crate) fn substitute(&self, binding: &Binding) -> Self {
        Self {
            symbol: self.symbol.clone(),
            terms: self.terms.iter().map(|t| t.substitute(binding)).collect(),
        }
    }

    /// The ground atom, if no variable is left after substitution.
    pub(crate) fn ground(&self, binding: &Binding) -> Option<Atom> {
        let args = self.terms.iter().map(|term| match term {
            Term::Object(name) => Some(name.clone()),
            Term::Variable(name) => binding.get(name).cloned(),
        });
        Some(Atom {
            symbol: self.symbol.clone(),
            args: args.collect::<Option<_>>()?,
        })
    }
}

impl std::fmt::Display for AtomPattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}", self.symbol)?;
        for term in &self.terms {
            write!(f, " {term}")?;
        }
        f.write_str(")")
    }
}

/// A first-order condition over one state, under the closed-world assumption.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Condition {
    /// The predicate holds.
    Atom(AtomPattern),
    /// Both terms name the same object.
    Equal(Term, Term),
    /// The condition does not hold.
    Not(Box<Condition>),
    /// All hold; the empty conjunction is true.
    And(Vec<Condition>),
    /// At least one holds; the empty disjunction is false.
    Or(Vec<Condition>),
    /// If the first holds, so does the second.
    Imply(Box<Condition>, Box<Condition>),
    /// Holds for every object of the variables' types.
    Forall(Vec<TypedName>, Box<Condition>),
    /// Holds for at least one choice of objects of the variables' types.
    Exists(Vec<TypedName>, Box<Condition>),
}

impl Default for Condition {
    fn default() -> Self {
        Self::always()
    }
}

impl Condition {
    /// The condition that always holds.
    pub fn always() -> Self {
        Self::And(Vec::new())
    }

    /// The predicate applied to the terms (`"?m"` is a variable, anything else an object).
    pub fn atom<'a>(symbol: impl Into<String>, terms: impl IntoIterator<Item = &'a str>) -> Self {
        Self::Atom(AtomPattern::new(symbol, terms))
    }

    /// The predicate applied to the terms does not hold.
    pub fn not_atom<'a>(
        symbol: impl Into<String>,
        terms: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::Not(Box::new(Self::atom(symbol, terms)))
    }

    /// All the conditions hold.
    pub fn all(conditions: impl IntoIterator<Item = Self>) -> Self {
        Self::And(conditions.into_iter().collect())
    }

    /// Whether this is the empty conjunction.
    pub fn is_always(&self) -> bool {
        matches!(self, Self::And(parts) if parts.is_empty())
    }

    /// The conjuncts, with nested conjunctions opened.
    pub fn conjuncts(&self) -> Vec<&Self> {
        match self {
            Self::And(parts) => parts.iter().flat_map(Self::conjuncts).collect(),
            other => vec![other],
        }
    }

    /// The condition with variables replaced by the objects bound to them; quantified ones stay.
    pub fn substitute(&self, binding: &Binding) -> Self {
        match self {
            Self::Atom(atom) => Self::Atom(atom.substitute(binding)),
            Self::Equal(a, b) => Self::Equal(a.substitute(binding), b.substitute(binding)),
            Self::Not(inner) => Self::Not(Box::new(inner.substitute(binding))),
            Self::And(parts) => Self::And(parts.iter().map(|p| p.substitute(binding)).collect()),
            Self::Or(parts) => Self::Or(parts.iter().map(|p| p.substitute(binding)).collect()),
            Self::Imply(premise, conclusion) => Self::Imply(
                Box::new(premise.substitute(binding)),
                Box::new(conclusion.substitute(binding)),
            ),
            Self::Forall(variables, inner) => {
                let inner = inner.substitute(&without(binding, variables));
                Self::Forall(variables.clone(), Box::new(inner))
            }
            Self::Exists(variables, inner) => {
                let inner = inner.substitute(&without(binding, variables));
                Self::Exists(variables.clone(), Box::new(inner))
            }
        }
    }

    /// Calls `visit` for this condition and everything inside it, outermost first.
    pub(crate) fn visit<'a>(&'a self, visit: &mut impl FnMut(&'a Self)) {
        visit(self);
        match self {
            Self::Atom(_) | Self::Equal(..) => {}
            Self::Not(inner) | Self::Forall(_, inner) | Self::Exists(_, inner) => {
                inner.visit(visit);
            }
            Self::And(parts) | Self::Or(parts) => {
                for part in parts {
                    part.visit(visit);
                }
            }
            Self::Imply(premise, conclusion) => {
                premise.visit(visit);
                conclusion.visit(visit);
            }
        }
    }

    /// The predicates read here, split into those read positively and those read negatively
    /// (under an odd number of negations; an implication's premise counts as negated).
    pub(crate) fn polarity(&self, negated: bool, reads: &mut PredicateReads) {
        match self {
            Self::Equal(..) => {}
            Self::Atom(atom) => {
                let set = if negated {
                    &mut reads.negative
                } else {
                    &mut reads.positive
                };
                set.insert(atom.symbol.clone());
            }
            Self::Not(inner) => inner.polarity(!negated, reads),
            Self::Forall(_, inner) | Self::Exists(_, inner) => inner.polarity(negated, reads),
            Self::And(parts) | Self::Or(parts) => {
                for part in parts {
                    part.polarity(negated, reads);
                }
            }
            Self::Imply(premise, conclusion) => {
                premise.polarity(!negated, reads);
                conclusion.polarity(negated, reads);
            }
        }
    }
}

impl std::fmt::Display for Condition {
    /// As PDDL writes it, on one line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let many = |f: &mut std::fmt::Formatter<'_>, head: &str, parts: &[Self]| {
            write!(f, "({head}")?;
            for part in parts {
                write!(f, " {part}")?;
            }
            f.write_str(")")
        };
        match self {
            Self::Atom(atom) => write!(f, "{atom}"),
            Self::Equal(a, b) => write!(f, "(= {a} {b})"),
            Self::Not(inner) => write!(f, "(not {inner})"),
            Self::And(parts) => many(f, "and", parts),
            Self::Or(parts) => many(f, "or", parts),
            Self::Imply(premise, conclusion) => write!(f, "(imply {premise} {conclusion})"),
            Self::Forall(variables, inner) => {
                write!(f, "(forall ({}) {inner})", Variables(variables))
            }
            Self::Exists(variables, inner) => {
                write!(f, "(exists ({}) {inner})", Variables(variables))
            }
        }
    }
}

/// Writes variables as `?a - t ?b - u`.
pub(crate) struct Variables<'a>(pub(crate) &'a [TypedName]);

impl std::fmt::Display for Variables<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, TypedName { name, type_name }) in self.0.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            write!(f, "{gap}?{name} - {type_name}")?;
        }
        Ok(())
    }
}

/// Objects bound to variables, by the variables' names.
pub type Binding = BTreeMap<String, String>;

fn without(binding: &Binding, variables: &[TypedName]) -> Binding {
    let mut inner = binding.clone();
    for variable in variables {
        inner.remove(&variable.name);
    }
    inner
}

/// The predicates a condition reads, by polarity.
#[derive(Debug, Default)]
pub(crate) struct PredicateReads {
    /// Read under an even number of negations.
    pub(crate) positive: BTreeSet<String>,
    /// Read under an odd number of negations.
    pub(crate) negative: BTreeSet<String>,
}
