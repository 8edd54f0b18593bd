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
use crate::motor::{EpochRecord, Init, MotorError};
use crate::storage::{StorageError, write_atomically};
use crate::sweep::{RESULTS_NAME, read_results};

/// What is said of a task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The task.
    pub task: String,
    /// Area under the curve of normalised returns of all rollouts that were learned from, from a plan.
    pub area_plan: Option<MeanInterval>,
    /// From random weights.
    pub area_random: Option<MeanInterval>,
    /// Their difference, seed by seed.
    pub area_difference: Option<MeanInterval>,
    /// Trials from a plan, and from random weights; a failed one counts as without success.
    pub n_trials: [usize; 2],
    /// Those whose first policy succeeds.
    pub n_first_succeeds: [usize; 2],
    /// Those whose last policy succeeds.
    pub n_last_succeeds: [usize; 2],
    /// Those whose last policy moves the object farther than the first.
    pub n_farther: [usize; 2],
    /// Where the object ends, first and last policy, means; rad or m.
    pub object_state: [[Option<MeanInterval>; 2]; 2],
    /// Trials that failed.
    pub failed: Vec<String>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// Task by task.
    pub rows: Vec<Row>,
}

/// Writes table and figure of the results in a folder into `out`; the table and the files.
///
/// # Errors
/// [`StudyError`] if there are no results, one is not of this program, or a file cannot be written.
pub fn report(from: &Path, out: &Path) -> Result<(Table, Vec<PathBuf>), StudyError> {
    let file = from.join(RESULTS_NAME);
    let results: Vec<TrialResult> = read_results(&file)?;
    if results.is_empty() {
        return Err(StudyError::Empty { file });
    }
    let tasks: BTreeSet<&str> = results.iter().map(|result| &*result.task).collect();
    let tasks: Vec<&str> = tasks.into_iter().collect();
    let table = Table {
        rows: tasks.iter().map(|task| row(task, &results)).collect(),
    };
    let json = serde_json::to_string_pretty(&table).map_err(StudyError::Table)?;
    let storage = |error| StudyError::Folder(MotorError::Storage(error));
    std::fs::create_dir_all(out).map_err(|error| storage(StorageError::writing(out, error)))?;
    let mut files = Vec::new();
    for (name, text) in [
        ("returns.svg", figure(&tasks, &results).to_svg()),
        ("table.md", table.to_markdown()),
        ("table.json", json + "\n"),
    ] {
        let file = out.join(name);
        write_atomically(&file, text.as_bytes()).map_err(storage)?;
        files.push(file);
    }
    Ok((table, files))
}

fn of<'a>(results: &'a [TrialResult], task: &str, init: Init) -> Vec<&'a TrialResult> {
    let mine = |result: &&TrialResult| result.task == task && result.init == init;
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

fn row(task: &str, results: &[TrialResult]) -> Row {
    let groups = [Init::Plan, Init::Random].map(|init| of(results, task, init));
    let [plan, random] = &groups;
    let areas = |group: &[&TrialResult]| {
        let areas: Vec<f64> = group.iter().map(|trial| area(trial)).collect();
        MeanInterval::of(&areas)
    };
    let differences: Vec<f64> = plan
        .iter()
        .filter_map(|trial| {
            let other = random.iter().find(|other| other.seed == trial.seed)?;
            Some(area(trial) - area(other))
        })
        .collect();
    let count = |holds: fn(&TrialResult) -> bool| {
        [plan, random].map(|group| group.iter().filter(|trial| holds(trial)).count())
    };
    let state = |which: fn(&[EpochRecord]) -> Option<&EpochRecord>| {
        [plan, random].map(|group| {
            let states = group
                .iter()
                .filter_map(|trial| Some(which(&trial.epochs)?.object_state));
            MeanInterval::of(&states.collect::<Vec<f64>>())
        })
    };
    Row {
        task: task.to_owned(),
        area_plan: areas(plan),
        area_random: areas(random),
        area_difference: MeanInterval::of(&differences),
        n_trials: [plan.len(), random.len()],
        n_first_succeeds: count(|trial| trial.epochs.first().is_some_and(|first| first.success)),
        n_last_succeeds: count(|trial| trial.epochs.last().is_some_and(|last| last.success)),
        n_farther: count(|trial| {
            let [start, goal] = trial.way;
            let far = |epoch: &EpochRecord| (epoch.object_state - start) / (goal - start);
            let ends = trial.epochs.first().zip(trial.epochs.last());
            ends.is_some_and(|(first, last)| far(last) > far(first))
        }),
        object_state: [state(<[EpochRecord]>::first), state(<[EpochRecord]>::last)],
        failed: groups
            .iter()
            .flatten()
            .filter_map(|trial| {
                let why = trial.failure.as_ref()?;
                Some(format!("{} seed {}: {why}", trial.init.name(), trial.seed))
            })
            .collect(),
    }
}

impl Table {
    /// The table as Markdown.
    pub fn to_markdown(&self) -> String {
        let mut text = "| task | area, plan | area, random | difference | first policy succeeds | last policy succeeds | last farther than first |\n\
                        |---|---|---|---|---|---|---|\n"
            .to_owned();
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
            let counts = |counts: &[usize; 2]| {
                format!(
                    "{} of {}, {} of {}",
                    counts[0], row.n_trials[0], counts[1], row.n_trials[1]
                )
            };
            writeln!(
                text,
                "| `{}` | {} | {} | {} | {} | {} | {} |",
                row.task,
                interval(&row.area_plan),
                interval(&row.area_random),
                interval(&row.area_difference),
                counts(&row.n_first_succeeds),
                counts(&row.n_last_succeeds),
                counts(&row.n_farther),
            )
            .ok();
        }
        text.push_str(
            "\nAreas are means over all rollouts that were learned from of the normalised return, with 95 % intervals over \
             seeds; the difference is taken seed by seed. Counts are of trials from a plan, then of those from random \
             weights.\n",
        );
        for row in &self.rows {
            for failed in &row.failed {
                writeln!(text, "\nFailed: `{}` {failed}", row.task).ok();
            }
        }
        text
    }
}

fn figure(tasks: &[&str], results: &[TrialResult]) -> Figure {
    type Value = fn(&TrialResult, &EpochRecord) -> f64;
    let rows: [(&str, Value); 2] = [
        ("normalised return", |trial, epoch| {
            normalised(trial, epoch.explored_return)
        }),
        ("success of exploring rollouts, %", |_, epoch| {
            100.0 * epoch.success_rate
        }),
    ];
    let line = |style: usize, init: Init, task: &str, value: Value| {
        let trials = of(results, task, init);
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
        title: "Motor skills: what a plan to begin with is worth".to_owned(),
        notes: vec![
            "Mean over seeds with its 95 % interval. A normalised return is 0 for an arm that never moves and would be 1 with the \
             object at its goal from the beginning."
                .to_owned(),
        ],
        x_label: "rollouts".to_owned(),
        columns: tasks.iter().map(|task| (*task).to_owned()).collect(),
        rows: rows
            .into_iter()
            .map(|(label, value)| FigureRow {
                label: label.to_owned(),
                y_max: None,
                panels: tasks
                    .iter()
                    .map(|task| {
                        vec![
                            line(0, Init::Plan, task, value),
                            line(1, Init::Random, task, value),
                        ]
                    })
                    .collect(),
            })
            .collect(),
        styles: vec![
            Style {
                name: "from a plan".to_owned(),
                color: "#0072b2",
                dash: Dash::Solid,
            },
            Style {
                name: "random weights".to_owned(),
                color: "#d55e00",
                dash: Dash::Short,
            },
        ],
    }
}
