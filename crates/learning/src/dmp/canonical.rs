//! The canonical system: a phase that stands for time, so that one shape runs in any duration.

use super::DmpError;
use super::error::check_positive;

/// Longest step of the integration as a share of the duration; with the default damping, positions then err by less
/// than a ten-thousandth of the way (the midpoint rule is of second order).
const SUBSTEP_SHARE_MAX: f64 = 1.0 / 400.0;

/// Longest single step in durations: by then the motion has long ended.
const STEP_SHARE_MAX: f64 = 1000.0;

/// Phase after a share of the duration: 1 at the start, towards 0 after the end.
pub(super) fn phase_at(share: f64, phase_decay: f64) -> f64 {
    (-phase_decay * share).exp()
}

/// How many equal substeps a step takes, and how long each is (s).
pub(super) fn substeps(step_s: f64, duration_s: f64) -> Result<(usize, f64), DmpError> {
    check_positive("step", step_s)?;
    let share = step_s / duration_s;
    if share > STEP_SHARE_MAX {
        return Err(DmpError::OutOfRange {
            name: "step in durations",
            found: share,
            wanted: "at most 1000",
        });
    }
    let n_substeps = (share / SUBSTEP_SHARE_MAX).ceil().max(1.0) as usize;
    Ok((n_substeps, step_s / n_substeps as f64))
}
