//! The folder in which a planner's process finds its task and leaves its plan.

use std::path::{Path, PathBuf};

use super::PlannerError;
use crate::operator::{Domain, Problem};
use crate::pddl::{write_domain, write_problem};

/// A temporary folder with `domain.pddl` and `problem.pddl`, removed when dropped.
#[derive(Debug)]
pub(super) struct Scratch {
    planner: String,
    dir: tempfile::TempDir,
}

impl Scratch {
    pub(super) fn new(
        planner: &str,
        domain: &Domain,
        problem: &Problem,
    ) -> Result<Self, PlannerError> {
        let dir = tempfile::Builder::new()
            .prefix("factotum-plan-")
            .tempdir()
            .map_err(|source| {
                let doing = "making a temporary folder".to_owned();
                PlannerError::Io {
                    planner: planner.to_owned(),
                    doing,
                    source,
                }
            })?;
        let scratch = Self {
            planner: planner.to_owned(),
            dir,
        };
        scratch.write(&scratch.domain(), &write_domain(domain))?;
        scratch.write(&scratch.problem(), &write_problem(problem))?;
        Ok(scratch)
    }

    pub(super) fn path(&self) -> &Path {
        self.dir.path()
    }

    pub(super) fn domain(&self) -> PathBuf {
        self.path().join("domain.pddl")
    }

    pub(super) fn problem(&self) -> PathBuf {
        self.path().join("problem.pddl")
    }

    pub(super) fn plan(&self) -> PathBuf {
        self.path().join("plan.txt")
    }

    fn write(&self, path: &Path, text: &str) -> Result<(), PlannerError> {
        std::fs::write(path, text)
            .map_err(|source| self.io(format!("writing {}", path.display()), source))
    }

    /// The plan file's text; `None` where there is none.
    pub(super) fn read_plan_file(&self) -> Result<Option<String>, PlannerError> {
        let path = self.plan();
        match std::fs::read_to_string(&path) {
            Ok(text) => Ok(Some(text)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(self.io(format!("reading {}", path.display()), source)),
        }
    }

    fn io(&self, doing: String, source: std::io::Error) -> PlannerError {
        PlannerError::Io {
            planner: self.planner.clone(),
            doing,
            source,
        }
    }
}
