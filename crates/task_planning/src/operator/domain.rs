//! Domains: types, constants, predicates, functions and operators, checked against each other.

use std::collections::BTreeMap;

use super::action::{Operator, check_distinct};
use super::condition::TypedName;
use super::error::OperatorError;
use super::scope::{Names, Scope, Signatures, TypeTree};
use crate::names::{fold, is_name};

/// A predicate or function with its parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signature {
    /// Its name.
    pub name: String,
    /// Its parameters; their names only serve the reader.
    pub parameters: Vec<TypedName>,
}

/// A planning domain whose names, arities, types and probabilities are known to be sound.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain {
    name: String,
    types: Vec<TypedName>,
    constants: Vec<TypedName>,
    predicates: Vec<Signature>,
    functions: Vec<Signature>,
    operators: Vec<Operator>,
    operator_idx: BTreeMap<String, usize>,
    pub(super) index: Index,
}

/// Everything a domain declares, by folded name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Index {
    pub(super) types: TypeTree,
    pub(super) constants: Names,
    pub(super) predicates: Signatures,
    pub(super) functions: Signatures,
}

impl Domain {
    /// Starts an empty domain.
    pub fn builder(name: impl Into<String>) -> DomainBuilder {
        DomainBuilder {
            name: name.into(),
            types: Vec::new(),
            constants: Vec::new(),
            predicates: Vec::new(),
            functions: Vec::new(),
            operators: Vec::new(),
        }
    }

    /// Opens the domain for changes; `build` checks it anew.
    pub fn into_builder(self) -> DomainBuilder {
        DomainBuilder {
            name: self.name,
            types: self.types,
            constants: self.constants,
            predicates: self.predicates,
            functions: self.functions,
            operators: self.operators,
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The declared types, each with its parent in `type_name`.
    pub fn types(&self) -> &[TypedName] {
        &self.types
    }

    /// Objects every problem of the domain has.
    pub fn constants(&self) -> &[TypedName] {
        &self.constants
    }

    /// The predicates.
    pub fn predicates(&self) -> &[Signature] {
        &self.predicates
    }

    /// The numeric functions that costs read; the total cost itself is not among them.
    pub fn functions(&self) -> &[Signature] {
        &self.functions
    }

    /// The operators, in the order they were given.
    pub fn operators(&self) -> &[Operator] {
        &self.operators
    }

    /// The operator of that name (case does not matter).
    pub fn operator(&self, name: &str) -> Option<&Operator> {
        self.operator_idx
            .get(&fold(name))
            .map(|&i| &self.operators[i])
    }

    /// The domain with one more operator.
    ///
    /// # Errors
    /// The operator's name is taken, or it uses what the domain does not declare.
    pub fn with_operator(mut self, mut operator: Operator) -> Result<Self, OperatorError> {
        if self.operator_idx.contains_key(&fold(&operator.name)) {
            let owner = format!("domain `{}`", self.name);
            return Err(OperatorError::Duplicate {
                kind: "operator",
                name: operator.name,
                owner,
            });
        }
        let mut scope = Scope {
            index: &self.index,
            objects: &self.index.constants,
            variables: Names::new(),
            owner: format!("operator `{}`", operator.name),
        };
        scope.bind(&mut operator.parameters)?;
        scope.condition(&mut operator.precondition)?;
        for outcome in &mut operator.outcomes {
            scope.outcome(outcome)?;
        }
        self.operator_idx
            .insert(fold(&operator.name), self.operators.len());
        self.operators.push(operator);
        Ok(self)
    }

    /// Whether every object of type `sub` is also of type `ancestor`.
    pub fn is_subtype(&self, sub: &str, ancestor: &str) -> bool {
        self.index.types.is_subtype(sub, ancestor)
    }

    /// Whether some operator costs something; otherwise a plan costs its number of steps.
    pub fn uses_costs(&self) -> bool {
        self.operators
            .iter()
            .flat_map(|o| &o.outcomes)
            .any(|outcome| !outcome.cost.is_zero())
    }

    /// Whether every operator always turns out the same way.
    pub fn is_deterministic(&self) -> bool {
        self.operators.iter().all(Operator::is_deterministic)
    }
}

/// Collects the parts of a [`Domain`].
#[derive(Debug, Clone)]
pub struct DomainBuilder {
    name: String,
    types: Vec<TypedName>,
    constants: Vec<TypedName>,
    predicates: Vec<Signature>,
    functions: Vec<Signature>,
    operators: Vec<Operator>,
}

impl DomainBuilder {
    /// Declares a type under a parent type (`object` is the root and needs no declaration).
    pub fn object_type(mut self, name: impl Into<String>, parent: impl Into<String>) -> Self {
        self.types.push(TypedName::new(name, parent));
        self
    }

    /// Declares an object every problem has.
    pub fn constant(mut self, name: impl Into<String>, type_name: impl Into<String>) -> Self {
        self.constants.push(TypedName::new(name, type_name));
        self
    }

    /// Declares a predicate with its parameters, as (name without `?`, type).
    pub fn predicate<'a>(
        mut self,
        name: impl Into<String>,
        parameters: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Self {
        self.predicates.push(signature(name, parameters));
        self
    }

    /// Declares a numeric function that costs may read.
    pub fn function<'a>(
        mut self,
        name: impl Into<String>,
        parameters: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Self {
        self.functions.push(signature(name, parameters));
        self
    }

    /// Adds an operator.
    pub fn operator(mut self, operator: Operator) -> Self {
        self.operators.push(operator);
        self
    }

    /// Replaces all operators.
    pub(crate) fn operators(mut self, operators: Vec<Operator>) -> Self {
        self.operators = operators;
        self
    }

    /// Adds a predicate or function already in the form of a [`Signature`].
    pub(crate) fn signature(mut self, kind: SignatureKind, signature: Signature) -> Self {
        match kind {
            SignatureKind::Predicate => self.predicates.push(signature),
            SignatureKind::Function => self.functions.push(signature),
        }
        self
    }

    /// Checks the whole and finishes the domain.
    ///
    /// # Errors
    /// See [`OperatorError`]: names declared twice or not at all, wrong arities, impossible types.
    pub fn build(mut self) -> Result<Domain, OperatorError> {
        let owner = format!("domain `{}`", self.name);
        if !is_name(&self.name) {
            return Err(OperatorError::InvalidName {
                kind: "domain",
                name: self.name,
            });
        }
        let types = TypeTree::new(&mut self.types, &owner)?;
        let constants = index_objects(&types, &mut self.constants, &owner)?;
        let predicates = index_signatures("predicate", &types, &mut self.predicates, &owner)?;
        let functions = index_signatures("function", &types, &mut self.functions, &owner)?;
        let empty = Domain {
            name: self.name,
            types: self.types,
            constants: self.constants,
            predicates: self.predicates,
            functions: self.functions,
            operators: Vec::new(),
            operator_idx: BTreeMap::new(),
            index: Index {
                types,
                constants,
                predicates,
                functions,
            },
        };
        self.operators
            .into_iter()
            .try_fold(empty, Domain::with_operator)
    }
}

/// Which list a signature belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SignatureKind {
    Predicate,
    Function,
}

fn signature<'a>(
    name: impl Into<String>,
    parameters: impl IntoIterator<Item = (&'a str, &'a str)>,
) -> Signature {
    Signature {
        name: name.into(),
        parameters: parameters
            .into_iter()
            .map(|(n, t)| TypedName::new(n, t))
            .collect(),
    }
}

/// Indexes objects by folded name, their types checked.
pub(super) fn index_objects(
    types: &TypeTree,
    objects: &mut [TypedName],
    owner: &str,
) -> Result<Names, OperatorError> {
    check_distinct("object", owner, objects)?;
    for object in objects.iter_mut() {
        object.type_name =
            types.spelling(&object.type_name, &format!("object `{}`", object.name))?;
    }
    Ok(objects.iter().map(|o| (fold(&o.name), o.clone())).collect())
}

/// Indexes signatures by folded name, their parameter types checked.
fn index_signatures(
    kind: &'static str,
    types: &TypeTree,
    signatures: &mut [Signature],
    owner: &str,
) -> Result<Signatures, OperatorError> {
    let mut index = BTreeMap::new();
    for signature in signatures {
        if !is_name(&signature.name) {
            return Err(OperatorError::InvalidName {
                kind,
                name: signature.name.clone(),
            });
        }
        let here = format!("{kind} `{}`", signature.name);
        check_distinct("parameter", &here, &signature.parameters)?;
        for parameter in &mut signature.parameters {
            parameter.type_name = types.spelling(&parameter.type_name, &here)?;
        }
        if index
            .insert(fold(&signature.name), signature.clone())
            .is_some()
        {
            let name = signature.name.clone();
            return Err(OperatorError::Duplicate {
                kind,
                name,
                owner: owner.to_owned(),
            });
        }
    }
    Ok(index)
}
