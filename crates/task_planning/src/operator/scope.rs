//! Checking names, arities and types against what a domain declares, and giving each reference the
//! spelling of its declaration.

use std::collections::BTreeMap;

use super::action::check_distinct;
use super::condition::{AtomPattern, Condition, OBJECT, Term, TypedName};
use super::domain::{Index, Signature};
use super::effect::{Cost, Outcome};
use super::error::OperatorError;
use super::plan::Atom;
use crate::names::fold;

/// Types by folded name: the declared spelling and the parent's folded name.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct TypeTree(BTreeMap<String, TypedName>);

impl TypeTree {
    /// Indexes the declared types, each with its parent's name.
    pub(super) fn new(types: &mut [TypedName], owner: &str) -> Result<Self, OperatorError> {
        check_distinct("type", owner, types)?;
        let mut tree = Self(types.iter().map(|t| (fold(&t.name), t.clone())).collect());
        for declared in types.iter_mut() {
            let parent = tree.spelling(&declared.type_name, owner)?;
            declared.type_name = parent;
            tree.0.insert(fold(&declared.name), declared.clone());
        }
        for declared in types.iter() {
            tree.refuse_cycle(&declared.name)?;
        }
        Ok(tree)
    }

    fn refuse_cycle(&self, name: &str) -> Result<(), OperatorError> {
        let mut at = fold(name);
        for _ in 0..=self.0.len() {
            match self.0.get(&at) {
                Some(declared) if at != OBJECT => at = fold(&declared.type_name),
                _ => return Ok(()),
            }
        }
        Err(OperatorError::TypeCycle {
            name: name.to_owned(),
        })
    }

    /// The declared spelling of a type.
    pub(super) fn spelling(&self, name: &str, owner: &str) -> Result<String, OperatorError> {
        if fold(name) == OBJECT {
            return Ok(OBJECT.to_owned());
        }
        self.0
            .get(&fold(name))
            .map(|t| t.name.clone())
            .ok_or_else(|| OperatorError::Unknown {
                kind: "type",
                name: name.to_owned(),
                owner: owner.to_owned(),
                known: self.0.values().map(|t| t.name.clone()).collect(),
            })
    }

    /// Whether every object of type `sub` is also of type `ancestor`.
    pub(super) fn is_subtype(&self, sub: &str, ancestor: &str) -> bool {
        let ancestor = fold(ancestor);
        if ancestor == OBJECT {
            return true;
        }
        let mut at = fold(sub);
        loop {
            if at == ancestor {
                return true;
            }
            match self.0.get(&at) {
                Some(declared) if at != OBJECT => at = fold(&declared.type_name),
                _ => return false,
            }
        }
    }
}

/// Named things with a signature, by folded name.
pub(super) type Signatures = BTreeMap<String, Signature>;

/// Objects or variables in reach, by folded name.
pub(super) type Names = BTreeMap<String, TypedName>;

/// What the names in one operator, goal or fact may refer to.
#[derive(Debug, Clone)]
pub(super) struct Scope<'a> {
    pub(super) index: &'a Index,
    pub(super) objects: &'a Names,
    pub(super) variables: Names,
    pub(super) owner: String,
}

impl Scope<'_> {
    /// The same scope with more variables, which hide outer ones of the same name.
    fn with_variables(&self, variables: &mut [TypedName]) -> Result<Self, OperatorError> {
        let mut inner = self.clone();
        inner.bind(variables)?;
        Ok(inner)
    }

    /// Brings variables into scope.
    pub(super) fn bind(&mut self, variables: &mut [TypedName]) -> Result<(), OperatorError> {
        check_distinct("variable", &self.owner, variables)?;
        for variable in variables {
            variable.type_name = self
                .index
                .types
                .spelling(&variable.type_name, &self.owner)?;
            self.variables
                .insert(fold(&variable.name), variable.clone());
        }
        Ok(())
    }

    pub(super) fn condition(&self, condition: &mut Condition) -> Result<(), OperatorError> {
        match condition {
            Condition::Atom(atom) => self.predicate(atom),
            Condition::Equal(a, b) => {
                self.term(a)?;
                self.term(b).map(|_| ())
            }
            Condition::Not(inner) => self.condition(inner),
            Condition::And(parts) | Condition::Or(parts) => {
                parts.iter_mut().try_for_each(|part| self.condition(part))
            }
            Condition::Imply(premise, conclusion) => {
                self.condition(premise)?;
                self.condition(conclusion)
            }
            Condition::Forall(variables, inner) | Condition::Exists(variables, inner) => {
                self.with_variables(variables)?.condition(inner)
            }
        }
    }

    pub(super) fn outcome(&self, outcome: &mut Outcome) -> Result<(), OperatorError> {
        for effect in &mut outcome.effects {
            let inner = self.with_variables(&mut effect.forall)?;
            inner.condition(&mut effect.when)?;
            inner.predicate(&mut effect.atom)?;
        }
        match &mut outcome.cost {
            Cost::Constant(_) => Ok(()),
            Cost::Function(atom) => self.pattern("function", &self.index.functions, atom),
        }
    }

    pub(super) fn predicate(&self, atom: &mut AtomPattern) -> Result<(), OperatorError> {
        self.pattern("predicate", &self.index.predicates, atom)
    }

    fn pattern(
        &self,
        kind: &'static str,
        declared: &Signatures,
        atom: &mut AtomPattern,
    ) -> Result<(), OperatorError> {
        let types = atom
            .terms
            .iter_mut()
            .map(|term| self.term(term))
            .collect::<Result<Vec<_>, _>>()?;
        let args: Vec<_> = atom
            .terms
            .iter()
            .map(ToString::to_string)
            .zip(types)
            .collect();
        atom.symbol = self.symbol(kind, declared, &atom.symbol, &args)?;
        Ok(())
    }

    /// Checks a ground fact or function value; every argument must be of the declared type.
    pub(super) fn ground(&self, kind: &'static str, atom: &mut Atom) -> Result<(), OperatorError> {
        let declared = if kind == "function" {
            &self.index.functions
        } else {
            &self.index.predicates
        };
        let mut args = Vec::new();
        for arg in &mut atom.args {
            let object = self.object(arg)?;
            arg.clone_from(&object.name);
            args.push((object.name.clone(), object.type_name.clone()));
        }
        atom.symbol = self.symbol(kind, declared, &atom.symbol, &args)?;
        let wanted = &declared[&fold(&atom.symbol)].parameters;
        for ((argument, found), parameter) in args.iter().zip(wanted) {
            if !self.index.types.is_subtype(found, &parameter.type_name) {
                return Err(self.mismatch(&atom.symbol, argument, found, &parameter.type_name));
            }
        }
        Ok(())
    }

    /// The declared spelling of a predicate or function, its arguments checked.
    ///
    /// An argument's type may be an ancestor of the declared one: the condition is then false for
    /// objects outside it, as every PDDL planner reads it.
    fn symbol(
        &self,
        kind: &'static str,
        declared: &Signatures,
        name: &str,
        args: &[(String, String)],
    ) -> Result<String, OperatorError> {
        let signature = declared
            .get(&fold(name))
            .ok_or_else(|| OperatorError::Unknown {
                kind,
                name: name.to_owned(),
                owner: self.owner.clone(),
                known: declared.values().map(|s| s.name.clone()).collect(),
            })?;
        if args.len() != signature.parameters.len() {
            return Err(OperatorError::Arity {
                kind,
                name: signature.name.clone(),
                found: args.len(),
                wanted: signature.parameters.len(),
                owner: self.owner.clone(),
            });
        }
        for ((argument, found), parameter) in args.iter().zip(&signature.parameters) {
            let wanted = &parameter.type_name;
            if !self.index.types.is_subtype(found, wanted)
                && !self.index.types.is_subtype(wanted, found)
            {
                return Err(self.mismatch(&signature.name, argument, found, wanted));
            }
        }
        Ok(signature.name.clone())
    }

    fn mismatch(&self, symbol: &str, argument: &str, found: &str, wanted: &str) -> OperatorError {
        OperatorError::TypeMismatch {
            symbol: symbol.to_owned(),
            argument: argument.to_owned(),
            found: found.to_owned(),
            wanted: wanted.to_owned(),
            owner: self.owner.clone(),
        }
    }

    /// Gives the term its declared spelling and returns its type.
    fn term(&self, term: &mut Term) -> Result<String, OperatorError> {
        match term {
            Term::Object(name) => {
                let object = self.object(name)?;
                name.clone_from(&object.name);
                Ok(object.type_name.clone())
            }
            Term::Variable(name) => {
                let variable =
                    self.variables
                        .get(&fold(name))
                        .ok_or_else(|| OperatorError::Unknown {
                            kind: "variable",
                            name: format!("?{name}"),
                            owner: self.owner.clone(),
                            known: self
                                .variables
                                .values()
                                .map(|v| format!("?{}", v.name))
                                .collect(),
                        })?;
                name.clone_from(&variable.name);
                Ok(variable.type_name.clone())
            }
        }
    }

    fn object(&self, name: &str) -> Result<&TypedName, OperatorError> {
        self.objects
            .get(&fold(name))
            .ok_or_else(|| OperatorError::Unknown {
                kind: "object",
                name: name.to_owned(),
                owner: self.owner.clone(),
                known: self.objects.values().map(|o| o.name.clone()).collect(),
            })
    }
}
