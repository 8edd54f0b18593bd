//! The space of configurations: limits, distance, interpolation, sampling.
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | q | configuration, length n | rad, or m for a slide |
//! | w | weight of a joint in the distance | 1, or 1/m for a slide |
//!
//! The distance is the weighted Euclidean norm of the joint differences; a continuous joint takes the
//! short way round. Weights make a metre of a slide comparable with radians.

use std::f64::consts::{PI, TAU};

use factotum_geometry::frames::wrap_angle;
use rand::{Rng, RngExt as _};

/// What one joint may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimit {
    /// Lowest position, rad or m; minus infinity for a continuous joint.
    pub lower: f64,
    /// Highest position, rad or m; infinity for a continuous joint.
    pub upper: f64,
    /// Largest speed, rad/s or m/s.
    pub velocity: f64,
    /// Largest acceleration, rad/s² or m/s².
    pub acceleration: f64,
    /// Largest jerk, rad/s³ or m/s³.
    pub jerk: f64,
    /// A hinge without position limits.
    pub continuous: bool,
    /// A slide: positions are metres.
    pub slide: bool,
}

impl JointLimit {
    /// Width of the position range; 2π for a continuous joint.
    pub fn range(&self) -> f64 {
        if self.continuous {
            TAU
        } else {
            self.upper - self.lower
        }
    }

    /// Whether a position is allowed, with a tolerance for rounding.
    pub fn allows(&self, position: f64) -> bool {
        const ROUNDING: f64 = 1e-9;
        position.is_finite()
            && (self.continuous
                || (position >= self.lower - ROUNDING && position <= self.upper + ROUNDING))
    }

    /// The nearest allowed position.
    pub fn clamp(&self, position: f64) -> f64 {
        if self.continuous {
            position
        } else {
            position.clamp(self.lower, self.upper)
        }
    }

    /// The equivalent position (a whole number of turns away, within the limits) nearest to `reference`.
    pub fn equivalent_near(&self, position: f64, reference: f64) -> f64 {
        if self.slide {
            return position;
        }
        if self.continuous {
            return reference + wrap_angle(position - reference);
        }
        let n_turns = ((reference - position) / TAU).round();
        let candidate = position + n_turns * TAU;
        // The best number of turns may lie outside the limits; fewer turns towards the given position are inside.
        let mut best = position;
        for candidate in [candidate, candidate - TAU, candidate + TAU] {
            if candidate >= self.lower
                && candidate <= self.upper
                && (candidate - reference).abs() < (best - reference).abs()
            {
                best = candidate;
            }
        }
        best
    }
}

/// The configurations of a chain.
#[derive(Debug, Clone, PartialEq)]
pub struct JointSpace {
    limits: Vec<JointLimit>,
    weights: Vec<f64>,
}

/// Radians that count as much as a metre of a slide: a lift carries the whole arm, which reaches less than a metre.
const SLIDE_WEIGHT: f64 = 2.0;

impl JointSpace {
    /// The space with these limits.
    pub fn new(limits: Vec<JointLimit>) -> Self {
        let weights = limits
            .iter()
            .map(|limit| if limit.slide { SLIDE_WEIGHT } else { 1.0 })
            .collect();
        Self { limits, weights }
    }

    /// Number of joints.
    pub fn n(&self) -> usize {
        self.limits.len()
    }

    /// What each joint may do.
    pub fn limits(&self) -> &[JointLimit] {
        &self.limits
    }

    /// Difference `to - from` of one joint, the short way round for a continuous one.
    pub fn difference(&self, joint_idx: usize, from: f64, to: f64) -> f64 {
        let d = to - from;
        if self.limits[joint_idx].continuous && d.abs() > PI {
            wrap_angle(d)
        } else {
            d
        }
    }

    /// Weighted distance of two configurations.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let squared: f64 = (0..self.n())
            .map(|i| {
                let d = self.weights[i] * self.difference(i, a[i], b[i]);
                d * d
            })
            .sum();
        squared.sqrt()
    }

    /// As [`Self::distance`], but infinity as soon as it is known to exceed `bound`.
    pub fn distance_below(&self, a: &[f64], b: &[f64], bound: f64) -> f64 {
        let bound_squared = bound * bound;
        let mut squared = 0.0;
        for i in 0..self.n() {
            let d = self.weights[i] * self.difference(i, a[i], b[i]);
            squared += d * d;
            if squared > bound_squared {
                return f64::INFINITY;
            }
        }
        squared.sqrt()
    }

    /// Length of a path.
    pub fn path_length(&self, path: &[Vec<f64>]) -> f64 {
        path.windows(2)
            .map(|pair| self.distance(&pair[0], &pair[1]))
            .sum()
    }

    /// The configuration at the fraction `t` of the way from `a` to `b`, written to `out`.
    pub fn interpolate_into(&self, a: &[f64], b: &[f64], t: f64, out: &mut [f64]) {
        for i in 0..self.n() {
            out[i] = a[i] + t * self.difference(i, a[i], b[i]);
        }
    }

    /// The configuration at the fraction `t` of the way from `a` to `b`.
    pub fn interpolate(&self, a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.n()];
        self.interpolate_into(a, b, t, &mut out);
        out
    }

    /// A uniform sample within the limits, written to `out`; continuous joints in [-π, π).
    pub fn sample_into(&self, rng: &mut impl Rng, out: &mut [f64]) {
        for (value, limit) in out.iter_mut().zip(&self.limits) {
            *value = if limit.continuous {
                rng.random_range(-PI..PI)
            } else if limit.lower < limit.upper {
                rng.random_range(limit.lower..=limit.upper)
            } else {
                limit.lower
            };
        }
    }

    /// Whether every joint is within its limits.
    pub fn is_within_limits(&self, q: &[f64]) -> bool {
        q.len() == self.n() && self.limits.iter().zip(q).all(|(limit, &q)| limit.allows(q))
    }

    /// The equivalent configuration nearest to `reference`: joints turned by whole turns where limits allow.
    pub fn equivalent_near(&self, q: &[f64], reference: &[f64]) -> Vec<f64> {
        (0..self.n())
            .map(|i| self.limits[i].equivalent_near(q[i], reference[i]))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn space() -> JointSpace {
        let limited = JointLimit {
            lower: -2.0,
            upper: 5.0,
            velocity: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
            continuous: false,
            slide: false,
        };
        let continuous = JointLimit {
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            continuous: true,
            ..limited
        };
        let lift = JointLimit {
            lower: 0.0,
            upper: 0.4,
            slide: true,
            ..limited
        };
        JointSpace::new(vec![lift, limited, continuous])
    }

    fn q() -> impl Strategy<Value = Vec<f64>> {
        (0.0..0.4, -2.0..5.0, -9.0..9.0).prop_map(|(a, b, c)| vec![a, b, c])
    }

    proptest! {
        #[test]
        fn distance_is_a_metric(a in q(), b in q(), c in q()) {
            let space = space();
            prop_assert!(space.distance(&a, &a) < 1e-12);
            prop_assert!((space.distance(&a, &b) - space.distance(&b, &a)).abs() < 1e-9);
            prop_assert!(space.distance(&a, &c) <= space.distance(&a, &b) + space.distance(&b, &c) + 1e-9);
        }

        #[test]
        fn interpolation_divides_the_distance(a in q(), b in q(), t in 0.0..1.0) {
            let space = space();
            let middle = space.interpolate(&a, &b, t);
            let whole = space.distance(&a, &b);
            // (at exactly half a turn the short way is not unique)
            prop_assume!((space.difference(2, a[2], b[2]).abs() - PI).abs() > 1e-6);
            prop_assert!((space.distance(&a, &middle) - t * whole).abs() < 1e-9);
        }

        #[test]
        fn the_nearest_equivalent_is_equivalent_allowed_and_near(a in q(), reference in q()) {
            let space = space();
            let near = space.equivalent_near(&a, &reference);
            prop_assert!(space.is_within_limits(&near));
            prop_assert!((near[0] - a[0]).abs() < 1e-12);
            for i in 1..3 {
                prop_assert!(wrap_angle(near[i] - a[i]).abs() < 1e-9);
                prop_assert!((near[i] - reference[i]).abs() <= (a[i] - reference[i]).abs() + 1e-9);
            }
            prop_assert!((near[2] - reference[2]).abs() <= PI + 1e-9);
        }
    }
}
