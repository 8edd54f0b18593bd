//! One descent of inverse kinematics from one start.
//!
//! Method: Sugihara, "Solvability-Unconcerned Inverse Kinematics by the Levenberg-Marquardt Method",
//! T-RO 27(5), 2011: the damping is the residual itself plus a small bias, so steps are short far from the
//! target and in singularities, and Newton-like near the solution.
//! Differs: joint limits are kept by an active set: a joint at its limit that would leave is fixed and the
//! step solved again without it; and a descent that stalls is given up early, since restarts are cheap.
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | e | residual: linear, then angular times L | m |
//! | L | length that weighs a radian against a metre | m/rad |
//! | E | ½ eᵀe | m² |

use nalgebra::{Matrix6, Matrix6xX, UnitQuaternion, Vector3, Vector6};

use crate::Pose;
use crate::chain::KinematicChain;
use crate::joint_space::JointSpace;

/// L: at the arm's reach a radian moves the tool about this far.
const METRES_PER_RADIAN: f64 = 0.4;
/// Damping per unit of E.
const DAMPING_GAIN: f64 = 0.5;
/// Damping at the solution (m²); keeps the 6 x 6 system regular when fewer than six directions are spanned.
const DAMPING_BIAS: f64 = 1e-9;
/// Largest change of one joint in one step (rad, m).
const STEP_MAX: f64 = 0.6;
/// A descent is given up when E has not fallen to this fraction...
const STALL_RATIO: f64 = 0.7;
/// ...within this many steps.
const STALL_STEPS: usize = 8;

/// What one descent came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Descent {
    pub(crate) is_converged: bool,
    pub(crate) position_error_m: f64,
    pub(crate) rotation_error_rad: f64,
    pub(crate) iterations: usize,
}

/// When a descent has arrived, and when it gives up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DescentOptions {
    pub(crate) position_tol_m: f64,
    pub(crate) rotation_tol_rad: f64,
    pub(crate) iterations: usize,
    /// Rotation about the tool's z axis does not matter.
    pub(crate) axis_free: bool,
}

/// Descends from configurations; keeps its buffers between calls.
#[derive(Debug)]
pub(crate) struct Descender<'a> {
    chain: &'a KinematicChain,
    space: &'a JointSpace,
    jacobian: Matrix6xX<f64>,
    is_fixed: Vec<bool>,
    step: Vec<f64>,
}

impl<'a> Descender<'a> {
    pub(crate) fn new(chain: &'a KinematicChain, space: &'a JointSpace) -> Self {
        let n = chain.n();
        Self {
            chain,
            space,
            jacobian: Matrix6xX::zeros(n),
            is_fixed: vec![false; n],
            step: vec![0.0; n],
        }
    }

    /// Moves `q` towards the target until it is reached, the caps end it, or it stalls.
    pub(crate) fn descend(
        &mut self,
        target: &Pose,
        q: &mut [f64],
        options: &DescentOptions,
    ) -> Descent {
        for (q, limit) in q.iter_mut().zip(self.space.limits()) {
            *q = limit.clamp(*q);
        }
        let mut energy_at_check = f64::INFINITY;
        let mut iterations = 0;
        loop {
            let pose = self
                .chain
                .base_from_tcp_and_jacobian_into(q, &mut self.jacobian);
            let (linear, angular) = residual(&pose, target, options.axis_free);
            let (position_error_m, rotation_error_rad) = (linear.norm(), angular.norm());
            let is_converged = position_error_m <= options.position_tol_m
                && rotation_error_rad <= options.rotation_tol_rad;
            let descent = Descent {
                is_converged,
                position_error_m,
                rotation_error_rad,
                iterations,
            };
            if is_converged || iterations >= options.iterations {
                return descent;
            }
            let e = weighted(&linear, &angular);
            let energy = 0.5 * e.norm_squared();
            if iterations.is_multiple_of(STALL_STEPS) {
                if energy > STALL_RATIO * energy_at_check {
                    return descent;
                }
                energy_at_check = energy;
            }
            if options.axis_free {
                drop_rotation_about(&mut self.jacobian, &(pose.rotation * Vector3::z()));
            }
            for mut column in self.jacobian.column_iter_mut() {
                column.fixed_rows_mut::<3>(3).scale_mut(METRES_PER_RADIAN);
            }
            if !self.take_step(q, &e, DAMPING_GAIN * energy + DAMPING_BIAS) {
                return descent;
            }
            iterations += 1;
        }
    }

    /// Adds the damped least-squares step to `q`, within limits; false when no step can be taken.
    fn take_step(&mut self, q: &mut [f64], e: &Vector6<f64>, damping: f64) -> bool {
        self.is_fixed.fill(false);
        // Each round fixes at least one more joint, so this ends after n rounds.
        loop {
            let mut gram = Matrix6::from_diagonal_element(damping);
            for (i, column) in self.jacobian.column_iter().enumerate() {
                if !self.is_fixed[i] {
                    gram.ger(1.0, &column, &column, 1.0);
                }
            }
            let Some(cholesky) = gram.cholesky() else {
                return false;
            };
            let y = cholesky.solve(e);
            let mut newly_fixed = false;
            for (i, column) in self.jacobian.column_iter().enumerate() {
                if self.is_fixed[i] {
                    self.step[i] = 0.0;
                    continue;
                }
                self.step[i] = column.dot(&y);
                let limit = &self.space.limits()[i];
                let leaves = (q[i] <= limit.lower && self.step[i] < 0.0)
                    || (q[i] >= limit.upper && self.step[i] > 0.0);
                if leaves {
                    self.is_fixed[i] = true;
                    newly_fixed = true;
                }
            }
            if !newly_fixed {
                break;
            }
        }
        let largest = self
            .step
            .iter()
            .fold(0.0_f64, |largest, step| largest.max(step.abs()));
        let scale = if largest > STEP_MAX {
            STEP_MAX / largest
        } else {
            1.0
        };
        for ((q, step), limit) in q.iter_mut().zip(&self.step).zip(self.space.limits()) {
            *q = limit.clamp(*q + scale * step);
        }
        largest > 0.0
    }
}

/// What is missing to the target: metres, and radians as a rotation vector; both in the base frame.
pub(crate) fn residual(
    pose: &Pose,
    target: &Pose,
    axis_free: bool,
) -> (Vector3<f64>, Vector3<f64>) {
    let linear = target.translation.vector - pose.translation.vector;
    let angular = if axis_free {
        let (z, z_target) = (pose.rotation * Vector3::z(), target.rotation * Vector3::z());
        // Opposite axes have no shortest rotation: any axis across serves.
        UnitQuaternion::rotation_between(&z, &z_target).map_or_else(
            || pose.rotation * Vector3::x() * std::f64::consts::PI,
            |rotation| rotation.scaled_axis(),
        )
    } else {
        (target.rotation * pose.rotation.inverse()).scaled_axis()
    };
    (linear, angular)
}

fn weighted(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    let a = angular * METRES_PER_RADIAN;
    Vector6::new(linear.x, linear.y, linear.z, a.x, a.y, a.z)
}

/// Removes from the angular rows what turns about `axis`.
fn drop_rotation_about(jacobian: &mut Matrix6xX<f64>, axis: &Vector3<f64>) {
    for mut column in jacobian.column_iter_mut() {
        let mut angular = column.fixed_rows_mut::<3>(3);
        let along = axis.dot(&angular);
        angular.axpy(-along, axis, 1.0);
    }
}

#[cfg(test)]
mod tests;
