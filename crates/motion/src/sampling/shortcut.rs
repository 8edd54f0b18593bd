//! Shortening of a path.
//!
//! Method: Geraerts & Overmars, "Creating High-quality Paths for Motion Planning", IJRR 26(8), 2007,
//! section 4: two points anywhere on the path are joined by a straight motion when that is valid.

use rand::{Rng, RngExt as _};

use super::{StateValidity, is_motion_valid};
use crate::joint_space::JointSpace;

/// Replaces parts of the path by straight motions, `attempts` times; the ends stay.
pub fn shortcut(
    space: &JointSpace,
    validity: &mut impl StateValidity,
    path: &mut Vec<Vec<f64>>,
    step: f64,
    attempts: usize,
    rng: &mut impl Rng,
) {
    drop_waypoints(space, validity, path, step);
    for _ in 0..attempts {
        if path.len() < 3 {
            return;
        }
        let lengths = cumulative_lengths(space, path);
        let total = lengths[lengths.len() - 1];
        if total <= 0.0 {
            return;
        }
        let (s, t) = (rng.random_range(0.0..total), rng.random_range(0.0..total));
        let (s, t) = (s.min(t), s.max(t));
        let (i, a) = point_at(space, path, &lengths, s);
        let (j, b) = point_at(space, path, &lengths, t);
        let saves = (t - s) - space.distance(&a, &b);
        const WORTHWHILE: f64 = 1e-3;
        if i == j || saves < WORTHWHILE || !is_motion_valid(space, validity, &a, &b, step) {
            continue;
        }
        // Waypoints i+1 ..= j lie between the two points.
        path.splice(i + 1..=j, [a, b]);
    }
    drop_waypoints(space, validity, path, step);
}

/// Leaves out each waypoint whose neighbours can be joined, from the start on.
fn drop_waypoints(
    space: &JointSpace,
    validity: &mut impl StateValidity,
    path: &mut Vec<Vec<f64>>,
    step: f64,
) {
    let mut i = 1;
    while i + 1 < path.len() {
        if is_motion_valid(space, validity, &path[i - 1], &path[i + 1], step) {
            path.remove(i);
        } else {
            i += 1;
        }
    }
}

fn cumulative_lengths(space: &JointSpace, path: &[Vec<f64>]) -> Vec<f64> {
    let mut lengths = vec![0.0];
    let mut total = 0.0;
    for pair in path.windows(2) {
        total += space.distance(&pair[0], &pair[1]);
        lengths.push(total);
    }
    lengths
}

/// The segment that holds the point at path length `s`, and the point.
fn point_at(space: &JointSpace, path: &[Vec<f64>], lengths: &[f64], s: f64) -> (usize, Vec<f64>) {
    let segment = lengths
        .partition_point(|&length| length <= s)
        .clamp(1, path.len() - 1)
        - 1;
    let length = lengths[segment + 1] - lengths[segment];
    let t = if length > 0.0 {
        ((s - lengths[segment]) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (
        segment,
        space.interpolate(&path[segment], &path[segment + 1], t),
    )
}
