//! The covariance of a block of parameters.

use std::ops::Range;

use nalgebra::DMatrix;

use super::Pi2Error;
use super::error::{check_finite, check_size};

/// Pivots below this share of the variance are rounding: the parameter follows those before it.
const PIVOT_SHARE_MIN: f64 = 1e-14;

/// Covariance of parameters that are explored together. The lower triangle alone is kept up.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    start: usize,
    lower: DMatrix<f64>,
}

/// A lower triangle `L` with `L Lᵀ` the covariance.
pub(super) struct Factor(DMatrix<f64>);

impl Block {
    pub(super) fn of_std(start: usize, std: &[f64]) -> Self {
        let mut lower = DMatrix::zeros(std.len(), std.len());
        for (i, std) in std.iter().enumerate() {
            lower[(i, i)] = std * std;
        }
        Self { start, lower }
    }

    /// Which of the parameters.
    pub(super) fn range(&self) -> Range<usize> {
        self.start..self.start + self.lower.nrows()
    }

    pub(super) fn std(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.lower.nrows()).map(|i| self.lower[(i, i)].sqrt())
    }

    /// `S <- (1 - share) S + share sum_k weights_k away_k away_kᵀ`.
    pub(super) fn blend(&mut self, share: f64, weights: &[f64], away: &DMatrix<f64>) {
        self.lower *= 1.0 - share;
        let n = self.lower.nrows();
        for (weight, away) in weights.iter().zip(away.column_iter()) {
            let away = &away.as_slice()[self.range()];
            for j in 0..n {
                let factor = share * weight * away[j];
                let column = &mut self.lower.as_mut_slice()[j * n + j..(j + 1) * n];
                for (sum, value) in column.iter_mut().zip(&away[j..]) {
                    *sum += factor * value;
                }
            }
        }
    }

    pub(super) fn scale(&mut self, factor: f64) {
        self.lower *= factor * factor;
    }

    /// Brings standard deviations into their bounds, given as multiples of the first. A variance that is raised
    /// stays uncorrelated in what was added; one that is lowered keeps its correlations.
    pub(super) fn bound(&mut self, first: &[f64], std_min: f64, std_max: f64) {
        for (i, first) in first.iter().enumerate() {
            let (least, most) = (std_min * first, std_max * first);
            let variance = self.lower[(i, i)];
            if variance > most * most {
                let factor = most / variance.sqrt();
                for j in 0..i {
                    self.lower[(i, j)] *= factor;
                }
                for j in i + 1..self.lower.nrows() {
                    self.lower[(j, i)] *= factor;
                }
                self.lower[(i, i)] = most * most;
            } else if variance < least * least {
                self.lower[(i, i)] = least * least;
            }
        }
    }

    /// By Cholesky's method, for covariances that may be singular.
    pub(super) fn factor(&self) -> Factor {
        let mut lower = self.lower.clone();
        let n = lower.nrows();
        for j in 0..n {
            let pivot = lower[(j, j)];
            if pivot <= PIVOT_SHARE_MIN * self.lower[(j, j)] {
                lower.column_mut(j).rows_range_mut(j..).fill(0.0);
                continue;
            }
            let inverse = 1.0 / pivot.sqrt();
            let (done, rest) = lower.as_mut_slice().split_at_mut((j + 1) * n);
            let column = &mut done[j * n + j..];
            for value in column.iter_mut() {
                *value *= inverse;
            }
            for (k, next) in rest.chunks_exact_mut(n).enumerate() {
                let above = &column[k + 1..];
                let factor = above[0];
                for (value, above) in next[j + 1 + k..].iter_mut().zip(above) {
                    *value -= factor * above;
                }
            }
        }
        Factor(lower)
    }

    /// The lower triangle, column after column.
    pub(super) fn into_covariance(self) -> Vec<f64> {
        let n = self.lower.nrows();
        (0..n)
            .flat_map(|j| (j..n).map(move |i| (i, j)))
            .map(|at| self.lower[at])
            .collect()
    }

    /// Takes over the lower triangle, column after column.
    pub(super) fn set(&mut self, covariance: Vec<f64>) -> Result<(), Pi2Error> {
        let n = self.lower.nrows();
        check_size("covariance", covariance.len(), n * (n + 1) / 2)?;
        check_finite("covariance", &covariance)?;
        let places = (0..n).flat_map(|j| (j..n).map(move |i| (i, j)));
        for ((i, j), value) in places.zip(covariance) {
            if i == j && value < 0.0 {
                return Err(Pi2Error::OutOfRange {
                    name: "variance",
                    found: value,
                    wanted: "a number of at least 0",
                });
            }
            self.lower[(i, j)] = value;
        }
        Ok(())
    }
}

impl Factor {
    /// `out += L normal`.
    pub(super) fn add_product(&self, normal: &[f64], out: &mut [f64]) {
        for (j, (column, normal)) in self.0.column_iter().zip(normal).enumerate() {
            for (out, value) in out[j..].iter_mut().zip(&column.as_slice()[j..]) {
                *out += normal * value;
            }
        }
    }
}
