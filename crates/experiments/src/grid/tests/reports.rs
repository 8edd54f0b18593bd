//! What is reported of results that are made up.

use super::super::curves::{Quantity, curve};
use super::*;
use crate::sweep::RESULTS_NAME;

/// Two settings on `door` over three seeds, one of whose cells crashed.
fn made_up() -> Vec<CellResult> {
    vec![
        result("door", Ablation::Mv, 100, [0.2, 0.4, 0.40, 0.40]),
        result("door", Ablation::Mv, 101, [0.4, 0.2, 0.20, 0.40]),
        result("door", Ablation::Mv, 102, [0.6, 0.6, 0.60, 0.60]),
        result("door", Ablation::Cip, 100, [0.8, 1.0, 1.00, 1.00]),
        result("door", Ablation::Cip, 101, [0.6, 0.8, 0.80, 0.80]),
        crashed("door", Ablation::Cip, 102),
    ]
}

fn close(interval: &MeanInterval, n: usize, mean: f64, half_width: f64) {
    let found = interval.half_width.unwrap();
    assert_eq!(interval.n, n, "{interval:?}");
    assert!(
        (interval.mean - mean).abs() < 1e-9,
        "{interval:?}, wanted {mean}"
    );
    assert!(
        (found - half_width).abs() < 1e-5,
        "{interval:?}, wanted {half_width}"
    );
}

#[test]
fn means_and_paired_differences_are_those_computed_by_hand() {
    let table = Table::of(&made_up());
    assert_eq!((table.n_cells, table.failed.len()), (6, 1));
    assert_eq!(table.failed[0].seed, 102);
    let [mv, cip] = &table.entries[..] else {
        panic!("{:?}", table.entries)
    };
    assert_eq!((mv.ablation, cip.ablation), (Ablation::Mv, Ablation::Cip));
    // 0.4, 0.2, 0.6: s = 0.2, times 4.302653 / √3.
    close(&mv.measures[&Measure::SuccessRateLast], 3, 0.4, 0.496_828);
    // 1, 0.8, and 0 of the crash: squares 0.56, s = √0.28.
    close(&cip.measures[&Measure::SuccessRateLast], 3, 0.6, 1.314_483);
    assert_eq!(cip.n_failed, 1);
    // Nothing else is taken of a crash.
    close(&cip.measures[&Measure::PeakForceNLast], 2, 80.0, 0.0);
    close(&mv.measures[&Measure::TrainingViolations], 3, 3.0, 0.0);
    // 0.6, 0.6, -0.6: squares 0.96, s = √0.48.
    let difference = table
        .differences
        .iter()
        .find(|difference| difference.measure == Measure::SuccessRateLast)
        .unwrap();
    assert_eq!(
        (difference.ablation, difference.minus),
        (Ablation::Cip, Ablation::Mv)
    );
    close(&difference.interval, 3, 0.2, 1.721_060);
    let markdown = table.to_markdown();
    for words in [
        "6 cells, 1 of them failed.",
        "| mv | 3 | 40 ± 50 | 47 ± 29 |",
        "| cip | 3, 1 failed | 60 ± 131 |",
        "| door | cip − mv | 3 | 20 ± 172 |",
        "| door | cip | 102 | skill train | 3 |",
    ] {
        assert!(markdown.contains(words), "{words}:\n{markdown}");
    }
}

#[test]
fn differences_are_taken_at_the_seeds_that_both_have() {
    let mut cells = made_up();
    cells.retain(|cell| cell.cell() != made_up()[0].cell() && cell.cell() != made_up()[4].cell());
    let table = Table::of(&cells);
    // Seed 102 alone is left, and there `cip` crashed.
    let success = &table.differences[0];
    assert_eq!((success.interval.n, success.interval.half_width), (1, None));
    assert!((success.interval.mean + 0.6).abs() < 1e-12);
    let forces = |difference: &&Difference| difference.measure == Measure::PeakForceNLast;
    assert_eq!(table.differences.iter().find(forces), None);
}

#[test]
fn curves_are_the_best_to_date_or_the_current_value() {
    let cells = made_up();
    let mv: Vec<&CellResult> = cells[..3].iter().collect();
    let means = |quantity, cells: &[&CellResult]| -> Vec<(u64, usize, f64)> {
        let round = |mean: f64| (mean * 1e9).round() / 1e9;
        curve(quantity, cells)
            .iter()
            .map(|(episode, interval)| (*episode, interval.n, round(interval.mean)))
            .collect()
    };
    assert_eq!(means(Quantity::Success, &mv), [(10, 3, 0.4), (20, 3, 0.4)]);
    // Seed 101 fell from 0.4 to 0.2: its best stays.
    assert_eq!(
        means(Quantity::BestSuccess, &mv),
        [(10, 3, 0.4), (20, 3, 0.466_666_667)]
    );
    // And so does the violation rate of that evaluation, 0.4; seed 102 takes the later of equals.
    assert_eq!(
        means(Quantity::BestViolation, &mv),
        [(10, 3, 0.4), (20, 3, 0.266_666_667)]
    );
    assert_eq!(
        means(Quantity::Violation, &mv),
        [(10, 3, 0.4), (20, 3, 0.2)]
    );
    // Violations in episodes 3, 10 and 11.
    assert_eq!(
        means(Quantity::TrainingViolations, &mv),
        [(0, 3, 0.0), (10, 3, 2.0), (20, 3, 3.0)]
    );
    // The crash after 13 episodes is a success rate of 0 from there on, and no more in anything else.
    let cip: Vec<&CellResult> = cells[3..].iter().collect();
    assert_eq!(
        means(Quantity::Success, &cip),
        [(10, 3, 0.633_333_333), (20, 3, 0.6)]
    );
    assert_eq!(
        means(Quantity::BestSuccess, &cip),
        [(10, 3, 0.633_333_333), (20, 3, 0.6)]
    );
    assert_eq!(
        means(Quantity::Violation, &cip),
        [(10, 3, 0.4), (20, 2, 0.2)]
    );
    assert_eq!(
        means(Quantity::TrainingViolations, &cip),
        [(0, 3, 0.0), (10, 3, 2.0), (20, 2, 3.0)]
    );
}

fn write(dir: &Path, cells: &[CellResult]) {
    let line = |cell| serde_json::to_string(cell).unwrap() + "\n";
    let lines: String = cells.iter().map(line).collect();
    std::fs::write(dir.join(RESULTS_NAME), lines).unwrap();
}

#[test]
fn a_report_is_drawn_from_the_results_alone() {
    let dir = tempfile::tempdir().unwrap();
    let (from, out) = (dir.path(), dir.path().join("drawn"));
    write(from, &made_up());
    let written = report(from, &out).unwrap();
    assert_eq!(written.table, Table::of(&made_up()));
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let best = read("best-to-date.svg");
    // A line in the legend and one in each of two panels, for each of two settings.
    assert_eq!(best.matches("<polyline").count(), 2 + 2 * 2);
    assert!(best.contains(
        "Means over seeds (3 a line) of evaluations of 10 rollouts; 1 of 6 cells failed."
    ));
    assert_eq!(read("current.svg").matches("<polyline").count(), 2 + 3 * 2);
    assert!(read("table.md").contains("## door, 20 training episodes"));
    let json: serde_json::Value = serde_json::from_str(&read("table.json")).unwrap();
    assert_eq!(json["entries"][1]["ablation"], "cip");
    assert_eq!(json["entries"][1]["measures"]["success_rate_last"]["n"], 3);
    // The order of the lines is that of whoever came first: it must not show.
    let mut turned = made_up();
    turned.reverse();
    write(from, &turned);
    report(from, &out).unwrap();
    assert_eq!(read("best-to-date.svg"), best);
}

#[test]
fn results_that_cannot_be_reported_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join(RESULTS_NAME);
    let refused = |wanted: &[&str]| {
        let error = report(dir.path(), dir.path()).unwrap_err();
        assert!(error.is_of_input(), "{error:?}");
        let cause = std::error::Error::source(&error).map(ToString::to_string);
        let message = format!("{error}: {}", cause.unwrap_or_default());
        assert!(
            wanted.iter().all(|words| message.contains(words)),
            "{message}"
        );
        assert!(!dir.path().join("table.md").exists());
    };
    refused(&["cannot read", "results.jsonl"]);
    std::fs::write(&file, "").unwrap();
    refused(&["results.jsonl", "no results"]);
    let good = serde_json::to_string(&made_up()[0]).unwrap();
    std::fs::write(&file, format!("{good}\n{}\n", &good[..100])).unwrap();
    refused(&["results.jsonl", "line 2", "not the result of a run"]);
    std::fs::write(
        &file,
        format!("{good}\n{}\n", good.replace("\"mv\"", "\"mw\"")),
    )
    .unwrap();
    refused(&["line 2", "unknown variant `mw`", "`cip`"]);
    std::fs::write(&file, format!("{good}\n{good}\n")).unwrap();
    refused(&["line 2", "a second result of door mv seed 100"]);
}
