//! The `Robot` trait away from the simulator: a chore by a robot that lives in another process, 50 ms away.
//!
//! The test starts its own program once more; there, [`serve_when_asked`] finds its orders in the environment and runs
//! the simulated robot behind a socket. On the way there and on the way back the robot's time goes on by half the
//! latency, so every reading is old when it arrives and every command late when it is heard, as with a real machine;
//! but nobody waits, and the test is the same each time.

mod client;
mod wire;

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{TcpListener, TcpStream};

use factotum_control::{
    Command, GripperGoal, MotionId, MotionStatus, Robot as _, RobotError, send_and_wait,
};
use factotum_descriptions::RobotDescription;
use serde_json::{Value, json};

use crate::known_home::{do_chore, household, near_the_switch, true_map};
use client::RemoteRobot;

/// There and back, seconds of robot time.
const LATENCY_SECS: f64 = 0.05;

/// Where the server finds the port to call and the seed.
const ORDERS: &str = "FACTOTUM_TEST_REMOTE";

/// Starts the other process and waits for its call.
fn remote_robot(description: RobotDescription, seed: u64) -> RemoteRobot {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let server = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["remote::serve_when_asked", "--exact", "--nocapture"])
        .env(ORDERS, format!("{port} {seed}"))
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let (stream, _) = listener.accept().unwrap();
    RemoteRobot::new(description, stream, server)
}

/// Not a test of its own: what the other process runs.
#[test]
fn serve_when_asked() {
    let Ok(orders) = std::env::var(ORDERS) else {
        return;
    };
    let Some((port, seed)) = orders.split_once(' ') else {
        panic!("orders `{orders}`")
    };
    let mut robot = household(seed.parse().unwrap(), near_the_switch());
    let stream = TcpStream::connect(("127.0.0.1", port.parse::<u16>().unwrap())).unwrap();
    let mut answers = stream.try_clone().unwrap();
    for line in BufReader::new(stream).lines() {
        let Ok(line) = line else { return };
        let request: Value = serde_json::from_str(&line).unwrap();
        if request["call"] == "judge" {
            let chore = request["chore"].as_str().unwrap();
            let verdict = robot.judge().achieved(chore).unwrap();
            let ok = json!({ "achieved": verdict.achieved, "measured": verdict.measured });
            writeln!(answers, "{}", json!({ "ok": ok })).unwrap();
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

/// The whole executive, through the trait alone: it drives up, looks, turns the light off, looks again; physics in the
/// other process says that the light is off.
#[test]
fn a_robot_in_another_process_turns_the_light_off() {
    let seed = 1;
    let twin = household(seed, near_the_switch());
    let mut robot = remote_robot(twin.description().clone(), seed);
    let first = robot.state().unwrap();
    let second = robot.state().unwrap();
    assert!(
        (second.time_secs - first.time_secs - LATENCY_SECS).abs() < 1e-6,
        "time goes on"
    );
    assert_eq!(robot.judge("turn-light-off")["achieved"], false);
    let report = do_chore(
        &mut robot,
        true_map(&twin),
        near_the_switch(),
        "light_switch",
        "turn_off",
    );
    assert!(report.is_believed_done, "{report:?}");
    let verdict = robot.judge("turn-light-off");
    assert_eq!(verdict["achieved"], true, "{verdict}");
}

#[test]
fn refusals_and_silence_come_through() {
    let description = household(1, near_the_switch()).description().clone();
    let mut robot = remote_robot(description, 1);
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
    let status = send_and_wait(&mut robot, Command::Gripper(soft), 5.0, &mut |_| Ok(true));
    assert_eq!(status, Ok(MotionStatus::Done));
    let id = robot.send(Command::Gripper(soft)).unwrap();
    robot.stop().unwrap();
    assert_eq!(robot.progress(id).unwrap(), MotionStatus::Preempted);
    // The other process dies: the robot does not answer, and says so.
    robot.kill();
    let error = robot.state().unwrap_err();
    assert!(matches!(error, RobotError::Lost { .. }), "{error}");
}
