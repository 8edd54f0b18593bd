//! What is learned over training episodes: means over the seeds of a task and a setting.

use std::collections::BTreeSet;

use factotum_skills::cip::training::EvaluationRecord;

use super::{CellResult, MeanInterval};

/// A quantity over training episodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Success rate of the evaluations, the highest so far (thesis 3.4).
    BestSuccess,
    /// Violation rate of the evaluation with the highest success rate so far, the later of equals. The thesis says "the
    /// best-to-date performance for both metrics"; this is what its figure's code draws.
    BestViolation,
    /// Success rate of the evaluation.
    Success,
    /// Violation rate of the evaluation.
    Violation,
    /// Training episodes with a violation so far.
    TrainingViolations,
}

/// The means of the seeds at every episode at which one of them was evaluated.
///
/// A cell that failed counts as without success from there on; its other quantities end.
pub(super) fn curve(quantity: Quantity, cells: &[&CellResult]) -> Vec<(u64, MeanInterval)> {
    let evaluations = cells.iter().flat_map(|cell| &cell.evaluations);
    let mut episodes: BTreeSet<u64> = evaluations.map(|evaluation| evaluation.episode).collect();
    if quantity == Quantity::TrainingViolations {
        episodes.insert(0);
    }
    let at = |episode: u64| {
        let values = cells
            .iter()
            .filter_map(|cell| value(quantity, cell, episode));
        Some((episode, MeanInterval::of(&values.collect::<Vec<_>>())?))
    };
    episodes.into_iter().filter_map(at).collect()
}

fn value(quantity: Quantity, cell: &CellResult, episode: u64) -> Option<f64> {
    if quantity == Quantity::TrainingViolations {
        let so_far = cell.training_violations.iter().filter(|&&at| at <= episode);
        return (episode <= cell.n_episodes).then(|| so_far.count() as f64);
    }
    let evaluation = match quantity {
        Quantity::Success | Quantity::Violation => evaluation_at(cell, episode),
        _ => evaluation_at(cell, episode).and(best_until(cell, episode)),
    };
    match (quantity, evaluation) {
        (Quantity::Success | Quantity::BestSuccess, Some(evaluation)) => {
            Some(evaluation.success_rate)
        }
        (Quantity::Success | Quantity::BestSuccess, None) => cell.failure.is_some().then_some(0.0),
        (_, evaluation) => Some(evaluation?.violation_rate),
    }
}

fn evaluation_at(cell: &CellResult, episode: u64) -> Option<&EvaluationRecord> {
    cell.evaluations
        .iter()
        .find(|evaluation| evaluation.episode == episode)
}

fn best_until(cell: &CellResult, episode: u64) -> Option<&EvaluationRecord> {
    cell.evaluations
        .iter()
        .filter(|evaluation| evaluation.episode <= episode)
        .max_by(|one, other| one.success_rate.total_cmp(&other.success_rate))
}
