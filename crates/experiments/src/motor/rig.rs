//! Where a motor skill is tried: the arm at the object, driven by joint velocities.

use factotum_descriptions::{MotorSpec, TaskSpec};
use factotum_geometry::Pose;
use factotum_motion::{Obstacle, ObstacleShape, PlanningScene};
use factotum_skills::bootstrap::{KinematicError, ObjectKinematics, PlannedDemo, initial_demo};
use factotum_skills::cip::rig::{Reading, Rig as _};
use factotum_worlds::TaskRig;
use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::MotorError;

/// c of Eq. 4.1, per rad² or m².
const GOAL_WEIGHT: f64 = 60.0;

/// The diagonal of R in Eq. 4.1, s²/rad².
const ACTION_WEIGHT: f64 = 0.001;

/// What came of a rollout.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MotorRollout {
    /// Sum of the rewards.
    pub total_reward: f64,
    /// Where the object's joint ended, rad or m.
    pub object_state: f64,
    /// Whether that is beyond the task's share of the way.
    pub success: bool,
}

/// What moves the arm in a rollout.
pub(super) trait Controller {
    /// Joint velocities for the next step, rad/s.
    fn act(&mut self, seen: &Reading, action: &mut [f64]) -> Result<(), MotorError>;

    /// What the last action earned.
    fn earn(&mut self, _reward: f64) {}
}

/// A rig on which a motor skill is tried.
#[derive(Debug)]
pub struct MotorRig {
    rig: TaskRig,
    motor: MotorSpec,
}

impl MotorRig {
    /// For a task with a table `[motor]`.
    ///
    /// # Errors
    /// [`MotorError`] if it has none, or robot and object do not fit it.
    pub fn new(task: &TaskSpec) -> Result<Self, MotorError> {
        let Some(motor) = task.motor.clone() else {
            return Err(MotorError::NoMotor {
                task: task.name.clone(),
            });
        };
        let mut rig = TaskRig::new(task)?;
        rig.place_for_motor_skill()?;
        Ok(Self { rig, motor })
    }

    /// The simulation, to look at.
    pub fn rig(&self) -> &TaskRig {
        &self.rig
    }

    /// Length of a step, seconds.
    pub(super) fn step_secs(&self) -> f64 {
        1.0 / self.rig.task().episode.control_hz
    }

    /// A demonstration by the robot's own plan.
    ///
    /// # Errors
    /// [`MotorError::Bootstrap`] where the arm cannot come to the object.
    pub fn plan(
        &mut self,
        error: &KinematicError,
        rng: &mut ChaCha8Rng,
    ) -> Result<PlannedDemo, MotorError> {
        self.rig.place_for_motor_skill()?;
        let task = self.rig.task();
        let anatomy = self.rig.anatomy();
        let start = task.start;
        let contact: Pose = self.motor.contact.into();
        let believed = ObjectKinematics {
            base_from_object: self.rig.reading().base_from_object,
            joint: anatomy.object_joint.clone(),
            start,
            goal: task.goal,
            object_from_contact: anatomy.object_joint.motion(0.0, start) * contact,
        }
        .mistaken(error, rng);
        let obstacle = Obstacle {
            name: task.name.clone(),
            shape: ObstacleShape::Model {
                file: task.model.clone(),
                joint_positions: vec![(task.joint.clone(), start)],
            },
            base_from_obstacle: believed.base_from_object,
        };
        let mut free = PlanningScene::new(&anatomy.robot, std::slice::from_ref(&obstacle), None)?;
        free.set_gripper(self.motor.opening);
        // The object moves with the tool, so that on the way its model where it stands says nothing.
        let mut near = PlanningScene::new(&anatomy.robot, &[], None)?;
        near.set_gripper(self.motor.opening);
        let q_start = self.rig.reading().arm_positions.clone();
        let step_secs = self.step_secs();
        Ok(initial_demo(
            &mut free,
            &mut near,
            &q_start,
            &believed,
            self.motor.plan_speed,
            step_secs,
            rng,
        )?)
    }

    /// Lets a controller move the arm from the start of the task to the end of its time; `watch` sees the rig after every
    /// step.
    ///
    /// # Errors
    /// [`MotorError`] when the physics breaks down.
    pub(super) fn roll_out(
        &mut self,
        controller: &mut dyn Controller,
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<MotorRollout, MotorError> {
        self.roll_out_for(self.n_steps(), controller, watch)
    }

    /// As [`Self::roll_out`], for another number of steps.
    pub(super) fn roll_out_for(
        &mut self,
        n_steps: usize,
        controller: &mut dyn Controller,
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<MotorRollout, MotorError> {
        self.begin()?;
        watch(&self.rig);
        let goal = self.rig.task().goal;
        let mut total_reward = 0.0;
        let mut action = vec![0.0; self.n_joints()];
        for _ in 0..n_steps {
            controller.act(self.rig.reading(), &mut action)?;
            self.drive(&action)?;
            watch(&self.rig);
            let off = goal - self.rig.reading().object_joint;
            let effort: f64 = action.iter().map(|action| action * action).sum();
            let reward = -(GOAL_WEIGHT * off * off + ACTION_WEIGHT * effort);
            controller.earn(reward);
            total_reward += reward;
        }
        Ok(MotorRollout {
            total_reward,
            object_state: self.rig.reading().object_joint,
            success: self.is_done(),
        })
    }

    /// Puts arm and object where the task begins.
    pub(super) fn begin(&mut self) -> Result<(), MotorError> {
        Ok(self.rig.place_for_motor_skill()?)
    }

    /// Drives the arm for one step.
    pub(super) fn drive(&mut self, action: &[f64]) -> Result<(), MotorError> {
        Ok(self.rig.drive(action)?)
    }

    /// Whether the object is where the task wants it.
    pub(super) fn is_done(&self) -> bool {
        self.rig.task().progress(self.rig.reading().object_joint) >= self.motor.done
    }

    /// Sum of the rewards of an arm that never moves and an object that does not either.
    pub fn still_return(&self) -> f64 {
        let task = self.rig.task();
        let off = task.goal - task.start;
        -GOAL_WEIGHT * off * off * self.n_steps() as f64
    }

    /// Joints of the arm.
    pub(super) fn n_joints(&self) -> usize {
        self.rig.reading().arm_positions.len()
    }

    /// Length of a rollout, seconds.
    pub(super) fn duration_secs(&self) -> f64 {
        self.motor.duration_secs
    }

    /// Steps of a rollout.
    fn n_steps(&self) -> usize {
        (self.motor.duration_secs / self.step_secs()).round() as usize
    }

    /// Standing still for the length of a rollout, as a demonstration: samples and their distance in time, seconds.
    pub(super) fn stillness(&self, n_samples_min: usize) -> (Vec<DVector<f64>>, f64) {
        let secs = self.motor.duration_secs;
        let n_steps = self.n_steps().max(n_samples_min);
        let here = DVector::from_row_slice(&self.rig.reading().arm_positions);
        (vec![here; n_steps + 1], secs / n_steps as f64)
    }
}
