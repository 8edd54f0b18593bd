//! From what a policy says, each component in -1..=1, to what an environment takes.

/// The range of each component of an action.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionBounds {
    low: Vec<f32>,
    high: Vec<f32>,
}

/// Why a range is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ActionError {
    /// Lower and upper ends, or caps, of different number.
    #[error("{what} has {found} components, expected {wanted}")]
    Size {
        /// What was given.
        what: &'static str,
        /// Its components.
        found: usize,
        /// Components wanted.
        wanted: usize,
    },
    /// An empty or infinite range.
    #[error(
        "component {index} ranges from {low} to {high}, expected two finite numbers, the second the larger"
    )]
    Range {
        /// Which component.
        index: usize,
        /// Its lower end.
        low: f32,
        /// Its upper end.
        high: f32,
    },
    /// A cap that cannot be.
    #[error("cap {index} of the correction is {found}, expected a number from 0 to 1")]
    Cap {
        /// Which component.
        index: usize,
        /// The cap.
        found: f32,
    },
}

fn check_size(what: &'static str, found: usize, wanted: usize) -> Result<(), ActionError> {
    if found == wanted {
        return Ok(());
    }
    Err(ActionError::Size {
        what,
        found,
        wanted,
    })
}

impl ActionBounds {
    /// The ranges `low[i]..=high[i]`.
    ///
    /// # Errors
    ///
    /// When the two differ in size, or a range is empty or infinite.
    pub fn new(low: Vec<f32>, high: Vec<f32>) -> Result<Self, ActionError> {
        check_size("the upper bound of the action", high.len(), low.len())?;
        for (index, (&low, &high)) in low.iter().zip(&high).enumerate() {
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(ActionError::Range { index, low, high });
            }
        }
        Ok(Self { low, high })
    }

    /// Components of an action.
    #[must_use]
    pub fn n_action(&self) -> usize {
        self.low.len()
    }

    /// Carries an action in -1..=1 to these ranges, in place; what lies outside is brought to the nearer end.
    ///
    /// # Errors
    ///
    /// When the action has another size.
    pub fn stretch(&self, action: &mut [f32]) -> Result<(), ActionError> {
        check_size("the action", action.len(), self.n_action())?;
        for (value, (low, high)) in action.iter_mut().zip(self.low.iter().zip(&self.high)) {
            // Halves first: the difference of the ends may not be finite.
            let share = 0.5 * (value.clamp(-1.0, 1.0) + 1.0);
            *value = (low * (1.0 - share) + high * share).clamp(*low, *high);
        }
        Ok(())
    }
}

/// A learned correction of a given action, no larger than a cap: residual reinforcement learning.
///
/// `action = clip(base + cap * correction, -1, 1)`, each component by itself, all within -1..=1. The cap bounds what
/// learning can do, however wrong it is. Johannink et al., "Residual Reinforcement Learning for Robot Control", ICRA
/// 2019, arXiv 1812.03201.
#[derive(Debug, Clone, PartialEq)]
pub struct CappedCorrection {
    caps: Vec<f32>,
}

impl CappedCorrection {
    /// A correction that moves component `i` by at most `caps[i]`.
    ///
    /// # Errors
    ///
    /// When a cap is not within 0..=1.
    pub fn new(caps: Vec<f32>) -> Result<Self, ActionError> {
        for (index, &found) in caps.iter().enumerate() {
            if !(0.0..=1.0).contains(&found) {
                return Err(ActionError::Cap { index, found });
            }
        }
        Ok(Self { caps })
    }

    /// Turns a correction into the corrected action, in place.
    ///
    /// # Errors
    ///
    /// When a slice has another size.
    pub fn apply(&self, base: &[f32], correction: &mut [f32]) -> Result<(), ActionError> {
        check_size("the base action", base.len(), self.caps.len())?;
        check_size("the correction", correction.len(), self.caps.len())?;
        for (value, (base, cap)) in correction.iter_mut().zip(base.iter().zip(&self.caps)) {
            *value = (base + cap * value.clamp(-1.0, 1.0)).clamp(-1.0, 1.0);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{ActionBounds, ActionError, CappedCorrection};

    proptest! {
        #[test]
        fn ends_go_to_ends_and_all_else_between(low in -1e3_f32..1e3, width in 0.01_f32..1e3, value in -1.0_f32..1.0) {
            let high = low + width;
            let bounds = ActionBounds::new(vec![low; 4], vec![high; 4]).unwrap();
            let mut action = [-1.0, 1.0, value, -7.0];
            bounds.stretch(&mut action).unwrap();
            prop_assert_eq!((action[0], action[1], action[3]), (low, high, low));
            let wanted = low + 0.5 * (value + 1.0) * width;
            prop_assert!((action[2] - wanted).abs() < 1e-5 * (low.abs() + width));
        }

        #[test]
        fn a_correction_stays_under_its_cap(base in -1.0_f32..1.0, cap in 0.0_f32..1.0, value in -9.0_f32..9.0) {
            let correction = CappedCorrection::new(vec![cap]).unwrap();
            let mut action = [value];
            correction.apply(&[base], &mut action).unwrap();
            prop_assert!((action[0] - base).abs() <= cap + 1e-6);
            prop_assert!(action[0].abs() <= 1.0);
        }
    }

    #[test]
    fn what_is_no_range_is_refused() {
        let refused = ActionBounds::new(vec![0.0, 1.0], vec![1.0, 1.0]).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "component 1 ranges from 1 to 1, expected two finite numbers, the second the larger"
        );
        assert!(ActionBounds::new(vec![0.0], vec![f32::INFINITY]).is_err());
        assert!(ActionBounds::new(vec![0.0], vec![]).is_err());
        let cap = CappedCorrection::new(vec![0.5, f32::NAN]).unwrap_err();
        assert!(matches!(cap, ActionError::Cap { index: 1, .. }));
        let correction = CappedCorrection::new(vec![0.5]).unwrap();
        assert!(correction.apply(&[0.0, 0.0], &mut [0.0]).is_err());
    }
}
