//! The kernel matrix as L Lᵀ, and the linear algebra on long columns.

use super::GpKernel;
use crate::samples::Samples;

/// Greatest error of a diagonal element of the kernel over σ².
const TOLERANCE: f64 = 1e-4;

/// The columns of L, each as long as there are samples: pivoted Cholesky decomposition, which takes the
/// column of the worst represented sample until all are represented well enough (Harbrecht, Peters &
/// Schneider, Applied Numerical Mathematics 62, 2012).
pub(super) fn decompose(kernel: &GpKernel, points: &Samples) -> Vec<Vec<f64>> {
    let n = points.len();
    let mut left = vec![1.0; n];
    let mut columns: Vec<Vec<f64>> = Vec::new();
    while columns.len() < n {
        let mut pivot = 0;
        for i in 1..n {
            if left[i] > left[pivot] {
                pivot = i;
            }
        }
        if left[pivot] <= TOLERANCE {
            break;
        }
        let own = points.row(pivot);
        let mut column: Vec<f64> = points
            .rows()
            .map(|row| kernel.correlation(row, own))
            .collect();
        for before in &columns {
            add_scaled(&mut column, -before[pivot], before);
        }
        let scale = 1.0 / left[pivot].sqrt();
        for (x, left) in column.iter_mut().zip(&mut left) {
            *x *= scale;
            *left -= *x * *x;
        }
        columns.push(column);
    }
    for column in &mut columns {
        column.iter_mut().for_each(|x| *x *= kernel.amplitude);
    }
    columns
}

/// y += a x.
pub(super) fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// Σ x_i y_i, in eight sums side by side so that the compiler can do several at once.
pub(super) fn dot(x: &[f64], y: &[f64]) -> f64 {
    const LANES: usize = 8;
    let (xs, ys) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let rest: f64 = xs
        .remainder()
        .iter()
        .zip(ys.remainder())
        .map(|(x, y)| x * y)
        .sum();
    let mut sums = [0.0; LANES];
    for (x, y) in xs.zip(ys) {
        for lane in 0..LANES {
            sums[lane] += x[lane] * y[lane];
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Lᵀ x.
pub(super) fn transposed_times(columns: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    columns.iter().map(|column| dot(column, x)).collect()
}

/// L u.
pub(super) fn times(columns: &[Vec<f64>], u: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; n];
    for (column, u) in columns.iter().zip(u) {
        add_scaled(&mut out, *u, column);
    }
    out
}

/// The lower Cholesky factor of I + Lᵀ W L, by rows.
pub(super) fn inner_factor(columns: &[Vec<f64>], weights: &[f64]) -> Vec<Vec<f64>> {
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(columns.len());
    for (i, column) in columns.iter().enumerate() {
        let weighted: Vec<f64> = column.iter().zip(weights).map(|(x, w)| x * w).collect();
        let mut row: Vec<f64> = columns[..=i]
            .iter()
            .map(|other| dot(&weighted, other))
            .collect();
        row[i] += 1.0;
        for j in 0..i {
            row[j] = (row[j] - dot(&row[..j], &factor[j][..j])) / factor[j][j];
        }
        // At least 1 but for rounding: the matrix is I plus something without negative eigenvalues.
        row[i] = (row[i] - dot(&row[..i], &row[..i]))
            .max(f64::EPSILON)
            .sqrt();
        factor.push(row);
    }
    factor
}

/// C⁻¹ u for a lower factor C by rows.
pub(super) fn forward(factor: &[Vec<f64>], u: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::with_capacity(u.len());
    for (row, u) in factor.iter().zip(u) {
        let i = out.len();
        out.push((u - dot(&row[..i], &out)) / row[i]);
    }
    out
}

/// C⁻ᵀ u.
pub(super) fn backward(factor: &[Vec<f64>], u: &[f64]) -> Vec<f64> {
    let mut out = u.to_vec();
    for i in (0..out.len()).rev() {
        out[i] /= factor[i][i];
        let x = out[i];
        add_scaled(&mut out[..i], -x, &factor[i][..i]);
    }
    out
}

/// The columns of L C⁻ᵀ.
pub(super) fn whiten(columns: &[Vec<f64>], factor: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut out: Vec<Vec<f64>> = Vec::with_capacity(columns.len());
    for (column, row) in columns.iter().zip(factor) {
        let mut column = column.clone();
        for (before, c) in out.iter().zip(row) {
            add_scaled(&mut column, -c, before);
        }
        let scale = 1.0 / row[out.len()];
        column.iter_mut().for_each(|x| *x *= scale);
        out.push(column);
    }
    out
}
