//! Preconditions: from where a partition of an option can run, and which variables that hangs on.
//!
//! Positive samples are the states the partition ran from; negative ones the states the option could not run
//! from and those of its other partitions. A support vector classifier with probabilities tells them apart, on as few
//! variables as it needs (feature selection as in feature_selection.py of skills-to-symbols; dissertation 5.4):
//!
//! 1. the grid's best score on all variables;
//! 2. a variable is kept if the score falls by more than `removal_threshold` without it (the best single one, if none is);
//! 3. a variable is added if the score rises by more than `addition_threshold` with it.
//!
//! Scores are held-out balanced accuracies; see [`SvmGrid::search`].

use rand::Rng;
use rand::seq::SliceRandom as _;

use crate::partition::Partition;
use crate::samples::Samples;
use crate::support_vector::{
    GridScore, Kernel, Labelled, SupportVectorClassifier, SvmGrid, cross_validate,
};
use crate::transitions::Transitions;

/// How preconditions are learned.
#[derive(Debug, Clone, PartialEq)]
pub struct PreconditionParams {
    /// The C and γ to choose from.
    pub grid: SvmGrid,
    /// Folds of the cross-validation; default 3, as in the reference.
    pub n_folds: usize,
    /// Loss of score above which a variable is needed; default 0.02 (the reference's `mask_removal_threshold`).
    pub removal_threshold: f64,
    /// Gain of score above which a variable is added; default 0.001 (the reference's `mask_addition_threshold`).
    pub addition_threshold: f64,
    /// Most samples of a precondition, drawn at random with the shares kept; default 2000, with which
    /// the reference was measured.
    pub n_samples_max: usize,
    /// Positive samples that are all kept where there are no more; default 100, as in the reference.
    pub n_positive_kept: usize,
}

impl Default for PreconditionParams {
    fn default() -> Self {
        Self {
            grid: SvmGrid::default(),
            n_folds: 3,
            removal_threshold: 0.02,
            addition_threshold: 0.001,
            n_samples_max: 2000,
            n_positive_kept: 100,
        }
    }
}

/// When something holds: a classifier over some of the state variables, and how sure it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Precondition {
    /// The variables it looks at, ascending; none if it always holds.
    pub variables: Vec<usize>,
    /// The classifier over these variables; `None` if nothing was seen to go against it.
    pub classifier: Option<SupportVectorClassifier>,
    /// How many samples it was seen to hold in.
    pub n_positive: usize,
    /// How many samples it was seen not to hold in.
    pub n_negative: usize,
    /// Held-out balanced accuracy; `None` where there were too few samples to hold any out.
    pub score: Option<f64>,
}

impl Precondition {
    /// How likely it holds, for the values of [`Self::variables`].
    pub fn probability(&self, values: &[f64]) -> f64 {
        match &self.classifier {
            Some(classifier) => classifier.probability(values),
            None => 1.0,
        }
    }
}

/// The transitions whose start states partition `index` was seen to run from, and those it was seen not to run from:
/// where its option could not run, or went another way.
pub fn samples_of(
    transitions: &Transitions,
    partitions: &[Partition],
    index: usize,
) -> (Vec<usize>, Vec<usize>) {
    let option = partitions[index].option;
    let mut negative: Vec<usize> = (0..transitions.len())
        .filter(|&i| !transitions.is_executable(i, option))
        .collect();
    for (other, partition) in partitions.iter().enumerate() {
        if other != index && partition.option == option {
            negative.extend(partition.rows());
        }
    }
    (partitions[index].rows().collect(), negative)
}

/// Learns what tells the positive rows of a table of states from the negative ones.
pub fn learn_classifier(
    states: &Samples,
    mut positive: Vec<usize>,
    mut negative: Vec<usize>,
    params: &PreconditionParams,
    rng: &mut dyn Rng,
) -> Precondition {
    let (n_positive, n_negative) = (positive.len(), negative.len());
    let found = |variables, classifier, score| Precondition {
        variables,
        classifier,
        n_positive,
        n_negative,
        score,
    };
    if n_positive.min(n_negative) < params.n_folds.max(2) {
        return found(Vec::new(), None, None);
    }
    thin(&mut positive, &mut negative, params, rng);
    let (positive, negative) = (states.select(&positive), states.select(&negative));
    let data = Labelled::new(&positive, &negative, params.n_folds, rng);
    let variables = Selection::new(&data, params).run();
    let data = data.project(&variables);
    let kernel = Kernel::new(&data.points);
    let best = params.grid.search(&data, &kernel);
    let classifier = SupportVectorClassifier::train(&data, &kernel, best.params);
    found(variables, Some(classifier), Some(best.score))
}

/// Draws as many samples as there may be, with the shares of the classes kept; few positive ones all stay.
pub(crate) fn thin(
    positive: &mut Vec<usize>,
    negative: &mut Vec<usize>,
    params: &PreconditionParams,
    rng: &mut dyn Rng,
) {
    let n = positive.len() + negative.len();
    if n <= params.n_samples_max {
        return;
    }
    let n_folds = params.n_folds;
    let share = params.n_samples_max as f64 * positive.len() as f64 / n as f64;
    let n_positive = (share.round() as usize)
        .max(positive.len().min(params.n_positive_kept))
        .clamp(
            n_folds,
            params.n_samples_max.saturating_sub(n_folds).max(n_folds),
        );
    let n_negative = params.n_samples_max.saturating_sub(n_positive).max(n_folds);
    for (rows, n) in [(positive, n_positive), (negative, n_negative)] {
        rows.shuffle(rng);
        rows.truncate(n);
        rows.sort_unstable();
    }
}

/// The search for the variables that matter.
struct Selection<'a> {
    data: &'a Labelled,
    params: &'a PreconditionParams,
    /// The variables whose values differ at all; the others tell nothing apart.
    varying: Vec<usize>,
    /// The best of the grid with all variables.
    whole: GridScore,
}

impl<'a> Selection<'a> {
    fn new(data: &'a Labelled, params: &'a PreconditionParams) -> Self {
        let varying: Vec<usize> = match data.points.bounds() {
            Some(bounds) => (0..data.points.n_variables())
                .filter(|&v| bounds.min[v] < bounds.max[v])
                .collect(),
            None => Vec::new(),
        };
        let seen = data.project(&varying);
        let whole = params.grid.search(&seen, &Kernel::new(&seen.points));
        Self {
            data,
            params,
            varying,
            whole,
        }
    }

    /// The held-out score with the given variables at the parameters found for all, unless it is below `floor`.
    fn score(&self, variables: &[usize], floor: f64) -> Option<f64> {
        let data = self.data.project(variables);
        cross_validate(&data, &Kernel::new(&data.points), self.whole.params, floor)
    }

    fn run(&self) -> Vec<usize> {
        let mut kept = self.needed();
        if kept.is_empty() {
            kept.extend(self.best_single());
        }
        let mut score = self.score(&kept, 0.0).unwrap_or(0.0);
        for &variable in &self.varying {
            if score >= 1.0 {
                break;
            }
            if kept.contains(&variable) {
                continue;
            }
            let mut with = kept.clone();
            with.push(variable);
            with.sort_unstable();
            let floor = score + self.params.addition_threshold;
            if let Some(better) = self.score(&with, floor).filter(|s| *s > floor) {
                (kept, score) = (with, better);
            }
        }
        kept
    }

    /// The variables without which the score falls below the threshold.
    fn needed(&self) -> Vec<usize> {
        let floor = self.whole.score - self.params.removal_threshold;
        let is_needed = |variable: &usize| {
            let others = self.varying.iter().copied().filter(|v| v != variable);
            self.score(&others.collect::<Vec<_>>(), floor).is_none()
        };
        self.varying.iter().copied().filter(is_needed).collect()
    }

    fn best_single(&self) -> Option<usize> {
        let mut best = (f64::NEG_INFINITY, None);
        for &variable in &self.varying {
            if let Some(score) = self.score(&[variable], best.0).filter(|s| *s > best.0) {
                best = (score, Some(variable));
            }
        }
        best.1
    }
}
