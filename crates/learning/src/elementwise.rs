//! What is done to each number of a row of sixteen by itself.

use pulp::{Arch, Simd, WithSimd};

use crate::panels::{Lanes, ZERO};

/// Every number becomes its hyperbolic tangent, to within 4e-7.
///
/// `tanh(x / 4)` by Lambert's continued fraction to the term 13, then twice `tanh(2 y) = 2 t / (1 + t²)`. The
/// fraction alone is good to 1e-7 only near zero; a quarter of what f32 can tell from one, |x| <= 10, is near enough.
pub(crate) fn tanh_in_place(rows: &mut [Lanes]) {
    Arch::new().dispatch(Tanh { rows });
}

/// `delta *= 1 - y²`: the derivative of the hyperbolic tangent by its value `y`.
pub(crate) fn gate_by_tanh(delta: &mut [Lanes], y: &[Lanes]) {
    Arch::new().dispatch(GateByTanh { delta, y });
}

/// Negative numbers become zero.
pub(crate) fn relu_in_place(rows: &mut [Lanes]) {
    for value in rows.as_flattened_mut() {
        *value = value.max(0.0);
    }
}

/// `delta` becomes zero where `y` is not positive.
pub(crate) fn gate_by_relu(delta: &mut [Lanes], y: &[Lanes]) {
    for (delta, y) in delta.as_flattened_mut().iter_mut().zip(y.as_flattened()) {
        if *y <= 0.0 {
            *delta = 0.0;
        }
    }
}

/// `target += share (source - target)`: the soft update of a target network (Lillicrap et al., 2016, section 3).
pub(crate) fn blend(target: &mut [Lanes], source: &[Lanes], share: f32) {
    Arch::new().dispatch(Blend {
        target,
        source,
        share,
    });
}

/// Whether no number is NaN or infinite.
pub(crate) fn all_finite(rows: &[Lanes]) -> bool {
    Arch::new().dispatch(AllFinite { rows })
}

struct Tanh<'a> {
    rows: &'a mut [Lanes],
}

impl WithSimd for Tanh<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let constant = |value| simd.splat_f32s(value);
        let (least, most) = (constant(-10.0), constant(10.0));
        let (quarter, one) = (constant(0.25), constant(1.0));
        let above = [135_135.0, 17_325.0, 378.0, 1.0].map(constant);
        let below = [135_135.0, 62_370.0, 3_150.0, 28.0].map(constant);
        let polynomial = |c: &[S::f32s; 4], y2| {
            let inner = simd.mul_add_e_f32s(c[3], y2, c[2]);
            let inner = simd.mul_add_e_f32s(inner, y2, c[1]);
            simd.mul_add_e_f32s(inner, y2, c[0])
        };
        let double = |t| {
            let t2 = simd.mul_add_e_f32s(t, t, one);
            simd.div_f32s(simd.add_f32s(t, t), t2)
        };
        for row in self.rows {
            for value in S::as_mut_simd_f32s(row).0 {
                // NaN stays NaN: where a comparison fails the second argument is taken, and that is the value.
                let x = simd.min_f32s(most, simd.max_f32s(least, *value));
                let y = simd.mul_f32s(x, quarter);
                let y2 = simd.mul_f32s(y, y);
                let t = simd.div_f32s(
                    simd.mul_f32s(y, polynomial(&above, y2)),
                    polynomial(&below, y2),
                );
                *value = double(double(t));
            }
        }
    }
}

struct GateByTanh<'a> {
    delta: &'a mut [Lanes],
    y: &'a [Lanes],
}

impl WithSimd for GateByTanh<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let one = simd.splat_f32s(1.0);
        for (delta, y) in self.delta.iter_mut().zip(self.y) {
            for (delta, y) in S::as_mut_simd_f32s(delta)
                .0
                .iter_mut()
                .zip(S::as_simd_f32s(y).0)
            {
                let slope = simd.sub_f32s(one, simd.mul_f32s(*y, *y));
                *delta = simd.mul_f32s(*delta, slope);
            }
        }
    }
}

struct Blend<'a> {
    target: &'a mut [Lanes],
    source: &'a [Lanes],
    share: f32,
}

impl WithSimd for Blend<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let share = simd.splat_f32s(self.share);
        for (target, source) in self.target.iter_mut().zip(self.source) {
            for (target, source) in S::as_mut_simd_f32s(target)
                .0
                .iter_mut()
                .zip(S::as_simd_f32s(source).0)
            {
                let way = simd.sub_f32s(*source, *target);
                *target = simd.mul_add_e_f32s(share, way, *target);
            }
        }
    }
}

struct AllFinite<'a> {
    rows: &'a [Lanes],
}

impl WithSimd for AllFinite<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        // x - x is zero for a finite x, and NaN otherwise; sums keep a NaN.
        let mut sums = ZERO;
        for row in self.rows {
            let sums = S::as_mut_simd_f32s(&mut sums).0;
            for (sum, value) in sums.iter_mut().zip(S::as_simd_f32s(row).0) {
                *sum = simd.add_f32s(*sum, simd.sub_f32s(*value, *value));
            }
        }
        sums.iter().all(|sum| !sum.is_nan())
    }
}

#[cfg(test)]
mod tests {
    use super::{all_finite, blend, gate_by_tanh, tanh_in_place};
    use crate::panels::WIDTH;

    #[test]
    fn tanh_is_that_of_the_standard_library() {
        let mut worst: f64 = 0.0;
        for step in -30_000..30_000 {
            let x = step as f32 * 5e-4;
            let mut row = [[x; WIDTH]];
            tanh_in_place(&mut row);
            let wanted = f64::from(x).tanh();
            worst = worst.max((f64::from(row[0][3]) - wanted).abs());
            assert!(row[0][3].abs() <= 1.0, "tanh {x} is {}", row[0][3]);
        }
        assert!(worst < 4e-7, "{worst}");
        let mut ends = [[0.0; WIDTH]];
        ends[0][..4].copy_from_slice(&[f32::INFINITY, f32::NEG_INFINITY, f32::NAN, -1e-20]);
        tanh_in_place(&mut ends);
        assert_eq!(ends[0][..2], [1.0, -1.0]);
        assert!(ends[0][2].is_nan());
        assert!((ends[0][3] + 1e-20).abs() < 1e-26);
    }

    #[test]
    fn the_slope_of_tanh_is_one_less_its_square() {
        let mut delta = [[2.0; WIDTH]];
        gate_by_tanh(&mut delta, &[[0.5; WIDTH]]);
        assert_eq!(delta[0], [1.5; WIDTH]);
    }

    #[test]
    fn a_target_goes_a_share_of_the_way() {
        let mut target = [[1.0; WIDTH]];
        blend(&mut target, &[[3.0; WIDTH]], 0.25);
        assert_eq!(target[0], [1.5; WIDTH]);
    }

    #[test]
    fn one_number_that_is_not_finite_is_found() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut rows = vec![[f32::MAX; WIDTH]; 9];
            assert!(all_finite(&rows));
            rows[7][11] = bad;
            assert!(!all_finite(&rows), "{bad}");
        }
    }
}
