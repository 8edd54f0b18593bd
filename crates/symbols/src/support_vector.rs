//! Support vector classifiers with an RBF kernel and probabilities.
//!
//! ```text
//! min over α   ½ Σ_ij α_i α_j y_i y_j k(x_i, x_j) − Σ_i α_i     with Σ_i y_i α_i = 0, 0 ≤ α_i ≤ C w_i
//! f(x) = Σ_i α_i y_i k(x_i, x) + b,    k(a, b) = exp(−γ |a − b|²),    P(y = 1 | x) = 1 / (1 + exp(A f(x) + B))
//! ```
//!
//! The problem is LIBSVM's (Chang & Lin, ACM TIST 2:27, 2011), solved as there by sequential minimal
//! optimisation with second-order working sets (Fan, Chen & Lin, JMLR 6, 2005), with probabilities by Platt's sigmoid
//! (Lin, Lin & Weng, Machine Learning 68, 2007). Where we differ, so that a search over many C, γ and variables
//! is fast and just as exact:
//!
//! - a point that comes n times is one point of n times the weight;
//! - all C, folds and γ share the rows of squared distances that any of them asks for ([`Kernel`]);
//! - a held-out point is a point of weight 0: it can never become a support vector, and the
//!   gradient, which the solver keeps anyway, is its decision value;
//! - the solution for one C starts the search for the next.

mod grid;
mod kernel;
mod platt;
mod solver;
#[cfg(test)]
mod tests;

pub(crate) use grid::cross_validate;
pub use grid::{GridScore, SvmGrid};
pub use kernel::Kernel;
pub use platt::Sigmoid;

use crate::samples::{Distinct, Samples};
use rand::Rng;
use rand::seq::SliceRandom as _;
use solver::{Solution, solve};

/// What separates the classes: how dear errors are and how far a sample reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SvmParams {
    /// Price of errors, C.
    pub cost: f64,
    /// Inverse squared reach of the kernel, γ, in the inverse squared units of the variables.
    pub gamma: f64,
}

/// Samples of two classes, each point once.
#[derive(Debug, Clone, PartialEq)]
pub struct Labelled {
    /// The points: first the negative ones, then the positive ones.
    pub points: Samples,
    /// How often each came.
    pub weights: Vec<f64>,
    /// How many points are negative.
    pub n_negative: usize,
    /// For each fold of a cross-validation, how much of each point's weight is held out in it.
    folds: Vec<Vec<f64>>,
}

impl Labelled {
    /// Collapses what repeats in each class, and deals the samples of each class to folds in random order.
    ///
    /// There are as many folds as samples in the smaller class where that has fewer, and none below two.
    ///
    /// # Panics
    /// If the classes have different variables.
    pub fn new(positive: &Samples, negative: &Samples, n_folds: usize, rng: &mut dyn Rng) -> Self {
        let n_folds = match n_folds.min(positive.len()).min(negative.len()) {
            0 | 1 => 0,
            n => n,
        };
        let (positive, negative) = (Distinct::of(positive), Distinct::of(negative));
        let n_negative = negative.points.len();
        let n = n_negative + positive.points.len();
        let mut folds = vec![vec![0.0; n]; n_folds];
        for (class, offset) in [(&negative, 0), (&positive, n_negative)] {
            let mut rows = class.point_of_row.clone();
            rows.shuffle(rng);
            for (point, fold) in rows.into_iter().zip((0..n_folds).cycle()) {
                folds[fold][offset + point] += 1.0;
            }
        }
        let mut points = negative.points;
        positive.points.rows().for_each(|row| points.push(row));
        let mut weights = negative.weights;
        weights.extend(positive.weights);
        Self {
            points,
            weights,
            n_negative,
            folds,
        }
    }

    /// How many folds the samples were dealt to.
    pub fn n_folds(&self) -> usize {
        self.folds.len()
    }

    /// The weights to train on and to test on in a fold.
    fn split(&self, fold: usize) -> (Vec<f64>, &[f64]) {
        let test = &self.folds[fold];
        (
            self.weights.iter().zip(test).map(|(w, t)| w - t).collect(),
            test,
        )
    }

    /// The same samples in the same folds, seen through some of their variables.
    pub fn project(&self, variables: &[usize]) -> Self {
        let (mut points, mut weights) = (Samples::new(variables.len()), Vec::new());
        let mut folds = vec![Vec::new(); self.folds.len()];
        let mut n_negative = 0;
        for class in [0..self.n_negative, self.n_negative..self.points.len()] {
            let distinct = Distinct::of(&self.points.project_rows(class.clone(), variables));
            let offset = points.len();
            distinct.points.rows().for_each(|row| points.push(row));
            let sources = std::iter::once(&self.weights).chain(&self.folds);
            for (from, to) in sources.zip(std::iter::once(&mut weights).chain(&mut folds)) {
                to.resize(points.len(), 0.0);
                for (point, weight) in distinct.point_of_row.iter().zip(&from[class.clone()]) {
                    to[offset + point] += weight;
                }
            }
            if class.start == 0 {
                n_negative = points.len();
            }
        }
        Self {
            points,
            weights,
            n_negative,
            folds,
        }
    }

    /// +1 for positive points, -1 for negative ones.
    fn signs(&self) -> Vec<f64> {
        (0..self.points.len())
            .map(|i| if i < self.n_negative { -1.0 } else { 1.0 })
            .collect()
    }

    /// The weight of the (negative, positive) points.
    pub fn class_weights(&self) -> (f64, f64) {
        let (negative, positive) = self.weights.split_at(self.n_negative);
        (negative.iter().sum(), positive.iter().sum())
    }
}

/// The upper bounds C w_i with both classes given the same say: a class of n_c among n counts n / (2 n_c).
fn balanced_bounds(weights: &[f64], n_negative: usize, cost: f64) -> Vec<f64> {
    let (negative, positive) = weights.split_at(n_negative);
    let sums = [negative.iter().sum::<f64>(), positive.iter().sum::<f64>()];
    let scale = |class: f64| cost * (sums[0] + sums[1]) / (2.0 * class);
    let scales = sums.map(|sum| if sum > 0.0 { scale(sum) } else { 0.0 });
    (0..weights.len())
        .map(|i| weights[i] * scales[usize::from(i >= n_negative)])
        .collect()
}

/// A trained classifier with probabilities.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportVectorClassifier {
    params: SvmParams,
    support: Samples,
    /// α_i y_i of each support vector.
    coefficients: Vec<f64>,
    offset: f64,
    sigmoid: Sigmoid,
}

impl SupportVectorClassifier {
    /// Trains on samples of both classes; the kernel must be of the same samples.
    ///
    /// The sigmoid is fitted to decision values of held-out samples, in the folds of `data` (LIBSVM deals five of its
    /// own), or of the training samples where there are no folds.
    ///
    /// # Panics
    /// If a class is empty.
    pub fn train(data: &Labelled, kernel: &Kernel, params: SvmParams) -> Self {
        let (negative, positive) = data.class_weights();
        assert!(negative > 0.0 && positive > 0.0, "samples of both classes");
        let signs = data.signs();
        let rows = kernel.at(params.gamma);
        let train = |weights: &[f64]| {
            let bounds = balanced_bounds(weights, data.n_negative, params.cost);
            solve(&rows, &signs, &bounds, None)
        };
        let whole = train(&data.weights);
        let mut values: Vec<(f64, bool, f64)> = (0..data.n_folds())
            .flat_map(|fold| {
                let (train_weights, test_weights) = data.split(fold);
                weighted_values(&train(&train_weights), &signs, test_weights)
            })
            .collect();
        if values.is_empty() {
            values = weighted_values(&whole, &signs, &data.weights);
        }
        let support: Vec<usize> = (0..signs.len()).filter(|&i| whole.alpha[i] > 0.0).collect();
        Self {
            params,
            coefficients: support.iter().map(|&i| whole.alpha[i] * signs[i]).collect(),
            support: data.points.select(&support),
            offset: whole.offset,
            sigmoid: Sigmoid::fit(&values),
        }
    }

    /// C and γ.
    pub fn params(&self) -> SvmParams {
        self.params
    }

    /// The support vectors.
    pub fn support(&self) -> &Samples {
        &self.support
    }

    /// α_i y_i of each support vector.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// The probability that belongs to Σ_i α_i y_i k(x_i, x), the decision value without b.
    pub fn probability_of_sum(&self, sum: f64) -> f64 {
        self.sigmoid.probability(sum + self.offset)
    }

    /// f(x): positive on the positive side, ±1 on the margins.
    pub fn decision(&self, point: &[f64]) -> f64 {
        let terms = self.support.rows().zip(&self.coefficients).map(|(row, c)| {
            let squared: f64 = row.iter().zip(point).map(|(a, b)| (a - b).powi(2)).sum();
            c * (-self.params.gamma * squared).exp()
        });
        terms.sum::<f64>() + self.offset
    }

    /// How likely the point is positive.
    pub fn probability(&self, point: &[f64]) -> f64 {
        self.sigmoid.probability(self.decision(point))
    }
}

/// (decision value, is positive, weight) of each point with a weight.
fn weighted_values(solution: &Solution, signs: &[f64], weights: &[f64]) -> Vec<(f64, bool, f64)> {
    (0..signs.len())
        .filter(|&i| weights[i] > 0.0)
        .map(|i| (solution.decision(i, signs), signs[i] > 0.0, weights[i]))
        .collect()
}
