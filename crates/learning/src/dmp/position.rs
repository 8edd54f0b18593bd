//! Primitives of positions: points, or joints that do not turn around.

use super::canonical::substeps;
use super::demonstration::{derivative, ends_of};
use super::error::{check_finite, check_positive, check_size};
use super::spring::{ForcedSprings, Response};
use super::{DmpError, DmpParams, ForcingTerms};
use crate::lwr::Activation;
use nalgebra::{DMatrix, DVector};

/// Share of a demonstration's extent below which a dimension counts as ending where it began.
const DISPLACEMENT_SHARE_MIN: f64 = 1e-3;

/// Longest step of the integration, in times between two kernels.
const SUBSTEP_KERNELS_MAX: f64 = 1.0 / 3.0;

/// What another goal does to the shape of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShapeScaling {
    /// The shape keeps its demonstrated size; only the spring leads to the other goal.
    #[default]
    Fixed,
    /// Each dimension's shape grows with the way from start to goal (Ijspeert et al. 2013).
    ///
    /// Dimensions that end where they began, within a thousandth of their extent, keep their size.
    WithDisplacement,
}

/// A motion of positions, learned from one demonstration.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionDmp {
    springs: ForcedSprings,
    duration_s: f64,
    start: DVector<f64>,
    goal: DVector<f64>,
    /// Per dimension, 1 / displacement, or nothing where the demonstration ends where it began.
    per_displacement: Vec<Option<f64>>,
}

/// A run of a primitive that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionMotion {
    /// Where it starts.
    pub start: DVector<f64>,
    /// Velocity there, per second.
    pub start_velocity: DVector<f64>,
    /// Where it ends.
    pub goal: DVector<f64>,
    /// How long it takes, seconds; what is left to the goal then fades within a fraction of it.
    pub duration_s: f64,
    /// What the goal does to the shape.
    pub scaling: ShapeScaling,
}

/// A moment of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionState {
    /// Since the start, seconds.
    pub time_s: f64,
    /// Position.
    pub position: DVector<f64>,
    /// Velocity, per second.
    pub velocity: DVector<f64>,
}

impl PositionDmp {
    /// Learns from positions at equal steps of `step_s` seconds.
    ///
    /// # Errors
    /// [`DmpError`] when there are fewer samples than kernels (or than 3), or anything is of another size or not finite.
    pub fn learn(
        demonstration: &[DVector<f64>],
        step_s: f64,
        params: &DmpParams,
    ) -> Result<Self, DmpError> {
        let (start, goal) = ends_of(demonstration, step_s, params)?;
        for sample in demonstration {
            check_size("sample", sample.len(), start.len())?;
            check_finite("sample", sample.iter())?;
        }
        let positions = DMatrix::from_columns(demonstration);
        let velocities = derivative(&positions, step_s);
        let to_goal = DMatrix::from_fn(start.len(), demonstration.len(), |dim, k| {
            goal[dim] - positions[(dim, k)]
        });
        let per_displacement = (0..start.len())
            .map(|dim| {
                let row = positions.row(dim);
                let displacement = goal[dim] - start[dim];
                let is_moved =
                    displacement.abs() > DISPLACEMENT_SHARE_MIN * (row.max() - row.min());
                is_moved.then(|| 1.0 / displacement)
            })
            .collect();
        Ok(Self {
            springs: ForcedSprings::learn(&to_goal, &velocities, step_s, params)?,
            duration_s: step_s * (demonstration.len() - 1) as f64,
            start: start.clone(),
            goal: goal.clone(),
            per_displacement,
        })
    }

    /// The run that was demonstrated, from rest.
    #[must_use]
    pub fn demonstrated(&self) -> PositionMotion {
        PositionMotion {
            start: self.start.clone(),
            start_velocity: DVector::zeros(self.start.len()),
            goal: self.goal.clone(),
            duration_s: self.duration_s,
            scaling: ShapeScaling::default(),
        }
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
    /// [`DmpError`] when a size differs from the demonstration's, or anything is not finite or the duration not positive.
    pub fn run(&self, motion: &PositionMotion) -> Result<PositionRollout<'_>, DmpError> {
        let n_dims = self.start.len();
        for (what, vector) in [
            ("start", &motion.start),
            ("start velocity", &motion.start_velocity),
            ("goal", &motion.goal),
        ] {
            check_size(what, vector.len(), n_dims)?;
            check_finite(what, vector.iter())?;
        }
        check_positive("duration", motion.duration_s)?;
        Ok(PositionRollout {
            dmp: self,
            motion: motion.clone(),
            state: PositionState {
                time_s: 0.0,
                position: motion.start.clone(),
                velocity: motion.start_velocity.clone(),
            },
            scales: self.shape_scales(motion),
            activation: self.springs.forcing.activation(),
            forces: [vec![0.0; n_dims], vec![0.0; n_dims]],
        })
    }

    /// Kernels that count after a share of the duration, each with its share of the force.
    pub(super) fn kernel_shares(&self, share: f64) -> Vec<(usize, f64)> {
        self.springs.kernel_shares(share)
    }

    fn shape_scales(&self, motion: &PositionMotion) -> DVector<f64> {
        DVector::from_fn(self.start.len(), |dim, _| {
            match (motion.scaling, self.per_displacement[dim]) {
                (ShapeScaling::WithDisplacement, Some(per_displacement)) => {
                    (motion.goal[dim] - motion.start[dim]) * per_displacement
                }
                _ => 1.0,
            }
        })
    }
}

/// A run under way.
#[derive(Debug, Clone)]
pub struct PositionRollout<'a> {
    dmp: &'a PositionDmp,
    motion: PositionMotion,
    state: PositionState,
    /// What the learned force is multiplied with, per dimension.
    scales: DVector<f64>,
    activation: Activation,
    /// Forces at the two nodes of a step.
    forces: [Vec<f64>; 2],
}

impl PositionRollout<'_> {
    /// The present moment.
    #[must_use]
    pub fn state(&self) -> &PositionState {
        &self.state
    }

    /// Leads to another goal from now on.
    ///
    /// # Errors
    /// [`DmpError`] when its size differs or it is not finite.
    pub fn set_goal(&mut self, goal: DVector<f64>) -> Result<(), DmpError> {
        check_size("goal", goal.len(), self.motion.goal.len())?;
        check_finite("goal", goal.iter())?;
        self.motion.goal = goal;
        self.scales = self.dmp.shape_scales(&self.motion);
        Ok(())
    }

    /// Goes on by a time in seconds. Allocates nothing.
    ///
    /// # Errors
    /// [`DmpError::OutOfRange`] when the step is not positive or longer than a thousand durations.
    pub fn advance(&mut self, step_s: f64) -> Result<&PositionState, DmpError> {
        let n_kernels = self.dmp.forcing().weights().ncols();
        let share_max = SUBSTEP_KERNELS_MAX / n_kernels as f64;
        let (n_substeps, substep_s) = substeps(step_s, self.motion.duration_s, share_max)?;
        let response = self.dmp.springs.response(substep_s, self.motion.duration_s);
        for _ in 0..n_substeps {
            self.substep(substep_s, &response);
        }
        Ok(&self.state)
    }

    fn substep(&mut self, step_s: f64, response: &Response) {
        let Self {
            dmp,
            motion,
            state,
            scales,
            activation,
            forces,
        } = self;
        for (node, forces) in Response::NODES.iter().zip(forces.iter_mut()) {
            let share = (state.time_s + node * step_s) / motion.duration_s;
            dmp.springs.force_into(share, activation, forces);
        }
        for dim in 0..scales.len() {
            let (goal, scale) = (motion.goal[dim], scales[dim]);
            let (from_goal, velocity) = response.after(
                state.position[dim] - goal,
                state.velocity[dim],
                [scale * forces[0][dim], scale * forces[1][dim]],
            );
            state.position[dim] = goal + from_goal;
            state.velocity[dim] = velocity;
        }
        state.time_s += step_s;
    }
}
