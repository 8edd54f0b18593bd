//! The manipulability value of thesis Eq. 3.2: Yoshikawa's index times Tsai's joint-limit penalty.
//!
//! ```text
//! w = sqrt(det(J Jᵀ))                                    Yoshikawa, IJRR 4(2), 1985
//! P = 1 - exp(-k Π_j (q_j - l_j)(u_j - q_j) / (u_j - l_j)²)    Tsai 1986; thesis Eq. 3.2, k = 1
//! ```
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | J | Jacobian of the tool, 6 x n: linear above angular | m/rad, rad/rad |
//! | l, u | joint limits | rad, m |
//!
//! A continuous joint has no limit and contributes no factor. With fewer than six joints det(J Jᵀ) is
//! always zero; then the volume of the ellipsoid that the chain does span is taken, sqrt(det(Jᵀ J)).

use nalgebra::{DMatrix, Matrix6, Matrix6xX};

use crate::joint_space::JointLimit;

/// k of Eq. 3.2.
const PENALTY_GAIN: f64 = 1.0;

/// Yoshikawa's index w of a Jacobian.
pub fn yoshikawa_index(jacobian: &Matrix6xX<f64>) -> f64 {
    let determinant = if jacobian.ncols() >= 6 {
        let gram: Matrix6<f64> = jacobian * jacobian.transpose();
        gram.determinant()
    } else {
        let gram: DMatrix<f64> = jacobian.transpose() * jacobian;
        gram.determinant()
    };
    // Rounding can make the determinant of a singular Gram matrix slightly negative.
    determinant.max(0.0).sqrt()
}

/// Tsai's penalty P: 0 at a joint limit, largest at the middle of all ranges.
pub fn limit_penalty(limits: &[JointLimit], q: &[f64]) -> f64 {
    let product: f64 = limits
        .iter()
        .zip(q)
        .filter(|(limit, _)| !limit.continuous)
        .map(|(limit, &q)| {
            let range = limit.upper - limit.lower;
            // A joint that cannot move is always at its limits.
            if range > 0.0 {
                ((q - limit.lower) * (limit.upper - q) / (range * range)).max(0.0)
            } else {
                0.0
            }
        })
        .product();
    1.0 - (-PENALTY_GAIN * product).exp()
}

/// The manipulability value w P of Eq. 3.2.
pub fn manipulability(jacobian: &Matrix6xX<f64>, limits: &[JointLimit], q: &[f64]) -> f64 {
    yoshikawa_index(jacobian) * limit_penalty(limits, q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn limit(lower: f64, upper: f64) -> JointLimit {
        JointLimit {
            lower,
            upper,
            velocity: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
            continuous: lower.is_infinite(),
            slide: false,
        }
    }

    #[test]
    fn penalty_of_the_middle_is_the_formula() {
        // One joint in the middle of its range: the factor is 1/4.
        let p = limit_penalty(&[limit(-1.0, 3.0)], &[1.0]);
        assert!((p - (1.0 - (-0.25_f64).exp())).abs() < 1e-15);
    }

    #[test]
    fn a_joint_at_its_limit_makes_the_value_zero() {
        assert_eq!(
            limit_penalty(&[limit(-1.0, 3.0), limit(0.0, 1.0)], &[3.0, 0.5]),
            0.0
        );
    }

    #[test]
    fn a_continuous_joint_contributes_no_factor() {
        let limited = [limit(-1.0, 3.0)];
        let both = [limit(f64::NEG_INFINITY, f64::INFINITY), limit(-1.0, 3.0)];
        assert_eq!(
            limit_penalty(&limited, &[0.3]),
            limit_penalty(&both, &[77.0, 0.3])
        );
        let none = [limit(f64::NEG_INFINITY, f64::INFINITY)];
        assert!((limit_penalty(&none, &[1.0]) - (1.0 - (-1.0_f64).exp())).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn the_index_is_the_product_of_singular_values(values in prop::collection::vec(-1.0..1.0, 6 * 7), n in 2usize..=7) {
            let jacobian = Matrix6xX::from_fn(n, |i, j| values[j * 6 + i]);
            let product: f64 = jacobian.clone().singular_values().iter().product();
            prop_assert!((yoshikawa_index(&jacobian) - product).abs() < 1e-6 * (1.0 + product));
        }
    }
}
