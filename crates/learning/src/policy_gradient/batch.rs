//! Many steps at once: likelihoods, their gradients, and products with the Fisher matrix.

use std::f64::consts::TAU;

use super::GaussianPolicy;
use crate::mlp::{Pass, Tangent};
use crate::panels::{Lanes, Panels, WIDTH, ZERO, n_panels};
use crate::replay::write_columns;

/// Steps in panels, and what a policy says of them.
#[derive(Debug, Clone)]
pub(super) struct Batch {
    n_rows: usize,
    n_observation: usize,
    observations: Vec<Lanes>,
    /// As the means lie.
    actions: Vec<Lanes>,
    pass: Pass,
    tangent: Tangent,
}

impl Batch {
    /// The rows named by their numbers, of steps that have been checked.
    pub(super) fn of(
        policy: &GaussianPolicy,
        observations: &[f32],
        actions: &[f32],
        rows: &[usize],
    ) -> Self {
        let (n_rows, n_observation) = (rows.len(), policy.n_observation());
        let n_action = policy.n_action();
        let mut batch = Self {
            n_rows,
            n_observation,
            observations: vec![ZERO; n_panels(n_observation) * n_rows],
            actions: vec![ZERO; n_panels(n_action) * n_rows],
            pass: Pass::new(policy.network.architecture(), n_rows),
            tangent: Tangent::new(policy.network.architecture(), n_rows),
        };
        write_columns(
            &mut batch.observations,
            n_rows,
            0,
            n_observation,
            |row, i| policy.standard(i, observations[rows[row] * n_observation + i]),
        );
        write_columns(&mut batch.actions, n_rows, 0, n_action, |row, i| {
            actions[rows[row] * n_action + i]
        });
        batch
    }

    fn input(&self) -> Panels<'_> {
        Panels::new(&self.observations, self.n_rows, self.n_observation)
    }

    /// The means that the policy says, as they lie in panels; what follows is about this policy.
    pub(super) fn evaluate(&mut self, policy: &GaussianPolicy) -> &[Lanes] {
        let input = Panels::new(&self.observations, self.n_rows, self.n_observation);
        policy.network.forward(input, 1, &mut self.pass);
        self.pass.output(0)
    }

    /// Mean of `ln pi(a|o)` over the rows, after [`Self::evaluate`].
    pub(super) fn log_likelihood(&self, policy: &GaussianPolicy) -> f64 {
        let precisions = policy.precisions();
        let mut squares = 0.0;
        for (at, (mean, action)) in self.pass.output(0).iter().zip(&self.actions).enumerate() {
            let precision = &precisions[at / self.n_rows];
            for lane in 0..WIDTH {
                let away = f64::from(action[lane]) - f64::from(mean[lane]);
                squares += f64::from(precision[lane]) * away * away;
            }
        }
        let logs: f64 = policy.log_std().iter().copied().map(f64::from).sum();
        let constant = 0.5 * policy.n_action() as f64 * TAU.ln();
        -0.5 * squares / self.n_rows as f64 - logs - constant
    }

    /// Gradient of `sum_rows weight ln pi(a|o)`, after [`Self::evaluate`].
    pub(super) fn gradient(
        &mut self,
        policy: &GaussianPolicy,
        weight: impl Fn(usize) -> f32,
    ) -> Vec<Lanes> {
        let precisions = policy.precisions();
        let n_network = policy.network.parameters().len();
        let mut gradient = vec![ZERO; n_network + precisions.len()];
        let (of_network, of_log_std) = gradient.split_at_mut(n_network);
        // In f64: sums over thousands of rows.
        let mut sums = vec![[0.0_f64; WIDTH]; precisions.len()];
        for at in 0..self.actions.len() {
            let (panel, row) = (at / self.n_rows, at % self.n_rows);
            let (mean, action) = (self.pass.output(0)[at], self.actions[at]);
            let (precision, weight) = (precisions[panel], weight(row));
            let delta = &mut self.pass.output_delta_mut(0)[at];
            for lane in 0..WIDTH {
                let away = action[lane] - mean[lane];
                delta[lane] = weight * precision[lane] * away;
                sums[panel][lane] += f64::from(delta[lane]) * f64::from(away) - f64::from(weight);
            }
        }
        let n_action = policy.n_action();
        let sums = sums.as_flattened().iter().take(n_action);
        for (to, sum) in of_log_std.as_flattened_mut().iter_mut().zip(sums) {
            *to = *sum as f32;
        }
        let input = Panels::new(&self.observations, self.n_rows, self.n_observation);
        policy.network.backward(input, &mut self.pass, of_network);
        gradient
    }

    /// `F v`, after [`Self::evaluate`].
    pub(super) fn fisher_product(
        &mut self,
        policy: &GaussianPolicy,
        direction: &[Lanes],
    ) -> Vec<Lanes> {
        let precisions = policy.precisions();
        let n_network = policy.network.parameters().len();
        let (network, log_std) = direction.split_at(n_network);
        let mut tangent = std::mem::replace(
            &mut self.tangent,
            Tangent::new(policy.network.architecture(), 0),
        );
        let moved = policy
            .network
            .tangent(self.input(), &self.pass, network, &mut tangent);
        let share = 1.0 / self.n_rows as f32;
        let deltas = self.pass.output_delta_mut(0).iter_mut();
        for (at, (delta, moved)) in deltas.zip(moved).enumerate() {
            let precision = &precisions[at / self.n_rows];
            for lane in 0..WIDTH {
                delta[lane] = share * precision[lane] * moved[lane];
            }
        }
        self.tangent = tangent;
        let mut product = vec![ZERO; direction.len()];
        let (of_network, of_log_std) = product.split_at_mut(n_network);
        let input = Panels::new(&self.observations, self.n_rows, self.n_observation);
        policy.network.backward(input, &mut self.pass, of_network);
        for (to, from) in of_log_std.iter_mut().zip(log_std) {
            *to = from.map(|value| 2.0 * value);
        }
        product
    }
}
