//! A hard guard of joint limits: a control-barrier filter on joint position and velocity.
//!
//! For each end `u` of a joint's range, kept at a distance `m`, the filter lets pass only accelerations with
//!
//! ```text
//! h = u - m - q ≥ 0,   q̈ ≤ α² h - 2 α q̇,   q̈ ≤ β (v_max - q̇)          (and their mirror images)
//! ```
//!
//! so that `h` decays no faster than a critically damped spring of rate α would let it: an exponential control barrier
//! function of relative degree two (Nguyen & Sreenath, "Exponential Control Barrier Functions for Enforcing High
//! Relative-Degree Safety-Critical Constraints", ACC 2016, doi:10.1109/ACC.2016.7524935). A joint that keeps
//! `q̇ ≤ α h` never reaches `u - m`, and one at its speed limit brakes with α v_max, which the arm must be able to: 11 rad/s²
//! for a joint of 2.2 rad/s. The acceleration nearest to the wished one within these bounds is a clamp of each
//! joint, the solution of the quadratic program `min |q̈ - q̈_wished|²`; torques follow from the arm's equation of
//! motion `τ = M q̈ + b - τ_ext`.
//!
//! What pulls at the arm from outside, `τ_ext`, is taken from the last step: `M Δq̇/Δt + b - τ`. Far from the limits the
//! filter changes nothing.
//!
//! It differs from the envelope σ ([`crate::safety`]): σ replaces the task once a joint is near a limit, this one only
//! takes away what would lead there. It holds as long as the motors can give the torque; a contact that overpowers them
//! is beyond any filter.

use nalgebra::{Cholesky, DVector};

use crate::error::check_size;
use crate::{ArmState, ControlError};

/// α, 1/s: the fastest approach to a limit is α times the distance that is left.
const RATE_PER_SEC: f64 = 5.0;

/// β, 1/s: how fast the speed limit is approached.
const SPEED_RATE_PER_SEC: f64 = 30.0;

/// Keeps joints away from their limits, whatever is wished.
#[derive(Debug, Clone, PartialEq)]
pub struct JointBarrier {
    limits_rad: Vec<Option<[f64; 2]>>,
    speed_max_rad_per_s: Vec<f64>,
    margin_rad: f64,
    last: Option<Last>,
}

/// The step before: joint velocities, and the torques that held the arm then.
#[derive(Debug, Clone, PartialEq)]
struct Last {
    velocities: DVector<f64>,
    bias: DVector<f64>,
}

impl JointBarrier {
    /// A barrier `margin_rad` before each limit, `None` for a joint without limits, and at each joint's speed limit.
    ///
    /// # Errors
    /// [`ControlError::Value`] unless the margin is positive and finite, [`ControlError::Size`] unless there is a speed limit
    /// for each joint.
    pub fn new(
        limits_rad: Vec<Option<[f64; 2]>>,
        speed_max_rad_per_s: Vec<f64>,
        margin_rad: f64,
    ) -> Result<Self, ControlError> {
        check_size("speed limits", speed_max_rad_per_s.len(), limits_rad.len())?;
        if !(margin_rad > 0.0 && margin_rad.is_finite()) {
            return Err(ControlError::Value {
                what: "margin of the joint barrier",
                found: format!("{margin_rad} rad"),
                expected: "a positive angle",
            });
        }
        Ok(Self {
            limits_rad,
            speed_max_rad_per_s,
            margin_rad,
            last: None,
        })
    }

    /// Forgets the step before, as when the arm was put somewhere else.
    pub fn restart(&mut self) {
        self.last = None;
    }

    /// The accelerations that a joint may have here, rad/s².
    pub fn bounds(&self, joint: usize, position: f64, velocity: f64) -> [f64; 2] {
        let speed_max = self.speed_max_rad_per_s.get(joint).copied();
        let speed_max = speed_max.unwrap_or(f64::INFINITY);
        let faster = SPEED_RATE_PER_SEC * (speed_max - velocity);
        let slower = -SPEED_RATE_PER_SEC * (speed_max + velocity);
        let Some(Some([lower, upper])) = self.limits_rad.get(joint) else {
            return [slower, faster];
        };
        let (spring, damper) = (RATE_PER_SEC * RATE_PER_SEC, 2.0 * RATE_PER_SEC);
        let at_most = spring * (upper - self.margin_rad - position) - damper * velocity;
        let at_least = spring * (lower + self.margin_rad - position) - damper * velocity;
        // In a range narrower than both margins these cross: then towards its middle.
        let [at_least, at_most] = [at_least.min(at_most), at_most.max(at_least)];
        // A limit is worse than too much speed.
        [
            slower.clamp(at_least, at_most),
            faster.clamp(at_least, at_most),
        ]
    }

    /// The torques nearest in effect to `task` that keep every joint behind its barrier, N m; `applied` are those of the
    /// step before, which took `dt_secs`, and `torque_max_nm` what the motors can give.
    ///
    /// # Errors
    /// [`ControlError::Size`] if sizes disagree, [`ControlError::MassMatrix`] if it cannot be inverted.
    pub fn filter(
        &mut self,
        arm: &ArmState,
        task: &DVector<f64>,
        applied: &DVector<f64>,
        torque_max_nm: &DVector<f64>,
        dt_secs: f64,
    ) -> Result<DVector<f64>, ControlError> {
        let n = arm.n_joints();
        check_size("joint barrier", self.limits_rad.len(), n)?;
        check_size("torques", task.len(), n)?;
        check_size("torques of the step before", applied.len(), n)?;
        check_size("torque limits", torque_max_nm.len(), n)?;
        // 1. What else pulls: it moved the arm in the step before, beside the motors.
        let external = match &self.last {
            Some(last) => {
                &arm.mass * (&arm.velocities - &last.velocities) / dt_secs + &last.bias - applied
            }
            None => DVector::zeros(n),
        };
        // 2. Where the task would lead, and what of it may be.
        let cholesky =
            Cholesky::new(arm.mass.clone()).ok_or(ControlError::MassMatrix { n_joints: n })?;
        let wished = cholesky.solve(&(task + &external - &arm.bias));
        let allowed = DVector::from_fn(n, |joint, _| {
            let [low, high] = self.bounds(joint, arm.positions[joint], arm.velocities[joint]);
            wished[joint].clamp(low, high)
        });
        self.last = Some(Last {
            velocities: arm.velocities.clone(),
            bias: arm.bias.clone(),
        });
        if allowed == wished {
            return Ok(task.clone());
        }
        // 3. Torques for that. Where the motors cannot give them, the joints that are free slow down for the others.
        let torques = |share: f64| {
            let accelerations = allowed.zip_map(&wished, |allowed, wished| {
                if allowed == wished {
                    share * allowed
                } else {
                    allowed
                }
            });
            &arm.mass * accelerations + &arm.bias - &external
        };
        let fits = |torques: &DVector<f64>| {
            let mut pairs = torques.iter().zip(torque_max_nm.iter());
            pairs.all(|(torque, max)| torque.abs() <= *max)
        };
        let shares = [1.0, 0.75, 0.5, 0.25];
        let found = shares.into_iter().map(torques).find(fits);
        Ok(found.unwrap_or_else(|| torques(0.0)))
    }
}
