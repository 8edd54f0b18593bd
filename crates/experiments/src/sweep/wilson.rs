//! The score interval for a probability (E. B. Wilson, 1927, J. Am. Stat. Assoc. 22, 209-212,
//! doi:10.1080/01621459.1927.10502953), which holds for few trials and for rates near 0 and 1.

use serde::Serialize;

/// The 97.5 % quantile of the standard normal distribution: 95 % lie within it on both sides.
const Z: f64 = 1.959_963_984_540_054;

/// A share with its 95 % confidence interval, from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// What was observed.
    pub share: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// The interval for `n_successes` in `n_trials`; nothing for no trials, or more successes than trials.
#[must_use]
pub fn wilson_interval(n_successes: usize, n_trials: usize) -> Option<Interval> {
    if n_trials == 0 || n_successes > n_trials {
        return None;
    }
    let n = n_trials as f64;
    let share = n_successes as f64 / n;
    let scale = 1.0 / (1.0 + Z * Z / n);
    let center = scale * (share + Z * Z / (2.0 * n));
    let half_width = scale * Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    // Rounding would otherwise put the ends a hair outside at shares of 0 and 1.
    let (lower, upper) = (
        (center - half_width).max(0.0).min(share),
        (center + half_width).min(1.0).max(share),
    );
    Some(Interval {
        share,
        lower,
        upper,
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_ends_solve_the_equation_that_defines_them() {
        // An end p satisfies |share - p| = z sqrt(p (1 - p) / n).
        for (k, n) in [(19_usize, 20_usize), (3, 10), (500, 1_000)] {
            let interval = wilson_interval(k, n).unwrap();
            for end in [interval.lower, interval.upper] {
                let deviation = Z * (end * (1.0 - end) / n as f64).sqrt();
                assert!(
                    ((interval.share - end).abs() - deviation).abs() < 1e-12,
                    "{k} of {n}: {end}"
                );
            }
        }
    }

    #[test]
    fn none_and_all_have_their_known_ends() {
        // For 0 of n the upper end is z^2 / (n + z^2), and 1 minus that below for n of n.
        let none = wilson_interval(0, 20).unwrap();
        let all = wilson_interval(20, 20).unwrap();
        let end = Z * Z / (20.0 + Z * Z);
        assert!(
            none.lower.abs() < 1e-12 && (none.upper - end).abs() < 1e-12,
            "{none:?}"
        );
        assert!(
            (all.lower - (1.0 - end)).abs() < 1e-12 && (all.upper - 1.0).abs() < 1e-12,
            "{all:?}"
        );
    }

    #[test]
    fn impossible_counts_have_no_interval() {
        assert_eq!(wilson_interval(0, 0), None);
        assert_eq!(wilson_interval(3, 2), None);
    }

    proptest! {
        #[test]
        fn the_share_lies_within_and_more_trials_narrow_it(n in 1_usize..2_000, share in 0.0..=1.0_f64) {
            let k = (share * n as f64) as usize;
            let few = wilson_interval(k, n).unwrap();
            let many = wilson_interval(10 * k, 10 * n).unwrap();
            prop_assert!(0.0 <= few.lower && few.lower <= few.share && few.share <= few.upper && few.upper <= 1.0);
            prop_assert!(many.upper - many.lower <= few.upper - few.lower);
        }
    }
}
