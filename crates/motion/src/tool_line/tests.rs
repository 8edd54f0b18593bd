use super::*;
use crate::robot::RobotModel;
use crate::scene::{Obstacle, ObstacleShape};
use crate::test_robots;
use nalgebra::{UnitQuaternion, Vector3};

fn ready(robot: &RobotModel) -> Vec<f64> {
    robot.q_from_state(0.2, &robot.description().arm.ready)
}

#[test]
fn the_tool_stays_on_the_line() {
    let robot = test_robots::load("movo");
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let q = ready(&robot);
    let start = robot.chain().base_from_tcp(&q);
    let back = start * Translation3::new(0.0, 0.0, -0.10);
    let up = Translation3::new(0.0, 0.0, 0.10) * back;
    let turned = up * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4);
    let options = ToolLineOptions::default();
    let path = plan_tool_line(&mut scene, &q, &[back, up, turned], &options).unwrap();
    assert_eq!(path[0], q);
    let end = robot.chain().base_from_tcp(&path[path.len() - 1]);
    assert!((end.inverse() * turned).translation.vector.norm() < 1e-3);
    assert!(end.rotation.angle_to(&turned.rotation) < 2e-3);
    // Between the waypoints of the joint path too.
    let n_back = (0.10 / options.step_m).ceil() as usize;
    for (i, pair) in path.windows(2).enumerate() {
        let jump = pair[0]
            .iter()
            .zip(&pair[1])
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(jump <= options.joint_step_max);
        for t in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let q = robot.space().interpolate(&pair[0], &pair[1], t);
            assert!(robot.space().is_within_limits(&q) && scene.is_free(&q));
            let in_start = start.inverse() * robot.chain().base_from_tcp(&q);
            if i < n_back {
                let p = in_start.translation.vector;
                assert!(
                    p.x.hypot(p.y) < 5e-4 && (-0.101..0.001).contains(&p.z),
                    "{p}"
                );
                assert!(in_start.rotation.angle() < 3e-3);
            }
        }
    }
}

#[test]
fn what_ends_a_line_is_named() {
    let robot = test_robots::load("movo");
    let q = ready(&robot);
    let start = robot.chain().base_from_tcp(&q);
    let options = ToolLineOptions::default();
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let far = start * Translation3::new(0.0, 0.0, 1.5);
    let failure = plan_tool_line(&mut scene, &q, &[far], &options).unwrap_err();
    assert!(
        failure.fraction_done > 0.05 && failure.fraction_done < 0.9,
        "{failure:?}"
    );
    assert!(!matches!(
        failure.reason,
        CartesianFailureReason::Collision(_)
    ));
    assert_eq!(
        failure.path.len() - 1,
        (failure.fraction_done * 300.0).round() as usize
    );

    let wall = Obstacle {
        name: "wall".to_owned(),
        shape: ObstacleShape::Box {
            half_extents_m: [0.3, 0.3, 0.01],
        },
        base_from_obstacle: start * Translation3::new(0.0, 0.0, 0.2),
    };
    let mut scene = PlanningScene::new(&robot, &[wall], None).unwrap();
    let ahead = start * Translation3::new(0.0, 0.0, 0.3);
    let failure = plan_tool_line(&mut scene, &q, &[ahead], &options).unwrap_err();
    let CartesianFailureReason::Collision((a, b)) = &failure.reason else {
        panic!("{failure:?}");
    };
    assert!(a == "wall" || b == "wall");

    let failure = plan_tool_line(&mut scene, &[0.0], &[ahead], &options).unwrap_err();
    assert_eq!(failure.reason, CartesianFailureReason::BadStart);
}
