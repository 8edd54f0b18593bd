//! The table and the figure of a study, drawn from its results alone.
//!
//! A normalised return is 0 for an arm that never moves, and would be 1 with the object at its goal from the beginning.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{StudyError, TrialResult};
use crate::figure::{Dash, Figure, Line, Point, Row as FigureRow, Style};
use crate::grid::MeanInterval;
use crate::motor::{EpochRecord, MotorError};
use crate::storage::{StorageError, write_atomically};
use crate::sweep::{RESULTS_NAME, read_results};

/// What a report compares.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Comparison {
    /// Title of the figure.
    pub title: String,
    /// Names of the variants, in the order of the report, with words for the legend.
    pub variants: Vec<(String, String)>,
    /// Name of the variant that the others are compared with.
    pub baseline: String,
}

/// What is said of a task and a variant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The task.
    pub task: String,
    /// The variant.
    pub variant: String,
    /// Area under the curve of normalised returns of all rollouts that were learned from.
    pub area: Option<MeanInterval>,
    /// Its difference to the baseline's, seed by seed; none for the baseline.
    pub area_difference: Option<MeanInterval>,
    /// Trials; a failed one counts as without success.
    pub n_trials: usize,
    /// Those whose first policy succeeds.
    pub n_first_succeeds: usize,
    /// Those whose last policy succeeds.
    pub n_last_succeeds: usize,
    /// Those whose last policy moves the object farther than the first.
    pub n_farther: usize,
    /// Where the object ends with the first and the last policy; rad or m.
    pub object_state: [Option<MeanInterval>; 2],
    /// Trials that failed.
    pub failed: Vec<String>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// What the others are compared with.
    pub baseline: String,
    /// Task by task, variant by variant.
    pub rows: Vec<Row>,
}

/// Writes table and figure of the results in a folder into `out`; the table and the files.
///
/// # Errors
/// [`StudyError`] if there are no results, one is not of this program, or a file cannot be written.
pub fn report(
    from: &Path,
    out: &Path,
    comparison: &Comparison,
) -> Result<(Table, Vec<PathBuf>), StudyError> {
    let file = from.join(RESULTS_NAME);
    let results: Vec<TrialResult> = read_results(&file)?;
    if results.is_empty() {
        return Err(StudyError::Empty { file });
    }
    let names: Vec<&String> = comparison.variants.iter().map(|(name, _)| name).collect();
    if let Some(other) = results
        .iter()
        .find(|result| !names.contains(&&result.variant))
    {
        return Err(StudyError::OtherVariant {
            file,
            found: other.variant.clone(),
            wanted: names.into_iter().cloned().collect(),
        });
    }
    let tasks: BTreeSet<&str> = results.iter().map(|result| &*result.task).collect();
    let tasks: Vec<&str> = tasks.into_iter().collect();
    let rows = tasks.iter().flat_map(|task| {
        names
            .iter()
            .filter_map(|name| row(task, name, &comparison.baseline, &results))
    });
    let table = Table {
        baseline: comparison.baseline.clone(),
        rows: rows.collect(),
    };
    let json = serde_json::to_string_pretty(&table).map_err(StudyError::Table)?;
    let storage = |error| StudyError::Folder(MotorError::Storage(error));
    std::fs::create_dir_all(out).map_err(|error| storage(StorageError::writing(out, error)))?;
    let mut files = Vec::new();
    for (name, text) in [
        ("returns.svg", figure(&tasks, &results, comparison).to_svg()),
        ("table.md", table.to_markdown()),
        ("table.json", json + "\n"),
    ] {
        let file = out.join(name);
        write_atomically(&file, text.as_bytes()).map_err(storage)?;
        files.push(file);
    }
    Ok((table, files))
}

fn of<'a>(results: &'a [TrialResult], task: &str, variant: &str) -> Vec<&'a TrialResult> {
    let mine = |result: &&TrialResult| result.task == task && result.variant == variant;
    results.iter().filter(mine).collect()
}

/// A return of a trial, normalised.
fn normalised(trial: &TrialResult, total_reward: f64) -> f64 {
    1.0 - total_reward / trial.still_return
}

/// Mean of the normalised returns of all rollouts that were learned from; 0 for a trial that failed.
fn area(trial: &TrialResult) -> f64 {
    let explored: Vec<f64> = trial
        .epochs
        .iter()
        .filter(|epoch| epoch.epoch > 0)
        .map(|epoch| normalised(trial, epoch.explored_return))
        .collect();
    if trial.failure.is_some() || explored.is_empty() {
        return 0.0;
    }
    explored.iter().sum::<f64>() / explored.len() as f64
}

fn row(task: &str, variant: &str, baseline: &str, results: &[TrialResult]) -> Option<Row> {
    let trials = of(results, task, variant);
    let others = of(results, task, baseline);
    let areas: Vec<f64> = trials.iter().map(|trial| area(trial)).collect();
    let differences: Vec<f64> = trials
        .iter()
        .filter_map(|trial| {
            let other = others.iter().find(|other| other.seed == trial.seed)?;
            Some(area(trial) - area(other))
        })
        .collect();
    let count =
        |holds: fn(&TrialResult) -> bool| trials.iter().filter(|trial| holds(trial)).count();
    let state = |which: fn(&[EpochRecord]) -> Option<&EpochRecord>| {
        let epochs = trials.iter().filter_map(|trial| which(&trial.epochs));
        MeanInterval::of(&epochs.map(|epoch| epoch.object_state).collect::<Vec<f64>>())
    };
    (!trials.is_empty()).then(|| Row {
        task: task.to_owned(),
        variant: variant.to_owned(),
        area: MeanInterval::of(&areas),
        area_difference: (variant != baseline)
            .then(|| MeanInterval::of(&differences))
            .flatten(),
        n_trials: trials.len(),
        n_first_succeeds: count(|trial| trial.epochs.first().is_some_and(|first| first.success)),
        n_last_succeeds: count(|trial| trial.epochs.last().is_some_and(|last| last.success)),
        n_farther: count(|trial| {
            let [start, goal] = trial.way;
            let far = |epoch: &EpochRecord| (epoch.object_state - start) / (goal - start);
            let ends = trial.epochs.first().zip(trial.epochs.last());
            ends.is_some_and(|(first, last)| far(last) > far(first))
        }),
        object_state: [state(<[EpochRecord]>::first), state(<[EpochRecord]>::last)],
        failed: trials
            .iter()
            .filter_map(|trial| Some(format!("seed {}: {}", trial.seed, trial.failure.as_ref()?)))
            .collect(),
    })
}

impl Table {
    /// The table as Markdown.
    pub fn to_markdown(&self) -> String {
        let mut text = format!(
            "| task | variant | area | more than `{}` | first policy succeeds | last policy succeeds | last farther than first \
             | object, first policy | object, last policy |\n|---|---|---|---|---|---|---|---|---|\n",
            self.baseline
        );
        let interval = |value: &Option<MeanInterval>| match value {
            Some(MeanInterval {
                mean,
                half_width: Some(half_width),
                ..
            }) => format!("{mean:.3} ± {half_width:.3}"),
            Some(MeanInterval { mean, .. }) => format!("{mean:.3}"),
            None => "-".to_owned(),
        };
        for row in &self.rows {
            let of_all = |count: usize| format!("{count} of {}", row.n_trials);
            let [first, last] = &row.object_state;
            writeln!(
                text,
                "| `{}` | `{}` | {} | {} | {} | {} | {} | {} | {} |",
                row.task,
                row.variant,
                interval(&row.area),
                interval(&row.area_difference),
                of_all(row.n_first_succeeds),
                of_all(row.n_last_succeeds),
                of_all(row.n_farther),
                interval(first),
                interval(last),
            )
            .ok();
        }
        text.push_str(
            "\nAreas are means over all rollouts that were learned from of the normalised return, with 95 % intervals over \
             seeds; differences are taken seed by seed. Where the object ends is in rad or m.\n",
        );
        for row in &self.rows {
            for failed in &row.failed {
                writeln!(text, "\nFailed: `{}` {} {failed}", row.task, row.variant).ok();
            }
        }
        text
    }
}

/// Looks of the lines, in the order of the variants: colours that the colour-blind tell apart (Okabe & Ito, 2008).
const LOOKS: [(&str, Dash); 6] = [
    ("#0072b2", Dash::Solid),
    ("#d55e00", Dash::Short),
    ("#009e73", Dash::Long),
    ("#cc79a7", Dash::Dots),
    ("#e69f00", Dash::Solid),
    ("#56b4e9", Dash::Short),
];

fn figure(tasks: &[&str], results: &[TrialResult], comparison: &Comparison) -> Figure {
    type Value = fn(&TrialResult, &EpochRecord) -> f64;
    let rows: [(&str, Option<f64>, Value); 2] = [
        ("normalised return", None, |trial, epoch| {
            normalised(trial, epoch.explored_return)
        }),
        (
            "success of exploring rollouts, %",
            Some(100.0),
            |_, epoch| 100.0 * epoch.success_rate,
        ),
    ];
    let line = |style: usize, variant: &str, task: &str, value: Value| {
        let trials = of(results, task, variant);
        let epochs: BTreeSet<(u64, u64)> = trials
            .iter()
            .flat_map(|trial| &trial.epochs)
            .map(|epoch| (epoch.epoch, epoch.rollouts))
            .collect();
        let points = epochs.into_iter().filter_map(|(number, rollouts)| {
            let values: Vec<f64> = trials
                .iter()
                .filter_map(|trial| {
                    let mut epochs = trial.epochs.iter();
                    let epoch = epochs.find(|epoch| epoch.epoch == number)?;
                    Some(value(trial, epoch))
                })
                .collect();
            let MeanInterval {
                mean, half_width, ..
            } = MeanInterval::of(&values)?;
            Some(Point {
                x: rollouts as f64,
                y: mean.max(0.0),
                half_width,
            })
        });
        Line {
            style,
            points: points.collect(),
        }
    };
    Figure {
        title: comparison.title.clone(),
        notes: vec![
            "Mean over seeds with its 95 % interval. A normalised return is 0 for an arm that never moves and would be 1 with the \
             object at its goal from the beginning."
                .to_owned(),
        ],
        x_label: "rollouts".to_owned(),
        columns: tasks.iter().map(|task| (*task).to_owned()).collect(),
        rows: rows
            .into_iter()
            .map(|(label, y_max, value)| FigureRow {
                label: label.to_owned(),
                y_max,
                panels: tasks
                    .iter()
                    .map(|task| {
                        let variants = comparison.variants.iter().enumerate();
                        let lines = variants.map(|(i, (name, _))| line(i, name, task, value));
                        lines.collect()
                    })
                    .collect(),
            })
            .collect(),
        styles: comparison
            .variants
            .iter()
            .zip(LOOKS.iter().cycle())
            .map(|((_, words), &(color, dash))| Style {
                name: words.clone(),
                color,
                dash,
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trial whose object goes from 0 to `ends`, towards 2.
    fn trial(variant: &str, seed: u64, returns: &[f64], ends: [f64; 2]) -> TrialResult {
        let n = returns.len() - 1;
        let epochs = returns.iter().enumerate().map(|(i, &explored_return)| {
            let object_state = ends[usize::from(i == n)];
            EpochRecord {
                epoch: i as u64,
                rollouts: 10 * i as u64,
                total_reward: explored_return,
                success_rate: 0.0,
                object_state,
                success: object_state >= 2.0,
                explored_return,
            }
        });
        TrialResult {
            task: "drawer-heavy".to_owned(),
            variant: variant.to_owned(),
            seed,
            wall_secs: 1.0,
            still_return: -100.0,
            way: [0.0, 2.0],
            epochs: epochs.collect(),
            failure: None,
        }
    }

    #[test]
    fn variants_are_compared_with_the_baseline_seed_by_seed() {
        let mut results = vec![
            trial("random", 1, &[-100.0, -100.0, -80.0], [0.0, 0.5]),
            trial("random", 2, &[-100.0, -90.0, -90.0], [0.0, 0.0]),
            trial("plan", 1, &[-50.0, -40.0, -20.0], [1.0, 2.0]),
            trial("plan", 2, &[-50.0, -20.0, -20.0], [1.0, 2.0]),
        ];
        let mut dead = trial("plan", 3, &[-50.0, -20.0], [1.0, 1.0]);
        dead.failure = Some("exit code 3".to_owned());
        results.push(dead);
        assert_eq!(row("drawer-heavy", "third", "random", &results), None);
        let random = row("drawer-heavy", "random", "random", &results).unwrap();
        assert_eq!(random.area_difference, None);
        assert!((random.area.unwrap().mean - 0.1).abs() < 1e-12);
        assert_eq!([random.n_last_succeeds, random.n_farther], [0, 1]);
        let plan = row("drawer-heavy", "plan", "random", &results).unwrap();
        // A failed trial has area 0, and no other of its seed to be compared with.
        assert!((plan.area.unwrap().mean - (0.7 + 0.8) / 3.0).abs() < 1e-12);
        let difference = plan.area_difference.unwrap();
        assert!((difference.mean - 0.65).abs() < 1e-12, "{difference:?}");
        assert_eq!(
            [
                plan.n_trials,
                plan.n_first_succeeds,
                plan.n_last_succeeds,
                plan.n_farther
            ],
            [3, 0, 2, 2]
        );
        assert_eq!(plan.failed, ["seed 3: exit code 3"]);
    }
}
