//! Climbing a smooth function of a few variables.

use nalgebra::{DMatrix, DVector};

/// Gain of a step below which the top is reached: a hundredth of a nat over all samples shows in no probability.
const GAIN_MIN: f64 = 1e-2;

const N_STEPS_MAX: usize = 50;

/// No variable moves further in a step; they are logarithms.
const STEP_MAX: f64 = 1.0;

/// The value and the gradient at a place.
pub(super) type Objective<'a> = dyn FnMut(&[f64]) -> (f64, Vec<f64>) + 'a;

/// A place reached by climbing.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) at: Vec<f64>,
    pub(super) value: f64,
    /// The inverse of the function's negative second derivatives, as far as it is known.
    pub(super) inverse: Option<DMatrix<f64>>,
}

impl Place {
    /// A place of which nothing is known yet.
    pub(super) fn new(at: Vec<f64>) -> Self {
        Self {
            at,
            value: f64::NEG_INFINITY,
            inverse: None,
        }
    }
}

/// The top near `start`, by BFGS with backtracking (Nocedal & Wright, *Numerical Optimization*, 2006, Algorithm 6.1).
pub(super) fn climb(start: Place, objective: &mut Objective<'_>) -> Place {
    let mut inverse = start.inverse;
    let mut at = DVector::from_vec(start.at);
    let n = at.len();
    let mut evaluate = |x: &DVector<f64>| {
        let (value, gradient) = objective(x.as_slice());
        (value, DVector::from_vec(gradient))
    };
    let (mut value, mut gradient) = evaluate(&at);
    for _ in 0..N_STEPS_MAX {
        let mut direction = match &inverse {
            Some(inverse) => inverse * &gradient,
            None => gradient.clone(),
        };
        if direction.dot(&gradient) <= 0.0 {
            (direction, inverse) = (gradient.clone(), None);
        }
        let longest = direction.amax();
        if longest > STEP_MAX {
            direction *= STEP_MAX / longest;
        }
        let slope = direction.dot(&gradient);
        // Half of what is promised is gained where the function is a parabola.
        if inverse.is_some() && 0.5 * slope < GAIN_MIN {
            break;
        }
        let Some((step, next_value, next_gradient)) =
            backtrack(&at, &direction, value, slope, &mut evaluate)
        else {
            break;
        };
        let s = step * &direction;
        let y = &gradient - &next_gradient;
        let gain = next_value - value;
        at += &s;
        (value, gradient) = (next_value, next_gradient);
        let curvature = s.dot(&y);
        if curvature > 1e-10 {
            let h = inverse
                .take()
                .unwrap_or_else(|| DMatrix::identity(n, n) * (curvature / y.dot(&y)));
            let hy = &h * &y;
            let scale = (1.0 + y.dot(&hy) / curvature) / curvature;
            let outer = (&hy * s.transpose() + &s * hy.transpose()) / curvature;
            inverse = Some(h + scale * &s * s.transpose() - outer);
        }
        if gain < GAIN_MIN {
            break;
        }
    }
    Place {
        at: at.as_slice().to_vec(),
        value,
        inverse,
    }
}

/// The first of ever shorter steps that gains enough (Armijo's rule), with value and gradient where it ends.
fn backtrack<E: FnMut(&DVector<f64>) -> (f64, DVector<f64>)>(
    at: &DVector<f64>,
    direction: &DVector<f64>,
    value: f64,
    slope: f64,
    evaluate: &mut E,
) -> Option<(f64, f64, DVector<f64>)> {
    let mut step = 1.0;
    while step > 1e-3 {
        let (next_value, gradient) = evaluate(&(at + step * direction));
        if next_value >= value + 1e-4 * step * slope {
            return Some((step, next_value, gradient));
        }
        step *= 0.4;
    }
    None
}
