//! A rounded corner between two straight segments.
//!
//! The tangent turns from the first direction `u` to the second `v` as a smoothstep, so the curve, its
//! tangent and its curvature join the straight parts without a jump:
//!
//! ```text
//! q'(s) = u + (v - u) φ(x),   x = s / 2r,   φ(x) = 3x² - 2x³,   s in [0, 2r]
//! q(0)  = c - r u,   q(2r) = c + r v
//! ```
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | c | corner | rad, m |
//! | r | reach: how much of each segment the blend replaces | rad (m) |
//!
//! Bounds used: |φ| ≤ 1, |φ'| ≤ 3/2, |φ''| ≤ 6, and the distance from the corner, which is largest at
//! the middle: r |v - u| · 3/16.

use crate::joint_space::JointLimit;

/// Largest distance of the curve from the corner per reach and per |v - u|.
const DEVIATION_FACTOR: f64 = 3.0 / 16.0;
/// Directions nearer than this are one direction: nothing to round.
const TURN_ZERO: f64 = 1e-9;

/// A rounded corner.
#[derive(Debug, Clone, PartialEq)]
pub struct Blend {
    start: Vec<f64>,
    u: Vec<f64>,
    turn: Vec<f64>,
    reach: f64,
}

impl Blend {
    /// The largest blend within the reach and the distance given; none if it would be nothing or a reversal.
    pub fn new(
        corner: &[f64],
        u: &[f64],
        v: &[f64],
        reach_max: f64,
        deviation_max: f64,
    ) -> Option<Self> {
        let turn: Vec<f64> = v.iter().zip(u).map(|(v, u)| v - u).collect();
        let turn_norm = turn.iter().map(|d| d * d).sum::<f64>().sqrt();
        let reach = if turn_norm > TURN_ZERO {
            reach_max.min(deviation_max / (DEVIATION_FACTOR * turn_norm))
        } else {
            reach_max
        };
        const REACH_MIN: f64 = 1e-7;
        if reach < REACH_MIN {
            return None;
        }
        let start = corner.iter().zip(u).map(|(c, u)| c - reach * u).collect();
        Some(Self {
            start,
            u: u.to_vec(),
            turn,
            reach,
        })
    }

    /// The largest blend of the corner between two segments; at most half of each is replaced.
    pub fn between(
        before: &[f64],
        corner: &[f64],
        after: &[f64],
        deviation_max: f64,
    ) -> Option<Self> {
        let (u, length_before) = direction(before, corner)?;
        let (v, length_after) = direction(corner, after)?;
        Self::new(
            corner,
            &u,
            &v,
            0.5 * length_before.min(length_after),
            deviation_max,
        )
    }

    /// How much of each segment the blend replaces.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Range of the parameter s.
    pub fn length(&self) -> f64 {
        2.0 * self.reach
    }

    /// Position and dq/ds at s.
    pub fn at(&self, s: f64) -> (Vec<f64>, Vec<f64>) {
        let x = (s / self.length()).clamp(0.0, 1.0);
        let phi = x * x * (3.0 - 2.0 * x);
        // Integral of φ from 0 to x.
        let area = x * x * x * (1.0 - 0.5 * x);
        let q = (0..self.u.len())
            .map(|i| self.start[i] + self.length() * (x * self.u[i] + area * self.turn[i]))
            .collect();
        let tangent = (0..self.u.len())
            .map(|i| self.u[i] + phi * self.turn[i])
            .collect();
        (q, tangent)
    }

    /// Largest constant ds/dt at which all joints keep their limits.
    pub fn speed_max(&self, limits: &[JointLimit]) -> f64 {
        let length = self.length();
        limits
            .iter()
            .enumerate()
            .map(|(i, limit)| {
                let (u, turn) = (self.u[i], self.turn[i].abs());
                let rate = u.abs().max((u + self.turn[i]).abs());
                let curvature = 1.5 * turn / length;
                let curvature_rate = 6.0 * turn / (length * length);
                (limit.velocity / rate)
                    .min((limit.acceleration / curvature).sqrt())
                    .min((limit.jerk / curvature_rate).cbrt())
            })
            .fold(f64::INFINITY, f64::min)
    }
}

/// Unit direction and length of a segment; none if it has no length.
fn direction(from: &[f64], to: &[f64]) -> Option<(Vec<f64>, f64)> {
    const LENGTH_ZERO: f64 = 1e-9;
    let difference: Vec<f64> = to.iter().zip(from).map(|(to, from)| to - from).collect();
    let length = difference.iter().map(|d| d * d).sum::<f64>().sqrt();
    (length > LENGTH_ZERO).then(|| (difference.iter().map(|d| d / length).collect(), length))
}
