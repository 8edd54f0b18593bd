//! Any PDDL planner that can be called as a command.

use std::path::PathBuf;

use super::{Limits, PlanOutcome, Planner, PlannerError};
use crate::operator::{Domain, Problem};

/// A configured PDDL command with placeholders.
#[derive(Debug, Clone)]
pub struct ExternalCommand {
    /// Name to show.
    pub name: String,
    /// The program.
    pub program: PathBuf,
    /// Its arguments; `{domain}`, `{problem}` and `{plan}` stand for files.
    pub args: Vec<String>,
}

impl Planner for ExternalCommand {
    fn name(&self) -> &str {
        &self.name
    }

    fn solve(&self, _: &Domain, _: &Problem, _: &Limits) -> Result<PlanOutcome, PlannerError> {
        Err(PlannerError::Failed {
            planner: self.name.clone(),
            reason: "not built yet".to_owned(),
        })
    }
}
