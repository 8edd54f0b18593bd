//! Straight tool motions: the tool follows the line through given poses.
//!
//! Between waypoints the tool point moves on a straight line and the rotation turns at a constant rate. The line is
//! tracked in small steps by damped least squares from the configuration before, so the joint path is continuous; each
//! step is checked against limits, collisions and jumps.

use nalgebra::Translation3;

use crate::Pose;
use crate::ik::descent::{Descender, DescentOptions};
use crate::scene::PlanningScene;

/// Resolution and tolerances of a tool line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolLineOptions {
    /// Largest distance of successive tool positions, metres.
    pub step_m: f64,
    /// Largest rotation between successive tool poses, radians.
    pub step_rad: f64,
    /// Largest distance of the tool from the line, metres.
    pub position_tol_m: f64,
    /// Largest rotation error, radians.
    pub rotation_tol_rad: f64,
    /// The rotation about the tool's z axis does not matter.
    pub axis_free: bool,
    /// Largest change of one joint in one step (rad, m): more is a jump to another branch.
    pub joint_step_max: f64,
    /// Whether configurations are checked for collision.
    pub avoid_collision: bool,
}

impl Default for ToolLineOptions {
    fn default() -> Self {
        Self {
            step_m: 0.005,
            step_rad: 0.02,
            position_tol_m: 1e-4,
            rotation_tol_rad: 1e-3,
            axis_free: false,
            joint_step_max: 0.2,
            avoid_collision: true,
        }
    }
}

/// Why a tool line could not be followed.
#[derive(Debug, Clone, PartialEq)]
pub struct CartesianFailure {
    /// How much of the line was followed, 0 to 1.
    pub fraction_done: f64,
    /// What ended it.
    pub reason: CartesianFailureReason,
    /// The joint path until there.
    pub path: Vec<Vec<f64>>,
}

/// What ended a tool line.
#[derive(Debug, Clone, PartialEq)]
pub enum CartesianFailureReason {
    /// The pose cannot be reached from the configuration before.
    Unreachable {
        /// Position error that remains, metres.
        position_error_m: f64,
        /// Rotation error that remains, radians.
        rotation_error_rad: f64,
        /// A joint that is at its limit there, if one is.
        joint_at_limit: Option<String>,
    },
    /// A joint would have to jump.
    Jump {
        /// The joint.
        joint: String,
        /// Change in one step, rad or m.
        change: f64,
    },
    /// Two things collide.
    Collision((String, String)),
    /// The start has the wrong length or is not finite.
    BadStart,
}

/// Follows the line from the tool's pose at `q_start` through the waypoints.
///
/// The path begins with `q_start`.
///
/// # Errors
/// [`CartesianFailure`] with what was followed until then.
pub fn plan_tool_line(
    scene: &mut PlanningScene,
    q_start: &[f64],
    base_from_tcp_waypoints: &[Pose],
    options: &ToolLineOptions,
) -> Result<Vec<Vec<f64>>, CartesianFailure> {
    const ITERATIONS: usize = 30;
    let robot = scene.robot().clone();
    let mut path = vec![q_start.to_vec()];
    if q_start.len() != robot.n() || q_start.iter().any(|q| !q.is_finite()) {
        let reason = CartesianFailureReason::BadStart;
        return Err(CartesianFailure {
            fraction_done: 0.0,
            reason,
            path,
        });
    }
    let mut descender = Descender::new(robot.chain(), robot.space());
    let descent_options = DescentOptions {
        position_tol_m: options.position_tol_m,
        rotation_tol_rad: options.rotation_tol_rad,
        iterations: ITERATIONS,
        axis_free: options.axis_free,
    };
    let poses = poses_on_line(
        &robot.chain().base_from_tcp(q_start),
        base_from_tcp_waypoints,
        options,
    );
    let mut q = q_start.to_vec();
    for (i, pose) in poses.iter().enumerate() {
        let before = q.clone();
        let descent = descender.descend(pose, &mut q, &descent_options);
        let jump = (0..q.len()).find(|&j| (q[j] - before[j]).abs() > options.joint_step_max);
        let reason = if !descent.is_converged {
            let at_limit = robot
                .limits()
                .iter()
                .zip(&q)
                .position(|(limit, &q)| q <= limit.lower || q >= limit.upper);
            CartesianFailureReason::Unreachable {
                position_error_m: descent.position_error_m,
                rotation_error_rad: descent.rotation_error_rad,
                joint_at_limit: at_limit.map(|j| robot.chain_joints()[j].clone()),
            }
        } else if let Some(j) = jump {
            let joint = robot.chain_joints()[j].clone();
            CartesianFailureReason::Jump {
                joint,
                change: q[j] - before[j],
            }
        } else if let Some(pair) = options
            .avoid_collision
            .then(|| scene.collision(&q))
            .flatten()
        {
            CartesianFailureReason::Collision(pair)
        } else {
            path.push(q.clone());
            continue;
        };
        return Err(CartesianFailure {
            fraction_done: i as f64 / poses.len() as f64,
            reason,
            path,
        });
    }
    Ok(path)
}

/// Smallest step (m, rad); keeps a zero or NaN from asking for endless poses.
const STEP_MIN: f64 = 1e-4;

/// Poses at most a step apart from `start` (not included) through the waypoints.
fn poses_on_line(start: &Pose, waypoints: &[Pose], options: &ToolLineOptions) -> Vec<Pose> {
    let mut poses = Vec::new();
    let mut from = *start;
    for to in waypoints {
        let shift = to.translation.vector - from.translation.vector;
        let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
        let n_steps = (shift.norm() / options.step_m.max(STEP_MIN))
            .max(turn.norm() / options.step_rad.max(STEP_MIN))
            .ceil();
        let n_steps = (n_steps as usize).max(1);
        for i in 1..=n_steps {
            let t = i as f64 / n_steps as f64;
            poses.push(if i == n_steps {
                *to
            } else {
                Pose::from_parts(
                    Translation3::from(from.translation.vector + t * shift),
                    nalgebra::UnitQuaternion::from_scaled_axis(t * turn) * from.rotation,
                )
            });
        }
        from = *to;
    }
    poses
}

#[cfg(test)]
mod tests;
