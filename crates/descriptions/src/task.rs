//! A task to learn a contact skill on: which robot, which object, which joint of it, and how far to move it.
//!
//! The task file is all that a new skill needs beside two models; `docs/skills.md` walks through one. What is said of
//! the object's joint and geoms is checked where its model is loaded.

use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

use crate::{DescriptionError, Placement, read_toml};

/// A contact task: one joint of one object, moved by one robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskSpec {
    /// The task file.
    #[serde(skip)]
    pub file: PathBuf,
    /// Name, used in commands.
    pub name: String,
    /// One sentence for people.
    #[serde(default)]
    pub description: String,
    /// Where its figures come from.
    #[serde(default)]
    pub source: String,
    /// Folder of `robot.toml`, relative to the task file until loaded.
    pub robot: PathBuf,
    /// Model of the object (MJCF or URDF) with one root body at Λ, relative to the task file until loaded.
    pub model: PathBuf,
    /// Model (MJCF or URDF) of what stands fixed about the object and moves with Λ, such as the wall beside a door; relative
    /// to the task file until loaded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surroundings: Option<PathBuf>,
    /// Joint of the model that is to be moved.
    pub joint: String,
    /// Where the joint is at the start, rad or m.
    #[serde(default)]
    pub start: f64,
    /// The task is done (β_c) once the joint is beyond this, seen from the start, rad or m.
    pub goal: f64,
    /// Geoms that may be grasped; all that the joint moves if absent.
    #[serde(default)]
    pub grasp_region: Vec<String>,
    /// Share of the object's turn that the hand takes part in: 1 if it is held fast, less if a round handle may turn between
    /// the fingers.
    #[serde(default = "held_fast")]
    pub hand_turns: f64,
    /// Where the object stands.
    pub placement: PlacementRange,
    /// How an episode runs.
    #[serde(default)]
    pub episode: EpisodeSpec,
    /// What makes it a motor skill, bootstrapped by a plan and found by policy search (thesis Chapter 4), instead of a
    /// contact skill.
    #[serde(default)]
    pub motor: Option<MotorSpec>,
}

/// A motor skill: from where the arm begins, by joint velocities, for a fixed time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorSpec {
    /// Where the tool touches the object: its pose in Λ with the object's joint at zero.
    pub contact: Placement,
    /// Where the arm begins, lift and arm, rad or m; the robot's ready posture if absent.
    #[serde(default)]
    pub q_start: Vec<f64>,
    /// Opening of the gripper all the while, 0 closed to 1 open.
    #[serde(default)]
    pub opening: f64,
    /// How long a rollout takes, seconds.
    pub duration_secs: f64,
    /// Fraction of the arm's joint speed limits that the plan is timed with, in (0, 1].
    #[serde(default = "default_plan_speed")]
    pub plan_speed: f64,
    /// Share of the way from start to goal beyond which a rollout has succeeded.
    #[serde(default = "default_done")]
    pub done: f64,
    /// Form of its policy, if nobody asks for another.
    #[serde(default)]
    pub policy: MotorPolicy,
}

/// Form of the policy of a motor skill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotorPolicy {
    /// A movement primitive for each joint of the arm.
    #[default]
    Dmp,
    /// A Gaussian whose mean is a network of where arm and object are.
    Mlp,
}

impl MotorPolicy {
    /// Name in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dmp => "dmp",
            Self::Mlp => "mlp",
        }
    }
}

fn default_plan_speed() -> f64 {
    1.0
}

fn default_done() -> f64 {
    0.95
}

fn held_fast() -> f64 {
    1.0
}

/// Where the object stands before the robot: Λ in the base frame, each value drawn uniformly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacementRange {
    /// Forward of the robot, metres.
    pub x_m: [f64; 2],
    /// To the robot's left, metres.
    pub y_m: [f64; 2],
    /// Above the robot's base, metres.
    pub z_m: [f64; 2],
    /// Turn about z, radians.
    pub yaw_rad: [f64; 2],
}

impl PlacementRange {
    /// The pose at the given shares (0 to 1) of the four ranges x, y, z, yaw.
    pub fn at(&self, shares: [f64; 4]) -> Isometry3<f64> {
        let value = |[low, high]: [f64; 2], share: f64| low + (high - low) * share;
        let [x, y, z, yaw] = shares;
        Isometry3::from_parts(
            Translation3::new(value(self.x_m, x), value(self.y_m, y), value(self.z_m, z)),
            UnitQuaternion::from_euler_angles(0.0, 0.0, value(self.yaw_rad, yaw)),
        )
    }
}

/// How an episode runs. The defaults are those of the dissertation's experiments, but for the grip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EpisodeSpec {
    /// Actions a second.
    pub control_hz: f64,
    /// Actions after which an episode is cut off.
    pub steps_max: u32,
    /// Actions without contact after which it has failed.
    pub contact_lost_steps: u32,
    /// Force with which the gripper holds, N. 30 N on our pads (friction 1.3) hold as the experiments' 20 N on theirs (2).
    pub grip_force_n: f64,
}

impl Default for EpisodeSpec {
    fn default() -> Self {
        Self {
            control_hz: 20.0,
            steps_max: 250,
            contact_lost_steps: 50,
            grip_force_n: 30.0,
        }
    }
}

impl TaskSpec {
    /// Reads a task file.
    ///
    /// # Errors
    /// [`DescriptionError`] if the file cannot be read, has an unknown key, or a value that makes no sense.
    pub fn load(file: &Path) -> Result<Self, DescriptionError> {
        let mut task: Self = read_toml(file)?;
        task.check(file)?;
        let dir = file.parent().unwrap_or(Path::new(""));
        task.robot = dir.join(&task.robot);
        task.model = dir.join(&task.model);
        task.surroundings = task.surroundings.map(|model| dir.join(model));
        task.file = file.to_owned();
        Ok(task)
    }

    /// How far the joint has come from start (0) to goal (1), not cut off.
    pub fn progress(&self, joint_position: f64) -> f64 {
        (joint_position - self.start) / (self.goal - self.start)
    }

    fn check(&self, file: &Path) -> Result<(), DescriptionError> {
        let bad = |field: &str, found: String, wanted: &str| {
            Err(DescriptionError::Value {
                path: file.to_owned(),
                field: field.to_owned(),
                found,
                wanted: wanted.to_owned(),
            })
        };
        let is_name = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
        if self.name.trim_matches('.').is_empty() || !self.name.chars().all(is_name) {
            return bad(
                "name",
                format!("`{}`", self.name),
                "letters, digits, `-`, `_`, `.` or spaces",
            );
        }
        for (field, value) in [("start", self.start), ("goal", self.goal)] {
            if !value.is_finite() {
                return bad(field, value.to_string(), "a finite number");
            }
        }
        if (self.goal - self.start).abs() < 1e-6 {
            return bad(
                "goal",
                format!("{}, where the joint starts", self.goal),
                "another position than `start`",
            );
        }
        if !(0.0..=1.0).contains(&self.hand_turns) {
            return bad("hand_turns", self.hand_turns.to_string(), "0 to 1");
        }
        let placement = &self.placement;
        for (field, range) in [
            ("placement.x_m", placement.x_m),
            ("placement.y_m", placement.y_m),
            ("placement.z_m", placement.z_m),
            ("placement.yaw_rad", placement.yaw_rad),
        ] {
            let [low, high] = range;
            if !(low.is_finite() && high.is_finite() && low <= high) {
                return bad(
                    field,
                    format!("{range:?}"),
                    "two finite numbers, the second not the smaller",
                );
            }
        }
        let episode = &self.episode;
        if !(1.0..=500.0).contains(&episode.control_hz) {
            return bad(
                "episode.control_hz",
                episode.control_hz.to_string(),
                "1 to 500 actions a second",
            );
        }
        for (field, count) in [
            ("episode.steps_max", episode.steps_max),
            ("episode.contact_lost_steps", episode.contact_lost_steps),
        ] {
            if count == 0 {
                return bad(field, "0".to_owned(), "at least 1");
            }
        }
        if let Some(motor) = &self.motor {
            for (field, value, least, most) in [
                ("motor.opening", motor.opening, 0.0, 1.0),
                ("motor.duration_secs", motor.duration_secs, 0.1, 600.0),
                ("motor.plan_speed", motor.plan_speed, 1e-3, 1.0),
                ("motor.done", motor.done, 1e-3, 1.0),
            ] {
                if !(least..=most).contains(&value) {
                    let wanted = format!("a number from {least} to {most}");
                    return bad(field, value.to_string(), &wanted);
                }
            }
        }
        if !(episode.grip_force_n > 0.0 && episode.grip_force_n.is_finite()) {
            return bad(
                "episode.grip_force_n",
                episode.grip_force_n.to_string(),
                "a positive force",
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOOR: &str = r#"
        name = "door"
        robot = "../robots/panda"
        model = "models/door.xml"
        joint = "hinge"
        goal = 0.3
        grasp_region = ["handle"]
        [placement]
        x_m = [0.4, 0.5]
        y_m = [-0.4, -0.3]
        z_m = [0.0, 0.0]
        yaw_rad = [-1.8, -1.6]
    "#;

    fn load(text: &str) -> Result<TaskSpec, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("door.toml");
        std::fs::write(&path, text).unwrap();
        TaskSpec::load(&path).map_err(|error| {
            error
                .to_string()
                .replace(&path.display().to_string(), "door.toml")
        })
    }

    #[test]
    fn defaults_are_those_of_the_experiments() {
        let task = load(DOOR).unwrap();
        assert_eq!(task.episode, EpisodeSpec::default());
        assert_eq!((task.start, task.hand_turns), (0.0, 1.0));
        assert!(task.model.ends_with("models/door.xml"));
        assert!((task.progress(0.15) - 0.5).abs() < 1e-12);
        let pose = task.placement.at([0.5, 0.0, 1.0, 0.25]);
        assert!((pose.translation.vector - nalgebra::Vector3::new(0.45, -0.4, 0.0)).norm() < 1e-12);
        assert!((pose.rotation.euler_angles().2 + 1.75).abs() < 1e-12);
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        let error = |from: &str, to: &str| load(&DOOR.replace(from, to)).unwrap_err();
        for name in ["", "..", "../../door", "a/b"] {
            let error = error("name = \"door\"", &format!("name = \"{name}\""));
            assert!(error.contains("`name`"), "{error}");
        }
        insta::assert_snapshot!(error("goal = 0.3", "goal = 0.0"),
            @"`door.toml`: `goal` is 0, where the joint starts, expected another position than `start`");
        insta::assert_snapshot!(error("[0.4, 0.5]", "[0.5, 0.4]"),
            @"`door.toml`: `placement.x_m` is [0.5, 0.4], expected two finite numbers, the second not the smaller");
        insta::assert_snapshot!(error("goal = ", "gaol = 1.0\ngoal = "),
            @"`door.toml`:6: unknown key `gaol`; did you mean `goal`?");
        insta::assert_snapshot!(error("goal = ", "hand_turns = 1.5\ngoal = "),
            @"`door.toml`: `hand_turns` is 1.5, expected 0 to 1");
        insta::assert_snapshot!(load(&format!("{DOOR}\n[episode]\nsteps_max = 0")).unwrap_err(),
            @"`door.toml`: `episode.steps_max` is 0, expected at least 1");
    }
}
