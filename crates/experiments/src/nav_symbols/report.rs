//! The table and the figure of a study, drawn from its results alone.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{Completion, Method, NavStudyError, Setting, TrialResult};
use crate::figure::{Dash, Figure, Line, Point, Row as FigureRow, Style};
use crate::grid::MeanInterval;
use crate::storage::{StorageError, write_atomically};
use crate::sweep::{RESULTS_NAME, read_results};

/// What is said of a method in a setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Tries of a trial.
    pub n_tries: MeanInterval,
    /// Their mean over that of the oracle; nothing without an oracle.
    pub ratio_to_oracle: Option<f64>,
    /// The same of the completions before a kitchen comes again; nothing where there is one kitchen only.
    pub ratio_each_kitchen_once: Option<f64>,
    /// Mean way a completion, metres.
    pub travel_m: f64,
    /// Trials that were stopped in a step that did not succeed; their tries so far are counted.
    pub n_stuck: usize,
}

/// What is said of a method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The method.
    pub method: Method,
    /// In ever other kitchens.
    pub multi: Option<Figures>,
    /// In one kitchen.
    pub single: Option<Figures>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// Method by method.
    pub rows: Vec<Row>,
}

/// The table of some results.
#[must_use]
pub fn table(results: &[TrialResult]) -> Table {
    let row = |method| Row {
        method,
        multi: figures(results, method, Setting::Multi),
        single: figures(results, method, Setting::Single),
    };
    let rows = Method::ALL.into_iter().map(row);
    Table {
        rows: rows
            .filter(|row| row.multi.is_some() || row.single.is_some())
            .collect(),
    }
}

/// Writes table and figure of the results in a folder into `out`; the table and the files.
///
/// # Errors
/// [`NavStudyError`] if there are no results, one is not of this program, or a file cannot be written.
pub fn report(from: &Path, out: &Path) -> Result<(Table, Vec<PathBuf>), NavStudyError> {
    let file = from.join(RESULTS_NAME);
    let results: Vec<TrialResult> = read_results(&file)?;
    if results.is_empty() {
        return Err(NavStudyError::Empty { file });
    }
    let table = table(&results);
    let json = serde_json::to_string_pretty(&table).map_err(NavStudyError::Table)?;
    std::fs::create_dir_all(out).map_err(|error| StorageError::writing(out, error))?;
    let mut files = Vec::new();
    for (name, text) in [
        ("tries.svg", figure(&results).to_svg()),
        ("table.md", table.to_markdown()),
        ("table.json", json + "\n"),
    ] {
        let file = out.join(name);
        write_atomically(&file, text.as_bytes())?;
        files.push(file);
    }
    Ok((table, files))
}

fn of(results: &[TrialResult], method: Method, setting: Setting) -> Vec<&TrialResult> {
    let mine = |result: &&TrialResult| result.method == method && result.setting == setting;
    results.iter().filter(mine).collect()
}

fn n_tries(completions: &[Completion]) -> f64 {
    completions.iter().map(|one| f64::from(one.n_tries())).sum()
}

/// The completions before a kitchen comes again.
fn each_kitchen_once(trial: &TrialResult) -> &[Completion] {
    let all = &trial.completions;
    let again = (1..all.len()).find(|&i| all[..i].iter().any(|one| one.kitchen == all[i].kitchen));
    &all[..again.unwrap_or(all.len())]
}

fn figures(results: &[TrialResult], method: Method, setting: Setting) -> Option<Figures> {
    let trials = of(results, method, setting);
    let tries = |of: fn(&TrialResult) -> &[Completion], trials: &[&TrialResult]| {
        let tries: Vec<f64> = trials.iter().map(|trial| n_tries(of(trial))).collect();
        MeanInterval::of(&tries)
    };
    let oracles = of(results, Method::Oracle, setting);
    let ratio = |of: fn(&TrialResult) -> &[Completion]| {
        Some(tries(of, &trials)?.mean / tries(of, &oracles)?.mean)
    };
    let all: fn(&TrialResult) -> &[Completion] = |trial| &trial.completions;
    let completions = trials.iter().flat_map(|trial| &trial.completions);
    let n_completions = completions.clone().count().max(1) as f64;
    Some(Figures {
        n_tries: tries(all, &trials)?,
        ratio_to_oracle: ratio(all),
        ratio_each_kitchen_once: ratio(each_kitchen_once).filter(|_| setting == Setting::Multi),
        travel_m: completions.map(|one| one.travel_m).sum::<f64>() / n_completions,
        n_stuck: trials.iter().filter(|trial| trial.is_stuck()).count(),
    })
}

impl Table {
    /// A ratio to the oracle, for each method that has it.
    pub fn ratios(&self, of: impl Fn(&Row) -> Option<f64>) -> BTreeMap<&'static str, f64> {
        let ratio = |row: &Row| Some((row.method.name(), of(row)?));
        self.rows.iter().filter_map(ratio).collect()
    }

    /// The table as Markdown.
    pub fn to_markdown(&self) -> String {
        let mut text = "| method | multi-scene: tries | over oracle | each kitchen once, over oracle | m a coffee | single-scene: tries | over oracle | m a coffee |\n\
                        |---|---|---|---|---|---|---|---|\n"
            .to_owned();
        for row in &self.rows {
            let ratio = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
            let [multi, single] = [&row.multi, &row.single].map(|figures| {
                figures.as_ref().map(|figures| {
                    let n_tries = &figures.n_tries;
                    let half_width = n_tries.half_width.unwrap_or(0.0);
                    let stuck = match figures.n_stuck {
                        0 => String::new(),
                        n => format!(" ({n} stuck)"),
                    };
                    [
                        format!("{:.0} ± {half_width:.0}{stuck}", n_tries.mean),
                        ratio(figures.ratio_to_oracle),
                        ratio(figures.ratio_each_kitchen_once),
                        format!("{:.1}", figures.travel_m),
                    ]
                })
            });
            let [multi, single] = [multi, single]
                .map(|words| words.unwrap_or_else(|| std::array::from_fn(|_| "-".to_owned())));
            writeln!(
                text,
                "| `{}` | {} | {} | {} | {} |",
                row.method,
                multi.join(" | "),
                single[0],
                single[1],
                single[3]
            )
            .ok();
        }
        text.push_str(
            "\nTries of a trial, means over seeds with 95 % intervals. A trial that is stuck was stopped in a step that did \
             not succeed; its tries until then are counted.\n",
        );
        text
    }
}

/// How a method's lines look: one colour for a way to choose, one dash for a frame.
fn style(method: Method) -> Style {
    let (name, color, dash) = match method {
        Method::Oracle => ("oracle", "#000000", Dash::Solid),
        Method::Ours => ("ours", "#0072b2", Dash::Solid),
        Method::OursObject => ("ours, object", "#0072b2", Dash::Short),
        Method::OursApart => ("ours, apart", "#0072b2", Dash::Dots),
        Method::HeuristicObject => ("3 m, object", "#d55e00", Dash::Short),
        Method::HeuristicPolar => ("3 m, polar", "#d55e00", Dash::Solid),
        Method::HeuristicGlobal => ("3 m, global", "#d55e00", Dash::Long),
        Method::NarrowObject => ("1.5 m, object", "#009e73", Dash::Short),
        Method::RandomObject => ("random, object", "#cc79a7", Dash::Short),
        Method::RandomPolar => ("random, polar", "#cc79a7", Dash::Solid),
        Method::RandomGlobal => ("random, global", "#cc79a7", Dash::Long),
    };
    Style {
        name: name.to_owned(),
        color,
        dash,
    }
}

fn line(results: &[TrialResult], idx: usize, method: Method, setting: Setting) -> Line {
    let trials = of(results, method, setting);
    let n_points = trials.iter().map(|trial| trial.completions.len()).max();
    let point = |n: usize| {
        let whole = trials.iter().filter(|trial| trial.completions.len() >= n);
        let tries: Vec<f64> = whole
            .map(|trial| n_tries(&trial.completions[..n]))
            .collect();
        let interval = MeanInterval::of(&tries)?;
        Some(Point {
            x: n as f64,
            y: interval.mean,
            half_width: interval.half_width,
        })
    };
    Line {
        style: idx,
        points: (0..=n_points.unwrap_or(0)).filter_map(point).collect(),
    }
}

fn figure(results: &[TrialResult]) -> Figure {
    let settings = [Setting::Single, Setting::Multi];
    let panels = |is_shown: fn(Method) -> bool| -> Vec<Vec<Line>> {
        let lines = |setting| {
            let methods = Method::ALL.into_iter().enumerate();
            methods
                .filter(|(_, method)| is_shown(*method))
                .map(|(idx, method)| line(results, idx, method, setting))
                .collect()
        };
        settings.map(lines).into()
    };
    Figure {
        title: "Navigation symbols: tries until coffee is made so often".to_owned(),
        notes: vec![
            "Mean over seeds with its 95 % interval. Below, the same without random proposals."
                .to_owned(),
        ],
        x_label: "times coffee was made".to_owned(),
        columns: settings.map(|setting| setting.to_string()).into(),
        rows: vec![
            FigureRow {
                label: "tries".to_owned(),
                y_max: None,
                panels: panels(|_| true),
            },
            FigureRow {
                label: "tries".to_owned(),
                y_max: None,
                panels: panels(|method| method < Method::RandomObject),
            },
        ],
        styles: Method::ALL.map(style).into(),
    }
}
