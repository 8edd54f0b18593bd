//! Adam: steps of a size that the gradient's own history sets.
//!
//! ```text
//! m <- b1 m + (1 - b1) g          v <- b2 v + (1 - b2) g²
//! p <- p - a / (1 - b1^t) m / (sqrt(v / (1 - b2^t)) + epsilon)
//! ```
//!
//! Kingma & Ba, "Adam: A Method for Stochastic Optimization", ICLR 2015, arXiv 1412.6980, algorithm 1, with the
//! constants it recommends. The dissertation names Adam and the rate alone.

use pulp::{Arch, Simd, WithSimd};

use crate::panels::{Lanes, ZERO};

/// Share of the mean kept in a step.
const BETA_1: f64 = 0.9;
/// Share of the mean square kept in a step.
const BETA_2: f64 = 0.999;
const EPSILON: f32 = 1e-8;

/// The moments of one network's gradient.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Adam {
    learning_rate: f64,
    /// t.
    pub(crate) n_steps: u64,
    /// m, as the parameters lie.
    pub(crate) first: Vec<Lanes>,
    /// v, as the parameters lie.
    pub(crate) second: Vec<Lanes>,
}

impl Adam {
    pub(crate) fn new(n_lanes: usize, learning_rate: f64) -> Self {
        Self {
            learning_rate,
            n_steps: 0,
            first: vec![ZERO; n_lanes],
            second: vec![ZERO; n_lanes],
        }
    }

    /// Moves the parameters against the gradient.
    pub(crate) fn step(&mut self, parameters: &mut [Lanes], gradient: &[Lanes]) {
        self.n_steps += 1;
        // Both powers are zero to f64 long before the count leaves i32.
        let t = i32::try_from(self.n_steps).unwrap_or(i32::MAX);
        Arch::new().dispatch(Step {
            rate: (self.learning_rate / (1.0 - BETA_1.powi(t))) as f32,
            correction: (1.0 / (1.0 - BETA_2.powi(t))) as f32,
            parameters,
            gradient,
            first: &mut self.first,
            second: &mut self.second,
        });
    }
}

struct Step<'a> {
    rate: f32,
    correction: f32,
    parameters: &'a mut [Lanes],
    gradient: &'a [Lanes],
    first: &'a mut [Lanes],
    second: &'a mut [Lanes],
}

impl WithSimd for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let keep_1 = simd.splat_f32s(BETA_1 as f32);
        let add_1 = simd.splat_f32s((1.0 - BETA_1) as f32);
        let keep_2 = simd.splat_f32s(BETA_2 as f32);
        let add_2 = simd.splat_f32s((1.0 - BETA_2) as f32);
        let rate = simd.splat_f32s(-self.rate);
        let correction = simd.splat_f32s(self.correction);
        let epsilon = simd.splat_f32s(EPSILON);
        let rows = self.parameters.iter_mut().zip(self.gradient);
        let moments = self.first.iter_mut().zip(self.second);
        for ((p, g), (m, v)) in rows.zip(moments) {
            let p = S::as_mut_simd_f32s(p).0.iter_mut();
            let g = S::as_simd_f32s(g).0;
            let m = S::as_mut_simd_f32s(m).0.iter_mut();
            let v = S::as_mut_simd_f32s(v).0;
            for ((p, g), (m, v)) in p.zip(g).zip(m.zip(v)) {
                *m = simd.mul_add_e_f32s(keep_1, *m, simd.mul_f32s(add_1, *g));
                let square = simd.mul_f32s(*g, *g);
                *v = simd.mul_add_e_f32s(keep_2, *v, simd.mul_f32s(add_2, square));
                let spread = simd.sqrt_f32s(simd.mul_f32s(*v, correction));
                let way = simd.div_f32s(*m, simd.add_f32s(spread, epsilon));
                *p = simd.mul_add_e_f32s(rate, way, *p);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Adam;
    use crate::panels::WIDTH;

    /// The algorithm as the paper prints it, in f64.
    fn printed(gradients: &[f64], rate: f64) -> f64 {
        let (mut p, mut m, mut v) = (0.0, 0.0, 0.0);
        for (t, g) in (1..).zip(gradients) {
            m = 0.9 * m + 0.1 * g;
            v = 0.999 * v + 0.001 * g * g;
            let (m_hat, v_hat) = (m / (1.0 - 0.9_f64.powi(t)), v / (1.0 - 0.999_f64.powi(t)));
            p -= rate * m_hat / (v_hat.sqrt() + 1e-8);
        }
        p
    }

    #[test]
    fn steps_are_those_of_the_paper() {
        let gradients: Vec<f64> = (0..50).map(|t| f64::from(t).sin() * 3.0 + 0.5).collect();
        let mut adam = Adam::new(1, 1e-2);
        let mut parameters = [[0.0; WIDTH]];
        for g in &gradients {
            let mut gradient = [[0.0; WIDTH]];
            gradient[0][..2].copy_from_slice(&[*g as f32, -1e3 * *g as f32]);
            adam.step(&mut parameters, &gradient);
        }
        let wanted = printed(&gradients, 1e-2);
        assert!((f64::from(parameters[0][0]) - wanted).abs() < 1e-6);
        assert!(
            (f64::from(parameters[0][1]) + wanted).abs() < 1e-6,
            "size of a gradient is no matter"
        );
        assert_eq!(parameters[0][2], 0.0, "nothing moves without a gradient");
    }
}
