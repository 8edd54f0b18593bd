//! What came of a run: the document of `--json`, the words for people, and the report.

use std::path::Path;

use factotum_agent::RunReport;
use factotum_experiments::report::{ExecutedStep, Fact, Report, Verdict};
use factotum_experiments::run_folder::Manifest;
use serde_json::{Value, json};

use crate::audience::Told;

/// What came of a run, as physics and clocks say.
#[derive(Debug, Clone)]
pub(crate) struct RunResult {
    /// Whether one chore was asked for: its document stands alone.
    pub(crate) is_single: bool,
    pub(crate) chores: Vec<ChoreResult>,
    pub(crate) known: Known,
    /// How well the free space of the map agrees with the home's, 0 to 1.
    pub(crate) map_iou: f64,
    /// Robot time spent exploring, seconds.
    pub(crate) explore_secs: f64,
    /// Robot time in all, seconds.
    pub(crate) sim_secs: f64,
    pub(crate) wall_secs: f64,
    pub(crate) peak_rss_mb: Option<f64>,
    /// What the fault asked for did, once it happened.
    pub(crate) fault: Option<String>,
    /// How often the run was gone on with after a crash or a stop.
    pub(crate) n_resumed: u32,
}

/// What came of one chore.
#[derive(Debug, Clone)]
pub(crate) struct ChoreResult {
    pub(crate) goal: String,
    pub(crate) report: RunReport,
    /// The judge's word.
    pub(crate) achieved: bool,
    /// What the judge measured, in words.
    pub(crate) measured: String,
}

/// How much of the home is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    pub(crate) classes: usize,
    pub(crate) objects: usize,
    pub(crate) nodes: usize,
    pub(crate) edges: usize,
}

impl RunResult {
    /// Whether every chore is achieved.
    pub(crate) fn is_achieved(&self) -> bool {
        !self.chores.is_empty() && self.chores.iter().all(|chore| chore.achieved)
    }

    /// A sentence a chore.
    pub(crate) fn summary(&self) -> String {
        let sentence = |chore: &ChoreResult| match &chore.report.reason {
            Some(reason) => format!("{}: {}; {reason}", chore.goal, chore.measured),
            None => format!("{}: {}", chore.goal, chore.measured),
        };
        self.chores
            .iter()
            .map(sentence)
            .collect::<Vec<_>>()
            .join(". ")
    }

    /// The document of `--json`: of the chore asked for, or of all of them.
    pub(crate) fn document(&self) -> Value {
        let mut chores: Vec<Value> = self
            .chores
            .iter()
            .map(|chore| self.chore_document(chore))
            .collect();
        if self.is_single && chores.len() == 1 {
            return chores.swap_remove(0);
        }
        json!({
            "achieved": self.is_achieved(),
            "chores": chores,
            "explore_secs": rounded(self.explore_secs),
            "wall_secs": rounded(self.wall_secs),
            "sim_secs": rounded(self.sim_secs),
            "peak_rss_mb": self.peak_rss_mb,
            "resumed": self.n_resumed,
        })
    }

    /// Robot time of a chore counts the exploring before it.
    fn chore_document(&self, chore: &ChoreResult) -> Value {
        let report = &chore.report;
        let Known {
            classes,
            objects,
            nodes,
            edges,
        } = self.known;
        json!({
            "achieved": chore.achieved,
            "goal": chore.goal,
            "measured": chore.measured,
            "reason": report.reason,
            "fault": self.fault,
            "plan": report.plan.iter().map(|step| json!({"action": step.name, "args": step.args})).collect::<Vec<_>>(),
            "executed": report.executed.iter().map(|step| json!({
                "action": step.action, "args": step.args, "outcome": step.outcome,
                "attempts": step.attempts, "sim_secs": rounded(step.robot_secs), "learned_skill": step.learned,
            })).collect::<Vec<_>>(),
            "replans": report.n_replans,
            "aosm": {"classes": classes, "objects": objects, "nodes": nodes, "edges": edges},
            "map_iou": rounded(self.map_iou),
            "wall_secs": rounded(self.wall_secs),
            "sim_secs": rounded(if self.is_single { self.sim_secs } else { self.explore_secs + report.robot_secs }),
            "peak_rss_mb": self.peak_rss_mb,
            "resumed": self.n_resumed,
        })
    }

    /// The answer in words.
    pub(crate) fn text(&self) -> String {
        let mut lines: Vec<String> = Vec::new();
        for chore in &self.chores {
            let mark = if chore.achieved {
                "achieved"
            } else {
                "NOT achieved"
            };
            lines.push(format!("{:<20} {mark}: {}", chore.goal, chore.measured));
            lines.extend(
                chore
                    .report
                    .reason
                    .iter()
                    .map(|reason| format!("  {reason}")),
            );
            for step in &chore.report.executed {
                let args = step.args.join(" ");
                let by = step.learned.as_ref();
                let by = by.map_or_else(String::new, |skill| format!(" (learned skill {skill})"));
                lines.push(format!(
                    "  {:<10} {args:<28} {:6.1} s  {}{by}",
                    step.action, step.robot_secs, step.outcome
                ));
            }
        }
        lines.push(format!(
            "{:.1} s of the robot's time in {:.1} s",
            self.sim_secs, self.wall_secs
        ));
        lines.join("\n")
    }

    /// The report of the run folder.
    pub(crate) fn report(&self, told: Told, manifest: &Manifest, robot: &Path) -> Report {
        let goals: Vec<String> = self
            .chores
            .iter()
            .map(|chore| chore.goal.replace('-', " "))
            .collect();
        let executed = self
            .chores
            .iter()
            .flat_map(|chore| &chore.report.executed)
            .map(|step| ExecutedStep {
                action: step.action.clone(),
                args: step.args.clone(),
                is_done: step.is_done,
                reason: match (&step.learned, step.is_done) {
                    (Some(skill), true) => format!("by the learned skill {skill}"),
                    (None, true) => String::new(),
                    (_, false) => step.outcome.clone(),
                },
                attempts: u32::try_from(step.attempts).unwrap_or(u32::MAX),
                robot_secs: step.robot_secs,
            });
        let mut figures = vec![
            Fact::new("Objects", self.known.objects),
            Fact::new("Navigation regions", self.known.nodes),
            Fact::new("Ways between them", self.known.edges),
            Fact::new(
                "Map agreement (IoU of free space)",
                format!("{:.2}", self.map_iou),
            ),
            Fact::new("Robot time", format!("{:.1} s", self.sim_secs)),
            Fact::new("Wall time", format!("{:.1} s", self.wall_secs)),
        ];
        figures.extend(
            self.peak_rss_mb
                .map(|mb| Fact::new("Peak memory", format!("{mb:.0} MB"))),
        );
        let mut facts = vec![
            Fact::new("Scene", &manifest.scene),
            Fact::new("Robot", robot.display()),
            Fact::new("Seed", manifest.seed),
            Fact::new("Command", manifest.command.join(" ")),
            Fact::new("Program", &manifest.program),
            Fact::new("Started", &manifest.started),
        ];
        if self.n_resumed > 0 {
            let times = if self.n_resumed == 1 { "time" } else { "times" };
            facts.push(Fact::new("Resumed", format!("{} {times}", self.n_resumed)));
        }
        facts.extend(self.fault.iter().map(|fault| Fact::new("Fault", fault)));
        Report {
            title: goals.join(", "),
            verdict: if self.is_achieved() {
                Verdict::Achieved
            } else {
                Verdict::NotAchieved
            },
            summary: self.summary(),
            facts,
            map: told.map,
            aosm: told.aosm,
            way_driven: told.way_driven,
            plan: told.plan,
            executed: executed.collect(),
            timings: told.timings,
            figures,
            events: told.events,
        }
    }
}

fn rounded(secs: f64) -> f64 {
    (secs * 100.0).round() / 100.0
}

/// The most memory the process has held, in MB, where the system tells.
pub(crate) fn peak_rss_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some((kib / 102.4).round() / 10.0)
}
