//! Which ground actions could ever run, if deletes did not matter.

use std::collections::{BTreeSet, HashMap};

use super::facts::{Facts, Row};
use super::formula::Formula;
use super::join::{Arg, Join, Pattern, Reached};
use super::{FactId, GroundEffect, GroundTask, Instance};
use crate::operator::{
    Atom, AtomPattern, Binding, Condition, Cost, Domain, GroundAction, Operator, Problem, Term,
    TypedName,
};
use crate::validate::ActionFault;

/// Bindings that are looked at before the task counts as too large (a few seconds of work).
const N_BINDINGS_MAX: usize = 400_000;

/// All actions that could ever run; `None` where there are too many.
pub(super) fn reachable(
    domain: &Domain,
    problem: &Problem,
) -> Result<Option<GroundTask>, ActionFault> {
    let mut grounder = Grounder::new(domain, problem);
    let compiled: Vec<_> = domain
        .operators()
        .iter()
        .map(|o| grounder.patterns(o))
        .collect();
    let mut first_new = 0;
    let mut first_round = true;
    loop {
        let end = grounder.reached.len();
        for (operator, patterns) in domain.operators().iter().zip(&compiled) {
            let Some(bindings) = grounder.bindings(operator, patterns, first_new, first_round)
            else {
                return Ok(None);
            };
            for binding in bindings {
                grounder.instantiate(operator, &binding)?;
            }
        }
        grounder.fire();
        first_round = false;
        first_new = end;
        if grounder.reached.len() == end && !grounder.progressed {
            break;
        }
        grounder.progressed = false;
    }
    let goal = grounder.formula(problem.goal(), &Binding::new(), false);
    let goal_conjuncts = problem
        .goal()
        .conjuncts()
        .into_iter()
        .map(|part| {
            (
                part.to_string(),
                grounder.formula(part, &Binding::new(), false),
            )
        })
        .collect();
    let ran = grounder
        .waiting
        .into_iter()
        .filter(|w| w.runs)
        .map(|w| w.instance);
    Ok(Some(GroundTask {
        instances: ran.collect(),
        facts: grounder.facts,
        goal,
        goal_conjuncts,
    }))
}

/// An instance whose preconditions match reached facts, and which of its parts have taken effect.
#[derive(Debug)]
struct Waiting {
    instance: Instance,
    /// Whether its whole precondition has been found possible.
    runs: bool,
    /// Whether each effect has been found possible.
    fired: Vec<bool>,
}

#[derive(Debug)]
struct Grounder<'a> {
    domain: &'a Domain,
    problem: &'a Problem,
    objects: Vec<&'a TypedName>,
    object_idx: HashMap<&'a str, u32>,
    predicate_idx: HashMap<&'a str, u32>,
    /// Predicates that some effect deletes.
    deleted: BTreeSet<&'a str>,
    facts: Facts,
    reached: Reached,
    waiting: Vec<Waiting>,
    n_bindings: usize,
    progressed: bool,
}

impl<'a> Grounder<'a> {
    fn new(domain: &'a Domain, problem: &'a Problem) -> Self {
        let objects: Vec<_> = domain.constants().iter().chain(problem.objects()).collect();
        let numbered = |names: Vec<&'a str>| (0u32..).zip(names).map(|(i, n)| (n, i)).collect();
        let effects = domain
            .operators()
            .iter()
            .flat_map(Operator::outcomes)
            .flat_map(|o| &o.effects);
        let mut grounder = Self {
            domain,
            problem,
            object_idx: numbered(objects.iter().map(|o| o.name.as_str()).collect()),
            predicate_idx: numbered(
                domain
                    .predicates()
                    .iter()
                    .map(|p| p.name.as_str())
                    .collect(),
            ),
            objects,
            deleted: effects
                .filter(|e| !e.adds)
                .map(|e| e.atom.symbol.as_str())
                .collect(),
            facts: Facts::default(),
            reached: Reached::default(),
            waiting: Vec::new(),
            n_bindings: 0,
            progressed: false,
        };
        for atom in problem.init() {
            let id = grounder.fact(atom);
            grounder.facts.initially[id] = true;
            grounder.reach(id);
        }
        grounder
    }

    fn row(&self, atom: &Atom) -> Row {
        std::iter::once(self.predicate_idx[atom.symbol.as_str()])
            .chain(atom.args.iter().map(|arg| self.object_idx[arg.as_str()]))
            .collect()
    }

    fn fact(&mut self, atom: &Atom) -> FactId {
        let row = self.row(atom);
        self.facts.id(row)
    }

    fn reach(&mut self, id: FactId) {
        if !self.facts.reached[id] {
            self.facts.reached[id] = true;
            self.reached.push(self.facts.row(id).clone(), id);
        }
    }

    /// The positive atoms among the conjuncts of the precondition.
    fn patterns(&self, operator: &Operator) -> Vec<Pattern> {
        let arg = |term: &Term| match term {
            Term::Object(name) => Arg::Object(self.object_idx[name.as_str()]),
            Term::Variable(name) => Arg::Parameter(
                operator
                    .parameters()
                    .iter()
                    .position(|p| p.name == *name)
                    .unwrap_or_default(),
            ),
        };
        let conjuncts = operator.precondition().conjuncts().into_iter();
        conjuncts
            .filter_map(|part| match part {
                Condition::Atom(atom) => Some(Pattern {
                    predicate: self.predicate_idx[atom.symbol.as_str()],
                    args: atom.terms.iter().map(arg).collect(),
                }),
                _ => None,
            })
            .collect()
    }

    /// New bindings of the operator's parameters by type and by join; `None` where there are too many.
    fn bindings(
        &mut self,
        operator: &Operator,
        patterns: &[Pattern],
        first_new: usize,
        first_round: bool,
    ) -> Option<Vec<Binding>> {
        let mut complete: Vec<Binding> = Vec::new();
        let budget = N_BINDINGS_MAX.saturating_sub(self.n_bindings);
        let mut take = |partial: &[Option<u32>]| {
            self.complete(operator, partial, budget, &mut complete);
            complete.len() <= budget
        };
        let n_parameters = operator.parameters().len();
        if patterns.is_empty() {
            if first_round {
                take(&vec![None; n_parameters]);
            }
        } else {
            let join = Join {
                patterns,
                reached: &self.reached,
                first_new,
            };
            join.run(n_parameters, &mut take);
        }
        if complete.len() > budget {
            return None;
        }
        self.n_bindings += complete.len();
        Some(complete)
    }

    /// Fills unbound parameters with every object of their type; drops bindings of wrong types.
    fn complete(
        &self,
        operator: &Operator,
        partial: &[Option<u32>],
        budget: usize,
        complete: &mut Vec<Binding>,
    ) {
        let mut bindings = vec![Binding::new()];
        for (parameter, bound) in operator.parameters().iter().zip(partial) {
            let fits = |o: &&&TypedName| self.domain.is_subtype(&o.type_name, &parameter.type_name);
            let candidates: Vec<_> = match bound {
                Some(idx) => self.objects[*idx as usize..=*idx as usize]
                    .iter()
                    .filter(fits)
                    .collect(),
                None => self.objects.iter().filter(fits).collect(),
            };
            bindings = bindings
                .iter()
                .flat_map(|binding| {
                    candidates.iter().map(|object| {
                        let mut extended = binding.clone();
                        extended.insert(parameter.name.clone(), object.name.clone());
                        extended
                    })
                })
                .take(budget + 1)
                .collect();
        }
        complete.extend(bindings);
    }

    fn instantiate(&mut self, operator: &Operator, binding: &Binding) -> Result<(), ActionFault> {
        let precondition = self.formula(operator.precondition(), binding, false);
        if precondition == Formula::False {
            return Ok(());
        }
        let outcome = &operator.outcomes()[0];
        let mut effects = Vec::new();
        for effect in &outcome.effects {
            for inner in self.quantified(&effect.forall, binding) {
                let when = self.formula(&effect.when, &inner, false);
                if let Some(atom) = effect.atom.ground(&inner) {
                    effects.push(GroundEffect {
                        when,
                        fact: self.fact(&atom),
                        adds: effect.adds,
                    });
                }
            }
        }
        let cost = self.cost(&outcome.cost, binding)?;
        let args = operator
            .parameters()
            .iter()
            .map(|p| binding[&p.name].clone());
        let action = GroundAction::new(operator.name(), args);
        let fired = vec![false; effects.len()];
        let instance = Instance {
            action,
            precondition,
            effects,
            cost,
        };
        self.waiting.push(Waiting {
            instance,
            runs: false,
            fired,
        });
        Ok(())
    }

    fn cost(&self, cost: &Cost, binding: &Binding) -> Result<f64, ActionFault> {
        match cost {
            Cost::Constant(value) => Ok(*value),
            Cost::Function(function) => function
                .ground(binding)
                .and_then(|atom| self.problem.values().get(&atom).copied())
                .ok_or_else(|| ActionFault::NoValue {
                    function: function.substitute(binding).to_string(),
                }),
        }
    }

    /// Lets every waiting part take effect whose conditions have become possible.
    fn fire(&mut self) {
        let mut waiting = std::mem::take(&mut self.waiting);
        for part in &mut waiting {
            if !part.runs {
                part.runs = self.is_possible(&part.instance.precondition);
                self.progressed |= part.runs;
            }
            if !part.runs {
                continue;
            }
            for (effect, fired) in part.instance.effects.iter().zip(&mut part.fired) {
                if !*fired && effect.adds && self.is_possible(&effect.when) {
                    *fired = true;
                    self.reach(effect.fact);
                }
            }
        }
        self.waiting = waiting;
    }

    fn is_possible(&self, formula: &Formula) -> bool {
        formula.is_possible(&|fact, positive| {
            // A fact can be false at some time unless it holds at first and nothing deletes its kind.
            let predicate = self.facts.row(fact)[0] as usize;
            let name = self.domain.predicates()[predicate].name.as_str();
            match positive {
                true => self.facts.reached[fact],
                false => !self.facts.initially[fact] || self.deleted.contains(name),
            }
        })
    }

    /// The condition over facts, quantifiers opened, equalities decided, negations at the leaves.
    fn formula(&mut self, condition: &Condition, binding: &Binding, negated: bool) -> Formula {
        match condition {
            Condition::Atom(atom) => self.literal(atom, binding, !negated),
            Condition::Equal(a, b) => {
                let equal = a.substitute(binding) == b.substitute(binding);
                if equal == negated {
                    Formula::False
                } else {
                    Formula::True
                }
            }
            Condition::Not(inner) => self.formula(inner, binding, !negated),
            Condition::And(parts) => {
                let parts: Vec<_> = parts
                    .iter()
                    .map(|p| self.formula(p, binding, negated))
                    .collect();
                joined(parts, !negated)
            }
            Condition::Or(parts) => {
                let parts: Vec<_> = parts
                    .iter()
                    .map(|p| self.formula(p, binding, negated))
                    .collect();
                joined(parts, negated)
            }
            Condition::Imply(premise, conclusion) => {
                let premise = self.formula(premise, binding, !negated);
                let conclusion = self.formula(conclusion, binding, negated);
                joined(vec![premise, conclusion], negated)
            }
            Condition::Forall(variables, inner) => {
                let parts = self.each(variables, inner, binding, negated);
                joined(parts, !negated)
            }
            Condition::Exists(variables, inner) => {
                let parts = self.each(variables, inner, binding, negated);
                joined(parts, negated)
            }
        }
    }

    fn each(
        &mut self,
        variables: &[TypedName],
        inner: &Condition,
        binding: &Binding,
        negated: bool,
    ) -> Vec<Formula> {
        let bindings = self.quantified(variables, binding);
        bindings
            .iter()
            .map(|b| self.formula(inner, b, negated))
            .collect()
    }

    fn literal(&mut self, atom: &AtomPattern, binding: &Binding, positive: bool) -> Formula {
        match atom.ground(binding) {
            Some(atom) => Formula::Literal(self.fact(&atom), positive),
            None => Formula::False,
        }
    }

    fn quantified(&self, variables: &[TypedName], outer: &Binding) -> Vec<Binding> {
        let mut bindings = vec![outer.clone()];
        for variable in variables {
            let fits = |o: &&&TypedName| self.domain.is_subtype(&o.type_name, &variable.type_name);
            let candidates: Vec<_> = self.objects.iter().filter(fits).collect();
            bindings = bindings
                .iter()
                .flat_map(|binding| {
                    candidates.iter().map(|object| {
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

fn joined(parts: Vec<Formula>, conjunction: bool) -> Formula {
    if conjunction {
        Formula::and(parts)
    } else {
        Formula::or(parts)
    }
}
