//! How much better than expected each step was.

use super::Trajectory;
use crate::replay::Ending;

/// `R_t = r_t + discount R_{t+1}`.
pub(super) fn returns(rewards: &[f32], discount: f64) -> Vec<f64> {
    let mut after = 0.0;
    let mut returns: Vec<f64> = rewards
        .iter()
        .rev()
        .map(|reward| {
            after = f64::from(*reward) + discount * after;
            after
        })
        .collect();
    returns.reverse();
    returns
}

/// Generalised advantages, `A_t = d_t + discount lambda A_{t+1}` with `d_t = r_t + discount V_{t+1} - V_t`.
///
/// What comes after a rollout that was cut is worth what its last observation is.
pub(super) fn advantages(
    trajectory: &Trajectory,
    values: &[f64],
    discount: f64,
    lambda: f64,
) -> Vec<f64> {
    let mut next = match (trajectory.ending, values.last()) {
        (Ending::Terminal, _) | (_, None) => 0.0,
        (Ending::Goes | Ending::Cut, Some(last)) => *last,
    };
    let mut after = 0.0;
    let steps = trajectory.rewards.iter().zip(values).rev();
    let mut advantages: Vec<f64> = steps
        .map(|(reward, value)| {
            let difference = f64::from(*reward) + discount * next - value;
            next = *value;
            after = difference + discount * lambda * after;
            after
        })
        .collect();
    advantages.reverse();
    advantages
}

/// Brings values to mean 0 and deviation 1; those that are all equal become zero.
pub(super) fn normalise(values: &mut [f64]) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let std = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
    // Roundings of equal numbers are no advantage.
    let is_spread = std > 1e-12 * mean.abs().max(f64::MIN_POSITIVE);
    let factor = if is_spread { 1.0 / std } else { 0.0 };
    for value in values {
        *value = (*value - mean) * factor;
    }
}
