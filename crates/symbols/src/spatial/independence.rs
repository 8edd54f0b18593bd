//! The test of spatial independence, from data.
//!
//! For distributions, independence of S_b and the rest in I_o is conditional independence (dissertation 5.3): among states
//! whose rest is as in a state that o ran from, whether o can run depends on the place alone. So two classifiers are
//! compared on held-out states of that kind: one sees the place, the other the place and the rest. If the
//! second is better by more than chance, independence fails. (The classifiers are those of preconditions; they
//! are compared state by state, by the log-likelihood of what was seen.)

use rand::Rng;
use rand::seq::SliceRandom as _;

use super::SpatialParams;
use crate::precondition::{Precondition, PreconditionParams, learn_classifier, thin};
use crate::samples::Samples;

/// Whether where an option can run depends on the rest of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Independence {
    /// The option, as its index.
    pub option: usize,
    /// The name of its navigation symbol, or what those of its operators begin with.
    pub place: String,
    /// States in which it could run.
    pub n_positive: usize,
    /// States in which it could not, though the rest was as in one where it could.
    pub n_negative: usize,
    /// What seeing the rest gains.
    pub gain: Option<Gain>,
    /// What follows.
    pub verdict: Verdict,
}

/// What a classifier gains by seeing the rest besides the place: log-likelihood a held-out state, nats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// The mean.
    pub mean_nats: f64,
    /// Its standard error.
    pub error_nats: f64,
}

/// The outcome of the test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Seeing the rest is of no use: Definition 5.3.1 is not contradicted.
    Holds,
    /// Seeing the rest helps: the place depends on it.
    Fails,
    /// Too few states, or a rest that never differed. Independence is taken for granted then.
    Untested,
}

/// States to learn a place from: what the test and the navigation symbol see.
pub(super) struct PlaceSamples<'a> {
    /// All states, with all variables.
    pub(super) states: &'a Samples,
    /// Rows in which the option could run.
    pub(super) positive: &'a [usize],
    /// Rows in which it could not, though the rest was right.
    pub(super) negative: &'a [usize],
}

impl PlaceSamples<'_> {
    /// The outcome of the test, the gain, and the variables of the rest that the place depends on.
    pub(super) fn test(
        &self,
        spatial: &SpatialParams,
        params: &PreconditionParams,
        rng: &mut dyn Rng,
    ) -> (Verdict, Option<Gain>, Vec<usize>) {
        let untested = (Verdict::Untested, None, Vec::new());
        if self.positive.len().min(self.negative.len()) < spatial.n_samples_min {
            return untested;
        }
        let (mut positive, mut negative) = (self.positive.to_vec(), self.negative.to_vec());
        let limits = PreconditionParams {
            n_samples_max: spatial.n_samples_max,
            ..params.clone()
        };
        thin(&mut positive, &mut negative, &limits, rng);
        let rest = self.differing_rest(&positive, &negative, spatial);
        if rest.is_empty() {
            return untested;
        }
        let mut both: Vec<usize> = spatial.variables.iter().chain(&rest).copied().collect();
        both.sort_unstable();
        let n_folds = spatial.n_folds;
        let mut gains = Vec::new();
        positive.shuffle(rng);
        negative.shuffle(rng);
        for fold in 0..n_folds {
            let (train_positive, test_positive) = split(&positive, fold, n_folds);
            let (train_negative, test_negative) = split(&negative, fold, n_folds);
            let mut train = |variables: &[usize]| {
                let rows = (train_positive.clone(), train_negative.clone());
                learn_on(self.states, variables, rows, params, rng)
            };
            let (place, joint) = (train(&spatial.variables), train(&both));
            for (rows, is_positive) in [(&test_positive, true), (&test_negative, false)] {
                gains.extend(rows.iter().map(|&row| {
                    let row = self.states.row(row);
                    log_likelihood(&joint, row, is_positive)
                        - log_likelihood(&place, row, is_positive)
                }));
            }
        }
        let gain = mean_and_error(&gains);
        let is_better = gain.mean_nats > spatial.gain_min_nats
            && gain.mean_nats > spatial.n_errors * gain.error_nats;
        if !is_better {
            return (Verdict::Holds, Some(gain), Vec::new());
        }
        let mut seen = learn_on(self.states, &both, (positive, negative), params, rng).variables;
        seen.retain(|v| !spatial.variables.contains(v));
        (Verdict::Fails, Some(gain), seen)
    }

    /// The variables of the rest that differ among the rows; of equal columns the first.
    fn differing_rest(
        &self,
        positive: &[usize],
        negative: &[usize],
        spatial: &SpatialParams,
    ) -> Vec<usize> {
        let rows: Vec<usize> = positive.iter().chain(negative).copied().collect();
        let mut columns: Vec<(usize, Vec<f64>)> = Vec::new();
        for variable in 0..self.states.n_variables() {
            if spatial.variables.contains(&variable) {
                continue;
            }
            let column: Vec<f64> = rows.iter().map(|&i| self.states.row(i)[variable]).collect();
            let differs = column.iter().any(|x| x.total_cmp(&column[0]).is_ne());
            if differs && !columns.iter().any(|(_, known)| *known == column) {
                columns.push((variable, column));
            }
        }
        columns.into_iter().map(|(variable, _)| variable).collect()
    }
}

/// A classifier on some variables of a table of states, in the table's variables.
pub(super) fn learn_on(
    states: &Samples,
    variables: &[usize],
    (positive, negative): (Vec<usize>, Vec<usize>),
    params: &PreconditionParams,
    rng: &mut dyn Rng,
) -> Precondition {
    // Only the rows that are looked at: states may have thousands of variables.
    let n_positive = positive.len();
    let rows = positive.into_iter().chain(negative);
    let seen = states.project_rows(rows, variables);
    let (positive, negative) = (0..seen.len()).partition(|&i| i < n_positive);
    let mut learned = learn_classifier(&seen, positive, negative, params, rng);
    (learned.variables.iter_mut()).for_each(|v| *v = variables[*v]);
    learned
}

/// The rows outside and inside of a fold.
fn split(rows: &[usize], fold: usize, n_folds: usize) -> (Vec<usize>, Vec<usize>) {
    let mut sides = (Vec::new(), Vec::new());
    for (i, &row) in rows.iter().enumerate() {
        if i % n_folds == fold {
            sides.1.push(row);
        } else {
            sides.0.push(row);
        }
    }
    sides
}

fn log_likelihood(condition: &Precondition, row: &[f64], is_positive: bool) -> f64 {
    // No classifier is surer than that of a few hundred samples.
    const SURE: f64 = 0.99;
    let values: Vec<f64> = condition.variables.iter().map(|&v| row[v]).collect();
    let p = condition.probability(&values).clamp(1.0 - SURE, SURE);
    if is_positive { p.ln() } else { (1.0 - p).ln() }
}

fn mean_and_error(values: &[f64]) -> Gain {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    Gain {
        mean_nats: mean,
        error_nats: (squares / (n * (n - 1.0).max(1.0))).sqrt(),
    }
}
