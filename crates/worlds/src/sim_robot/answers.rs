//! The simulated robot as a [`Robot`]: what it answers, and how time passes.

use factotum_control::{Command, MotionId, MotionStatus, Robot, RobotError, RobotState, Stamped};
use factotum_descriptions::RobotDescription;
use factotum_geometry::sensing::{DepthFrame, LaserScan};

use super::SimRobot;
use crate::assembly::STEP_SECS;
use crate::sensing;

impl Robot for SimRobot {
    fn description(&self) -> &RobotDescription {
        &self.config.robot
    }

    fn state(&mut self) -> Result<RobotState, RobotError> {
        self.alive()?;
        self.read_state()
    }

    fn send(&mut self, command: Command) -> Result<MotionId, RobotError> {
        self.alive()?;
        self.accept(command)
    }

    fn progress(&mut self, id: MotionId) -> Result<MotionStatus, RobotError> {
        let status = self.live.statuses.get(&id).cloned();
        status.ok_or_else(|| RobotError::Refused {
            reason: if id.0 < self.live.next_id {
                format!("motion {} ended long ago", id.0)
            } else {
                format!(
                    "motion {} was never given; the last is {}",
                    id.0,
                    self.live.next_id - 1
                )
            },
        })
    }

    fn scan(&mut self) -> Result<Stamped<LaserScan>, RobotError> {
        self.alive()?;
        let (Some(lidar), Some(site)) =
            (&self.config.robot.sensors.lidar, self.assembly.robot.lidar)
        else {
            return Err(self.absent("lidar"));
        };
        let now_secs = self.state.time_secs();
        let fresh_secs = lidar.rate_hz.max(1e-3).recip() - STEP_SECS / 2.0;
        if let Some(last) = &self.live.last_scan
            && now_secs - last.time_secs < fresh_secs
        {
            return Ok(last.clone());
        }
        let noise = &self.config.noise;
        let rng = &mut self.live.lidar_rng;
        let scan = sensing::scan(&self.assembly, &self.state, lidar, site, noise, rng)
            .map_err(|error| self.lost(&error))?;
        let scan = self.stamped(scan);
        self.live.last_scan = Some(scan.clone());
        Ok(scan)
    }

    fn look(&mut self) -> Result<Stamped<DepthFrame>, RobotError> {
        self.alive()?;
        let (Some(camera), Some(site)) = (
            &self.config.robot.sensors.camera,
            self.assembly.robot.camera,
        ) else {
            return Err(self.absent("camera"));
        };
        let noise = &self.config.noise;
        let rng = &mut self.live.camera_rng;
        let frame = sensing::look(&self.assembly, &self.state, camera, site, noise, rng)
            .map_err(|error| self.lost(&error))?;
        Ok(self.stamped(frame))
    }

    fn wait(&mut self, secs: f64) -> Result<(), RobotError> {
        self.alive()?;
        if !(secs.is_finite() && secs >= 0.0) {
            return Err(RobotError::Refused {
                reason: format!("cannot wait {secs} s; expected a finite time, zero or more"),
            });
        }
        self.live.remainder_secs += secs;
        // Half a step of slack, so that 0.1 s is 50 steps whatever the rounding.
        while self.live.remainder_secs >= STEP_SECS / 2.0 {
            self.live.remainder_secs -= STEP_SECS;
            self.step().map_err(|error| self.lost(&error))?;
            self.observe()?;
        }
        self.state
            .forward_kinematics()
            .map_err(|error| self.lost(&error))
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.alive()?;
        self.stop_all();
        Ok(())
    }
}
