//! The embedded planner: always there, no process, one thread.
//!
//! `ferroplan` is a forward search with the FF heuristic. It gets the [reduced](super::reduction) task
//! as PDDL text. Its satisficing search may end without a plan and without saying whether
//! there is none; then its exact search is asked for a proof with the time that is left.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use ferroplan::{Mode, Options, Solution, SolveError};

use super::reduction::{Reduction, reduce};
use super::task_check::{accept, check_task};
use super::{Limit, Limits, PlanOutcome, PlanQuality, PlanStats, Planner, PlannerError};
use crate::operator::{Domain, GroundAction, Problem};
use crate::pddl::{write_domain, write_problem};

/// The embedded planner `ferroplan`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ferroplan {
    /// How good a plan is asked for.
    pub quality: PlanQuality,
}

impl Planner for Ferroplan {
    fn name(&self) -> &str {
        "ferroplan"
    }

    fn solve(
        &self,
        domain: &Domain,
        problem: &Problem,
        limits: &Limits,
    ) -> Result<PlanOutcome, PlannerError> {
        check_task(self.name(), domain, problem)?;
        let started = Instant::now();
        let reduced = match reduce(domain, problem) {
            Ok(Reduction::Task(task)) => Some(task),
            // Its own grounding may still manage.
            Ok(Reduction::TooLarge) => None,
            Ok(Reduction::Unreachable { conjuncts }) => {
                let reason = format!("no action can ever make {} hold", conjuncts.join(" and "));
                return Ok(PlanOutcome::Unsolvable { reason });
            }
            Err(error) => {
                let (planner, reason) = (self.name().to_owned(), error.to_string());
                return Err(PlannerError::InvalidTask { planner, reason });
            }
        };
        let (given_domain, given_problem) = match &reduced {
            Some(task) => (&task.domain, &task.problem),
            None => (domain, problem),
        };
        let (domain_text, problem_text) =
            (write_domain(given_domain), write_problem(given_problem));
        let ask = |mode| {
            let left = limits.time.saturating_sub(started.elapsed());
            self.ask(&domain_text, &problem_text, mode, left)
        };
        let mut solution = match self.quality {
            PlanQuality::Satisficing => ask(Mode::Ff)?,
            PlanQuality::Optimal => ask(Mode::Optimal)?,
        };
        if !solution.solved && verdict(&solution).is_none() && solution.mode != Mode::Optimal {
            tracing::debug!(notes = ?solution.notes, "no plan and no proof; asking for one");
            solution = ask(Mode::Optimal)?;
        }
        match solution.plan.take() {
            Some(plan) => {
                let steps: Vec<_> = plan
                    .steps
                    .iter()
                    .map(|s| GroundAction::new(&s.action, &s.args))
                    .collect();
                let original = match &reduced {
                    Some(task) => task.restore(&steps),
                    None => Some(steps),
                };
                let steps = original.ok_or_else(|| PlannerError::Failed {
                    planner: self.name().to_owned(),
                    reason: "it returned an action it was not given".to_owned(),
                })?;
                accept(self.name(), domain, problem, &steps, stats(solution))
            }
            None => Ok(verdict(&solution).unwrap_or(PlanOutcome::Exhausted {
                reason: solution.notes.join("; "),
            })),
        }
    }
}

impl Ferroplan {
    fn ask(
        &self,
        domain_text: &str,
        problem_text: &str,
        mode: Mode,
        time: Duration,
    ) -> Result<Solution, PlannerError> {
        let options = Options {
            mode,
            threads: 1,
            wall_ms: Some(u64::try_from(time.as_millis()).unwrap_or(u64::MAX).max(1)),
            ..Options::default()
        };
        // A fault in the planner must not take the executive down with it.
        let solved = catch_unwind(AssertUnwindSafe(|| {
            ferroplan::solve(domain_text, problem_text, &options)
        }));
        let planner = self.name().to_owned();
        match solved {
            Ok(Ok(solution)) => Ok(solution),
            Ok(Err(SolveError::Unsupported(what))) => Err(PlannerError::Unsupported {
                planner,
                what,
                hint: "use another planner".to_owned(),
            }),
            Ok(Err(error)) => Err(PlannerError::InvalidTask {
                planner,
                reason: error.to_string(),
            }),
            Err(_) => Err(PlannerError::Failed {
                planner,
                reason: "it panicked".to_owned(),
            }),
        }
    }
}

/// What the planner's remarks say about a search without a plan: proof, limit, or nothing.
///
/// The remarks are the planner's only channel for this; their wording is pinned with its version.
fn verdict(solution: &Solution) -> Option<PlanOutcome> {
    let note = |marks: &[&str]| {
        solution
            .notes
            .iter()
            .find(|note| marks.iter().any(|mark| note.contains(mark)))
    };
    if let Some(proof) = note(&["unsolvable at grounding", "PROVEN UNSOLVABLE"]) {
        return Some(PlanOutcome::Unsolvable {
            reason: proof.clone(),
        });
    }
    note(&[
        "stopped at the declared budget",
        "inconclusive: wall reached",
    ])
    .map(|_| PlanOutcome::LimitReached { limit: Limit::Time })
}

fn stats(solution: Solution) -> PlanStats {
    PlanStats {
        n_ground_actions: Some(solution.statistics.grounded_actions),
        n_evaluated: Some(solution.statistics.evaluated_states),
        notes: solution.notes,
    }
}
