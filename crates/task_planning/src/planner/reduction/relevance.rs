//! Dropping actions and effects that cannot help the goal.

use super::GroundTask;
use super::formula::Formula;

/// Keeps what the goal depends on, going backwards from it.
///
/// An action helps if it adds a fact that is read positively, or deletes one read negatively, by the
/// goal or by another action that helps. Effects on facts that nothing reads are dropped too.
pub(super) fn keep_relevant(task: &mut GroundTask) {
    let n_facts = task.facts.len();
    let mut wanted = Wanted {
        holds: vec![false; n_facts],
        fails: vec![false; n_facts],
    };
    wanted.add(&task.goal);
    let mut helps = vec![false; task.instances.len()];
    loop {
        let mut grew = false;
        for (instance, helps) in task.instances.iter().zip(&mut helps) {
            if !*helps
                && instance
                    .effects
                    .iter()
                    .any(|e| wanted.is_met_by(e.fact, e.adds))
            {
                *helps = true;
                grew = true;
                wanted.add(&instance.precondition);
            }
            if *helps {
                // Conditions of kept effects are read in both ways: an effect may be wanted or feared.
                for effect in &instance.effects {
                    grew |= wanted.reads(effect.fact) && wanted.add_both(&effect.when);
                }
            }
        }
        if !grew {
            break;
        }
    }
    let mut helps = helps.into_iter();
    task.instances.retain(|_| helps.next().unwrap_or(false));
    for instance in &mut task.instances {
        instance.effects.retain(|effect| wanted.reads(effect.fact));
    }
}

/// Facts that something reads.
#[derive(Debug)]
struct Wanted {
    /// Read positively.
    holds: Vec<bool>,
    /// Read negatively.
    fails: Vec<bool>,
}

impl Wanted {
    fn add(&mut self, formula: &Formula) {
        formula.literals(&mut |fact, positive| {
            let list = if positive {
                &mut self.holds
            } else {
                &mut self.fails
            };
            list[fact] = true;
        });
    }

    /// Adds the formula's facts both ways; true if any is new.
    fn add_both(&mut self, formula: &Formula) -> bool {
        let mut grew = false;
        formula.literals(&mut |fact, _| {
            grew |= !(self.holds[fact] && self.fails[fact]);
            self.holds[fact] = true;
            self.fails[fact] = true;
        });
        grew
    }

    fn is_met_by(&self, fact: usize, adds: bool) -> bool {
        if adds {
            self.holds[fact]
        } else {
            self.fails[fact]
        }
    }

    fn reads(&self, fact: usize) -> bool {
        self.holds[fact] || self.fails[fact]
    }
}
