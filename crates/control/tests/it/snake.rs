//! A small arm of any number of joints, as a description and in physics.

use factotum_control::{ArmDynamics, ArmState};
use factotum_descriptions::RobotDescription;
use factotum_physics::{ActuatorId, BodyId, JointId, State};
use nalgebra::{DVector, Vector3};

pub(crate) const STEP_SECS: f64 = 0.002;
pub(crate) const TORQUE_MAX_NM: f64 = 60.0;
pub(crate) const LIMIT_RAD: f64 = 2.0;

/// An arm of `n` links of 0.18 m, 0.8 kg, with joints that turn about z and y by turns, without friction.
pub(crate) struct Snake {
    pub(crate) dynamics: ArmDynamics,
    pub(crate) state: State,
    pub(crate) tip: BodyId,
    joints: Vec<JointId>,
    actuators: Vec<ActuatorId>,
}

impl Snake {
    pub(crate) fn new(n: usize, positions: &[f64]) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let mut open = String::new();
        let mut motors = String::new();
        for i in 1..=n {
            let (axis, z) = (
                if i % 2 == 1 { "0 0 1" } else { "0 1 0" },
                if i == 1 { 0.2 } else { 0.18 },
            );
            open += &format!(
                r#"<body name="link{i}" pos="0 0 {z}">
                   <joint name="j{i}" axis="{axis}" range="-{LIMIT_RAD} {LIMIT_RAD}" armature="0.01"/>
                   <geom type="capsule" fromto="0 0 0.02 0 0 0.16" size="0.02" mass="0.8" contype="0" conaffinity="0"/>"#
            );
            motors += &format!(
                r#"<motor name="j{i}" joint="j{i}" ctrlrange="-{TORQUE_MAX_NM} {TORQUE_MAX_NM}"/>"#
            );
        }
        let xml = format!(
            r#"<mujoco model="snake"><compiler angle="radian" autolimits="true"/>
            <worldbody>{open}<site name="tcp" pos="0 0 0.2" euler="0 0 0.4"/>{}</worldbody>
            <actuator>{motors}</actuator></mujoco>"#,
            "</body>".repeat(n)
        );
        std::fs::write(dir.path().join("snake.xml"), xml).unwrap();
        let names: Vec<String> = (1..=n).map(|i| format!("\"j{i}\"")).collect();
        let all = |value: &str| vec![value; n].join(", ");
        let toml = format!(
            "name = \"snake\"\n[[parts]]\nname = \"arm\"\nmodel = \"snake.xml\"\n[arm]\njoints = [{}]\n\
             tcp_site = \"tcp\"\nvelocity_max_rad_per_s = [{}]\nacceleration_max_rad_per_s2 = [{}]\n\
             torque_max_nm = [{}]\nrest = [{}]\nready = [{}]\n",
            names.join(", "),
            all("2.0"),
            all("10.0"),
            all("60.0"),
            all("0.0"),
            all("0.0"),
        );
        std::fs::write(dir.path().join("robot.toml"), toml).unwrap();
        let robot = RobotDescription::load(dir.path()).unwrap();
        let dynamics = ArmDynamics::new(&robot).unwrap();
        let model = dynamics.model().clone();
        let mut state = State::new(&model).unwrap();
        let joints: Vec<JointId> = robot
            .arm
            .joints
            .iter()
            .map(|name| model.joint(name).unwrap())
            .collect();
        for (joint, position) in joints.iter().zip(positions) {
            state.set_joint_position(*joint, *position);
        }
        Self {
            tip: model.body(&format!("link{n}")).unwrap(),
            actuators: robot
                .arm
                .actuators
                .iter()
                .map(|name| model.actuator(name).unwrap())
                .collect(),
            joints,
            dynamics,
            state,
        }
    }

    pub(crate) fn arm_state(&mut self) -> ArmState {
        let q: Vec<f64> = self
            .joints
            .iter()
            .map(|&j| self.state.joint_position(j))
            .collect();
        let v: Vec<f64> = self
            .joints
            .iter()
            .map(|&j| self.state.joint_velocity(j))
            .collect();
        self.dynamics.arm_state(0.0, &q, &v).unwrap()
    }

    pub(crate) fn step(&mut self, torques: &DVector<f64>) {
        for (actuator, torque) in self.actuators.iter().zip(torques.iter()) {
            self.state.set_ctrl(*actuator, *torque);
        }
        self.state.step().unwrap();
    }

    /// Pushes the tool with a constant force in the world until told otherwise.
    pub(crate) fn push_tool(&mut self, force: Vector3<f64>) {
        let tool = self.arm_state().base_from_tcp.translation.vector;
        self.state.forward_kinematics().unwrap();
        let com = self.state.body_com_in_world(self.tip).coords;
        let torque = (tool - com).cross(&force);
        let applied = self.state.xfrc_applied_mut(self.tip);
        *applied = [force.x, force.y, force.z, torque.x, torque.y, torque.z];
    }
}

/// A bent posture, far from singular and from the limits.
pub(crate) fn bent(n: usize) -> Vec<f64> {
    let pattern = [0.3, 0.7, -0.4, 0.9, 0.5, -0.8, 0.2, 0.6, -0.3];
    pattern.iter().copied().cycle().take(n).collect()
}
