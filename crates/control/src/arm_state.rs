//! What a control law knows of the arm at one instant.
//!
//! | symbol | field | shape, unit |
//! |---|---|---|
//! | q, q̇ | `positions`, `velocities` | n; rad, rad/s |
//! | M | `mass` | n × n; kg m² |
//! | b = C q̇ + g | `bias` | n; N m |
//! | J | `jacobian` | 6 × n; linear rows first, base frame |

use factotum_geometry::Pose;
use nalgebra::{DMatrix, DVector, Matrix6xX, Vector6};

use crate::ControlError;
use crate::error::{check_finite, check_size};

/// Equation of motion of an arm, `M q̈ + b = τ + Jᵀ f`, at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmState {
    /// Joint positions, rad.
    pub positions: DVector<f64>,
    /// Joint velocities, rad/s.
    pub velocities: DVector<f64>,
    /// Joint-space inertia, n × n.
    pub mass: DMatrix<f64>,
    /// Torques that hold the arm against gravity, Coriolis and centrifugal forces, N m.
    pub bias: DVector<f64>,
    /// Velocity of the tool frame per joint velocity, in the base frame: three linear rows, then three angular.
    pub jacobian: Matrix6xX<f64>,
    /// Tool pose in the base frame.
    pub base_from_tcp: Pose,
}

impl ArmState {
    /// Number of joints.
    pub fn n_joints(&self) -> usize {
        self.positions.len()
    }

    /// Velocity of the tool frame in the base frame: linear (m/s), then angular (rad/s).
    pub fn tool_velocity(&self) -> Vector6<f64> {
        let velocity = &self.jacobian * &self.velocities;
        Vector6::from_iterator(velocity.iter().copied())
    }

    /// Checks that the parts have matching sizes and finite numbers.
    ///
    /// # Errors
    /// [`ControlError::Size`] or [`ControlError::NotFinite`] naming the part.
    pub fn check(&self) -> Result<(), ControlError> {
        let n = self.n_joints();
        check_size("arm velocities", self.velocities.len(), n)?;
        check_size("arm mass matrix rows", self.mass.nrows(), n)?;
        check_size("arm mass matrix columns", self.mass.ncols(), n)?;
        check_size("arm bias forces", self.bias.len(), n)?;
        check_size("arm Jacobian columns", self.jacobian.ncols(), n)?;
        check_finite("arm positions", self.positions.iter())?;
        check_finite("arm velocities", self.velocities.iter())?;
        check_finite("arm mass matrix", self.mass.iter())?;
        check_finite("arm bias forces", self.bias.iter())?;
        check_finite("arm Jacobian", self.jacobian.iter())
    }
}
