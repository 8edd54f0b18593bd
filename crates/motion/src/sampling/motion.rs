//! Validity of a straight motion.

use super::StateValidity;
use crate::joint_space::JointSpace;

/// Whether the motion from `a` (taken to be valid) to `b` is valid at configurations at most `step` apart, `b` included.
///
/// The middle is tried before the quarters and so on: a motion that collides mostly does so far from its ends.
pub fn is_motion_valid(
    space: &JointSpace,
    validity: &mut impl StateValidity,
    a: &[f64],
    b: &[f64],
    step: f64,
) -> bool {
    if !validity.is_valid(b) {
        return false;
    }
    let n_steps = (space.distance(a, b) / step).ceil() as usize;
    if n_steps < 2 {
        return true;
    }
    let mut q = vec![0.0; space.n()];
    let mut stride = n_steps.next_power_of_two() / 2;
    while stride > 0 {
        for i in (stride..n_steps).step_by(2 * stride) {
            space.interpolate_into(a, b, i as f64 / n_steps as f64, &mut q);
            if !validity.is_valid(&q) {
                return false;
            }
        }
        stride /= 2;
    }
    true
}
