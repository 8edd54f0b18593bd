//! Dense products of matrices that lie in panels, sixteen columns wide.
//!
//! A matrix of `n_rows` x `n_cols` is kept as `ceil(n_cols / 16)` panels, one after the other; row `i` of a panel is
//! one [`Lanes`]. Columns beyond `n_cols` are zero. So the product's inner loop reads both factors in the order they
//! lie in memory, and nothing is packed, which is most of what a general matrix product pays at these sizes (products
//! of 256 x 64 by 64 x 64: measured in `benches/td3.rs`).
//!
//! Every element of a product is summed in the order of its inner index, whatever the width of the processor's
//! vectors, so that machines with fused multiply-add agree to the bit.

use pulp::{Arch, Simd, WithSimd};

/// Columns of a panel: one cache line.
pub(crate) const WIDTH: usize = 16;

/// One row of a panel.
pub(crate) type Lanes = [f32; WIDTH];

/// A row of zeros.
pub(crate) const ZERO: Lanes = [0.0; WIDTH];

/// Panels that hold so many columns.
pub(crate) const fn n_panels(n_cols: usize) -> usize {
    n_cols.div_ceil(WIDTH)
}

/// A matrix in panels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Panels<'a> {
    lanes: &'a [Lanes],
    n_rows: usize,
    n_cols: usize,
}

impl<'a> Panels<'a> {
    /// The matrix in `lanes`, which may hold further panels behind it.
    pub(crate) fn new(lanes: &'a [Lanes], n_rows: usize, n_cols: usize) -> Self {
        Self {
            lanes: &lanes[..n_rows * n_panels(n_cols)],
            n_rows,
            n_cols,
        }
    }

    /// Its columns from the panel `first` on.
    pub(crate) fn after_panels(self, first: usize) -> Self {
        Self {
            lanes: &self.lanes[first * self.n_rows..],
            n_rows: self.n_rows,
            n_cols: self.n_cols - first * WIDTH,
        }
    }

    fn n_panels(&self) -> usize {
        n_panels(self.n_cols)
    }

    fn panel(&self, index: usize) -> &'a [Lanes] {
        &self.lanes[index * self.n_rows..][..self.n_rows]
    }
}

/// What becomes of a sum before it is stored.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Finish<'a> {
    /// Stored as it is.
    Keep,
    /// Negative sums become zero.
    Relu,
    /// Zero wherever the given matrix is not positive: the derivative of [`Finish::Relu`].
    Gate(&'a [Lanes]),
}

/// `out = finish(a b + bias)`, the bias added to every row.
pub(crate) fn multiply_into(
    a: Panels<'_>,
    b: Panels<'_>,
    bias: Option<&[Lanes]>,
    finish: Finish<'_>,
    out: &mut [Lanes],
) {
    assert_eq!(a.n_cols, b.n_rows, "inner sizes of a product");
    Arch::new().dispatch(Multiply {
        a,
        b,
        bias,
        finish,
        out,
    });
}

/// `out = aᵀ b`.
pub(crate) fn multiply_transposed_into(a: Panels<'_>, b: Panels<'_>, out: &mut [Lanes]) {
    assert_eq!(a.n_rows, b.n_rows, "inner sizes of a transposed product");
    Arch::new().dispatch(MultiplyTransposed { a, b, out });
}

/// `out = a wᵀ + bias` for one row `w`: a product with one column.
pub(crate) fn dot_into(a: Panels<'_>, w: &[Lanes], bias: f32, out: &mut [Lanes]) {
    Arch::new().dispatch(Dot { a, w, bias, out });
}

/// `out = aᵀ`.
pub(crate) fn transpose_into(a: Panels<'_>, out: &mut [Lanes]) {
    let out_rows = a.n_cols;
    for (block, out_panel) in out[..out_rows * n_panels(a.n_rows)]
        .chunks_exact_mut(out_rows)
        .enumerate()
    {
        let rows = block * WIDTH..((block + 1) * WIDTH).min(a.n_rows);
        for (p, out_rows) in out_panel.chunks_mut(WIDTH).enumerate() {
            let source = &a.panel(p)[rows.clone()];
            for (column, out_row) in out_rows.iter_mut().enumerate() {
                *out_row = ZERO;
                for (to, from) in out_row.iter_mut().zip(source) {
                    *to = from[column];
                }
            }
        }
    }
}

/// `out` = the sum of the rows of `a`.
pub(crate) fn sum_rows_into(a: Panels<'_>, out: &mut [Lanes]) {
    Arch::new().dispatch(SumRows { a, out });
}

/// The vectors of one row; `N` of them make [`WIDTH`].
#[inline(always)]
fn load<S: Simd, const N: usize>(simd: S, row: &Lanes) -> [S::f32s; N] {
    let vectors = S::as_simd_f32s(row).0;
    let mut loaded = [simd.splat_f32s(0.0); N];
    for (to, from) in loaded.iter_mut().zip(vectors) {
        *to = *from;
    }
    loaded
}

#[inline(always)]
fn store<S: Simd, const N: usize>(_: S, values: [S::f32s; N], row: &mut Lanes) {
    for (to, from) in S::as_mut_simd_f32s(row).0.iter_mut().zip(values) {
        *to = from;
    }
}

/// `sums[r] += a[r] b` for each row `r` of the tile.
#[inline(always)]
fn accumulate<S: Simd, const R: usize, const N: usize>(
    simd: S,
    a: [f32; R],
    b: &Lanes,
    sums: &mut [[S::f32s; N]; R],
) {
    let b = load::<S, N>(simd, b);
    for r in 0..R {
        let a = simd.splat_f32s(a[r]);
        for n in 0..N {
            sums[r][n] = simd.mul_add_e_f32s(a, b[n], sums[r][n]);
        }
    }
}

struct Multiply<'a> {
    a: Panels<'a>,
    b: Panels<'a>,
    bias: Option<&'a [Lanes]>,
    finish: Finish<'a>,
    out: &'a mut [Lanes],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        // OPTIMIZATION: tiles as high as the registers hold: 12 sums of 16 with 16 registers of 8, 12 with 32 of 16.
        match S::F32_LANES {
            16 => self.run::<S, 12, 1>(simd),
            8 => self.run::<S, 6, 2>(simd),
            4 => self.run::<S, 6, 4>(simd),
            _ => self.run::<S, 1, 16>(simd),
        }
    }
}

impl Multiply<'_> {
    #[inline(always)]
    fn run<S: Simd, const R: usize, const N: usize>(&mut self, simd: S) {
        let n_rows = self.a.n_rows;
        for panel in 0..self.b.n_panels() {
            let mut row = 0;
            while row + R <= n_rows {
                self.tile::<S, R, N>(simd, panel, row);
                row += R;
            }
            while row + 4 <= n_rows {
                self.tile::<S, 4, N>(simd, panel, row);
                row += 4;
            }
            while row < n_rows {
                self.tile::<S, 1, N>(simd, panel, row);
                row += 1;
            }
        }
    }

    /// Rows `row..row + R` of one panel.
    #[inline(always)]
    fn tile<S: Simd, const R: usize, const N: usize>(&mut self, simd: S, panel: usize, row: usize) {
        let zero = simd.splat_f32s(0.0);
        let first = match self.bias {
            Some(bias) => load::<S, N>(simd, &bias[panel]),
            None => [zero; N],
        };
        let mut sums = [first; R];
        for (p, b) in self.b.panel(panel).chunks(WIDTH).enumerate() {
            let a = self.a.panel(p)[row..].first_chunk::<R>();
            let Some(a) = a else { return };
            // OPTIMIZATION: a whole block has a known length, so that the loop is unrolled.
            if let Some(b) = b.as_array::<WIDTH>() {
                for k in 0..WIDTH {
                    accumulate(simd, std::array::from_fn(|r| a[r][k]), &b[k], &mut sums);
                }
            } else {
                for (k, b) in b.iter().enumerate() {
                    accumulate(simd, std::array::from_fn(|r| a[r][k]), b, &mut sums);
                }
            }
        }
        let at = panel * self.a.n_rows + row;
        let out = &mut self.out[at..][..R];
        match self.finish {
            Finish::Keep => {
                for (sum, row) in sums.into_iter().zip(out) {
                    store(simd, sum, row);
                }
            }
            Finish::Relu => {
                for (sum, row) in sums.into_iter().zip(out) {
                    store(simd, sum.map(|sum| simd.max_f32s(sum, zero)), row);
                }
            }
            Finish::Gate(gate) => {
                for ((sum, row), gate) in sums.into_iter().zip(out).zip(&gate[at..][..R]) {
                    let gate = load::<S, N>(simd, gate);
                    let gated = std::array::from_fn(|n| {
                        let open = simd.less_than_f32s(zero, gate[n]);
                        simd.select_f32s(open, sum[n], zero)
                    });
                    store::<S, N>(simd, gated, row);
                }
            }
        }
    }
}

struct MultiplyTransposed<'a> {
    a: Panels<'a>,
    b: Panels<'a>,
    out: &'a mut [Lanes],
}

impl WithSimd for MultiplyTransposed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        match S::F32_LANES {
            16 => self.run::<S, 1>(simd),
            8 => self.run::<S, 2>(simd),
            4 => self.run::<S, 4>(simd),
            _ => self.run::<S, 16>(simd),
        }
    }
}

impl MultiplyTransposed<'_> {
    #[inline(always)]
    fn run<S: Simd, const N: usize>(&mut self, simd: S) {
        for a in 0..self.a.n_panels() {
            let n_lanes = (self.a.n_cols - a * WIDTH).min(WIDTH);
            for b in 0..self.b.n_panels() {
                let mut lane = 0;
                // OPTIMIZATION: 16 rows are 6 + 5 + 5, as many as the registers hold.
                while lane < n_lanes {
                    lane += match n_lanes - lane {
                        16 | 15 => self.tile::<S, 6, N>(simd, a, lane, b),
                        5..15 => self.tile::<S, 5, N>(simd, a, lane, b),
                        2..5 => self.tile::<S, 2, N>(simd, a, lane, b),
                        _ => self.tile::<S, 1, N>(simd, a, lane, b),
                    };
                }
            }
        }
    }

    /// Rows `lane..lane + R` of the block under panel `a` of the first factor and panel `b` of the second; returns `R`.
    #[inline(always)]
    fn tile<S: Simd, const R: usize, const N: usize>(
        &mut self,
        simd: S,
        a: usize,
        lane: usize,
        b: usize,
    ) -> usize {
        let mut sums = [[simd.splat_f32s(0.0); N]; R];
        for (a, b) in self.a.panel(a).iter().zip(self.b.panel(b)) {
            if let Some(a) = a[lane..].first_chunk::<R>() {
                accumulate(simd, *a, b, &mut sums);
            }
        }
        let at = b * self.a.n_cols + a * WIDTH + lane;
        for (sum, row) in sums.into_iter().zip(&mut self.out[at..][..R]) {
            store(simd, sum, row);
        }
        R
    }
}

struct Dot<'a> {
    a: Panels<'a>,
    w: &'a [Lanes],
    bias: f32,
    out: &'a mut [Lanes],
}

impl WithSimd for Dot<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let a = self.a;
        for (row, out) in self.out[..a.n_rows].iter_mut().enumerate() {
            let mut sums = ZERO;
            for (p, w) in self.w.iter().enumerate().take(a.n_panels()) {
                let values = S::as_simd_f32s(&a.lanes[p * a.n_rows + row]).0;
                let weights = S::as_simd_f32s(w).0;
                let sums = S::as_mut_simd_f32s(&mut sums).0;
                for ((sum, value), weight) in sums.iter_mut().zip(values).zip(weights) {
                    *sum = simd.mul_add_e_f32s(*value, *weight, *sum);
                }
            }
            *out = ZERO;
            out[0] = self.bias + sum_lanes(&sums);
        }
    }
}

/// The sum of a row, in pairs, in the same order on every machine.
#[inline(always)]
pub(crate) fn sum_lanes(row: &Lanes) -> f32 {
    let mut sums = *row;
    let mut half = WIDTH / 2;
    while half > 0 {
        for lane in 0..half {
            sums[lane] += sums[lane + half];
        }
        half /= 2;
    }
    sums[0]
}

struct SumRows<'a> {
    a: Panels<'a>,
    out: &'a mut [Lanes],
}

impl WithSimd for SumRows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (p, out) in self.out.iter_mut().enumerate().take(self.a.n_panels()) {
            // OPTIMIZATION: four sums side by side, since each waits for the one before it.
            let mut sums = [ZERO; 4];
            for rows in self.a.panel(p).chunks(4) {
                for (sum, row) in sums.iter_mut().zip(rows) {
                    let sum = S::as_mut_simd_f32s(sum).0;
                    for (sum, value) in sum.iter_mut().zip(S::as_simd_f32s(row).0) {
                        *sum = simd.add_f32s(*sum, *value);
                    }
                }
            }
            for (lane, out) in out.iter_mut().enumerate() {
                *out = (sums[0][lane] + sums[1][lane]) + (sums[2][lane] + sums[3][lane]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
