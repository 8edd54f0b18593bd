//! Conjugate gradients: `F x = g` from products with F alone.
//!
//! Hestenes & Stiefel, "Methods of Conjugate Gradients for Solving Linear Systems", J. Res. NBS 49 (1952), doi
//! 10.6028/jres.049.044.

use crate::panels::{Lanes, ZERO};

/// Squared residual at which there is nothing left to find.
const RESIDUAL_MIN: f64 = 1e-10;

pub(super) fn dot(a: &[Lanes], b: &[Lanes]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

/// `a += factor b`.
pub(super) fn add(a: &mut [Lanes], factor: f64, b: &[Lanes]) {
    let factor = factor as f32;
    for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
        *a += factor * b;
    }
}

/// `x` of `(F + damping) x = wanted`, from zero, in at most so many products.
pub(super) fn solve(
    mut product: impl FnMut(&[Lanes]) -> Vec<Lanes>,
    wanted: &[Lanes],
    damping: f64,
    n_iterations: usize,
) -> Vec<Lanes> {
    let mut x = vec![ZERO; wanted.len()];
    let mut residual = wanted.to_vec();
    let mut direction = residual.clone();
    let mut square = dot(&residual, &residual);
    for _ in 0..n_iterations {
        if square < RESIDUAL_MIN {
            break;
        }
        let mut curved = product(&direction);
        add(&mut curved, damping, &direction);
        let step = square / dot(&direction, &curved);
        add(&mut x, step, &direction);
        add(&mut residual, -step, &curved);
        let next = dot(&residual, &residual);
        let kept = (next / square) as f32;
        let pairs = direction.as_flattened_mut().iter_mut();
        for (direction, residual) in pairs.zip(residual.as_flattened()) {
            *direction = residual + kept * *direction;
        }
        square = next;
    }
    x
}
