//! The numbers of a state, to read and to write. Writing changes nothing that follows from them until
//! the next computation.

use crate::Pose;
use crate::axes::wxyz_from_quat;
use crate::error::PhysicsError;
use crate::ids::{ActuatorId, BodyId, JointId, SensorId};
use crate::joint_kind::JointKind;
use crate::model::Model;
use crate::state::{State, view, view_mut};

impl State {
    /// Simulated time, s.
    pub fn time_secs(&self) -> f64 {
        self.raw().time
    }

    /// Sets the simulated time, s.
    pub fn set_time_secs(&mut self, time_secs: f64) {
        self.raw_mut().time = time_secs;
    }

    /// Positions, length `n_q`.
    pub fn qpos(&self) -> &[f64] {
        view!(self, qpos, self.model().n_q())
    }

    /// Positions, to write; nothing that follows from them changes until the next computation.
    pub fn qpos_mut(&mut self) -> &mut [f64] {
        view_mut!(self, qpos, self.model().n_q())
    }

    /// Velocities, length `n_v`.
    pub fn qvel(&self) -> &[f64] {
        view!(self, qvel, self.model().n_v())
    }

    /// Velocities, to write.
    pub fn qvel_mut(&mut self) -> &mut [f64] {
        view_mut!(self, qvel, self.model().n_v())
    }

    /// Accelerations, length `n_v`.
    pub fn qacc(&self) -> &[f64] {
        view!(self, qacc, self.model().n_v())
    }

    /// Accelerations, to write, for [`inverse`](Self::inverse).
    pub fn qacc_mut(&mut self) -> &mut [f64] {
        view_mut!(self, qacc, self.model().n_v())
    }

    /// Controls, length `n_u`.
    pub fn ctrl(&self) -> &[f64] {
        view!(self, ctrl, self.model().n_u())
    }

    /// Controls, to write. A value that is not finite is an error at the next step.
    pub fn ctrl_mut(&mut self) -> &mut [f64] {
        view_mut!(self, ctrl, self.model().n_u())
    }

    /// Sets one actuator's control.
    pub fn set_ctrl(&mut self, actuator: ActuatorId, value: f64) {
        let adr = self.model().ctrl_adr(actuator);
        self.ctrl_mut()[adr] = value;
    }

    /// Forces applied to degrees of freedom, length `n_v`.
    pub fn qfrc_applied(&self) -> &[f64] {
        view!(self, qfrc_applied, self.model().n_v())
    }

    /// Forces applied to degrees of freedom, to write; they stay until changed.
    pub fn qfrc_applied_mut(&mut self) -> &mut [f64] {
        view_mut!(self, qfrc_applied, self.model().n_v())
    }

    /// Force (N) and torque (N m) applied at the centre of mass of a body, world axes.
    pub fn xfrc_applied(&self, body: BodyId) -> [f64; 6] {
        let all = view!(self, xfrc_applied, 6 * self.model().n_bodies());
        let mut wrench = [0.0; 6];
        wrench.copy_from_slice(&all[6 * body.0..6 * body.0 + 6]);
        wrench
    }

    /// Force (N) and torque (N m) applied at the centre of mass of a body, world axes, to write;
    /// they stay until changed.
    pub fn xfrc_applied_mut(&mut self, body: BodyId) -> &mut [f64; 6] {
        let all = view_mut!(self, xfrc_applied, 6 * self.model().n_bodies());
        let (rows, _) = all.as_chunks_mut::<6>();
        &mut rows[body.0]
    }

    /// Forces of the actuators on degrees of freedom, length `n_v`, after a computation.
    pub fn qfrc_actuator(&self) -> &[f64] {
        view!(self, qfrc_actuator, self.model().n_v())
    }

    /// Forces of contacts, limits and other constraints, length `n_v`, after a computation.
    pub fn qfrc_constraint(&self) -> &[f64] {
        view!(self, qfrc_constraint, self.model().n_v())
    }

    /// Springs, dampers and gravity compensation, length `n_v`, after a computation.
    pub fn qfrc_passive(&self) -> &[f64] {
        view!(self, qfrc_passive, self.model().n_v())
    }

    /// Forces found by [`inverse`](Self::inverse), length `n_v`.
    pub fn qfrc_inverse(&self) -> &[f64] {
        view!(self, qfrc_inverse, self.model().n_v())
    }

    /// Gravity and Coriolis forces, length `n_v`, after [`forward`](Self::forward) or
    /// [`dynamics`](Self::dynamics): the force that holds the arm still at zero velocity.
    pub fn bias_forces(&self) -> &[f64] {
        view!(self, qfrc_bias, self.model().n_v())
    }

    /// Values of a sensor, after a computation.
    pub fn sensor(&self, sensor: SensorId) -> &[f64] {
        let all = view!(self, sensordata, self.model().tables().n_sensor_data);
        &all[self.model().tables().sensors[sensor.0].values.clone()]
    }

    /// Position of a slide (m) or hinge (rad); the first coordinate of another joint.
    pub fn joint_position(&self, joint: JointId) -> f64 {
        self.qpos()[self.model().qpos_adr(joint)]
    }

    /// Sets the position of a slide (m) or hinge (rad).
    pub fn set_joint_position(&mut self, joint: JointId, value: f64) {
        let adr = self.model().qpos_adr(joint);
        self.qpos_mut()[adr] = value;
    }

    /// Velocity of a slide (m/s) or hinge (rad/s); the first coordinate of another joint.
    pub fn joint_velocity(&self, joint: JointId) -> f64 {
        self.qvel()[self.model().dof_adr(joint)]
    }

    /// Sets the pose of a body that hangs on a free joint, at rest, in the world.
    ///
    /// # Errors
    /// [`PhysicsError::Argument`] when the body has no free joint.
    pub fn set_free_body_pose(
        &mut self,
        body: BodyId,
        world_from_body: &Pose,
    ) -> Result<(), PhysicsError> {
        let joint = self.model().free_joint_of(body)?;
        let (qpos_adr, dof_adr) = (self.model().qpos_adr(joint), self.model().dof_adr(joint));
        let position: [f64; 3] = world_from_body.translation.vector.into();
        let qpos = self.qpos_mut();
        qpos[qpos_adr..qpos_adr + 3].copy_from_slice(&position);
        qpos[qpos_adr + 3..qpos_adr + 7]
            .copy_from_slice(&wxyz_from_quat(&world_from_body.rotation));
        self.qvel_mut()[dof_adr..dof_adr + 6].fill(0.0);
        Ok(())
    }

    /// Sets the pose of a mocap body in the world.
    ///
    /// # Errors
    /// [`PhysicsError::Argument`] when the body is not a mocap body.
    pub fn set_mocap(&mut self, body: BodyId, world_from_body: &Pose) -> Result<(), PhysicsError> {
        let n = self.model().tables().n_mocap;
        let Some(row) = self.model().tables().bodies[body.0].mocap else {
            return Err(PhysicsError::Argument {
                what: "mocap body",
                found: format!("body `{}`", self.model().body_name(body)),
                expected: "a body with mocap=\"true\"",
            });
        };
        let position: [f64; 3] = world_from_body.translation.vector.into();
        view_mut!(self, mocap_pos, 3 * n)[3 * row..3 * row + 3].copy_from_slice(&position);
        view_mut!(self, mocap_quat, 4 * n)[4 * row..4 * row + 4]
            .copy_from_slice(&wxyz_from_quat(&world_from_body.rotation));
        Ok(())
    }
}

impl Model {
    /// The free joint of a body.
    ///
    /// # Errors
    /// [`PhysicsError::Argument`] when it has none.
    pub fn free_joint_of(&self, body: BodyId) -> Result<JointId, PhysicsError> {
        self.joints_of_body(body)
            .into_iter()
            .find(|&joint| self.joint_kind(joint) == JointKind::Free)
            .ok_or_else(|| PhysicsError::Argument {
                what: "free body",
                found: format!("body `{}`", self.body_name(body)),
                expected: "a body with a free joint",
            })
    }
}
