//! Figures and tables of the grid, drawn from its results alone.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use factotum_skills::cip::setting::Ablation;

use super::curves::{Quantity, curve};
use super::table::{group, tasks};
use super::{CellResult, GridError, Table, results_in};
use crate::figure::{Dash, Figure, Line, Point, Row, Style};
use crate::storage::{StorageError, write_atomically};

/// What a report wrote, and what it says.
#[derive(Debug, Clone, PartialEq)]
pub struct GridReport {
    /// The table.
    pub table: Table,
    /// The files.
    pub files: Vec<PathBuf>,
}

/// Draws the figures and writes the table of the results in `from`, into `out`.
///
/// # Errors
/// [`GridError`] if there are no results, one is not of this program or there twice, or a file cannot be written.
pub fn report(from: &Path, out: &Path) -> Result<GridReport, GridError> {
    let cells: Vec<CellResult> = results_in(from)?;
    let table = Table::of(&cells);
    let json = serde_json::to_string_pretty(&table).map_err(GridError::Table)?;
    std::fs::create_dir_all(out).map_err(|error| StorageError::writing(out, error))?;
    let texts = [
        ("best-to-date.svg", best_to_date(&cells).to_svg()),
        ("current.svg", current(&cells).to_svg()),
        ("table.md", table.to_markdown()),
        ("table.json", json + "\n"),
    ];
    let mut files = Vec::new();
    for (name, text) in texts {
        let file = out.join(name);
        write_atomically(&file, text.as_bytes())?;
        files.push(file);
    }
    Ok(GridReport { table, files })
}

/// Success and violation rate, best to date, as in thesis Fig. 3.2.
fn best_to_date(cells: &[CellResult]) -> Figure {
    figure(
        cells,
        "Contact skills: best to date",
        "Violation rate is that of the evaluation with the highest success rate so far (the later of equals).",
        &[
            ("success rate, %", Quantity::BestSuccess),
            ("joint-limit violation rate, %", Quantity::BestViolation),
        ],
    )
}

/// What the policy does at each evaluation, and what training has cost until then.
fn current(cells: &[CellResult]) -> Figure {
    figure(
        cells,
        "Contact skills: current value and training violations",
        "Evaluations as they are, not the best so far; below, training episodes with a violation so far.",
        &[
            ("success rate, %", Quantity::Success),
            ("joint-limit violation rate, %", Quantity::Violation),
            (
                "training violations, episodes",
                Quantity::TrainingViolations,
            ),
        ],
    )
}

fn figure(
    cells: &[CellResult],
    title: &str,
    note: &str,
    quantities: &[(&str, Quantity)],
) -> Figure {
    let tasks: Vec<&str> = tasks(cells).into_iter().collect();
    let settings: Vec<Ablation> = Ablation::ALL
        .into_iter()
        .filter(|&ablation| cells.iter().any(|cell| cell.ablation == ablation))
        .collect();
    let rows = quantities.iter().map(|&(label, quantity)| {
        let panel = |task: &&str| {
            let line = |(style, &ablation): (usize, &Ablation)| Line {
                style,
                points: points(quantity, &group(cells, task, ablation)),
            };
            settings.iter().enumerate().map(line).collect()
        };
        Row {
            label: label.to_owned(),
            y_max: (quantity != Quantity::TrainingViolations).then_some(100.0),
            panels: tasks.iter().map(panel).collect(),
        }
    });
    Figure {
        title: title.to_owned(),
        notes: vec![
            seeds_note(cells, &settings),
            note.to_owned(),
            "Shaded: 95 % interval of the mean by Student's t. A cell that failed counts as without success.".to_owned(),
        ],
        x_label: "training episodes".to_owned(),
        columns: tasks.iter().map(|&task| task.to_owned()).collect(),
        rows: rows.collect(),
        styles: settings.iter().map(|&ablation| style(ablation)).collect(),
    }
}

/// How many seeds a mean is over, and how many cells failed.
fn seeds_note(cells: &[CellResult], settings: &[Ablation]) -> String {
    let counts: BTreeSet<usize> = tasks(cells)
        .into_iter()
        .flat_map(|task| {
            settings
                .iter()
                .map(move |&ablation| group(cells, task, ablation).len())
        })
        .filter(|&n| n > 0)
        .collect();
    let n = match (counts.first(), counts.last()) {
        (Some(least), Some(most)) if least < most => format!("{least} to {most}"),
        (_, most) => most.copied().unwrap_or(0).to_string(),
    };
    let n_failed = cells.iter().filter(|cell| cell.failure.is_some()).count();
    let rollouts: BTreeSet<u32> = cells
        .iter()
        .flat_map(|cell| &cell.evaluations)
        .map(|evaluation| evaluation.rollouts)
        .collect();
    let rollouts: Vec<String> = rollouts.iter().map(u32::to_string).collect();
    format!(
        "Means over seeds ({n} a line) of evaluations of {} rollouts; {n_failed} of {} cells failed.",
        rollouts.join(" or "),
        cells.len()
    )
}

fn points(quantity: Quantity, cells: &[&CellResult]) -> Vec<Point> {
    let scale = if quantity == Quantity::TrainingViolations {
        1.0
    } else {
        100.0
    };
    let point = |(episode, interval): (u64, super::MeanInterval)| Point {
        x: episode as f64,
        y: scale * interval.mean,
        half_width: interval.half_width.map(|half_width| scale * half_width),
    };
    curve(quantity, cells).into_iter().map(point).collect()
}

/// Colours of Okabe & Ito (2008, "Color Universal Design"), told apart by dashes as well.
fn style(ablation: Ablation) -> Style {
    let (color, dash) = match ablation {
        Ablation::Unstructured => ("#000000", Dash::Dots),
        Ablation::Head => ("#e69f00", Dash::Short),
        Ablation::Safety => ("#56b4e9", Dash::OneDot),
        Ablation::Mv => ("#009e73", Dash::Long),
        Ablation::Cip => ("#0072b2", Dash::Solid),
        Ablation::HardGuard => ("#cc79a7", Dash::TwoDots),
        Ablation::Fast => ("#d55e00", Dash::Longest),
    };
    Style {
        name: ablation.name().to_owned(),
        color,
        dash,
    }
}
