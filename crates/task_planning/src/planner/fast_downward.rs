//! Fast Downward as a process (Helmert, "The Fast Downward Planning System", JAIR 26, 2006).
//!
//! It is GPL, so it is never linked, only called. Two layouts are known:
//!
//! - the PyPI wheel `up-fast-downward`: its translator and its search binary are called one after the
//!   other, which saves the start of its driver (about 0.05 s a call);
//! - a driver script `fast-downward.py` or `fast-downward`, as a source build or a package has it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::child_process::{Ended, Invocation, run};
use super::integer_costs::with_integer_costs;
use super::plan_file::read_plan;
use super::scratch::Scratch;
use super::task_check::{accept, check_task};
use super::{Limit, Limits, PlanOutcome, PlanQuality, PlanStats, Planner, PlannerError};
use crate::operator::{Domain, Problem};

const NAME: &str = "fast-downward";

const HOW_TO_GET: &str =
    "install it with `pip install up-fast-downward`, or put `fast-downward.py` on the PATH";

/// Folders of the wheel, below the `site-packages` it is installed in.
const WHEEL_BIN: &str = "up_fast_downward/downward/builds/release/bin";

/// Names of the driver script.
const DRIVERS: [&str; 2] = ["fast-downward.py", "fast-downward"];

/// Greedy search with the FF and landmark heuristics and their preferred operators: the first
/// iteration of LAMA (Richter & Westphal, JAIR 39, 2010), in the syntax of release 26.
const SEARCH_LAMA_FIRST: &str = "let(hlm, eval_modify_costs(landmark_sum(\
    lm_factory=lm_reasonable_orders_hps(lm_rhw()),pref=false),cost_type=one),\
    let(hff, eval_modify_costs(ff(),cost_type=one),\
    lazy_greedy([hff,hlm],preferred=[hff,hlm],cost_type=one,reopen_closed=false)))";

/// A* with the landmark-cut heuristic (Helmert & Domshlak, ICAPS 2009).
const SEARCH_ASTAR_LMCUT: &str = "astar(lmcut())";

/// Fast Downward, found on this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FastDownward {
    installation: Installation,
    python: PathBuf,
    quality: PlanQuality,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Installation {
    /// The folder with `downward` and the package `fast_downward.translate`.
    Wheel(PathBuf),
    /// The driver script.
    Driver(PathBuf),
}

impl FastDownward {
    /// Looks for Fast Downward at the candidates, in order.
    ///
    /// A candidate may be a folder of the PATH or a source build (with the driver script in it), a
    /// `site-packages` folder, the root of a virtual environment, or the driver script itself. The
    /// environment is the caller's to read.
    ///
    /// # Errors
    /// [`PlannerError::Missing`] with all candidates.
    pub fn discover(candidates: &[PathBuf]) -> Result<Self, PlannerError> {
        candidates
            .iter()
            .find_map(|candidate| Self::at(candidate))
            .ok_or_else(|| PlannerError::Missing {
                planner: NAME.to_owned(),
                looked_at: candidates.to_vec(),
                how_to_get: HOW_TO_GET.to_owned(),
            })
    }

    /// The same planner, asked for plans of another quality.
    pub fn with_quality(self, quality: PlanQuality) -> Self {
        Self { quality, ..self }
    }

    /// The same planner with another Python interpreter for its translator (default `python3`, or
    /// that of the virtual environment it was found in).
    pub fn with_python(self, python: impl Into<PathBuf>) -> Self {
        Self {
            python: python.into(),
            ..self
        }
    }

    fn at(candidate: &Path) -> Option<Self> {
        let found = |installation, python: Option<PathBuf>| Self {
            installation,
            python: python.unwrap_or_else(|| PathBuf::from("python3")),
            quality: PlanQuality::Satisficing,
        };
        let is_driver = |path: &Path| {
            path.is_file()
                && path
                    .file_name()
                    .is_some_and(|n| DRIVERS.iter().any(|d| n == *d))
        };
        if is_driver(candidate) {
            return Some(found(Installation::Driver(candidate.to_owned()), None));
        }
        if let Some(bin) = wheel_in(candidate) {
            return Some(found(Installation::Wheel(bin), None));
        }
        if let Some(bin) = site_packages(candidate)
            .iter()
            .find_map(|dir| wheel_in(dir))
        {
            let python = candidate.join("bin/python3");
            return Some(found(
                Installation::Wheel(bin),
                python.is_file().then_some(python),
            ));
        }
        let driver = DRIVERS
            .iter()
            .map(|name| candidate.join(name))
            .find(|p| is_driver(p))?;
        Some(found(Installation::Driver(driver), None))
    }
}

/// The wheel's folder of binaries, where `site_packages` holds the wheel.
fn wheel_in(site_packages: &Path) -> Option<PathBuf> {
    let bin = site_packages.join(WHEEL_BIN);
    bin.join("downward").is_file().then_some(bin)
}

/// The `lib/python3.X/site-packages` folders of a virtual environment, in order.
fn site_packages(root: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root.join("lib"))
        .into_iter()
        .flatten()
        .flatten();
    let mut dirs: Vec<_> = entries
        .filter(|entry| entry.file_name().to_string_lossy().starts_with("python3"))
        .map(|entry| entry.path().join("site-packages"))
        .collect();
    dirs.sort();
    dirs
}

impl Planner for FastDownward {
    fn name(&self) -> &str {
        NAME
    }

    fn solve(
        &self,
        domain: &Domain,
        problem: &Problem,
        limits: &Limits,
    ) -> Result<PlanOutcome, PlannerError> {
        let deadline = Instant::now() + limits.time;
        check_task(NAME, domain, problem)?;
        let (whole_domain, whole_problem) =
            with_integer_costs(domain, problem).map_err(|error| PlannerError::InvalidTask {
                planner: NAME.to_owned(),
                reason: error.to_string(),
            })?;
        let scratch = Scratch::new(NAME, &whole_domain, &whole_problem)?;
        let mut verdict = None;
        for invocation in self.invocations(&scratch, limits.time) {
            let ended = run(&invocation, deadline, limits.memory_mib)?;
            verdict = judge(&ended)?;
            if verdict.is_some() {
                break;
            }
        }
        // A limit may strike after a plan was written; the plan counts.
        match (scratch.read_plan_file()?, verdict) {
            (Some(text), _) => {
                let steps = read_plan(NAME, &text)?;
                accept(NAME, domain, problem, &steps, PlanStats::default())
            }
            (None, Some(outcome)) => Ok(outcome),
            (None, None) => Err(PlannerError::Failed {
                planner: NAME.to_owned(),
                reason: "it reported success and wrote no plan".to_owned(),
            }),
        }
    }
}

impl FastDownward {
    /// The processes to run, one after the other.
    fn invocations<'a>(&'a self, scratch: &'a Scratch, time: Duration) -> Vec<Invocation<'a>> {
        let text = |path: PathBuf| path.to_string_lossy().into_owned();
        let (domain, problem) = (text(scratch.domain()), text(scratch.problem()));
        let plan = text(scratch.plan());
        let sas = text(scratch.path().join("task.sas"));
        let seconds = time.as_secs().max(1).to_string();
        let search = match self.quality {
            PlanQuality::Satisficing => SEARCH_LAMA_FIRST,
            PlanQuality::Optimal => SEARCH_ASTAR_LMCUT,
        };
        let call = |program: &'a Path, work_dir: &'a Path, args: Vec<String>| Invocation {
            planner: NAME,
            program,
            args,
            work_dir,
            scratch_dir: scratch.path(),
        };
        let strings = |args: &[&str]| args.iter().map(|arg| (*arg).to_owned()).collect();
        match &self.installation {
            Installation::Wheel(bin) => vec![
                call(
                    &self.python,
                    bin,
                    strings(&[
                        "-m",
                        "fast_downward.translate",
                        &domain,
                        &problem,
                        "--sas-file",
                        &sas,
                    ]),
                ),
                call(
                    Path::new("/bin/sh"),
                    bin,
                    // The search reads its task from standard input.
                    strings(&[
                        "-c",
                        "exec ./downward --internal-plan-file \"$1\" --search \"$2\" < \"$3\"",
                        "downward",
                        &plan,
                        search,
                        &sas,
                    ]),
                ),
            ],
            Installation::Driver(script) => {
                let alias = match self.quality {
                    PlanQuality::Satisficing => "lama-first",
                    PlanQuality::Optimal => "seq-opt-lmcut",
                };
                let mut args: Vec<String> = strings(&["--alias", alias, "--plan-file", &plan]);
                args.extend(["--overall-time-limit".to_owned(), seconds]);
                args.extend([domain, problem]);
                if script.extension().is_some_and(|e| e == "py") {
                    args.insert(0, text(script.clone()));
                    vec![call(&self.python, scratch.path(), args)]
                } else {
                    vec![call(script, scratch.path(), args)]
                }
            }
        }
    }
}

/// Reads Fast Downward's exit codes (its documentation, "Exit codes"); `None` lets the next process run.
fn judge(ended: &Ended) -> Result<Option<PlanOutcome>, PlannerError> {
    let Ended::Exited { status, tail } = ended else {
        return Ok(Some(PlanOutcome::LimitReached { limit: Limit::Time }));
    };
    let limit = |limit| Ok(Some(PlanOutcome::LimitReached { limit }));
    match status.code() {
        Some(0..=3) => Ok(None),
        Some(code @ (10 | 11)) => Ok(Some(PlanOutcome::Unsolvable {
            reason: format!("Fast Downward proved it (exit code {code})"),
        })),
        Some(12 | 13) => Ok(Some(PlanOutcome::Exhausted {
            reason: "the search is incomplete and found no plan".to_owned(),
        })),
        Some(20 | 22 | 24) => limit(Limit::Memory),
        Some(21 | 23) => limit(Limit::Time),
        Some(34 | 37) => Err(PlannerError::Unsupported {
            planner: NAME.to_owned(),
            what: "a construct of this task with this search".to_owned(),
            hint: "ask for a satisficing plan or use another planner".to_owned(),
        }),
        _ => Err(PlannerError::Failed {
            planner: NAME.to_owned(),
            reason: format!("{status}: {tail}"),
        }),
    }
}
