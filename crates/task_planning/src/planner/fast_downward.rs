//! Fast Downward as a process.

use std::path::PathBuf;

use super::{Limits, PlanOutcome, Planner, PlannerError};
use crate::operator::{Domain, Problem};

/// What Fast Downward searches for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FastDownwardSearch {
    /// A plan, fast (`lama-first`).
    #[default]
    Satisficing,
    /// A cheapest plan (A* with landmark-cut).
    Optimal,
}

/// Fast Downward, run as a process.
#[derive(Debug, Clone)]
pub struct FastDownward {
    #[expect(dead_code, reason = "filled in next")]
    binary: PathBuf,
}

impl FastDownward {
    /// Looks for Fast Downward in the candidate folders, in order.
    ///
    /// # Errors
    /// It is in none of them.
    pub fn discover(candidates: &[PathBuf]) -> Result<Self, PlannerError> {
        Err(PlannerError::Missing {
            planner: "fast-downward".to_owned(),
            looked_at: candidates.to_vec(),
            how_to_get: "install it with `pip install up-fast-downward`".to_owned(),
        })
    }
}

impl Planner for FastDownward {
    fn name(&self) -> &str {
        "fast-downward"
    }

    fn solve(&self, _: &Domain, _: &Problem, _: &Limits) -> Result<PlanOutcome, PlannerError> {
        Err(PlannerError::Failed {
            planner: self.name().to_owned(),
            reason: "not built yet".to_owned(),
        })
    }
}
