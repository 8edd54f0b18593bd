//! The mean of a few values with its 95 % interval by Student's t (Student, 1908, Biometrika 6, 1-25,
//! doi:10.1093/biomet/6.1.1).
//!
//! mean ± t s / √n, with s² = Σ (x - mean)² / (n - 1) and t the 97.5 % quantile with n - 1 degrees of freedom. It is exact
//! for normal values. A rate over seeds is not normal, least of all near 0 and 1: equal values give a width of 0, and an
//! end may lie outside of 0 to 1; it is left there.

use serde::Serialize;

/// Halvings of an angle's range: beyond the precision of its representation.
const N_HALVINGS: usize = 60;

/// A mean with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeanInterval {
    /// Values.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    /// Half the width of the interval; nothing for a single value.
    pub half_width: Option<f64>,
}

impl MeanInterval {
    /// The interval of some values; nothing for none.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len();
        if n == 0 {
            return None;
        }
        let mean = values.iter().sum::<f64>() / n as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let half_width = (n > 1).then(|| {
            let variance = squares / (n - 1) as f64;
            quantile(n - 1) * (variance / n as f64).sqrt()
        });
        Some(Self {
            n,
            mean,
            half_width,
        })
    }
}

/// The t that 95 % of Student's distribution lie within, on both sides; `dof` at least 1.
fn quantile(dof: usize) -> f64 {
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..N_HALVINGS {
        let middle = f64::midpoint(low, high);
        if within(middle, dof) < 0.95 {
            low = middle;
        } else {
            high = middle;
        }
    }
    (dof as f64).sqrt() * f64::midpoint(low, high).tan()
}

/// The probability of |T| ≤ √ν tan θ, by the finite series of Abramowitz & Stegun (1964), 26.7.3 and 26.7.4.
fn within(theta: f64, dof: usize) -> f64 {
    let (sin, cos) = theta.sin_cos();
    let is_odd = dof % 2 == 1;
    // The first power of the cosine is 1 for odd ν and 0 for even ν; each term follows from the one before.
    let first = usize::from(is_odd);
    let mut term = if is_odd { cos } else { 1.0 };
    let mut sum = 0.0;
    let mut power = first;
    while power + 2 <= dof {
        sum += term;
        term *= cos * cos * (power + 1) as f64 / (power + 2) as f64;
        power += 2;
    }
    if is_odd {
        (theta + sin * sum) * std::f64::consts::FRAC_2_PI
    } else {
        sin * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun, table 26.10 (two-sided 0.95).
        for (dof, t) in [
            (1, 12.706),
            (2, 4.303),
            (3, 3.182),
            (4, 2.776),
            (5, 2.571),
            (9, 2.262),
            (10, 2.228),
            (29, 2.045),
            (30, 2.042),
            (120, 1.980),
        ] {
            assert!((quantile(dof) - t).abs() < 6e-4, "{dof}: {}", quantile(dof));
        }
    }

    #[test]
    fn an_interval_is_that_computed_by_hand() {
        // Mean 0.8, squares 0.04 + 0.01 + 0 + 0.01 + 0.04 = 0.1, s² = 0.025, s / √5 = 0.070711, times 2.776445.
        let interval = MeanInterval::of(&[0.6, 0.7, 0.8, 0.9, 1.0]).unwrap();
        assert_eq!(interval.n, 5);
        assert!((interval.mean - 0.8).abs() < 1e-12);
        assert!((interval.half_width.unwrap() - 0.196_324).abs() < 1e-6);
    }

    #[test]
    fn one_value_has_no_width_and_none_no_mean() {
        assert_eq!(MeanInterval::of(&[]), None);
        assert_eq!(MeanInterval::of(&[0.3]).unwrap().half_width, None);
        assert_eq!(MeanInterval::of(&[0.25; 4]).unwrap().half_width, Some(0.0));
    }
}
