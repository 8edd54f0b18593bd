//! Variable-impedance control of the tool in operational space, with a posture in the null space.
//!
//! Thesis Eq. 3.1, after Khatib, "A unified approach for motion and force control of robot manipulators: the operational
//! space formulation", IEEE J. Robotics and Automation 3(1), 1987, doi:10.1109/JRA.1987.1087068, with the impedance as
//! part of the action (Martín-Martín et al., "Variable Impedance Control in End-Effector Space", IROS 2019,
//! arXiv:1906.08880):
//!
//! ```text
//! τ = J_pᵀ Λ_p [kp_p (p_d - p) - kd_p v] + J_Rᵀ Λ_R [kp_R (R_d ⊖ R) - kd_R ω] + b + Nᵀ τ_posture
//! Λ_p = (J_p M⁻¹ J_pᵀ)⁻¹,  Λ_R = (J_R M⁻¹ J_Rᵀ)⁻¹,  kd = 2 ζ sqrt(kp)
//! Nᵀ = I - Jᵀ Λ J M⁻¹,     Λ = (J M⁻¹ Jᵀ)⁻¹,        τ_posture = M [kp_q (q_0 - q) - kd_q q̇]
//! ```
//!
//! So a tool that is displaced by Δx and held there pushes back with `F = Λ_p kp_p Δx`.
//!
//! Where we differ from the printed equation:
//! - It prints `J_p[...]`; the transposes are needed for the sizes to agree.
//! - `R_d × R` ("subtraction in SO(3)") is the rotation vector of `R_d Rᵀ` in the base frame. It grows up to a half turn,
//!   where the sum of cross products that is common in code falls off beyond 90 degrees.
//! - Λ is expressed in the base frame, not in the tool frame. The law is the same: rotating Λ, the errors and J by the
//!   tool's rotation cancels.
//! - Damping acts on the velocity error `v - v_d`; with `v_d = 0` it is the printed law. A moving target is then not
//!   held back by its own motion.
//! - Gravity, Coriolis and centrifugal forces `b` are compensated, and a posture is held in the null space (the
//!   equation leaves both unsaid; the thesis' experiments have them).
//!
//! Position and orientation are decoupled as printed: Λ_p and Λ_R are inverses of the diagonal blocks, not blocks of the
//! inverse. The null-space projection uses the coupled Λ, without which it is not dynamically consistent.
//!
//! **Near singularities** `J M⁻¹ Jᵀ` loses rank. Its eigenvalues are raised to at least
//! [`MOBILITY_RATIO_MIN`] of the largest before inverting, so the apparent inertia of the direction that is being lost
//! saturates instead of growing without bound; `Jᵀ` goes to zero there, and so do the torques. Within the guarded region
//! the posture is no longer exactly invisible to the tool.

use factotum_geometry::Pose;
use nalgebra::{
    Cholesky, DMatrix, DVector, Matrix3, Matrix6, SMatrix, SVector, SymmetricEigen, Vector3,
    Vector6,
};

use crate::error::{check_finite, check_size};
use crate::robot::Impedance;
use crate::{ArmState, ControlError};

/// Smallest eigenvalue of the operational-space mobility `J M⁻¹ Jᵀ`, relative to its largest, that is inverted as it is.
///
/// 1/1000: in ordinary postures the directions of a seven-joint arm differ by up to about a hundredfold, which must not
/// be touched, or Λ would no longer be the arm's own.
pub const MOBILITY_RATIO_MIN: f64 = 1e-3;

/// Where the tool should be, and how fast it should move there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolTarget {
    /// Wanted tool pose in the base frame.
    pub base_from_tcp: Pose,
    /// Wanted velocity in the base frame, linear then angular; zero gives the printed law.
    pub velocity: Vector6<f64>,
}

impl ToolTarget {
    /// A target at rest.
    pub fn at_rest(base_from_tcp: Pose) -> Self {
        Self {
            base_from_tcp,
            velocity: Vector6::zeros(),
        }
    }
}

/// Joint positions that the arm drifts to where the tool does not mind.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// Wanted joint positions, rad.
    pub positions: DVector<f64>,
    /// Gain, 1/s²; damping is critical.
    pub kp: f64,
}

impl Posture {
    /// Holds `positions` with 10 1/s², the value of the thesis' experiments.
    pub fn soft(positions: DVector<f64>) -> Self {
        Self {
            positions,
            kp: 10.0,
        }
    }
}

/// Inertia of the arm as felt at the tool, and what is derived from it.
#[derive(Debug, Clone, PartialEq)]
pub struct OperationalSpace {
    /// Λ_p: apparent mass at the tool, kg, base frame.
    pub inertia_position: Matrix3<f64>,
    /// Λ_R: apparent rotational inertia at the tool, kg m², base frame.
    pub inertia_rotation: Matrix3<f64>,
    /// Λ: both, with their coupling.
    pub inertia: Matrix6<f64>,
    /// Nᵀ: what is left of a joint torque after everything that would accelerate the tool is taken away, n × n.
    pub null_space: DMatrix<f64>,
}

impl OperationalSpace {
    /// Inverts the operational-space mobility of an arm, guarded near singularities (see the module).
    ///
    /// # Errors
    /// Sizes that disagree, numbers that are not finite, or a mass matrix that is not positive definite.
    pub fn of(arm: &ArmState) -> Result<Self, ControlError> {
        arm.check()?;
        let n = arm.n_joints();
        let cholesky =
            Cholesky::new(arm.mass.clone()).ok_or(ControlError::MassMatrix { n_joints: n })?;
        let mut mass_inv_jt = arm.jacobian.transpose();
        cholesky.solve_mut(&mut mass_inv_jt);
        let mobility = &arm.jacobian * &mass_inv_jt;
        let inertia = guarded_inverse_6(&mobility);
        let null_space =
            DMatrix::identity(n, n) - arm.jacobian.tr_mul(&(inertia * mass_inv_jt.transpose()));
        Ok(Self {
            inertia_position: guarded_inverse(&mobility.fixed_view::<3, 3>(0, 0).into_owned()),
            inertia_rotation: guarded_inverse(&mobility.fixed_view::<3, 3>(3, 3).into_owned()),
            inertia,
            null_space,
        })
    }
}

/// Inverse of a symmetric positive semi-definite matrix whose eigenvalues are first raised to
/// [`MOBILITY_RATIO_MIN`] of the largest; zero for the zero matrix (an arm that cannot move the tool at all).
pub fn guarded_inverse(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let symmetric = (matrix + matrix.transpose()) * 0.5;
    well_conditioned_inverse(&symmetric).unwrap_or_else(|| {
        let eigen = SymmetricEigen::new(symmetric);
        let inverse = Matrix3::from_diagonal(&raised_reciprocals(&eigen.eigenvalues));
        eigen.eigenvectors * inverse * eigen.eigenvectors.transpose()
    })
}

/// As [`guarded_inverse`] for the coupled mobility. Its blocks differ in unit (1/kg and 1/(kg m²)), so each is first
/// scaled by its own trace: eigenvalues of the scaled matrix can be compared.
fn guarded_inverse_6(matrix: &Matrix6<f64>) -> Matrix6<f64> {
    let scale_of = |first: usize| {
        let trace = matrix.fixed_view::<3, 3>(first, first).trace();
        if trace > 0.0 {
            trace.sqrt().recip()
        } else {
            0.0
        }
    };
    let (linear, angular) = (scale_of(0), scale_of(3));
    let scale = Vector6::new(linear, linear, linear, angular, angular, angular);
    let scales = scale * scale.transpose();
    let scaled = (matrix + matrix.transpose()).component_mul(&scales) * 0.5;
    let inverse = well_conditioned_inverse(&scaled).unwrap_or_else(|| {
        let eigen = SymmetricEigen::new(scaled);
        let inverse = Matrix6::from_diagonal(&raised_reciprocals(&eigen.eigenvalues));
        eigen.eigenvectors * inverse * eigen.eigenvectors.transpose()
    });
    inverse.component_mul(&scales)
}

/// Inverse of a symmetric matrix none of whose eigenvalues would be raised, without finding them; `None` where one might
/// be. The Frobenius norm bounds the largest eigenvalue, that of the inverse the reciprocal of the smallest.
fn well_conditioned_inverse<const N: usize>(
    matrix: &SMatrix<f64, N, N>,
) -> Option<SMatrix<f64, N, N>> {
    let inverse = Cholesky::new(*matrix)?.inverse();
    (matrix.norm() * inverse.norm() * MOBILITY_RATIO_MIN <= 1.0).then_some(inverse)
}

/// Reciprocals of eigenvalues that are first raised to [`MOBILITY_RATIO_MIN`] of the largest; zeros if none is positive.
fn raised_reciprocals<const N: usize>(eigenvalues: &SVector<f64, N>) -> SVector<f64, N> {
    let floor = eigenvalues.max() * MOBILITY_RATIO_MIN;
    if floor <= 0.0 {
        return SVector::zeros();
    }
    eigenvalues.map(|value| 1.0 / value.max(floor))
}

/// Damping gain of a stiffness gain: `2 ζ sqrt(kp)`, 1/s.
pub fn damping(kp: f64, damping_ratio: f64) -> f64 {
    2.0 * damping_ratio * kp.max(0.0).sqrt()
}

/// Rotation vector, in the base frame, that turns `from` into `to` (rad; at most a half turn).
pub fn rotation_error(from: &Pose, to: &Pose) -> Vector3<f64> {
    (to.rotation * from.rotation.inverse()).scaled_axis()
}

/// Joint torques of thesis Eq. 3.1 (see the module), n values in N m, before any limit.
///
/// # Errors
/// What [`OperationalSpace::of`] refuses; a posture of the wrong size; gains or targets that are not finite.
pub fn impedance_torques(
    arm: &ArmState,
    target: &ToolTarget,
    gains: &Impedance,
    posture: Option<&Posture>,
) -> Result<DVector<f64>, ControlError> {
    let space = OperationalSpace::of(arm)?;
    impedance_torques_in(&space, arm, target, gains, posture)
}

/// As [`impedance_torques`], with the operational space already at hand.
///
/// # Errors
/// A posture of the wrong size; gains or targets that are not finite.
pub fn impedance_torques_in(
    space: &OperationalSpace,
    arm: &ArmState,
    target: &ToolTarget,
    gains: &Impedance,
    posture: Option<&Posture>,
) -> Result<DVector<f64>, ControlError> {
    check_finite(
        "impedance gains",
        gains
            .kp_position
            .iter()
            .chain(&gains.kp_rotation)
            .chain([&gains.damping_ratio]),
    )?;
    let wanted = &target.base_from_tcp;
    check_finite(
        "tool target",
        wanted
            .translation
            .vector
            .iter()
            .chain(wanted.rotation.coords.iter()),
    )?;
    check_finite("tool target velocity", target.velocity.iter())?;
    let damping_of = |kp: &Vector3<f64>| kp.map(|kp| damping(kp, gains.damping_ratio));
    let velocity_error = target.velocity - arm.tool_velocity();
    let position_error = wanted.translation.vector - arm.base_from_tcp.translation.vector;
    let force = space.inertia_position
        * (position_error.component_mul(&gains.kp_position)
            + velocity_error
                .fixed_rows::<3>(0)
                .component_mul(&damping_of(&gains.kp_position)));
    let moment = space.inertia_rotation
        * (rotation_error(&arm.base_from_tcp, wanted).component_mul(&gains.kp_rotation)
            + velocity_error
                .fixed_rows::<3>(3)
                .component_mul(&damping_of(&gains.kp_rotation)));
    let wrench = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
    let mut torques = arm.bias.clone();
    torques.gemv_tr(1.0, &arm.jacobian, &wrench, 1.0);
    if let Some(posture) = posture {
        check_size("posture", posture.positions.len(), arm.n_joints())?;
        torques.gemv(1.0, &space.null_space, &posture_torques(arm, posture), 1.0);
    }
    Ok(torques)
}

/// Torques that pull the joints to a posture with critical damping, before projection.
fn posture_torques(arm: &ArmState, posture: &Posture) -> DVector<f64> {
    let kd = damping(posture.kp, 1.0);
    let mut pull = &posture.positions - &arm.positions;
    pull.axpy(-kd, &arm.velocities, posture.kp);
    &arm.mass * pull
}
