//! What came of the grid, as a table with intervals.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use factotum_skills::cip::setting::Ablation;
use serde::Serialize;

use super::{CellResult, MeanInterval, Measure};

/// The table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// Cells with a result.
    pub n_cells: usize,
    /// Those that ended early.
    pub failed: Vec<FailedCell>,
    /// A line for each task and setting.
    pub entries: Vec<Entry>,
    /// Each measure of a setting minus that of another, by seeds that both have.
    pub differences: Vec<Difference>,
}

/// A cell that ended early.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FailedCell {
    /// Task.
    pub task: String,
    /// Setting.
    pub ablation: Ablation,
    /// Seed.
    pub seed: u64,
    /// The command that failed.
    pub command: String,
    /// Its exit code; nothing when a signal ended it.
    pub exit_code: Option<i32>,
}

/// What a setting does on a task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Task.
    pub task: String,
    /// Setting.
    pub ablation: Ablation,
    /// Cells with a result.
    pub n_cells: usize,
    /// Those that ended early.
    pub n_failed: usize,
    /// Most training episodes of a cell.
    pub n_episodes: u64,
    /// Means over the seeds.
    pub measures: BTreeMap<Measure, MeanInterval>,
}

/// How much more a setting has of something than another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Task.
    pub task: String,
    /// The setting.
    pub ablation: Ablation,
    /// The other.
    pub minus: Ablation,
    /// Of what.
    pub measure: Measure,
    /// Mean over the seeds that both have.
    pub interval: MeanInterval,
}

/// The cells of a task and a setting.
pub(super) fn group<'a>(
    cells: &'a [CellResult],
    task: &str,
    ablation: Ablation,
) -> Vec<&'a CellResult> {
    cells
        .iter()
        .filter(|cell| cell.task == task && cell.ablation == ablation)
        .collect()
}

/// The tasks of some cells, by name.
pub(super) fn tasks(cells: &[CellResult]) -> BTreeSet<&str> {
    cells.iter().map(|cell| cell.task.as_str()).collect()
}

/// The setting that another adds one part to, or changes one part of.
fn base(ablation: Ablation) -> Option<Ablation> {
    match ablation {
        Ablation::Unstructured => None,
        Ablation::Head => Some(Ablation::Unstructured),
        Ablation::Safety => Some(Ablation::Head),
        Ablation::Mv => Some(Ablation::Safety),
        Ablation::Cip => Some(Ablation::Mv),
        Ablation::HardGuard | Ablation::Fast => Some(Ablation::Cip),
    }
}

impl Table {
    /// The table of some cells, each there once.
    #[must_use]
    pub fn of(cells: &[CellResult]) -> Self {
        let mut entries = Vec::new();
        let mut differences = Vec::new();
        for task in tasks(cells) {
            for ablation in Ablation::ALL {
                let here = group(cells, task, ablation);
                if here.is_empty() {
                    continue;
                }
                entries.push(Entry::of(task, ablation, &here));
                for minus in Ablation::ALL
                    .into_iter()
                    .take_while(|&other| other != ablation)
                {
                    let there = group(cells, task, minus);
                    let of = |measure: Measure| {
                        Some(Difference {
                            task: task.to_owned(),
                            ablation,
                            minus,
                            measure,
                            interval: paired(measure, &here, &there)?,
                        })
                    };
                    differences.extend(Measure::ALL.into_iter().filter_map(of));
                }
            }
        }
        Self {
            n_cells: cells.len(),
            failed: cells.iter().filter_map(FailedCell::of).collect(),
            entries,
            differences,
        }
    }

    /// The table as Markdown: shares in percent, means with half the width of their 95 % interval.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let mut text = format!(
            "{} cells, {} of them failed. Means over seeds ± half the width of the 95 % interval (Student's t); `last` is \
             the policy after the last episode, `best` that of the best evaluation, each judged by fresh rollouts. A cell \
             that failed counts as without success, and in nothing else.\n",
            self.n_cells,
            self.failed.len()
        );
        self.write_entries(&mut text);
        self.write_differences(&mut text);
        if !self.failed.is_empty() {
            text.push_str("\n## Cells that failed\n\n| task | setting | seed | command | exit code |\n|---|---|---|---|---|\n");
            for cell in &self.failed {
                let code = cell
                    .exit_code
                    .map_or("signal".to_owned(), |code| code.to_string());
                push_row(
                    &mut text,
                    &[
                        cell.task.clone(),
                        cell.ablation.name().to_owned(),
                        cell.seed.to_string(),
                        cell.command.clone(),
                        code,
                    ],
                );
            }
        }
        text
    }

    fn write_entries(&self, text: &mut String) {
        const HEADS: &str = "| setting | seeds | success, last, % | success, best, % | violations, last, % | violations, best, % | \
                             training episodes with a violation | peak force, last, N | time to success, last, s |\n\
                             |---|---|---|---|---|---|---|---|---|\n";
        let mut task = "";
        for entry in &self.entries {
            if entry.task != task {
                task = &entry.task;
                let n = entry.n_episodes;
                // A `String` takes whatever is written.
                writeln!(text, "\n## {task}, {n} training episodes\n").ok();
                text.push_str(HEADS);
            }
            let cell = |measure, scale, digits| words(entry.measures.get(&measure), scale, digits);
            let n = match entry.n_failed {
                0 => entry.n_cells.to_string(),
                n_failed => format!("{}, {n_failed} failed", entry.n_cells),
            };
            push_row(
                text,
                &[
                    entry.ablation.name().to_owned(),
                    n,
                    cell(Measure::SuccessRateLast, 100.0, 0),
                    cell(Measure::SuccessRateBest, 100.0, 0),
                    cell(Measure::ViolationRateLast, 100.0, 0),
                    cell(Measure::ViolationRateBest, 100.0, 0),
                    cell(Measure::TrainingViolations, 1.0, 1),
                    cell(Measure::PeakForceNLast, 1.0, 0),
                    cell(Measure::TimeToSuccessSecsLast, 1.0, 2),
                ],
            );
        }
    }

    fn write_differences(&self, text: &mut String) {
        let ladder: Vec<&Difference> = self
            .differences
            .iter()
            .filter(|difference| base(difference.ablation) == Some(difference.minus))
            .collect();
        let mut pairs: Vec<(&str, Ablation, Ablation)> = ladder
            .iter()
            .map(|difference| (&*difference.task, difference.ablation, difference.minus))
            .collect();
        pairs.dedup();
        if pairs.is_empty() {
            return;
        }
        text.push_str(
            "\n## What each part changes\n\nDifferences between settings, seed by seed, with 95 % intervals; not corrected for \
             their number.\n\n| task | settings | seeds | success, last, points | success, best, points | violations, last, \
             points | training episodes with a violation | peak force, last, N |\n|---|---|---|---|---|---|---|---|\n",
        );
        for (task, ablation, minus) in pairs {
            let of = |measure| {
                let difference = ladder.iter().find(|difference| {
                    (&*difference.task, difference.ablation, difference.measure)
                        == (task, ablation, measure)
                });
                difference.map(|difference| &difference.interval)
            };
            let n = of(Measure::SuccessRateLast).map_or(0, |interval| interval.n);
            let cell = |measure, scale, digits| words(of(measure), scale, digits);
            push_row(
                text,
                &[
                    task.to_owned(),
                    format!("{} − {}", ablation.name(), minus.name()),
                    n.to_string(),
                    cell(Measure::SuccessRateLast, 100.0, 0),
                    cell(Measure::SuccessRateBest, 100.0, 0),
                    cell(Measure::ViolationRateLast, 100.0, 0),
                    cell(Measure::TrainingViolations, 1.0, 1),
                    cell(Measure::PeakForceNLast, 1.0, 0),
                ],
            );
        }
    }
}

impl Entry {
    fn of(task: &str, ablation: Ablation, cells: &[&CellResult]) -> Self {
        let mean = |measure: Measure| {
            let values: Vec<f64> = cells.iter().filter_map(|cell| measure.of(cell)).collect();
            Some((measure, MeanInterval::of(&values)?))
        };
        Self {
            task: task.to_owned(),
            ablation,
            n_cells: cells.len(),
            n_failed: cells.iter().filter(|cell| cell.failure.is_some()).count(),
            n_episodes: cells.iter().map(|cell| cell.n_episodes).max().unwrap_or(0),
            measures: Measure::ALL.into_iter().filter_map(mean).collect(),
        }
    }
}

impl FailedCell {
    fn of(cell: &CellResult) -> Option<Self> {
        let failure = cell.failure.as_ref()?;
        Some(Self {
            task: cell.task.clone(),
            ablation: cell.ablation,
            seed: cell.seed,
            command: failure.command.clone(),
            exit_code: failure.exit_code,
        })
    }
}

/// The mean difference over the seeds at which both have a value.
fn paired(measure: Measure, here: &[&CellResult], there: &[&CellResult]) -> Option<MeanInterval> {
    let by_seed: BTreeMap<u64, f64> = there
        .iter()
        .filter_map(|cell| Some((cell.seed, measure.of(cell)?)))
        .collect();
    let differences: Vec<f64> = here
        .iter()
        .filter_map(|cell| Some(measure.of(cell)? - by_seed.get(&cell.seed)?))
        .collect();
    MeanInterval::of(&differences)
}

/// `83 ± 12`, or a dash where there is nothing.
pub(super) fn words(interval: Option<&MeanInterval>, scale: f64, digits: usize) -> String {
    let Some(interval) = interval else {
        return "-".to_owned();
    };
    // What rounds to zero has no sign.
    let unit = 10_f64.powi(i32::try_from(digits).unwrap_or(0));
    let mean = (scale * interval.mean * unit).round() / unit + 0.0;
    match interval.half_width {
        Some(half_width) => format!("{mean:.digits$} ± {:.digits$}", scale * half_width),
        None => format!("{mean:.digits$}"),
    }
}

pub(super) fn push_row(text: &mut String, cells: &[String]) {
    text.push_str("| ");
    text.push_str(&cells.join(" | "));
    text.push_str(" |\n");
}
