//! From costs to weights.

use nalgebra::DMatrix;

/// Weights of samples by their costs; none when all cost the same.
pub(super) fn share_by_cost(costs: &[f64], eliteness: f64) -> Option<Vec<f64>> {
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let most = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Halves first, so that the range of finite costs is finite.
    let range = 0.5 * most - 0.5 * least;
    if range <= 0.0 || costs.is_empty() {
        return None;
    }
    let mut shares: Vec<f64> = costs
        .iter()
        .map(|cost| (-eliteness * ((0.5 * cost - 0.5 * least) / range)).exp())
        .collect();
    let sum: f64 = shares.iter().sum();
    for share in &mut shares {
        *share /= sum;
    }
    Some(shares)
}

/// Weights by what each rollout still cost at each step, averaged over the steps.
pub(super) struct StepWeights {
    /// w.
    pub(super) of_rollouts: Vec<f64>,
    /// W, `(n_rollouts, n_parameters)`.
    pub(super) of_parameters: DMatrix<f64>,
}

impl StepWeights {
    /// None when at every step all rollouts still cost the same; such steps do not count.
    pub(super) fn new(costs: &[Vec<f64>], activity: &DMatrix<f64>, eliteness: f64) -> Option<Self> {
        let (n_parameters, n_steps) = activity.shape();
        let n_rollouts = costs.len();
        let mut to_come = vec![0.0; n_rollouts];
        let mut of_rollouts = vec![0.0; n_rollouts];
        let mut of_all = 0.0;
        let mut of_parameters = DMatrix::zeros(n_rollouts, n_parameters);
        let mut of_activity = vec![0.0; n_parameters];
        for step in (0..n_steps).rev() {
            for (sum, costs) in to_come.iter_mut().zip(costs) {
                *sum += costs[step];
            }
            let Some(shares) = share_by_cost(&to_come, eliteness) else {
                continue;
            };
            let left = (n_steps - step) as f64;
            of_all += left;
            for (sum, share) in of_rollouts.iter_mut().zip(&shares) {
                *sum += left * share;
            }
            let columns = of_parameters.column_iter_mut().zip(&mut of_activity);
            for ((mut column, of_activity), activity) in columns.zip(&activity.column(step)) {
                let weight = left * activity;
                if weight > 0.0 {
                    *of_activity += weight;
                    for (sum, share) in column.iter_mut().zip(&shares) {
                        *sum += weight * share;
                    }
                }
            }
        }
        if of_all <= 0.0 {
            return None;
        }
        for weight in &mut of_rollouts {
            *weight /= of_all;
        }
        for (mut column, of_activity) in of_parameters.column_iter_mut().zip(of_activity) {
            // A parameter that never had a say stays.
            if of_activity > 0.0 {
                column /= of_activity;
            }
        }
        Some(Self {
            of_rollouts,
            of_parameters,
        })
    }
}
