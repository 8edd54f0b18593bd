//! Commands and readings as JSON, for this test only.

use factotum_control::{
    BasePath, BaseTwist, Command, GripperGoal, GuardSpec, Impedance, MotionId, MotionStatus, Robot,
    RobotError, RobotState, Stamped, ToolGoal, ToolPath,
};
use factotum_descriptions::{JointTrajectory, TrajectoryPoint};
use factotum_geometry::sensing::{DepthFrame, LaserScan};
use factotum_geometry::{Pose, Pose2};
use nalgebra::{Quaternion, UnitQuaternion, Vector2, Vector3, Vector6};
use serde_json::{Value, json};

/// The far end: does what a request asks.
pub(crate) fn serve(robot: &mut dyn Robot, request: &Value) -> Value {
    let result = match request["call"].as_str().unwrap() {
        "state" => robot.state().map(|state| state_to(&state)),
        "send" => robot
            .send(command_from(&request["command"]))
            .map(|id| json!(id.0)),
        "progress" => {
            let id = MotionId(request["id"].as_u64().unwrap());
            robot.progress(id).map(|status| status_to(&status))
        }
        "scan" => robot.scan().map(|scan| stamped_to(&scan, scan_to)),
        "look" => robot.look().map(|frame| stamped_to(&frame, frame_to)),
        "wait" => robot.wait(number(&request["secs"])).map(|()| Value::Null),
        "stop" => robot.stop().map(|()| Value::Null),
        other => panic!("call `{other}`"),
    };
    match result {
        Ok(ok) => json!({ "ok": ok }),
        Err(RobotError::Refused { reason }) => json!({ "error": { "refused": reason } }),
        Err(error) => json!({ "error": { "lost": error.to_string() } }),
    }
}

pub(crate) fn error_from(error: &Value, robot: &str) -> RobotError {
    match error["refused"].as_str() {
        Some(reason) => RobotError::Refused {
            reason: reason.to_owned(),
        },
        None => RobotError::Lost {
            robot: robot.to_owned(),
            reason: text(&error["lost"]),
        },
    }
}

pub(crate) fn command_to(command: &Command) -> Value {
    match command {
        Command::Joints(trajectory) => json!({ "joints": trajectory.joints(), "points": trajectory
            .points()
            .iter()
            .map(|point| json!([point.time_secs, point.positions, point.velocities]))
            .collect::<Vec<_>>() }),
        Command::Tool(path) => json!({
            "tool": path.base_from_tcp.iter().map(|(time, pose)| json!([time, pose_to(pose)])).collect::<Vec<_>>(),
            "impedance": gains_to(&path.impedance),
            "stop_force_n": path.stop_force_n,
            "tolerance_m": path.tolerance_m,
        }),
        Command::ToolGoal(goal) => json!({
            "goal": pose_to(&goal.base_from_tcp),
            "impedance": gains_to(&goal.impedance),
            "guard": match goal.guard {
                GuardSpec::None => vec![],
                GuardSpec::Barrier { margin_rad } => vec![margin_rad],
                GuardSpec::Envelope { null_space_rad, push_back_rad } => vec![null_space_rad, push_back_rad],
            },
            "valid_secs": goal.valid_secs,
        }),
        Command::BasePath(path) => json!({
            "base_path": path.odom_from_base.iter().map(pose2_to).collect::<Vec<_>>(),
            "speed": path.speed,
        }),
        Command::BaseTwist(twist) => {
            json!({ "twist": twist.velocity.as_slice(), "valid_secs": twist.valid_secs })
        }
        Command::Gripper(goal) => json!({ "opening": goal.opening, "force_n": goal.force_n }),
    }
}

fn gains_to(impedance: &Impedance) -> Vec<f64> {
    let gains = impedance.kp_position.iter().chain(&impedance.kp_rotation);
    gains.copied().chain([impedance.damping_ratio]).collect()
}

fn gains_from(value: &Value) -> Impedance {
    let gains = numbers(value);
    Impedance {
        kp_position: Vector3::from_column_slice(&gains[..3]),
        kp_rotation: Vector3::from_column_slice(&gains[3..6]),
        damping_ratio: gains[6],
    }
}

fn command_from(value: &Value) -> Command {
    if let Some(joints) = value.get("joints") {
        let points = list(&value["points"], |point| TrajectoryPoint {
            time_secs: number(&point[0]),
            positions: numbers(&point[1]),
            velocities: numbers(&point[2]),
        });
        return Command::Joints(JointTrajectory::new(list(joints, text), points).unwrap());
    }
    if let Some(tool) = value.get("tool") {
        return Command::Tool(ToolPath {
            base_from_tcp: list(tool, |item| (number(&item[0]), pose_from(&item[1]))),
            impedance: gains_from(&value["impedance"]),
            stop_force_n: value["stop_force_n"].as_f64(),
            tolerance_m: number(&value["tolerance_m"]),
        });
    }
    if let Some(goal) = value.get("goal") {
        return Command::ToolGoal(ToolGoal {
            base_from_tcp: pose_from(goal),
            impedance: gains_from(&value["impedance"]),
            guard: match numbers(&value["guard"])[..] {
                [margin_rad] => GuardSpec::Barrier { margin_rad },
                [null_space_rad, push_back_rad] => GuardSpec::Envelope {
                    null_space_rad,
                    push_back_rad,
                },
                _ => GuardSpec::None,
            },
            valid_secs: number(&value["valid_secs"]),
        });
    }
    if let Some(path) = value.get("base_path") {
        return Command::BasePath(BasePath {
            odom_from_base: list(path, pose2_from),
            speed: number(&value["speed"]),
        });
    }
    if let Some(twist) = value.get("twist") {
        return Command::BaseTwist(BaseTwist {
            velocity: Vector3::from_row_slice(&numbers(twist)),
            valid_secs: number(&value["valid_secs"]),
        });
    }
    Command::Gripper(GripperGoal {
        opening: number(&value["opening"]),
        force_n: number(&value["force_n"]),
    })
}

fn state_to(state: &RobotState) -> Value {
    json!({
        "time": state.time_secs,
        "odom": pose2_to(&state.odom_from_base),
        "base_velocity": state.base_velocity.as_slice(),
        "lift": state.lift_m,
        "positions": state.arm_positions,
        "velocities": state.arm_velocities,
        "opening": state.gripper_opening,
        "fingers": [state.finger_positions, state.finger_velocities],
        "pads": state.pad_forces_in_tcp.iter().map(|force| force.as_slice()).collect::<Vec<_>>(),
        "wrench": state.tool_wrench_in_base.as_slice(),
    })
}

pub(crate) fn state_from(value: &Value) -> RobotState {
    RobotState {
        time_secs: number(&value["time"]),
        odom_from_base: pose2_from(&value["odom"]),
        base_velocity: Vector3::from_row_slice(&numbers(&value["base_velocity"])),
        lift_m: number(&value["lift"]),
        arm_positions: numbers(&value["positions"]),
        arm_velocities: numbers(&value["velocities"]),
        gripper_opening: number(&value["opening"]),
        finger_positions: numbers(&value["fingers"][0]),
        finger_velocities: numbers(&value["fingers"][1]),
        pad_forces_in_tcp: list(&value["pads"], |force| {
            Vector3::from_row_slice(&numbers(force))
        }),
        tool_wrench_in_base: Vector6::from_row_slice(&numbers(&value["wrench"])),
    }
}

fn status_to(status: &MotionStatus) -> Value {
    match status {
        MotionStatus::Active => json!("active"),
        MotionStatus::Done => json!("done"),
        MotionStatus::Guarded => json!("guarded"),
        MotionStatus::Preempted => json!("preempted"),
        MotionStatus::Aborted(reason) => json!({ "aborted": reason }),
    }
}

pub(crate) fn status_from(value: &Value) -> MotionStatus {
    match value.as_str() {
        Some("active") => MotionStatus::Active,
        Some("done") => MotionStatus::Done,
        Some("guarded") => MotionStatus::Guarded,
        Some("preempted") => MotionStatus::Preempted,
        _ => MotionStatus::Aborted(text(&value["aborted"])),
    }
}

fn stamped_to<T>(stamped: &Stamped<T>, data: fn(&T) -> Value) -> Value {
    json!({
        "time": stamped.time_secs,
        "odom": pose2_to(&stamped.odom_from_base),
        "data": data(&stamped.data),
    })
}

pub(crate) fn stamped_from<T>(value: &Value, data: fn(&Value) -> T) -> Stamped<T> {
    Stamped {
        time_secs: number(&value["time"]),
        odom_from_base: pose2_from(&value["odom"]),
        data: data(&value["data"]),
    }
}

fn scan_to(scan: &LaserScan) -> Value {
    // JSON has no infinity: a ray without a return is null.
    json!({
        "angles": [scan.angle_min_rad, scan.angle_step_rad],
        "ranges": scan.ranges_m,
        "limits": [scan.range_min_m, scan.range_max_m],
        "lidar": pose2_to(&scan.base_from_lidar),
    })
}

pub(crate) fn scan_from(value: &Value) -> LaserScan {
    LaserScan {
        angle_min_rad: number(&value["angles"][0]),
        angle_step_rad: number(&value["angles"][1]),
        ranges_m: list(&value["ranges"], |range| {
            range.as_f64().unwrap_or(f64::INFINITY)
        }),
        range_min_m: number(&value["limits"][0]),
        range_max_m: number(&value["limits"][1]),
        base_from_lidar: pose2_from(&value["lidar"]),
    }
}

fn frame_to(frame: &DepthFrame) -> Value {
    json!({
        "size": [frame.width, frame.height],
        "camera": [frame.fx, frame.fy, frame.cx, frame.cy],
        "depth": frame.depth_m,
        "labels": frame.labels,
        "classes": frame.label_classes,
        "optical": pose_to(&frame.base_from_optical),
    })
}

pub(crate) fn frame_from(value: &Value) -> DepthFrame {
    let camera = numbers(&value["camera"]);
    DepthFrame {
        width: value["size"][0].as_u64().unwrap() as usize,
        height: value["size"][1].as_u64().unwrap() as usize,
        fx: camera[0],
        fy: camera[1],
        cx: camera[2],
        cy: camera[3],
        depth_m: list(&value["depth"], |depth| number(depth) as f32),
        labels: list(&value["labels"], |label| label.as_u64().unwrap() as u16),
        label_classes: list(&value["classes"], text),
        base_from_optical: pose_from(&value["optical"]),
    }
}

fn pose2_to(pose: &Pose2) -> Value {
    json!([
        pose.translation.x,
        pose.translation.y,
        pose.rotation.angle()
    ])
}

fn pose2_from(value: &Value) -> Pose2 {
    let [x, y, yaw] = numbers(value)[..] else {
        panic!("pose {value}")
    };
    Pose2::new(Vector2::new(x, y), yaw)
}

fn pose_to(pose: &Pose) -> Value {
    let (p, q) = (pose.translation.vector, pose.rotation);
    json!([p.x, p.y, p.z, q.i, q.j, q.k, q.w])
}

fn pose_from(value: &Value) -> Pose {
    let [x, y, z, i, j, k, w] = numbers(value)[..] else {
        panic!("pose {value}")
    };
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    Pose::from_parts(Vector3::new(x, y, z).into(), rotation)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn text(value: &Value) -> String {
    value.as_str().unwrap().to_owned()
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value, number)
}

fn list<T>(value: &Value, item: impl Fn(&Value) -> T) -> Vec<T> {
    value.as_array().unwrap().iter().map(item).collect()
}
