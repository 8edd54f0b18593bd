//! Where the numbers of an arm lie in a physics model.

use factotum_geometry::Pose;
use factotum_physics::{JointId, Model, SiteChain, SiteId, State};
use nalgebra::{DMatrix, DVector, Matrix6xX};

use crate::ArmState;

/// The joints of an arm and its tool frame, found once in a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelArm {
    joints: Vec<JointId>,
    chain: SiteChain,
}

impl ModelArm {
    /// The arm of these joints, from the base on, that carries the tool frame `tcp`.
    pub fn new(model: &Model, joints: Vec<JointId>, tcp: SiteId) -> Self {
        let dofs: Vec<usize> = joints.iter().map(|&joint| model.dof_adr(joint)).collect();
        Self {
            joints,
            chain: model.site_chain(tcp, &dofs),
        }
    }

    /// The joints.
    pub fn joints(&self) -> &[JointId] {
        &self.joints
    }

    /// The tool frame.
    pub fn tcp(&self) -> SiteId {
        self.chain.site()
    }

    /// The arm as it is in a simulated state, in the frame of the world; needs [`State::dynamics`], [`State::forward`] or
    /// [`State::step1`].
    pub fn read(&self, state: &State) -> ArmState {
        let n = self.joints.len();
        let mut arm = ArmState {
            positions: DVector::zeros(n),
            velocities: DVector::zeros(n),
            mass: DMatrix::zeros(n, n),
            bias: DVector::zeros(n),
            jacobian: Matrix6xX::zeros(n),
            base_from_tcp: Pose::identity(),
        };
        self.read_into(state, &mut arm);
        arm
    }

    /// As [`read`](Self::read), into an arm state that was read before.
    pub fn read_into(&self, state: &State, arm: &mut ArmState) {
        let (velocities, bias) = (state.qvel(), state.bias_forces());
        for (i, (&joint, &dof)) in self.joints.iter().zip(self.chain.dofs()).enumerate() {
            arm.positions[i] = state.joint_position(joint);
            arm.velocities[i] = velocities[dof];
            arm.bias[i] = bias[dof];
        }
        state.chain_mass_into(&self.chain, &mut arm.mass);
        state.chain_jacobian_into(&self.chain, &mut arm.jacobian);
        arm.base_from_tcp = state.world_from_site(self.tcp());
    }
}
