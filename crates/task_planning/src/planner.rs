//! Planners behind one trait: embedded, Fast Downward as a process, or any PDDL command.
//!
//! "No plan" has three faces that must not be confused: the problem is [unsolvable], the planner
//! [gave up](PlanOutcome::Exhausted) without proving that, or a [limit](PlanOutcome::LimitReached)
//! stopped it. A planner that is missing or fails is an error. Every plan is checked by the
//! independent validator before it is returned.
//!
//! [unsolvable]: PlanOutcome::Unsolvable

mod child_process;
mod error;
mod external_command;
mod fast_downward;
mod ferroplan;
mod integer_costs;
mod plan_file;
mod reduction;
mod scratch;
mod task_check;

use std::time::Duration;

pub use error::PlannerError;
pub use external_command::ExternalCommand;
pub use fast_downward::FastDownward;
pub use ferroplan::Ferroplan;

use crate::operator::{Domain, Plan, Problem};

/// A task planner.
pub trait Planner: std::fmt::Debug + Send + Sync {
    /// The planner's name, as a user would choose it.
    fn name(&self) -> &str;

    /// Looks for a plan; a plan that is returned has been validated.
    ///
    /// # Errors
    /// The planner is missing, cannot take this domain, or failed; see [`PlannerError`].
    fn solve(
        &self,
        domain: &Domain,
        problem: &Problem,
        limits: &Limits,
    ) -> Result<PlanOutcome, PlannerError>;
}

/// How good a plan is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlanQuality {
    /// A plan soon; cheap if that is easy.
    #[default]
    Satisficing,
    /// A cheapest plan by the operators' costs, with proof (a shortest one where there are none).
    Optimal,
}

/// What one call may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Wall time, from call to return.
    pub time: Duration,
    /// Address space of each external process in MiB; embedded planners cannot be limited.
    pub memory_mib: u64,
}

impl Default for Limits {
    /// 30 s and 2 GiB: a chore plans in milliseconds, and a person who waits longer wants to be told.
    fn default() -> Self {
        Self {
            time: Duration::from_secs(30),
            memory_mib: 2048,
        }
    }
}

/// Which limit stopped a planner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// [`Limits::time`].
    Time,
    /// [`Limits::memory_mib`].
    Memory,
}

/// What a planner reports about its search; `None` where it does not say.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PlanStats {
    /// Actions after grounding.
    pub n_ground_actions: Option<usize>,
    /// States evaluated.
    pub n_evaluated: Option<usize>,
    /// The planner's own remarks.
    pub notes: Vec<String>,
}

/// How a search ended.
#[derive(Debug, Clone, PartialEq)]
pub enum PlanOutcome {
    /// A validated plan.
    Solved {
        /// The plan.
        plan: Plan,
        /// What the search took.
        stats: PlanStats,
    },
    /// Proven to have no plan.
    Unsolvable {
        /// How it was proven.
        reason: String,
    },
    /// The search ended without a plan and without a proof that there is none.
    Exhausted {
        /// What the planner said.
        reason: String,
    },
    /// A limit stopped the search.
    LimitReached {
        /// Which one.
        limit: Limit,
    },
}

impl PlanOutcome {
    /// The plan, if there is one.
    pub fn plan(&self) -> Option<&Plan> {
        match self {
            Self::Solved { plan, .. } => Some(plan),
            _ => None,
        }
    }
}
