//! The products against sums written out, at sizes that fill tiles and panels and that do not.

use pulp::{Arch, Scalar, Scalar128b, Scalar256b, Scalar512b, WithSimd as _};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::{
    Dot, Finish, Lanes, Multiply, MultiplyTransposed, Panels, SumRows, WIDTH, ZERO, dot_into,
    multiply_into, multiply_transposed_into, n_panels, sum_rows_into, transpose_into,
};

/// A matrix of random numbers, and it in panels.
struct Sample {
    n_rows: usize,
    n_cols: usize,
    lanes: Vec<Lanes>,
}

impl Sample {
    fn new(rng: &mut ChaCha8Rng, n_rows: usize, n_cols: usize) -> Self {
        let mut lanes = vec![ZERO; n_rows * n_panels(n_cols)];
        for column in 0..n_cols {
            for row in 0..n_rows {
                lanes[column / WIDTH * n_rows + row][column % WIDTH] = rng.random_range(-1.0..1.0);
            }
        }
        Self {
            n_rows,
            n_cols,
            lanes,
        }
    }

    fn panels(&self) -> Panels<'_> {
        Panels::new(&self.lanes, self.n_rows, self.n_cols)
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        at(&self.lanes, self.n_rows, row, column)
    }
}

fn at(lanes: &[Lanes], n_rows: usize, row: usize, column: usize) -> f64 {
    f64::from(lanes[column / WIDTH * n_rows + row][column % WIDTH])
}

/// Rounding of at most 260 products of numbers below one.
const TOLERANCE: f64 = 2e-5;

fn check(found: f64, wanted: f64, what: &str) {
    assert!(
        (found - wanted).abs() < TOLERANCE,
        "{what}: {found} for {wanted}"
    );
}

const SIZES: [(usize, usize, usize); 6] = [
    (1, 1, 1),
    (1, 50, 13),
    (7, 16, 17),
    (23, 33, 5),
    (64, 63, 128),
    (259, 64, 64),
];

#[test]
fn products_are_sums_of_products() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for (m, k, n) in SIZES {
        let (a, b) = (Sample::new(&mut rng, m, k), Sample::new(&mut rng, k, n));
        let (bias, gate) = (Sample::new(&mut rng, 1, n), Sample::new(&mut rng, m, n));
        let mut out = vec![[f32::NAN; WIDTH]; m * n_panels(n)];
        let wanted = |i: usize, j: usize| (0..k).map(|l| a.at(i, l) * b.at(l, j)).sum::<f64>();
        let each = |check: &dyn Fn(usize, usize)| {
            for i in 0..m {
                for j in 0..n_panels(n) * WIDTH {
                    check(i, j);
                }
            }
        };

        multiply_into(a.panels(), b.panels(), None, Finish::Keep, &mut out);
        each(&|i, j| {
            let wanted = if j < n { wanted(i, j) } else { 0.0 };
            check(at(&out, m, i, j), wanted, "plain");
        });

        multiply_into(
            a.panels(),
            b.panels(),
            Some(&bias.lanes),
            Finish::Relu,
            &mut out,
        );
        each(&|i, j| {
            let wanted = if j < n {
                (wanted(i, j) + bias.at(0, j)).max(0.0)
            } else {
                0.0
            };
            check(at(&out, m, i, j), wanted, "bias and relu");
        });

        multiply_into(
            a.panels(),
            b.panels(),
            None,
            Finish::Gate(&gate.lanes),
            &mut out,
        );
        each(&|i, j| {
            let open = j < n && gate.at(i, j) > 0.0;
            check(
                at(&out, m, i, j),
                if open { wanted(i, j) } else { 0.0 },
                "gated",
            );
        });
    }
}

#[test]
fn transposed_products_are_sums_over_rows() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for (k, m, n) in SIZES {
        let (a, b) = (Sample::new(&mut rng, k, m), Sample::new(&mut rng, k, n));
        let mut out = vec![[f32::NAN; WIDTH]; m * n_panels(n)];
        multiply_transposed_into(a.panels(), b.panels(), &mut out);
        for i in 0..m {
            for j in 0..n {
                let wanted = (0..k).map(|l| a.at(l, i) * b.at(l, j)).sum();
                check(at(&out, m, i, j), wanted, "transposed product");
            }
        }
        let mut transposed = vec![[f32::NAN; WIDTH]; m * n_panels(k)];
        transpose_into(a.panels(), &mut transposed);
        for i in 0..m {
            for j in 0..n_panels(k) * WIDTH {
                let wanted = if j < k { a.at(j, i) } else { 0.0 };
                check(at(&transposed, m, i, j), wanted, "transposed");
            }
        }
    }
}

#[test]
fn a_row_gives_dot_products_and_rows_are_summed() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for (m, k, _) in SIZES {
        let (a, w) = (Sample::new(&mut rng, m, k), Sample::new(&mut rng, 1, k));
        let mut out = vec![[f32::NAN; WIDTH]; m];
        dot_into(a.panels(), &w.lanes, 0.5, &mut out);
        for i in 0..m {
            let wanted = (0..k).map(|l| a.at(i, l) * w.at(0, l)).sum::<f64>() + 0.5;
            check(at(&out, m, i, 0), wanted, "dot product");
        }
        let mut sums = vec![[f32::NAN; WIDTH]; n_panels(k)];
        sum_rows_into(a.panels(), &mut sums);
        for j in 0..k {
            check(
                at(&sums, 1, 0, j),
                (0..m).map(|i| a.at(i, j)).sum(),
                "sum of rows",
            );
        }
    }
}

#[test]
fn the_last_panels_of_a_matrix_are_a_matrix() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let a = Sample::new(&mut rng, 5, 35);
    let tail = a.panels().after_panels(2);
    assert_eq!((tail.n_rows, tail.n_cols), (5, 3));
    assert_eq!(tail.panel(0), &a.lanes[10..]);
}

/// What each kernel makes of one pair of matrices.
fn all_kernels(
    (m, k, n): (usize, usize, usize),
    multiply: impl Fn(Multiply<'_>),
    multiply_transposed: impl Fn(MultiplyTransposed<'_>),
    dot: impl Fn(Dot<'_>),
    sum_rows: impl Fn(SumRows<'_>),
) -> Vec<Lanes> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (a, b) = (Sample::new(&mut rng, m, k), Sample::new(&mut rng, k, n));
    let (c, w) = (Sample::new(&mut rng, m, n), Sample::new(&mut rng, 1, k));
    let mut all = Vec::new();
    for finish in [Finish::Keep, Finish::Relu, Finish::Gate(&c.lanes)] {
        let mut out = vec![ZERO; m * n_panels(n)];
        multiply(Multiply {
            a: a.panels(),
            b: b.panels(),
            bias: Some(&b.lanes),
            finish,
            out: &mut out,
        });
        all.extend(out);
    }
    let mut out = vec![ZERO; k * n_panels(n)];
    multiply_transposed(MultiplyTransposed {
        a: a.panels(),
        b: c.panels(),
        out: &mut out,
    });
    all.extend(out);
    let mut out = vec![ZERO; m];
    dot(Dot {
        a: a.panels(),
        w: &w.lanes,
        bias: 0.25,
        out: &mut out,
    });
    all.extend(out);
    let mut out = vec![ZERO; n_panels(k)];
    sum_rows(SumRows {
        a: a.panels(),
        out: &mut out,
    });
    all.extend(out);
    all
}

/// Processors have vectors of 4, 8 or 16; one machine runs but one of them, so the others are imitated.
#[test]
fn every_width_of_vectors_gives_the_same_bits() {
    macro_rules! by {
        ($sizes:expr, $simd:expr) => {
            all_kernels(
                $sizes,
                |op| op.with_simd($simd),
                |op| op.with_simd($simd),
                |op| op.with_simd($simd),
                |op| op.with_simd($simd),
            )
        };
    }
    for sizes in SIZES {
        let bits = |lanes: &[Lanes]| -> Vec<u32> {
            lanes
                .as_flattened()
                .iter()
                .map(|value| value.to_bits())
                .collect()
        };
        let narrow = by!(sizes, Scalar128b);
        assert_eq!(bits(&narrow), bits(&by!(sizes, Scalar256b)), "{sizes:?}");
        assert_eq!(bits(&narrow), bits(&by!(sizes, Scalar512b)), "{sizes:?}");
        let arch = Arch::new();
        let this_machine = all_kernels(
            sizes,
            |op| arch.dispatch(op),
            |op| arch.dispatch(op),
            |op| arch.dispatch(op),
            |op| arch.dispatch(op),
        );
        if !matches!(arch, Arch::Scalar) {
            assert_eq!(bits(&narrow), bits(&this_machine), "{sizes:?}");
        }
        // Without vectors there is no fused multiply-add, and sums round otherwise.
        let without = by!(sizes, Scalar);
        for (one, other) in without.as_flattened().iter().zip(narrow.as_flattened()) {
            check(f64::from(*one), f64::from(*other), "without vectors");
        }
    }
}
