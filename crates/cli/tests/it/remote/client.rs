//! The near end: a [`Robot`] whose every call crosses a socket.

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::TcpStream;
use std::process::Child;

use factotum_control::{Command, MotionId, MotionStatus, Robot, RobotError, RobotState, Stamped};
use factotum_descriptions::RobotDescription;
use factotum_geometry::sensing::{DepthFrame, LaserScan};
use serde_json::{Value, json};

use super::wire;

pub(crate) struct RemoteRobot {
    description: RobotDescription,
    requests: TcpStream,
    answers: BufReader<TcpStream>,
    server: Child,
}

impl RemoteRobot {
    pub(crate) fn new(description: RobotDescription, stream: TcpStream, server: Child) -> Self {
        Self {
            description,
            requests: stream.try_clone().unwrap(),
            answers: BufReader::new(stream),
            server,
        }
    }

    /// What physics says of a chore: for the test, not for the robot.
    pub(crate) fn judge(&mut self, chore: &str) -> Value {
        self.call(&json!({ "call": "judge", "chore": chore }))
            .unwrap()
    }

    pub(crate) fn kill(&mut self) {
        self.server.kill().unwrap();
        self.server.wait().unwrap();
    }

    fn lost(&self, reason: &str) -> RobotError {
        RobotError::Lost {
            robot: self.description.name.clone(),
            reason: reason.to_owned(),
        }
    }

    fn call(&mut self, request: &Value) -> Result<Value, RobotError> {
        writeln!(self.requests, "{request}").map_err(|error| self.lost(&error.to_string()))?;
        let mut line = String::new();
        match self.answers.read_line(&mut line) {
            Ok(n) if n > 0 => {}
            Ok(_) => return Err(self.lost("the connection was closed")),
            Err(error) => return Err(self.lost(&error.to_string())),
        }
        let answer: Value =
            serde_json::from_str(&line).map_err(|error| self.lost(&error.to_string()))?;
        match answer.get("error") {
            Some(error) => Err(wire::error_from(error, &self.description.name)),
            None => Ok(answer["ok"].clone()),
        }
    }
}

impl Drop for RemoteRobot {
    fn drop(&mut self) {
        // Either may fail when the process is already gone.
        self.server.kill().ok();
        self.server.wait().ok();
    }
}

impl Robot for RemoteRobot {
    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn state(&mut self) -> Result<RobotState, RobotError> {
        Ok(wire::state_from(&self.call(&json!({ "call": "state" }))?))
    }

    fn send(&mut self, command: Command) -> Result<MotionId, RobotError> {
        let command = wire::command_to(&command);
        let id = self.call(&json!({ "call": "send", "command": command }))?;
        Ok(MotionId(id.as_u64().unwrap()))
    }

    fn progress(&mut self, id: MotionId) -> Result<MotionStatus, RobotError> {
        let status = self.call(&json!({ "call": "progress", "id": id.0 }))?;
        Ok(wire::status_from(&status))
    }

    fn scan(&mut self) -> Result<Stamped<LaserScan>, RobotError> {
        Ok(wire::stamped_from(
            &self.call(&json!({ "call": "scan" }))?,
            wire::scan_from,
        ))
    }

    fn look(&mut self) -> Result<Stamped<DepthFrame>, RobotError> {
        Ok(wire::stamped_from(
            &self.call(&json!({ "call": "look" }))?,
            wire::frame_from,
        ))
    }

    fn wait(&mut self, secs: f64) -> Result<(), RobotError> {
        self.call(&json!({ "call": "wait", "secs": secs }))
            .map(drop)
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.call(&json!({ "call": "stop" })).map(drop)
    }
}
