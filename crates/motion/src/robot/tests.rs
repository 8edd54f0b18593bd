use super::*;
use crate::test_robots;
use nalgebra::DMatrix;

/// Pose and Jacobian of the tool by the physics engine.
fn by_physics(robot: &RobotModel, q: &[f64]) -> (crate::Pose, DMatrix<f64>) {
    let model = scene_of_robot(robot.description())
        .unwrap()
        .compile()
        .unwrap();
    let mut state = State::new(&model).unwrap();
    let joints: Vec<JointId> = robot
        .chain_joints()
        .iter()
        .map(|name| model.joint(name).unwrap())
        .collect();
    for (&joint, &q) in joints.iter().zip(q) {
        state.set_joint_position(joint, q);
    }
    state.forward_kinematics().unwrap();
    let site = model.site(&robot.description().arm.tcp_site).unwrap();
    let mut all = DMatrix::zeros(6, model.n_v());
    state.site_jacobian_into(site, &mut all);
    let columns: Vec<_> = joints
        .iter()
        .map(|&joint| all.column(model.dof_adr(joint)).into_owned())
        .collect();
    (state.world_from_site(site), DMatrix::from_columns(&columns))
}

#[test]
fn kinematics_agree_with_physics() {
    for name in ["panda", "iiwa7", "jaco", "movo"] {
        let robot = test_robots::load(name);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut q = vec![0.0; robot.n()];
        for _ in 0..20 {
            robot.space().sample_into(&mut rng, &mut q);
            let (pose, jacobian) = by_physics(&robot, &q);
            let error = pose.inverse() * robot.chain().base_from_tcp(&q);
            assert!(error.translation.vector.norm() < 1e-9, "{name}: {error}");
            assert!(error.rotation.angle() < 1e-7, "{name}: {error}");
            assert!(
                (robot.chain().jacobian(&q) - jacobian).norm() < 1e-9,
                "{name}"
            );
        }
    }
}

#[test]
fn the_jaco_has_four_continuous_joints() {
    let robot = test_robots::load("jaco");
    let continuous: Vec<bool> = robot
        .limits()
        .iter()
        .map(|limit| limit.continuous)
        .collect();
    assert_eq!(continuous, [true, false, true, false, true, false, true]);
}

#[test]
fn the_lift_comes_first() {
    let robot = test_robots::load("movo");
    assert_eq!(robot.chain_joints()[0], "lift");
    assert!(robot.limits()[0].slide && !robot.limits()[1].slide);
    assert_eq!(robot.n(), 8);
    assert_eq!(robot.q_from_state(0.3, &[1.0; 7])[0], 0.3);
}

#[test]
fn a_joint_outside_the_chain_is_named() {
    let mut description = test_robots::load("jaco").description().clone();
    description.arm.joints[6] = "finger_thumb".to_owned();
    let error = RobotModel::load(&description).unwrap_err().to_string();
    assert_eq!(
        error,
        "joint `finger_thumb` does not move the tool frame `tcp`"
    );
    description.arm.joints[6] = "j8".to_owned();
    let error = RobotModel::load(&description).unwrap_err().to_string();
    assert!(
        error.starts_with("joint `j8` is not in model") && error.contains("`j7`"),
        "{error}"
    );
}
