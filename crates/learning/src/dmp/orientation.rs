//! Primitives of rotations, on unit quaternions.
//!
//! The way left to the goal is the rotation vector `2 log(g * conj(q))`, angular velocities are expressed in the frame
//! in which the rotations are given: `tau eta' = alpha_z (beta_z 2 log(g * conj(q)) - eta) + f(x)`, `eta = tau omega`.
//!
//! Limit: the rotation vector jumps where the way left is a half turn; a motion should stay within that of its goal.
//! Koutras & Doulgeri, "A correct formulation for the Orientation Dynamic Movement Primitives for robot control in the
//! Cartesian space", CoRL 2019, PMLR 100 (2020), 293-302, show that motions can swing under this form.

use super::canonical::substeps;
use super::demonstration::ends_of;
use super::error::{check_finite, check_positive};
use super::spring::ForcedSprings;
use super::{DmpError, DmpParams, ForcingTerms};
use crate::lwr::Activation;
use nalgebra::{DMatrix, UnitQuaternion, Vector3};

/// Longest step of the integration as a share of the duration; with the default damping, rotations then err by less
/// than a ten-thousandth of the way (the midpoint rule is of second order).
const SUBSTEP_SHARE_MAX: f64 = 1.0 / 400.0;

/// A motion of rotations, learned from one demonstration.
#[derive(Debug, Clone, PartialEq)]
pub struct OrientationDmp {
    springs: ForcedSprings,
    demonstrated: OrientationMotion,
}

/// A run of a primitive that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct OrientationMotion {
    /// Where it starts.
    pub start: UnitQuaternion<f64>,
    /// Angular velocity there, rad/s.
    pub start_velocity: Vector3<f64>,
    /// Where it ends.
    pub goal: UnitQuaternion<f64>,
    /// How long it takes, seconds.
    pub duration_s: f64,
}

/// A moment of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct OrientationState {
    /// Since the start, seconds.
    pub time_s: f64,
    /// Rotation.
    pub rotation: UnitQuaternion<f64>,
    /// Angular velocity, rad/s, in the frame in which the rotation is given.
    pub velocity: Vector3<f64>,
}

/// Rotation vector (rad, at most a half turn) that leads from one rotation to another by multiplication from the left.
fn rotation_between(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> Vector3<f64> {
    (to * from.inverse()).scaled_axis()
}

impl OrientationDmp {
    /// Learns from rotations at equal steps of `step_s` seconds, each less than a half turn from the last sample.
    ///
    /// # Errors
    /// [`DmpError`] when there are fewer samples than kernels (or than 3), or anything is not finite.
    pub fn learn(
        demonstration: &[UnitQuaternion<f64>],
        step_s: f64,
        params: &DmpParams,
    ) -> Result<Self, DmpError> {
        let (start, goal) = ends_of(demonstration, step_s, params)?;
        for sample in demonstration {
            check_finite("sample", sample.coords.iter())?;
        }
        let velocities = angular_velocities(demonstration, step_s);
        let ways: Vec<Vector3<f64>> = demonstration
            .iter()
            .map(|rotation| rotation_between(rotation, goal))
            .collect();
        let to_goal = DMatrix::from_fn(3, ways.len(), |dim, k| ways[k][dim]);
        Ok(Self {
            springs: ForcedSprings::learn(&to_goal, &velocities, step_s, params)?,
            demonstrated: OrientationMotion {
                start: *start,
                start_velocity: Vector3::zeros(),
                goal: *goal,
                duration_s: step_s * (demonstration.len() - 1) as f64,
            },
        })
    }

    /// The run that was demonstrated, from rest.
    #[must_use]
    pub fn demonstrated(&self) -> &OrientationMotion {
        &self.demonstrated
    }

    /// The learned forces.
    #[must_use]
    pub fn forcing(&self) -> &ForcingTerms {
        &self.springs.forcing
    }

    /// The learned forces, to be changed by policy search.
    pub fn forcing_mut(&mut self) -> &mut ForcingTerms {
        &mut self.springs.forcing
    }

    /// Begins a run.
    ///
    /// # Errors
    /// [`DmpError`] when anything is not finite or the duration not positive.
    pub fn run(&self, motion: &OrientationMotion) -> Result<OrientationRollout<'_>, DmpError> {
        check_finite("start", motion.start.coords.iter())?;
        check_finite("start velocity", motion.start_velocity.iter())?;
        check_finite("goal", motion.goal.coords.iter())?;
        check_positive("duration", motion.duration_s)?;
        Ok(OrientationRollout {
            dmp: self,
            motion: motion.clone(),
            state: OrientationState {
                time_s: 0.0,
                rotation: motion.start,
                velocity: motion.start_velocity,
            },
            activation: self.springs.forcing.activation(),
        })
    }
}

/// Angular velocities `(3, n_samples)` by differences of rotations, central inside and one-sided at both ends.
fn angular_velocities(rotations: &[UnitQuaternion<f64>], step_s: f64) -> DMatrix<f64> {
    let last = rotations.len() - 1;
    let way = |from: usize, to: usize| rotation_between(&rotations[from], &rotations[to]);
    let columns: Vec<Vector3<f64>> = (0..=last)
        .map(|k| {
            let twice = if k == 0 {
                4.0 * way(0, 1) - way(0, 2)
            } else if k == last {
                4.0 * way(last - 1, last) - way(last - 2, last)
            } else {
                way(k - 1, k) + way(k, k + 1)
            };
            twice / (2.0 * step_s)
        })
        .collect();
    DMatrix::from_fn(3, columns.len(), |dim, k| columns[k][dim])
}

/// A run under way.
#[derive(Debug, Clone)]
pub struct OrientationRollout<'a> {
    dmp: &'a OrientationDmp,
    motion: OrientationMotion,
    state: OrientationState,
    activation: Activation,
}

impl OrientationRollout<'_> {
    /// The present moment.
    #[must_use]
    pub fn state(&self) -> &OrientationState {
        &self.state
    }

    /// Leads to another goal from now on.
    ///
    /// # Errors
    /// [`DmpError::NotFinite`] when it is no rotation.
    pub fn set_goal(&mut self, goal: UnitQuaternion<f64>) -> Result<(), DmpError> {
        check_finite("goal", goal.coords.iter())?;
        self.motion.goal = goal;
        Ok(())
    }

    /// Goes on by a time in seconds.
    ///
    /// # Errors
    /// [`DmpError::OutOfRange`] when the step is not positive or longer than a thousand durations.
    pub fn advance(&mut self, step_s: f64) -> Result<&OrientationState, DmpError> {
        let (n_substeps, substep_s) = substeps(step_s, self.motion.duration_s, SUBSTEP_SHARE_MAX)?;
        for _ in 0..n_substeps {
            self.substep(substep_s);
        }
        Ok(&self.state)
    }

    /// One step of the midpoint rule, rotations moved along the exponential map.
    fn substep(&mut self, step_s: f64) {
        let now = self.state.clone();
        let turned = |velocity: Vector3<f64>, time_s: f64| {
            let rotation = UnitQuaternion::from_scaled_axis(velocity * time_s) * now.rotation;
            // Products of unit quaternions drift from unit length by a rounding each.
            UnitQuaternion::new_normalize(rotation.into_inner())
        };
        let middle = OrientationState {
            time_s: now.time_s + 0.5 * step_s,
            rotation: turned(now.velocity, 0.5 * step_s),
            velocity: now.velocity + 0.5 * step_s * self.acceleration(&now),
        };
        self.state = OrientationState {
            time_s: now.time_s + step_s,
            rotation: turned(middle.velocity, step_s),
            velocity: now.velocity + step_s * self.acceleration(&middle),
        };
    }

    fn acceleration(&mut self, at: &OrientationState) -> Vector3<f64> {
        let duration_s = self.motion.duration_s;
        let springs = &self.dmp.springs;
        let mut forces = [0.0; 3];
        springs.force_into(at.time_s / duration_s, &mut self.activation, &mut forces);
        let to_goal = rotation_between(&at.rotation, &self.motion.goal);
        Vector3::from_fn(|dim, _| {
            springs.acceleration((to_goal[dim], at.velocity[dim]), forces[dim], duration_s)
        })
    }
}
