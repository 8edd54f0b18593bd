//! Why a planner could not be asked.

use std::path::PathBuf;

use crate::validate::PlanFault;

/// Why a planner gave no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlannerError {
    /// The planner is not on this machine.
    #[error(
        "planner `{planner}` not found; looked at {}; {how_to_get}",
        listed(looked_at)
    )]
    Missing {
        /// The planner's name.
        planner: String,
        /// Every place that was tried.
        looked_at: Vec<PathBuf>,
        /// How to install it.
        how_to_get: String,
    },
    /// The planner cannot take this domain or problem.
    #[error("planner `{planner}` cannot take {what}; {hint}")]
    Unsupported {
        /// The planner's name.
        planner: String,
        /// What it cannot take.
        what: String,
        /// What to do about it.
        hint: String,
    },
    /// The problem was made for another domain, or the reduced task is malformed.
    #[error("planner `{planner}` was given an invalid task: {reason}")]
    InvalidTask {
        /// The planner's name.
        planner: String,
        /// What is wrong.
        reason: String,
    },
    /// Its process could not be started, fed or read.
    #[error("planner `{planner}` could not be run: {doing}")]
    Io {
        /// The planner's name.
        planner: String,
        /// What was being done, with the path.
        doing: String,
        /// What the system said.
        #[source]
        source: std::io::Error,
    },
    /// It ended in a way that is neither a plan nor a "no plan".
    #[error("planner `{planner}` failed: {reason}")]
    Failed {
        /// The planner's name.
        planner: String,
        /// Exit status and the end of what it wrote.
        reason: String,
    },
    /// It wrote something that is no plan.
    #[error(
        "planner `{planner}` wrote a plan that cannot be read: line {line}: expected {expected}, got `{got}`"
    )]
    PlanFile {
        /// The planner's name.
        planner: String,
        /// Line number, from 1.
        line: usize,
        /// What was expected.
        expected: String,
        /// What was found.
        got: String,
    },
    /// Its plan does not solve the problem.
    #[error("planner `{planner}` returned a plan that does not solve the problem")]
    InvalidPlan {
        /// The planner's name.
        planner: String,
        /// What is wrong with the plan.
        #[source]
        fault: PlanFault,
    },
}

fn listed(paths: &[PathBuf]) -> String {
    if paths.is_empty() {
        return "no path".to_owned();
    }
    paths
        .iter()
        .map(|p| format!("`{}`", p.display()))
        .collect::<Vec<_>>()
        .join(", ")
}
