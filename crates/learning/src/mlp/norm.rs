//! Layer normalisation: each row of a layer's sums is shifted and scaled to mean 0 and variance 1, then scaled and
//! shifted by learned numbers.
//!
//! ```text
//! x_i = (z_i - mean z) / sqrt(var z + epsilon)          y_i = g_i x_i + s_i
//! dz_i = (dx_i - mean dx - x_i mean(dx x)) / sqrt(var z + epsilon),   dx_i = g_i dy_i
//! ```
//!
//! Ba, Kiros & Hinton, "Layer Normalization", 2016, arXiv 1607.06450, equation 4.

use pulp::Arch;

use crate::panels::{Lanes, WIDTH, ZERO, n_panels, sum_lanes};

use super::layout::Layer;

/// Added to the variance; PyTorch's default.
const EPSILON: f32 = 1e-5;

/// What the backward pass needs of one layer.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Normalised {
    /// x, as the layer's outputs lie.
    values: Vec<Lanes>,
    /// 1 / sqrt(var + epsilon) of each row of each member.
    inverse_std: Vec<f32>,
}

impl Normalised {
    pub(super) fn new(n_units: usize, n_members: usize, n_rows: usize) -> Self {
        Self {
            values: vec![ZERO; n_panels(n_units) * n_members * n_rows],
            inverse_std: vec![0.0; n_members * n_rows],
        }
    }
}

/// `values` (z) become y.
pub(super) fn normalise(
    layer: &Layer,
    parameters: &[Lanes],
    n_members: usize,
    values: &mut [Lanes],
    saved: &mut Normalised,
) {
    let shape = Shape::new(layer, values.len(), n_members);
    for member in 0..n_members {
        let Some((gain, shift)) = layer.norm_of(member) else {
            return;
        };
        let (gain, shift) = (gain.of(parameters), shift.of(parameters));
        let part = shape.part(member);
        let values = &mut values[part.clone()];
        let saved_values = &mut saved.values[part];
        let inverse_std = &mut saved.inverse_std[member * shape.n_rows..][..shape.n_rows];
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for (row, inverse_std) in inverse_std.iter_mut().enumerate() {
                    let mean = shape.sum(|p, _| values[p * shape.n_rows + row]) / shape.n;
                    let variance = shape.sum(|p, mask| {
                        lanes(|i| {
                            let d = (values[p * shape.n_rows + row][i] - mean) * mask[i];
                            d * d
                        })
                    }) / shape.n;
                    *inverse_std = 1.0 / (variance + EPSILON).sqrt();
                    for p in 0..shape.n_panels {
                        let at = p * shape.n_rows + row;
                        let mask = shape.mask(p);
                        let x = lanes(|i| (values[at][i] - mean) * *inverse_std * mask[i]);
                        values[at] = lanes(|i| gain[p][i] * x[i] + shift[p][i]);
                        saved_values[at] = x;
                    }
                }
            },
        );
    }
}

/// `delta` (dy) becomes dz; writes the derivatives by gain and shift.
pub(super) fn normalise_back(
    layer: &Layer,
    parameters: &[Lanes],
    n_members: usize,
    delta: &mut [Lanes],
    saved: &Normalised,
    mut gradient: Option<&mut [Lanes]>,
) {
    let shape = Shape::new(layer, delta.len(), n_members);
    for member in 0..n_members {
        let Some((gain, shift)) = layer.norm_of(member) else {
            return;
        };
        let part = shape.part(member);
        let delta = &mut delta[part.clone()];
        let x = &saved.values[part];
        let inverse_std = &saved.inverse_std[member * shape.n_rows..][..shape.n_rows];
        if let Some(gradient) = gradient.as_deref_mut() {
            let panels = delta
                .chunks_exact(shape.n_rows)
                .zip(x.chunks_exact(shape.n_rows));
            for (p, (delta, x)) in panels.enumerate() {
                let (mut by_gain, mut by_shift) = (ZERO, ZERO);
                for (delta, x) in delta.iter().zip(x) {
                    for i in 0..WIDTH {
                        by_gain[i] += delta[i] * x[i];
                        by_shift[i] += delta[i];
                    }
                }
                gradient[gain.start + p] = by_gain;
                gradient[shift.start + p] = by_shift;
            }
        }
        let gain = gain.of(parameters);
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for (row, inverse_std) in inverse_std.iter().enumerate() {
                    let at = |p: usize| p * shape.n_rows + row;
                    let mean = shape.sum(|p, _| lanes(|i| gain[p][i] * delta[at(p)][i])) / shape.n;
                    let mean_along = shape
                        .sum(|p, _| lanes(|i| gain[p][i] * delta[at(p)][i] * x[at(p)][i]))
                        / shape.n;
                    for p in 0..shape.n_panels {
                        let mask = shape.mask(p);
                        delta[at(p)] = lanes(|i| {
                            let dx = gain[p][i] * delta[at(p)][i];
                            (dx - mean - x[at(p)][i] * mean_along) * inverse_std * mask[i]
                        });
                    }
                }
            },
        );
    }
}

#[inline(always)]
fn lanes(value: impl Fn(usize) -> f32) -> Lanes {
    std::array::from_fn(value)
}

/// How the rows of one member lie.
#[derive(Debug, Clone, Copy)]
struct Shape {
    n_rows: usize,
    n_panels: usize,
    /// Columns that count, as a number to divide by.
    n: f32,
    /// One in the columns of the last panel that count.
    last: Lanes,
}

impl Shape {
    fn new(layer: &Layer, n_lanes: usize, n_members: usize) -> Self {
        let n_panels = n_panels(layer.n_outputs);
        let n_last = layer.n_outputs - (n_panels - 1) * WIDTH;
        Self {
            n_rows: n_lanes / n_members / n_panels,
            n_panels,
            n: layer.n_outputs as f32,
            last: lanes(|i| if i < n_last { 1.0 } else { 0.0 }),
        }
    }

    fn part(&self, member: usize) -> std::ops::Range<usize> {
        let size = self.n_panels * self.n_rows;
        member * size..(member + 1) * size
    }

    #[inline(always)]
    fn mask(&self, panel: usize) -> Lanes {
        if panel + 1 == self.n_panels {
            self.last
        } else {
            [1.0; WIDTH]
        }
    }

    /// Sum over all panels of what `term` gives for the panel and its mask.
    #[inline(always)]
    fn sum(&self, term: impl Fn(usize, Lanes) -> Lanes) -> f32 {
        let mut sums = ZERO;
        for p in 0..self.n_panels {
            let term = term(p, self.mask(p));
            for i in 0..WIDTH {
                sums[i] += term[i];
            }
        }
        sum_lanes(&sums)
    }
}
