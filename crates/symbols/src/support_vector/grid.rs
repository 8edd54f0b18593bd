//! The search for C and γ by cross-validation.

use std::collections::BTreeMap;

use super::kernel::{Kernel, KernelRows};
use super::solver::{Solution, solve};
use super::{Labelled, SvmParams, balanced_bounds};

/// The values of C and γ to choose from, each ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct SvmGrid {
    /// Values of C.
    pub costs: Vec<f64>,
    /// Values of γ.
    pub gammas: Vec<f64>,
}

impl Default for SvmGrid {
    /// C = 1, 3, ..., 15 and γ = 4, 6, ..., 20 as in the reference of dissertation 5.4
    /// (`precondition_c_range` and `precondition_gamma_range` of skills-to-symbols).
    fn default() -> Self {
        Self {
            costs: (0..8).map(|i| f64::from(1 + 2 * i)).collect(),
            gammas: (0..9).map(|i| f64::from(4 + 2 * i)).collect(),
        }
    }
}

/// The best of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridScore {
    /// C and γ.
    pub params: SvmParams,
    /// Held-out balanced accuracy: the mean over folds of the mean over classes of the share that is right.
    pub score: f64,
}

impl SvmGrid {
    /// The best C and γ; among equals the least C, then the least γ.
    ///
    /// Balanced accuracy, where the reference takes plain accuracy: with that, a class of one in a hundred hardly
    /// counts, and the variables that tell it apart are lost.
    ///
    /// The search goes from coarse to fine. It scores every second value of both and then the neighbours of the
    /// best until none is better. A candidate is dropped as soon as perfect remaining folds could not make it the
    /// best, and nothing is looked for beyond a perfect score.
    ///
    /// # Panics
    /// If the grid is empty or the data have no folds.
    pub fn search(&self, data: &Labelled, kernel: &Kernel) -> GridScore {
        assert!(data.n_folds() > 1, "folds to hold samples out");
        let mut search = Search {
            grid: self,
            data,
            kernel,
            signs: data.signs(),
            scored: BTreeMap::new(),
            best: (f64::NEG_INFINITY, (0, 0)),
        };
        let coarse = |n: usize| (0..n).step_by(2).chain((n > 1).then_some(n - 1));
        for gamma in coarse(self.gammas.len()) {
            search.score_costs(gamma, &coarse(self.costs.len()).collect::<Vec<_>>());
        }
        loop {
            let (cost, gamma) = search.best.1;
            for gamma in gamma.saturating_sub(1)..(gamma + 2).min(self.gammas.len()) {
                let costs = cost.saturating_sub(1)..(cost + 2).min(self.costs.len());
                search.score_costs(gamma, &costs.collect::<Vec<_>>());
            }
            if search.best.1 == (cost, gamma) {
                break;
            }
        }
        let (score, (cost, gamma)) = search.best;
        GridScore {
            params: SvmParams {
                cost: self.costs[cost],
                gamma: self.gammas[gamma],
            },
            score,
        }
    }
}

/// The held-out balanced accuracy of one choice of C and γ; `None` as soon as it cannot reach `floor`.
pub(crate) fn cross_validate(
    data: &Labelled,
    kernel: &Kernel,
    params: SvmParams,
    floor: f64,
) -> Option<f64> {
    let mut before = vec![None; data.n_folds()];
    let rows = kernel.at(params.gamma);
    score(data, &data.signs(), &rows, params.cost, floor, &mut before)
}

/// As [`cross_validate`]; `before` are the folds' solutions for a lower C, and then those for this one.
fn score(
    data: &Labelled,
    signs: &[f64],
    rows: &KernelRows<'_>,
    cost: f64,
    floor: f64,
    before: &mut [Option<Solution>],
) -> Option<f64> {
    let n_folds = before.len();
    let mut sum = 0.0;
    for (fold, before) in before.iter_mut().enumerate() {
        let (train, test) = data.split(fold);
        let bounds = balanced_bounds(&train, data.n_negative, cost);
        let solution = solve(rows, signs, &bounds, before.as_ref());
        sum += balanced_accuracy(data, signs, &solution, test);
        *before = Some(solution);
        let best_possible = sum + (n_folds - fold - 1) as f64;
        if best_possible / (n_folds as f64) < floor {
            return None;
        }
    }
    Some(sum / n_folds as f64)
}

fn balanced_accuracy(data: &Labelled, signs: &[f64], solution: &Solution, test: &[f64]) -> f64 {
    let share = |class: std::ops::Range<usize>| {
        let right = |&i: &usize| solution.decision(i, signs) * signs[i] > 0.0;
        let all: f64 = test[class.clone()].iter().sum();
        let right: f64 = class.filter(right).map(|i| test[i]).sum();
        right / all
    };
    0.5 * (share(0..data.n_negative) + share(data.n_negative..signs.len()))
}

struct Search<'a> {
    grid: &'a SvmGrid,
    data: &'a Labelled,
    kernel: &'a Kernel,
    signs: Vec<f64>,
    /// The score of each (cost, γ) looked at; `None` where it was dropped.
    scored: BTreeMap<(usize, usize), Option<f64>>,
    /// Score and (cost, γ) of the best.
    best: (f64, (usize, usize)),
}

impl Search<'_> {
    const PERFECT: f64 = 1.0 - 1e-12;

    /// Scores several C, ascending, at one γ; the solution for each starts the search for the next.
    fn score_costs(&mut self, gamma: usize, costs: &[usize]) {
        let new: Vec<usize> = (costs.iter().copied())
            .filter(|&cost| !self.scored.contains_key(&(cost, gamma)))
            .collect();
        if new.is_empty() || self.best.0 >= Self::PERFECT {
            return;
        }
        let rows = self.kernel.at(self.grid.gammas[gamma]);
        let mut before: Vec<Option<Solution>> = vec![None; self.data.n_folds()];
        for cost in new {
            let price = self.grid.costs[cost];
            let score = score(
                self.data,
                &self.signs,
                &rows,
                price,
                self.best.0,
                &mut before,
            );
            self.scored.insert((cost, gamma), score);
            if let Some(score) = score {
                let place = (cost, gamma);
                let better = score > self.best.0 || (score == self.best.0 && place < self.best.1);
                if better {
                    self.best = (score, place);
                }
                if score >= Self::PERFECT {
                    return;
                }
            }
        }
    }
}
