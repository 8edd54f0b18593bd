//! The `Robot` trait away from the simulator: a robot that lives in another process, 50 ms away.
//!
//! The test starts its own program once more; there, [`serve_when_asked`] finds its orders in the environment and runs
//! the simulated robot behind a socket. On the way there and on the way back the robot's time goes on by half the
//! latency, so every reading is old when it arrives and every command late when it is heard, as with a real machine;
//! but nobody waits, and the test is the same each time.

mod client;
mod wire;

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{TcpListener, TcpStream};

use factotum_control::{Command, GripperGoal, MotionId, MotionStatus, Robot as _, RobotError};
use serde_json::{Value, json};

use crate::fixture::{config, must, starting_at};
use crate::picking::{CLEARANCE_M, grasp_and_raise, near_bottle, reach_for_the_bottle};
use client::RemoteRobot;

/// There and back, seconds of robot time.
const LATENCY_SECS: f64 = 0.05;

/// Where the server finds the port to call, the seed and where to start.
const ORDERS: &str = "FACTOTUM_TEST_REMOTE";

/// Starts the other process and waits for its call.
fn remote_robot(seed: u64, x: f64, y: f64) -> RemoteRobot {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let server = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["remote::serve_when_asked", "--exact", "--nocapture"])
        .env(ORDERS, format!("{port} {seed} {x} {y}"))
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let (stream, _) = listener.accept().unwrap();
    RemoteRobot::new(config(seed).robot, stream, server)
}

/// Not a test of its own: what the other process runs.
#[test]
fn serve_when_asked() {
    let Ok(orders) = std::env::var(ORDERS) else {
        return;
    };
    let words: Vec<&str> = orders.split(' ').collect();
    let [port, seed, x, y] = words[..] else {
        panic!("orders `{orders}`")
    };
    let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
    let config = config(seed.parse().unwrap());
    let mut robot = starting_at(config, x, y, std::f64::consts::FRAC_PI_2);
    let stream = TcpStream::connect(("127.0.0.1", port.parse::<u16>().unwrap())).unwrap();
    let mut answers = stream.try_clone().unwrap();
    for line in BufReader::new(stream).lines() {
        let Ok(line) = line else { return };
        let request: Value = serde_json::from_str(&line).unwrap();
        if request["call"] == "bottle_height" {
            let height = robot.world_from_object("bottle_1").unwrap().translation.z;
            writeln!(answers, "{}", json!({ "ok": height })).unwrap();
            continue;
        }
        robot.wait(LATENCY_SECS / 2.0).unwrap();
        let answer = wire::serve(&mut robot, &request);
        robot.wait(LATENCY_SECS / 2.0).unwrap();
        if writeln!(answers, "{answer}").is_err() {
            return;
        }
    }
}

#[test]
fn a_robot_in_another_process_fetches_the_bottle() {
    let (seed, x, y) = near_bottle();
    let mut robot = remote_robot(seed, x, y - CLEARANCE_M);
    let before = robot.bottle_height();

    let first = robot.state().unwrap();
    let second = robot.state().unwrap();
    assert!(
        (second.time_secs - first.time_secs - LATENCY_SECS).abs() < 1e-6,
        "time goes on"
    );

    let scan = robot.scan().unwrap();
    assert!(scan.data.hits_in_base().len() > 300);
    let frame = robot.look().unwrap();
    frame.data.check().unwrap();
    assert!(
        frame
            .data
            .label_classes
            .iter()
            .any(|class| class == "bottle")
    );

    reach_for_the_bottle(&mut robot);
    grasp_and_raise(&mut robot);
    let raised = robot.bottle_height() - before;
    assert!((raised - 0.2).abs() < 0.02, "raised by {raised} m");
}

#[test]
fn refusals_and_silence_come_through() {
    let mut robot = remote_robot(1, 3.3, 1.2);
    let hard = GripperGoal {
        opening: 0.0,
        force_n: 400.0,
    };
    assert_eq!(
        robot.send(Command::Gripper(hard)).unwrap_err(),
        RobotError::Refused {
            reason: "gripper force 400 N is more than its limit 40 N".to_owned()
        }
    );
    assert!(matches!(
        robot.progress(MotionId(7)),
        Err(RobotError::Refused { .. })
    ));
    let soft = GripperGoal {
        opening: 0.5,
        force_n: 20.0,
    };
    must(&mut robot, Command::Gripper(soft));
    let id = robot.send(Command::Gripper(soft)).unwrap();
    robot.stop().unwrap();
    assert_eq!(robot.progress(id).unwrap(), MotionStatus::Preempted);
    // The other process dies: the robot does not answer, and says so.
    robot.kill();
    let error = robot.state().unwrap_err();
    assert!(matches!(error, RobotError::Lost { .. }), "{error}");
}
