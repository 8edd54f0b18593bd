//! Handing a planner the relevant part of a task, ground, and nothing else.
//!
//! 1. [`instances`]: which ground actions could ever run, if deletes did not matter (relaxed
//!    reachability). Arguments come from joining preconditions with reached facts, so objects that no
//!    reachable fact mentions cost nothing.
//! 2. Conditions are simplified by what always or never holds.
//! 3. [`relevance`]: actions and facts that cannot help the goal are dropped, going backwards from it.
//!
//! What is left is a propositional task with neutral names. This keeps large homes tractable for a
//! planner with weak grounding, proves many impossible goals outright and says which part of the goal
//! it is, and leaves no action that both adds and deletes a fact, which ferroplan 0.30 gets wrong
//! where the fact is also read negatively.

mod emit;
mod facts;
mod formula;
mod instances;
mod join;
mod relevance;

use crate::operator::{Domain, GroundAction, OperatorError, Problem};
use crate::validate::ActionFault;

/// What is left of a task.
#[derive(Debug, Clone)]
pub(super) enum Reduction {
    /// A smaller task with the same plans, up to actions that do not help.
    Task(Box<ReducedTask>),
    /// The goal cannot be reached, even if nothing were ever undone.
    Unreachable {
        /// The goal's conjuncts that can never hold, as PDDL.
        conjuncts: Vec<String>,
    },
    /// The task has too many ground actions to be listed.
    TooLarge,
}

/// Why a task could not be reduced.
#[derive(Debug, thiserror::Error)]
pub(super) enum ReductionError {
    /// An action has no cost.
    #[error(transparent)]
    Cost(#[from] ActionFault),
    /// The propositional task did not pass its own checks.
    #[error(transparent)]
    Task(#[from] OperatorError),
}

/// A propositional task and what its operators stand for.
#[derive(Debug, Clone)]
pub(super) struct ReducedTask {
    pub(super) domain: Domain,
    pub(super) problem: Problem,
    actions: Vec<GroundAction>,
}

impl ReducedTask {
    /// The steps in the names of the original task; `None` where a step is not one of this task's.
    pub(super) fn restore(&self, steps: &[GroundAction]) -> Option<Vec<GroundAction>> {
        let original = |step: &GroundAction| {
            let idx: usize = emit::action_idx(&step.name)?;
            self.actions.get(idx).cloned()
        };
        steps.iter().map(original).collect()
    }
}

/// Reduces a deterministic task.
///
/// # Errors
/// A cost reads a function that the problem gives no value.
pub(super) fn reduce(domain: &Domain, problem: &Problem) -> Result<Reduction, ReductionError> {
    let Some(mut ground) = instances::reachable(domain, problem)? else {
        return Ok(Reduction::TooLarge);
    };
    ground.simplify();
    if ground.goal == formula::Formula::False {
        let conjuncts = ground.unreachable_conjuncts(problem);
        return Ok(Reduction::Unreachable { conjuncts });
    }
    relevance::keep_relevant(&mut ground);
    Ok(Reduction::Task(Box::new(emit::emit(&ground, problem)?)))
}

/// A fact as an index into the table of facts.
type FactId = usize;

/// The ground task between the phases.
#[derive(Debug)]
struct GroundTask {
    facts: facts::Facts,
    instances: Vec<Instance>,
    goal: formula::Formula,
    goal_conjuncts: Vec<(String, formula::Formula)>,
}

/// A ground action with its conditions as formulas over facts.
#[derive(Debug)]
struct Instance {
    action: GroundAction,
    precondition: formula::Formula,
    effects: Vec<GroundEffect>,
    cost: f64,
}

/// A ground effect: the fact becomes `adds` where `when` held before.
#[derive(Debug, Clone)]
struct GroundEffect {
    when: formula::Formula,
    fact: FactId,
    adds: bool,
}

impl GroundTask {
    /// Replaces what always or never holds, drops what never runs, and lets adds win over deletes.
    fn simplify(&mut self) {
        let knowledge = self.facts.knowledge(&self.instances);
        for instance in &mut self.instances {
            instance.precondition = instance.precondition.simplified(&knowledge);
            for effect in &mut instance.effects {
                effect.when = effect.when.simplified(&knowledge);
            }
            instance
                .effects
                .retain(|e| e.when != formula::Formula::False);
            adds_win(&mut instance.effects);
        }
        self.instances
            .retain(|i| i.precondition != formula::Formula::False);
        self.goal = self.goal.simplified(&knowledge);
        for (_, conjunct) in &mut self.goal_conjuncts {
            *conjunct = conjunct.simplified(&knowledge);
        }
    }

    fn unreachable_conjuncts(&self, problem: &Problem) -> Vec<String> {
        let never: Vec<_> = self
            .goal_conjuncts
            .iter()
            .filter(|(_, formula)| *formula == formula::Formula::False)
            .map(|(text, _)| text.clone())
            .collect();
        if never.is_empty() {
            vec![problem.goal().to_string()]
        } else {
            never
        }
    }
}

/// A delete happens only where no add of the same fact does.
fn adds_win(effects: &mut Vec<GroundEffect>) {
    let adds: Vec<_> = effects.iter().filter(|e| e.adds).cloned().collect();
    for effect in effects.iter_mut().filter(|e| !e.adds) {
        for add in adds.iter().filter(|add| add.fact == effect.fact) {
            effect.when = formula::Formula::and([effect.when.clone(), add.when.negated()]);
        }
    }
    effects.retain(|e| e.when != formula::Formula::False);
}
