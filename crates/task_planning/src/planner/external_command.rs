//! Any PDDL planner that can be called as a command.

use std::path::PathBuf;
use std::time::Instant;

use super::child_process::{Ended, Invocation, run};
use super::plan_file::read_plan;
use super::scratch::Scratch;
use super::task_check::{accept, check_task};
use super::{Limit, Limits, PlanOutcome, PlanStats, Planner, PlannerError};
use crate::operator::{Domain, Problem};

/// A planner called as a command with files.
///
/// The command is judged by the plan file alone: a plan that validates is a plan. Without one, exit
/// codes in [`unsolvable_exit_codes`](Self::unsolvable_exit_codes) mean that there is none, exit
/// code 0 means that the planner found none, and any other is a failure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExternalCommand {
    /// Name to show and to choose it by.
    pub name: String,
    /// The program: a path, or a name for the system to find.
    pub program: PathBuf,
    /// Its arguments; `{domain}`, `{problem}` and `{plan}` stand for the files' paths.
    pub args: Vec<String>,
    /// Exit codes by which the planner says that it proved the problem unsolvable.
    pub unsolvable_exit_codes: Vec<i32>,
}

impl Planner for ExternalCommand {
    fn name(&self) -> &str {
        &self.name
    }

    fn solve(
        &self,
        domain: &Domain,
        problem: &Problem,
        limits: &Limits,
    ) -> Result<PlanOutcome, PlannerError> {
        let deadline = Instant::now() + limits.time;
        check_task(self.name(), domain, problem)?;
        self.check_program()?;
        let scratch = Scratch::new(self.name(), domain, problem)?;
        let invocation = Invocation {
            planner: self.name(),
            program: &self.program,
            args: self
                .args
                .iter()
                .map(|arg| filled_in(arg, &scratch))
                .collect(),
            work_dir: scratch.path(),
            scratch_dir: scratch.path(),
        };
        let ended = run(&invocation, deadline, limits.memory_mib)?;
        if let Some(text) = scratch.read_plan_file()? {
            let steps = read_plan(self.name(), &text)?;
            return accept(self.name(), domain, problem, &steps, PlanStats::default());
        }
        match ended {
            Ended::TimedOut => Ok(PlanOutcome::LimitReached { limit: Limit::Time }),
            Ended::Exited { status, tail } => match status.code() {
                Some(code) if self.unsolvable_exit_codes.contains(&code) => {
                    Ok(PlanOutcome::Unsolvable {
                        reason: format!("exit code {code}"),
                    })
                }
                Some(0) => Ok(PlanOutcome::Exhausted { reason: tail }),
                _ => Err(PlannerError::Failed {
                    planner: self.name.clone(),
                    reason: format!("{status}: {tail}"),
                }),
            },
        }
    }
}

impl ExternalCommand {
    /// A path must lead to a file; a bare name is for the system to find.
    fn check_program(&self) -> Result<(), PlannerError> {
        if self.program.components().count() == 1 || self.program.is_file() {
            return Ok(());
        }
        Err(PlannerError::Missing {
            planner: self.name.clone(),
            looked_at: vec![self.program.clone()],
            how_to_get: "correct the configured program".to_owned(),
        })
    }
}

fn filled_in(arg: &str, scratch: &Scratch) -> String {
    arg.replace("{domain}", &scratch.domain().to_string_lossy())
        .replace("{problem}", &scratch.problem().to_string_lossy())
        .replace("{plan}", &scratch.plan().to_string_lossy())
}
