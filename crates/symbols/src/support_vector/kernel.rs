//! The kernel, shared by all γ, C and folds of a search.

use std::cell::OnceCell;

use crate::samples::Samples;

/// |x_i − x_j|² of pairs of points, from which the kernel at any γ follows.
///
/// Rows are computed when they are first asked for. The solver asks only for those of points that it
/// moves, which are few among thousands. Single precision, as LIBSVM keeps its kernel rows.
#[derive(Debug, Clone)]
pub struct Kernel {
    n: usize,
    /// The points, by variables.
    columns: Vec<Vec<f64>>,
    distances_squared: Vec<OnceCell<Vec<f32>>>,
}

impl Kernel {
    /// The squared distances between these points.
    pub fn new(points: &Samples) -> Self {
        let column = |v: usize| points.rows().map(|row| row[v]).collect();
        Self {
            n: points.len(),
            columns: (0..points.n_variables()).map(column).collect(),
            distances_squared: vec![OnceCell::new(); points.len()],
        }
    }

    /// The kernel at one γ.
    pub fn at(&self, gamma: f64) -> KernelRows<'_> {
        KernelRows {
            kernel: self,
            gamma: gamma as f32,
            rows: vec![OnceCell::new(); self.n],
        }
    }

    fn distances_squared(&self, i: usize) -> &[f32] {
        self.distances_squared[i].get_or_init(|| {
            let mut sums = vec![0.0; self.n];
            for column in &self.columns {
                let own = column[i];
                for (sum, x) in sums.iter_mut().zip(column) {
                    *sum += (x - own) * (x - own);
                }
            }
            sums.into_iter().map(|sum| sum as f32).collect()
        })
    }
}

/// The kernel at one γ.
#[derive(Debug, Clone)]
pub struct KernelRows<'a> {
    kernel: &'a Kernel,
    gamma: f32,
    rows: Vec<OnceCell<Vec<f32>>>,
}

impl KernelRows<'_> {
    /// How many points.
    pub(super) fn n(&self) -> usize {
        self.rows.len()
    }

    /// The kernel between point `i` and all points.
    pub(super) fn row(&self, i: usize) -> &[f32] {
        self.rows[i].get_or_init(|| {
            let distances = self.kernel.distances_squared(i).iter();
            distances
                .map(|d| exp_of_negative(-self.gamma * d))
                .collect()
        })
    }
}

/// e^x for x ≤ 0 to a relative error below 4e-6; 0 below the least normal number.
///
/// OPTIMIZATION: without a call and without branches, so that the compiler does several at once. e^x = 2^k 2^f with
/// k whole and |f| ≤ ½; 2^f by its Taylor series in f ln 2, of which seven terms fill single precision.
fn exp_of_negative(x: f32) -> f32 {
    const ROUND: f32 = 12_582_912.0; // 1.5 · 2²³: adding it leaves a whole number in the low bits
    let t = (x * std::f32::consts::LOG2_E).max(-126.0);
    let shifted = t + ROUND;
    let k = shifted - ROUND;
    let f = (t - k) * std::f32::consts::LN_2;
    let series = 1.0 / 720.0;
    let series = series * f + 1.0 / 120.0;
    let series = series * f + 1.0 / 24.0;
    let series = series * f + 1.0 / 6.0;
    let series = series * f + 0.5;
    let series = (series * f + 1.0) * f + 1.0;
    let power = f32::from_bits(((k as i32 + 127) as u32) << 23);
    if t > -126.0 { series * power } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_the_libraries() {
        for i in 0..20_000 {
            let x = -0.005 * i as f32;
            let wanted = f64::from(x).exp();
            let error = (f64::from(exp_of_negative(x)) - wanted).abs();
            assert!(error <= 4e-6 * wanted + 1e-37, "{x}: {error}");
        }
        assert_eq!(exp_of_negative(0.0), 1.0);
        assert_eq!(exp_of_negative(-1e9), 0.0);
    }
}
