//! The embedded planner.

use super::{Limits, PlanOutcome, Planner, PlannerError};
use crate::operator::{Domain, Problem};

/// The embedded planner `ferroplan`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ferroplan;

impl Planner for Ferroplan {
    fn name(&self) -> &str {
        "ferroplan"
    }

    fn solve(&self, _: &Domain, _: &Problem, _: &Limits) -> Result<PlanOutcome, PlannerError> {
        Err(PlannerError::Failed {
            planner: self.name().to_owned(),
            reason: "not built yet".to_owned(),
        })
    }
}
