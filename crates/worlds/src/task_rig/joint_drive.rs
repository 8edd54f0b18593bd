//! The arm driven by joint velocities, as the policies of thesis Chapter 4 command it.
//!
//! ```text
//! τ = M(q) k (q̇_d - q̇) + b(q, q̇),   |τ| ≤ τ_max,   |q̇_d| ≤ q̇_max
//! ```
//!
//! with k = 50 1/s. There is no integral and no position to return to: what is heavy lags behind, and what is blocked stays.

use factotum_control::GripperGoal;
use factotum_skills::cip::rig::{Placing, Rig as _};
use nalgebra::DVector;

use super::{RigError, TaskRig};

/// Velocity gain, 1/s.
const GAIN_PER_SEC: f64 = 50.0;

impl TaskRig {
    /// Puts the object in the middle of its placements and the arm where the motor skill begins.
    ///
    /// # Errors
    /// [`RigError::Size`] for a start of another arm.
    pub fn place_for_motor_skill(&mut self) -> Result<(), RigError> {
        let Some(motor) = self.task.motor.clone() else {
            return Ok(());
        };
        let q = if motor.q_start.is_empty() {
            self.anatomy.robot.q_ready()
        } else {
            motor.q_start
        };
        self.place(&Placing {
            base_from_object: self.task.placement.at([0.5; 4]),
            object_joint: self.task.start,
            q,
            opening: motor.opening,
        })?;
        self.grip.set_goal(GripperGoal {
            opening: motor.opening,
            force_n: self.task.episode.grip_force_n,
        })?;
        Ok(())
    }

    /// Drives the arm's joints at these velocities, rad/s, for one control period.
    ///
    /// # Errors
    /// [`RigError::Size`] for another number of joints, [`RigError::Physics`] when the physics breaks down.
    pub fn drive(&mut self, velocities: &[f64]) -> Result<(), RigError> {
        let limits = &self.robot.arm.velocity_max_rad_per_s;
        if velocities.len() != limits.len() {
            return Err(RigError::Size {
                found: velocities.len(),
                wanted: limits.len(),
            });
        }
        let wished = DVector::from_iterator(
            limits.len(),
            velocities
                .iter()
                .zip(limits)
                .map(|(velocity, most)| velocity.clamp(-most, *most)),
        );
        for _ in 0..self.n_substeps {
            self.begin_substep()?;
            let arm = &self.arm;
            let torques = &arm.mass * (&wished - &arm.velocities) * GAIN_PER_SEC + &arm.bias;
            let most = &self.robot.arm.torque_max_nm;
            let drives = self.ids.arm_actuators.iter().zip(&torques).zip(most);
            for ((&actuator, torque), most) in drives {
                self.state.set_ctrl(actuator, torque.clamp(-most, *most));
            }
            self.end_substep()?;
        }
        self.state
            .forward_kinematics()
            .map_err(|error| self.physics(error))?;
        self.read();
        Ok(())
    }
}
