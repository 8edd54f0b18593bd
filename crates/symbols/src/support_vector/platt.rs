//! From decision values to probabilities.

/// P(y = 1 | f) = 1 / (1 + exp(A f + B)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sigmoid {
    /// A, negative where greater values are likelier positive.
    pub slope: f64,
    /// B.
    pub offset: f64,
}

impl Sigmoid {
    /// Fits to (decision value, is positive, weight), by Newton's method with backtracking as in Lin,
    /// Lin & Weng (2007, Algorithm 1), with their targets, which keep sure samples from growing A without bound.
    pub fn fit(values: &[(f64, bool, f64)]) -> Self {
        const N_STEPS_MAX: usize = 100;
        const STEP_MIN: f64 = 1e-10;
        const RIDGE: f64 = 1e-12;
        const GRADIENT_MIN: f64 = 1e-5;
        let weight = |wanted: bool| -> f64 {
            let of_class = values.iter().filter(|(_, positive, _)| *positive == wanted);
            of_class.map(|(_, _, w)| w).sum()
        };
        let (positive, negative) = (weight(true), weight(false));
        let target = |is_positive: bool| match is_positive {
            true => (positive + 1.0) / (positive + 2.0),
            false => 1.0 / (negative + 2.0),
        };
        let objective = |s: &Self| -> f64 {
            let loss = |&(f, is_positive, w): &(f64, bool, f64)| {
                let z = s.slope * f + s.offset;
                let t = target(is_positive);
                w * if z >= 0.0 {
                    t * z + (-z).exp().ln_1p()
                } else {
                    (t - 1.0) * z + z.exp().ln_1p()
                }
            };
            values.iter().map(loss).sum()
        };
        let mut sigmoid = Self {
            slope: 0.0,
            offset: ((negative + 1.0) / (positive + 1.0)).ln(),
        };
        let mut loss = objective(&sigmoid);
        for _ in 0..N_STEPS_MAX {
            let (mut h11, mut h22, mut h21, mut g1, mut g2) = (RIDGE, RIDGE, 0.0, 0.0, 0.0);
            for &(f, is_positive, w) in values {
                let p = sigmoid.probability(f);
                let curvature = w * p * (1.0 - p);
                h11 += f * f * curvature;
                h22 += curvature;
                h21 += f * curvature;
                let slope = w * (target(is_positive) - p);
                g1 += f * slope;
                g2 += slope;
            }
            if g1.abs() < GRADIENT_MIN && g2.abs() < GRADIENT_MIN {
                break;
            }
            let det = h11 * h22 - h21 * h21;
            let (d1, d2) = (-(h22 * g1 - h21 * g2) / det, -(h11 * g2 - h21 * g1) / det);
            let descent = g1 * d1 + g2 * d2;
            let mut step = 1.0;
            while step >= STEP_MIN {
                let next = Self {
                    slope: sigmoid.slope + step * d1,
                    offset: sigmoid.offset + step * d2,
                };
                let next_loss = objective(&next);
                if next_loss < loss + 1e-4 * step * descent {
                    (sigmoid, loss) = (next, next_loss);
                    break;
                }
                step *= 0.5;
            }
            if step < STEP_MIN {
                break;
            }
        }
        sigmoid
    }

    /// The probability of a decision value.
    pub fn probability(&self, decision: f64) -> f64 {
        let z = self.slope * decision + self.offset;
        // Either form loses digits on one side only.
        if z >= 0.0 {
            (-z).exp() / (1.0 + (-z).exp())
        } else {
            1.0 / (1.0 + z.exp())
        }
    }
}
