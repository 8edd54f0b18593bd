//! How deep a hand may reach over an object: fingers are of different lengths, and a class's grasps are for all hands.
//!
//! A short hand would push the object away with its palm where a long one takes it. It stays back along the approach
//! direction until nothing of the open hand touches the object; where a finger's width does not suffice for that, the
//! grasp is not for this hand.

use factotum_descriptions::Grasp;
use nalgebra::Translation3;

use crate::Pose;
use crate::error::MotionError;
use crate::robot::RobotModel;
use crate::scene::{Obstacle, ObstacleShape, PlanningScene};

/// Ways back that are tried, metres. The pads of common fingers reach about 0.01 m beyond the tool frame.
const BACK_M: [f64; 3] = [0.0, 0.004, 0.008];

/// Room that is left between open hand and object, metres.
const CLEARANCE_M: f64 = 0.0015;

/// A grasp of an object, drawn back as far as this robot's hand needs; `None` if the hand does not fit around it.
///
/// # Errors
/// [`MotionError`] if the object's model does not load.
pub fn fit_grasp(
    robot: &RobotModel,
    object: &ObstacleShape,
    grasp: &Grasp,
) -> Result<Option<Grasp>, MotionError> {
    for back_m in BACK_M {
        let back = Translation3::new(0.0, 0.0, -back_m);
        let object_from_tcp = grasp.object_from_tcp() * back;
        if open_hand_clears(robot, object, &object_from_tcp)? {
            let mut fitted = grasp.clone();
            fitted.xyz = object_from_tcp.translation.vector.into();
            return Ok(Some(fitted));
        }
    }
    Ok(None)
}

/// Whether nothing of the open hand touches the object when the tool is at this pose; the arm does not matter.
fn open_hand_clears(
    robot: &RobotModel,
    object: &ObstacleShape,
    object_from_tcp: &Pose,
) -> Result<bool, MotionError> {
    const OBJECT: &str = "object to grasp";
    let q = robot.q_ready();
    let object = Obstacle {
        name: OBJECT.to_owned(),
        shape: object.clone(),
        base_from_obstacle: robot.chain().base_from_tcp(&q) * object_from_tcp.inverse(),
    };
    let mut scene = PlanningScene::new(robot, &[object], None)?;
    scene.set_gripper(1.0);
    Ok(scene.tool_clearance_m(&q, OBJECT) >= CLEARANCE_M)
}
