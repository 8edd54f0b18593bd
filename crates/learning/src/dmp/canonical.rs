//! The canonical system: a phase that stands for time, so that one shape runs in any duration.

use super::DmpError;
use super::error::check_positive;

/// Longest single step in durations: by then the motion has long ended.
const STEP_SHARE_MAX: f64 = 1000.0;

/// Phase after a share of the duration: 1 at the start, towards 0 after the end.
pub(super) fn phase_at(share: f64, phase_decay: f64) -> f64 {
    (-phase_decay * share).exp()
}

/// How many equal substeps a step takes that last at most a share of the duration, and how long each is (s).
pub(super) fn substeps(
    step_s: f64,
    duration_s: f64,
    share_max: f64,
) -> Result<(usize, f64), DmpError> {
    check_positive("step", step_s)?;
    let share = step_s / duration_s;
    if share > STEP_SHARE_MAX {
        return Err(DmpError::OutOfRange {
            name: "step in durations",
            found: share,
            wanted: "at most 1000",
        });
    }
    let n_substeps = (share / share_max).ceil().max(1.0) as usize;
    Ok((n_substeps, step_s / n_substeps as f64))
}
