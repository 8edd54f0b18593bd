//! The table of the trials: means over seeds, and what each condition changes, seed by seed.

use std::collections::{BTreeMap, BTreeSet};

use factotum_skills::cip::setting::Ablation;
use serde::Serialize;

use super::{Condition, TrialResult};
use crate::grid::student::MeanInterval;
use crate::grid::table::{push_row, words};

/// What the trials say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// Trials with a result.
    pub n_trials: usize,
    /// Those that ended early.
    pub n_failed: usize,
    /// A row for each setting, task and condition.
    pub rows: Vec<Row>,
}

/// Skills of a task and setting under a condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Setting.
    pub ablation: Ablation,
    /// Task.
    pub task: String,
    /// Condition.
    pub condition: Condition,
    /// Share of rollouts that succeeded; 0 for a trial that failed.
    pub success_rate: MeanInterval,
    /// That share less the one as trained, by seeds that have both.
    pub success_change: Option<MeanInterval>,
    /// Share of rollouts in which a joint came within 5 degrees of its limit.
    pub violation_rate: Option<MeanInterval>,
    /// Median over the rollouts of the largest contact force on a finger, N.
    pub peak_force_n: Option<MeanInterval>,
}

impl Table {
    /// The table of some trials, each there once.
    #[must_use]
    pub fn of(trials: &[TrialResult]) -> Self {
        let tasks: BTreeSet<&str> = trials.iter().map(|trial| trial.task.as_str()).collect();
        let mut rows = Vec::new();
        for ablation in Ablation::ALL {
            for &task in &tasks {
                let of = |condition| Row::of(trials, ablation, task, condition);
                rows.extend(Condition::ALL.into_iter().filter_map(of));
            }
        }
        Self {
            n_trials: trials.len(),
            n_failed: trials
                .iter()
                .filter(|trial| trial.failure.is_some())
                .count(),
            rows,
        }
    }

    /// The table as Markdown: shares in percent, means with half the width of their 95 % interval.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let mut text = format!(
            "{} trials, {} of them failed. Means over seeds ± half the width of the 95 % interval (Student's t). The change \
             is against the same skills as trained, seed by seed; it is not corrected for the number of rows.\n",
            self.n_trials, self.n_failed
        );
        let mut ablation = None;
        for row in &self.rows {
            if ablation != Some(row.ablation) {
                ablation = Some(row.ablation);
                text.push_str(&format!(
                    "\n## {}\n\n| task | condition | seeds | success, % | change, points | violations, % | peak force, N |\n\
                     |---|---|---|---|---|---|---|\n",
                    row.ablation.name()
                ));
            }
            push_row(
                &mut text,
                &[
                    row.task.clone(),
                    row.condition.name().to_owned(),
                    row.success_rate.n.to_string(),
                    words(Some(&row.success_rate), 100.0, 1),
                    words(row.success_change.as_ref(), 100.0, 1),
                    words(row.violation_rate.as_ref(), 100.0, 1),
                    words(row.peak_force_n.as_ref(), 1.0, 0),
                ],
            );
        }
        text
    }
}

impl Row {
    /// Nothing if there is no such trial.
    fn of(
        trials: &[TrialResult],
        ablation: Ablation,
        task: &str,
        condition: Condition,
    ) -> Option<Self> {
        let group = |condition| {
            trials.iter().filter(move |trial| {
                trial.ablation == ablation && trial.task == task && trial.condition == condition
            })
        };
        let rate = |trial: &TrialResult| trial.judgement.map_or(0.0, |judged| judged.success_rate);
        let here = || group(condition);
        let rates: Vec<f64> = here().map(rate).collect();
        let as_trained: BTreeMap<u64, f64> = group(Condition::AsTrained)
            .map(|trial| (trial.seed, rate(trial)))
            .collect();
        let change = |trial: &TrialResult| Some(rate(trial) - as_trained.get(&trial.seed)?);
        let changes: Vec<f64> = match condition {
            Condition::AsTrained => Vec::new(),
            _ => here().filter_map(change).collect(),
        };
        let judged = || here().filter_map(|trial| trial.judgement);
        let violations: Vec<f64> = judged().map(|judged| judged.violation_rate).collect();
        let forces: Vec<f64> = judged().map(|judged| judged.peak_force_n).collect();
        Some(Self {
            ablation,
            task: task.to_owned(),
            condition,
            success_rate: MeanInterval::of(&rates)?,
            success_change: MeanInterval::of(&changes),
            violation_rate: MeanInterval::of(&violations),
            peak_force_n: MeanInterval::of(&forces),
        })
    }
}
