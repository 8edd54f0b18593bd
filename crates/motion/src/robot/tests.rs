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

/// A chain of four joints whose tool frame is given in `robot.toml`, mounted on another part.
const SHORT_ARM: &str = r#"
<mujoco><compiler angle="radian"/><worldbody>
  <body name="shoulder"><joint name="a" axis="0 0 1" range="-3 3" limited="true"/>
    <geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.03"/>
    <body name="upper" pos="0 0 0.25"><joint name="b" axis="0 1 0" range="-2 2" limited="true"/>
      <geom type="capsule" fromto="0.05 0 0 0.25 0 0" size="0.03"/>
      <body name="fore" pos="0.3 0 0"><joint name="c" axis="0 1 0" range="-2.5 2.5" limited="true"/>
        <geom type="capsule" fromto="0.05 0 0 0.2 0 0" size="0.03"/>
        <body name="hand" pos="0.25 0 0"><joint name="d" axis="1 0 0" limited="false"/>
          <geom type="sphere" pos="0.05 0 0" size="0.03"/>
        </body></body></body></body></worldbody></mujoco>"#;

const STAND: &str = r#"
<mujoco><worldbody><body name="stand"><geom type="box" pos="0 0 0.25" size="0.1 0.1 0.25"/>
  <site name="top" pos="0 0 0.5"/></body></worldbody></mujoco>"#;

const SHORT_ROBOT: &str = r#"
name = "short"
[[parts]]
name = "stand"
model = "stand.xml"
[[parts]]
name = "arm"
model = "arm.xml"
prefix = "arm/"
attach_to = "top"
offset_xyz = [0.0, 0.0, 0.05]
[arm]
joints = ["arm/a", "arm/b", "arm/c", "arm/d"]
tcp_site = "arm/tcp"
velocity_max_rad_per_s = [1.0, 1.0, 1.0, 1.0]
acceleration_max_rad_per_s2 = [2.0, 2.0, 2.0, 2.0]
torque_max_nm = [1.0, 1.0, 1.0, 1.0]
rest = [0.0, 0.0, 0.0, 0.0]
ready = [0.3, -0.5, 1.0, 0.0]
[arm.tcp]
body = "arm/hand"
xyz = [0.1, 0.0, 0.0]
rpy = [0.0, 1.5707963267948966, 0.0]
"#;

fn short_robot() -> (tempfile::TempDir, RobotModel) {
    let dir = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("arm.xml", SHORT_ARM),
        ("stand.xml", STAND),
        ("robot.toml", SHORT_ROBOT),
    ] {
        std::fs::write(dir.path().join(name), text).unwrap();
    }
    let robot = RobotModel::load(&RobotDescription::load(dir.path()).unwrap()).unwrap();
    (dir, robot)
}

#[test]
fn a_tool_frame_given_in_the_description_is_added() {
    let (_dir, robot) = short_robot();
    let tcp = robot.chain().base_from_tcp(&[0.0; 4]);
    let expected = nalgebra::Vector3::new(0.3 + 0.25 + 0.1, 0.0, 0.5 + 0.05 + 0.25);
    assert!((tcp.translation.vector - expected).norm() < 1e-9, "{tcp}");
    // Approach along the forearm.
    let approach = tcp.rotation * nalgebra::Vector3::z();
    assert!((approach - nalgebra::Vector3::x()).norm() < 1e-9);
}

#[test]
fn a_chain_of_four_joints_has_manipulability_and_is_solved() {
    let (_dir, robot) = short_robot();
    let q = robot.q_ready();
    let jacobian = robot.chain().jacobian(&q);
    let value = crate::manipulability::manipulability(&jacobian, robot.limits(), &q);
    assert!(value > 0.0);
    let mut scene = crate::PlanningScene::new(&robot, &[], None).unwrap();
    let target = robot.chain().base_from_tcp(&q);
    let options = crate::IkOptions::default();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let outcome = crate::solve_ik(&mut scene, &target, &[], &options, &mut rng);
    let found = robot.chain().base_from_tcp(outcome.q().unwrap());
    assert!((found.inverse() * target).translation.vector.norm() <= options.position_tol_m);
}

#[test]
fn a_check_finds_what_is_so() {
    let robot = test_robots::load("movo_panda");
    let examine = || check_robot(&robot, &mut ChaCha8Rng::seed_from_u64(1)).unwrap();
    let check = examine();
    assert_eq!(check, examine(), "same seed, same answer");
    let roles: Vec<&str> = check.frames.iter().map(|frame| frame.role).collect();
    assert_eq!(roles, ["tool", "lidar", "camera"]);
    let tool = robot.chain().base_from_tcp(&robot.q_ready());
    let off = tool.inverse() * check.frames[0].base_from_frame;
    assert!(off.translation.vector.norm() < 1e-9, "{off}");
    assert_eq!(check.frames[1].body, "base_link");
    for posture in &check.postures {
        assert_eq!(posture.problem, None, "{}", posture.name);
    }
    // The Panda reaches 0.855 m to its flange, from a mount 0.09 m before the axis; the hand adds 0.21 m.
    let reach = check.reach;
    assert!((0.95..1.16).contains(&reach.distance_max_m), "{reach:?}");
    assert!(reach.ik_share > 0.9, "{reach:?}");
    let meet = |a: &str, b: &str| {
        let mut pairs = check.meeting.iter();
        pairs.any(|pair| [&pair.a, &pair.b].map(String::as_str) == [a, b])
    };
    assert!(meet("base_link", "arm/hand/hand"), "{:?}", check.meeting);
    assert!(!meet("arm/link1", "arm/link2"), "neighbours");
}

#[test]
fn a_posture_beyond_a_limit_is_told() {
    let mut description = test_robots::load("panda").description().clone();
    description.arm.ready[3] = 0.5;
    let robot = RobotModel::load(&description).unwrap();
    let check = check_robot(&robot, &mut ChaCha8Rng::seed_from_u64(1)).unwrap();
    let problem = check.postures[1].problem.as_deref().unwrap();
    assert!(
        problem.starts_with("joint `joint4` is at 0.500, outside its limits -3.07"),
        "{problem}"
    );
    assert_eq!(check.postures[0].problem, None);
}
