//! What conditions and actions mean in a state: the semantics plans are judged by.
//!
//! Written apart from every planner: nothing here grounds, compiles or prunes. Quantifiers run over
//! the objects by their types, conditions are read as they stand, and where an action both deletes
//! and adds an atom the add wins (PDDL 2.1, Fox & Long, JAIR 20, 2003, section 8).

use std::collections::BTreeSet;

use super::fault::ActionFault;
use crate::names::fold;
use crate::operator::{
    Atom, AtomPattern, Binding, Condition, Cost, Domain, Effect, GroundAction, Operator, Outcome,
    Problem, TypedName,
};

/// The facts that hold; all others do not.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct State(BTreeSet<Atom>);

impl State {
    /// The state in which exactly these facts hold.
    pub fn new(facts: impl IntoIterator<Item = Atom>) -> Self {
        Self(facts.into_iter().collect())
    }

    /// Whether the fact holds.
    pub fn contains(&self, atom: &Atom) -> bool {
        self.0.contains(atom)
    }

    /// The facts that hold, in order.
    pub fn facts(&self) -> &BTreeSet<Atom> {
        &self.0
    }
}

/// A domain together with a problem's objects and function values: everything a state is read against.
#[derive(Debug, Clone)]
pub struct World<'a> {
    domain: &'a Domain,
    problem: &'a Problem,
    objects: Vec<&'a TypedName>,
}

/// An action whose operator, arguments and types are known to be sound in a [`World`].
#[derive(Debug, Clone)]
pub struct BoundAction<'a> {
    operator: &'a Operator,
    binding: Binding,
}

impl<'a> BoundAction<'a> {
    /// Its operator.
    pub fn operator(&self) -> &'a Operator {
        self.operator
    }

    /// The action in the spelling of the domain and problem.
    pub fn ground_action(&self) -> GroundAction {
        let args = self
            .operator
            .parameters()
            .iter()
            .map(|p| self.binding[&p.name].clone());
        GroundAction::new(self.operator.name(), args)
    }
}

impl<'a> World<'a> {
    /// The world of a problem.
    pub fn new(domain: &'a Domain, problem: &'a Problem) -> Self {
        let objects = domain.constants().iter().chain(problem.objects()).collect();
        Self {
            domain,
            problem,
            objects,
        }
    }

    /// The problem's initial state.
    pub fn initial_state(&self) -> State {
        State(self.problem.init().clone())
    }

    /// The goal's conjuncts that do not hold; empty where the goal is met.
    pub fn unmet_goal(&self, state: &State) -> Vec<Condition> {
        self.unmet(state, self.problem.goal(), &Binding::new())
    }

    /// Finds the operator and binds the arguments.
    ///
    /// # Errors
    /// An unknown operator or object, a wrong number of arguments, or an argument of the wrong type.
    pub fn bind(&self, action: &GroundAction) -> Result<BoundAction<'a>, ActionFault> {
        let domain = self.domain;
        let operator =
            domain
                .operator(&action.name)
                .ok_or_else(|| ActionFault::UnknownOperator {
                    name: action.name.clone(),
                    known: domain
                        .operators()
                        .iter()
                        .map(|o| o.name().to_owned())
                        .collect(),
                })?;
        let parameters = operator.parameters();
        if parameters.len() != action.args.len() {
            return Err(ActionFault::Arity {
                operator: operator.name().to_owned(),
                found: action.args.len(),
                wanted: parameters.len(),
            });
        }
        let mut binding = Binding::new();
        for (parameter, arg) in parameters.iter().zip(&action.args) {
            let object = self.object(arg)?;
            if !domain.is_subtype(&object.type_name, &parameter.type_name) {
                return Err(ActionFault::WrongType {
                    operator: operator.name().to_owned(),
                    object: object.name.clone(),
                    found: object.type_name.clone(),
                    wanted: parameter.type_name.clone(),
                });
            }
            binding.insert(parameter.name.clone(), object.name.clone());
        }
        Ok(BoundAction { operator, binding })
    }

    /// The conjuncts of the action's precondition that do not hold; empty where it can run.
    pub fn unmet_precondition(&self, state: &State, action: &BoundAction<'_>) -> Vec<Condition> {
        self.unmet(state, action.operator.precondition(), &action.binding)
    }

    /// The state after one outcome of the action, whether or not its precondition holds.
    pub fn apply(&self, state: &State, action: &BoundAction<'_>, outcome: &Outcome) -> State {
        let (mut adds, mut deletes) = (Vec::new(), Vec::new());
        for effect in &outcome.effects {
            for binding in self.bindings(&effect.forall, &action.binding) {
                self.collect(state, effect, &binding, &mut adds, &mut deletes);
            }
        }
        let mut after = state.clone();
        for atom in &deletes {
            after.0.remove(atom);
        }
        after.0.extend(adds);
        after
    }

    fn collect(
        &self,
        state: &State,
        effect: &Effect,
        binding: &Binding,
        adds: &mut Vec<Atom>,
        deletes: &mut Vec<Atom>,
    ) {
        if self.holds(state, &effect.when, binding)
            && let Some(atom) = effect.atom.ground(binding)
        {
            if effect.adds {
                adds.push(atom)
            } else {
                deletes.push(atom)
            }
        }
    }

    /// What one outcome of the action costs.
    ///
    /// # Errors
    /// The problem gives no value to the function the cost reads.
    pub fn cost(&self, action: &BoundAction<'_>, outcome: &Outcome) -> Result<f64, ActionFault> {
        match &outcome.cost {
            Cost::Constant(value) => Ok(*value),
            Cost::Function(function) => self.value(function, &action.binding),
        }
    }

    fn value(&self, function: &AtomPattern, binding: &Binding) -> Result<f64, ActionFault> {
        function
            .ground(binding)
            .and_then(|atom| self.problem.values().get(&atom).copied())
            .ok_or_else(|| ActionFault::NoValue {
                function: function.substitute(binding).to_string(),
            })
    }

    fn object(&self, name: &str) -> Result<&'a TypedName, ActionFault> {
        self.objects
            .iter()
            .find(|o| fold(&o.name) == fold(name))
            .copied()
            .ok_or_else(|| ActionFault::UnknownObject {
                name: name.to_owned(),
                known: self.objects.iter().map(|o| o.name.clone()).collect(),
            })
    }

    fn unmet(&self, state: &State, condition: &Condition, binding: &Binding) -> Vec<Condition> {
        condition
            .conjuncts()
            .into_iter()
            .filter(|part| !self.holds(state, part, binding))
            .map(|part| part.substitute(binding))
            .collect()
    }

    /// Whether the condition holds in the state under the binding of its free variables.
    pub fn holds(&self, state: &State, condition: &Condition, binding: &Binding) -> bool {
        match condition {
            Condition::Atom(atom) => atom.ground(binding).is_some_and(|a| state.0.contains(&a)),
            Condition::Equal(a, b) => a.substitute(binding) == b.substitute(binding),
            Condition::Not(inner) => !self.holds(state, inner, binding),
            Condition::And(parts) => parts.iter().all(|p| self.holds(state, p, binding)),
            Condition::Or(parts) => parts.iter().any(|p| self.holds(state, p, binding)),
            Condition::Imply(premise, conclusion) => {
                !self.holds(state, premise, binding) || self.holds(state, conclusion, binding)
            }
            Condition::Forall(variables, inner) => self
                .bindings(variables, binding)
                .iter()
                .all(|b| self.holds(state, inner, b)),
            Condition::Exists(variables, inner) => self
                .bindings(variables, binding)
                .iter()
                .any(|b| self.holds(state, inner, b)),
        }
    }

    /// The binding extended in every way by objects of the variables' types.
    fn bindings(&self, variables: &[TypedName], outer: &Binding) -> Vec<Binding> {
        let mut bindings = vec![outer.clone()];
        for variable in variables {
            let candidates: Vec<_> = self
                .objects
                .iter()
                .filter(|o| self.domain.is_subtype(&o.type_name, &variable.type_name))
                .collect();
            bindings = bindings
                .iter()
                .flat_map(|binding| {
                    candidates.iter().map(move |object| {
                        let mut extended = binding.clone();
                        extended.insert(variable.name.clone(), object.name.clone());
                        extended
                    })
                })
                .collect();
        }
        bindings
    }
}
