//! What makes no sense for this robot is refused, and changes nothing.

use factotum_control::{
    BasePath, BaseTwist, Command, GripperGoal, GuardSpec, Impedance, MotionId, Robot as _,
    ToolGoal, ToolPath,
};
use factotum_descriptions::{JointTrajectory, TrajectoryPoint};
use factotum_geometry::Pose;
use factotum_worlds::SimRobot;
use nalgebra::Vector3;

use crate::fixture::{base_from_tcp, household};

fn refusal(robot: &mut SimRobot, command: Command) -> String {
    robot.send(command).unwrap_err().to_string()
}

fn single(joint: &str, points: &[(f64, f64, f64)]) -> Command {
    let points = points
        .iter()
        .map(|&(time_secs, position, velocity)| TrajectoryPoint {
            time_secs,
            positions: vec![position],
            velocities: vec![velocity],
        })
        .collect();
    Command::Joints(JointTrajectory::new(vec![joint.to_owned()], points).unwrap())
}

#[test]
fn bad_commands_are_refused_with_the_reason() {
    let mut robot = household(1);
    assert_eq!(
        refusal(&mut robot, single("arm/j8", &[(0.0, 0.0, 0.0)])),
        "command refused: trajectory joint `arm/j8` is neither a joint of the arm nor the lift; did you mean `arm/j7`?"
    );
    assert_eq!(
        refusal(&mut robot, single("arm/j1", &[(0.0, 1.0, 0.0)])),
        "command refused: the trajectory starts with joint `arm/j1` at 1.000, but it is at -0.900"
    );
    assert_eq!(
        refusal(
            &mut robot,
            single("arm/j2", &[(0.0, 3.6, 0.0), (9.0, 6.0, 0.0)])
        ),
        "command refused: joint `arm/j2` at 6.000 is outside its limits [0.820, 5.463]"
    );
    assert_eq!(
        refusal(
            &mut robot,
            single("arm/j1", &[(0.0, -0.9, 2.0), (1.0, 0.0, 0.0)])
        ),
        "command refused: joint `arm/j1` at speed 2.000 is faster than its limit 0.628"
    );
    assert_eq!(
        refusal(
            &mut robot,
            Command::BasePath(BasePath {
                odom_from_base: vec![],
                speed: 1.0
            })
        ),
        "command refused: base path is empty, expected at least one pose"
    );
    assert_eq!(
        refusal(
            &mut robot,
            Command::Gripper(GripperGoal {
                opening: 0.0,
                force_n: 400.0
            })
        ),
        "command refused: gripper force 400 N is more than its limit 40 N"
    );
    let nan = BaseTwist {
        velocity: Vector3::new(f64::NAN, 0.0, 0.0),
        valid_secs: 1.0,
    };
    assert!(refusal(&mut robot, Command::BaseTwist(nan)).contains("expected finite numbers"));
    let far = ToolPath {
        base_from_tcp: vec![(0.0, Pose::translation(2.0, 0.0, 1.0))],
        impedance: Impedance::default(),
        stop_force_n: None,
        tolerance_m: 0.01,
    };
    assert!(refusal(&mut robot, Command::Tool(far)).contains("m from the tool"));
    let here = base_from_tcp(&mut robot);
    let goal = ToolGoal {
        base_from_tcp: here,
        impedance: Impedance::default(),
        guard: GuardSpec::None,
        valid_secs: 0.1,
    };
    let elsewhere = Pose::translation(f64::NAN, 0.0, 1.0);
    let crossed = GuardSpec::Envelope {
        null_space_rad: 0.1,
        push_back_rad: 0.2,
    };
    for (goal, reason) in [
        (
            ToolGoal {
                base_from_tcp: Pose::translation(0.2, 0.0, 0.0) * here,
                ..goal
            },
            "the tool goal is 0.200 m from the tool, expected at most 0.1 m",
        ),
        (
            ToolGoal {
                base_from_tcp: elsewhere,
                ..goal
            },
            "the tool goal is NaN m from the tool",
        ),
        (
            ToolGoal {
                valid_secs: 0.0,
                ..goal
            },
            "a tool goal for 0 s; expected a positive time",
        ),
        (
            ToolGoal {
                guard: crossed,
                ..goal
            },
            "safety thresholds",
        ),
    ] {
        let refused = refusal(&mut robot, Command::ToolGoal(goal));
        assert!(refused.contains(reason), "{refused}");
    }
    assert!(robot.wait(f64::INFINITY).is_err());
    // Nothing was started: the first motion gets the first name.
    assert!(robot.progress(MotionId(1)).is_err());
    let here = single("arm/j1", &[(0.0, -0.9, 0.0)]);
    assert_eq!(robot.send(here).unwrap(), MotionId(1));
}

#[test]
fn subsystems_that_are_not_there_are_named() {
    let mut config = crate::fixture::config(1);
    config.robot.gripper = None;
    let mut robot = SimRobot::new(config).unwrap();
    let goal = Command::Gripper(GripperGoal {
        opening: 0.0,
        force_n: 1.0,
    });
    assert_eq!(refusal(&mut robot, goal), "robot `movo` has no gripper");
}
