//! The robot's own model of itself: mass matrix, bias forces, Jacobian and tool pose from measured joints.
//!
//! It is compiled from the robot's description alone, with the base at rest at the origin, the fingers open and nothing
//! in the hand. A controller that uses it therefore knows what the maker of the robot knows, and nothing of its
//! surroundings.

use factotum_descriptions::RobotDescription;
use factotum_geometry::Pose;
use factotum_physics::{AttachPoint, JointId, Model, PhysicsError, SceneBuilder, State};

use crate::composition::attach_robot;
use crate::error::{check_finite, check_size};
use crate::{ArmState, ControlError, ModelArm};

/// Computes an [`ArmState`] from joint readings.
#[derive(Debug)]
pub struct ArmDynamics {
    robot: String,
    state: State,
    arm: ModelArm,
    lift: Option<JointId>,
    /// Pose of the base link when the base joints are at zero.
    world_from_base: Pose,
}

impl ArmDynamics {
    /// Compiles the robot's own model.
    ///
    /// # Errors
    /// [`ControlError::Model`] if a model is missing or broken, or lacks a joint or site that the description names.
    pub fn new(robot: &RobotDescription) -> Result<Self, ControlError> {
        Self::build(robot).map_err(|source| ControlError::Model {
            robot: robot.name.clone(),
            source,
        })
    }

    fn build(robot: &RobotDescription) -> Result<Self, PhysicsError> {
        let mut scene = SceneBuilder::new();
        scene.name(&robot.name).visuals(false);
        attach_robot(&mut scene, robot, &AttachPoint::World(Pose::identity()))?;
        let model = scene.compile()?;
        let joints = robot
            .arm
            .joints
            .iter()
            .map(|name| model.joint(name))
            .collect::<Result<Vec<_>, _>>()?;
        let lift = robot
            .lift
            .as_ref()
            .map(|lift| model.joint(&lift.joint))
            .transpose()?;
        let tcp = model.site(&robot.arm.tcp_site)?;
        let base = robot
            .base
            .as_ref()
            .map(|base| model.body(&base.link))
            .transpose()?;
        let mut state = State::new(&model)?;
        state.forward_kinematics()?;
        let world_from_base = base.map_or_else(Pose::identity, |body| state.world_from_body(body));
        Ok(Self {
            robot: robot.name.clone(),
            state,
            arm: ModelArm::new(&model, joints, tcp),
            lift,
            world_from_base,
        })
    }

    /// The compiled model of the robot alone.
    pub fn model(&self) -> &Model {
        self.state.model()
    }

    /// Number of arm joints.
    pub fn n_joints(&self) -> usize {
        self.arm.joints().len()
    }

    /// Limits of the arm joints in rad, `None` for a joint that turns without end.
    pub fn joint_limits(&self) -> Vec<Option<[f64; 2]>> {
        let model = self.state.model();
        let joints = self.arm.joints().iter();
        joints.map(|&joint| model.joint_range(joint)).collect()
    }

    /// Limits of the lift in m, if there is a lift and it has limits.
    pub fn lift_limits(&self) -> Option<[f64; 2]> {
        self.state.model().joint_range(self.lift?)
    }

    /// The arm at these joint positions and velocities, with the lift at rest at `lift_m` (ignored without a lift).
    ///
    /// # Errors
    /// [`ControlError::Size`] or [`ControlError::NotFinite`] for bad readings, [`ControlError::Model`] if the engine fails.
    pub fn arm_state(
        &mut self,
        lift_m: f64,
        positions: &[f64],
        velocities: &[f64],
    ) -> Result<ArmState, ControlError> {
        let n = self.n_joints();
        check_size("arm positions", positions.len(), n)?;
        check_size("arm velocities", velocities.len(), n)?;
        check_finite("joint readings", positions.iter().chain(velocities))?;
        check_finite("lift reading", [&lift_m])?;
        self.place(lift_m, positions, velocities)
            .map_err(|source| ControlError::Model {
                robot: self.robot.clone(),
                source,
            })?;
        Ok(self.read())
    }

    /// Tool pose in the base frame at these joint positions.
    ///
    /// # Errors
    /// As [`arm_state`](Self::arm_state).
    pub fn base_from_tcp(&mut self, lift_m: f64, positions: &[f64]) -> Result<Pose, ControlError> {
        let at_rest = vec![0.0; positions.len()];
        Ok(self.arm_state(lift_m, positions, &at_rest)?.base_from_tcp)
    }

    fn place(
        &mut self,
        lift_m: f64,
        positions: &[f64],
        velocities: &[f64],
    ) -> Result<(), PhysicsError> {
        if let Some(lift) = self.lift {
            self.state.set_joint_position(lift, lift_m);
        }
        for ((&joint, &position), &velocity) in
            self.arm.joints().iter().zip(positions).zip(velocities)
        {
            self.state.set_joint_position(joint, position);
            let dof = self.state.model().dof_adr(joint);
            self.state.qvel_mut()[dof] = velocity;
        }
        self.state.dynamics()
    }

    fn read(&self) -> ArmState {
        let mut arm = self.arm.read(&self.state);
        let base_from_world = self.world_from_base.inverse();
        let rotation = base_from_world.rotation.to_rotation_matrix();
        for mut column in arm.jacobian.column_iter_mut() {
            for first in [0, 3] {
                let rotated = rotation * column.fixed_rows::<3>(first);
                column.fixed_rows_mut::<3>(first).copy_from(&rotated);
            }
        }
        arm.base_from_tcp = base_from_world * arm.base_from_tcp;
        arm
    }
}
