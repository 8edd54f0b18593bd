//! Where an axis is marked.

/// At most so many steps from 0 to the end.
const N_STEPS_MAX: f64 = 5.0;

/// Marks from 0 to at least `most`, a step of 1, 2 or 5 times a power of ten apart. An axis of nothing goes to 1.
pub(super) fn ticks(most: f64) -> Vec<f64> {
    let most = if most.is_finite() && most > 0.0 {
        most
    } else {
        1.0
    };
    let power = 10_f64.powf((most / N_STEPS_MAX).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        // Rounding must not cost a step that fits.
        .find(|step| most / step <= N_STEPS_MAX + 1e-9)
        .unwrap_or(10.0 * power);
    let n_steps = (most / step - 1e-9).ceil() as u32;
    // Rounded to the digits of the step, so that labels are short.
    let digits = 1.0 / power;
    (0..=n_steps)
        .map(|idx| (f64::from(idx) * step * digits).round() / digits)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::ticks;

    #[test]
    fn marks_are_round_and_reach_the_end() {
        assert_eq!(ticks(100.0), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(ticks(37.0), [0.0, 10.0, 20.0, 30.0, 40.0]);
        assert_eq!(ticks(5.0), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(ticks(0.3), [0.0, 0.1, 0.2, 0.3]);
        assert_eq!(ticks(0.0), ticks(1.0));
        assert_eq!(ticks(f64::NAN), ticks(1.0));
    }
}
