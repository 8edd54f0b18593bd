//! What can be wrong with what a control law is given.

/// Why a control law gave no command.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// A list has the wrong number of values.
    #[error("{what} has {found} values, expected {expected}")]
    Size {
        /// The list.
        what: &'static str,
        /// Values it has.
        found: usize,
        /// Values it should have.
        expected: usize,
    },
    /// A number is infinite or not a number.
    #[error("{what} holds a number that is not finite")]
    NotFinite {
        /// What holds it.
        what: &'static str,
    },
    /// The mass matrix cannot be inverted.
    #[error("the arm's {n_joints} x {n_joints} mass matrix is not positive definite")]
    MassMatrix {
        /// Its size.
        n_joints: usize,
    },
    /// A value is out of its range.
    #[error("{what} is {found}, expected {expected}")]
    Value {
        /// The value's name.
        what: &'static str,
        /// What was given.
        found: String,
        /// What is allowed.
        expected: &'static str,
    },
    /// The robot's model cannot be built or evaluated.
    #[error("model of robot `{robot}`: {source}")]
    Model {
        /// The robot's name.
        robot: String,
        /// The engine's word.
        source: factotum_physics::PhysicsError,
    },
}

/// Refuses a list of the wrong length.
pub(crate) fn check_size(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), ControlError> {
    if found == expected {
        Ok(())
    } else {
        Err(ControlError::Size {
            what,
            found,
            expected,
        })
    }
}

/// Refuses numbers that are not finite.
pub(crate) fn check_finite<'a>(
    what: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
) -> Result<(), ControlError> {
    if values.into_iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(ControlError::NotFinite { what })
    }
}
