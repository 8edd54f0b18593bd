//! A robot as checked data: which models it is made of and which of their names mean what.
//!
//! The format is documented key by key on the types below; `assets/robots/` holds worked examples. The tool frame
//! (`tcp`) has z along the approach direction, out of the gripper, and x along the closing direction of the fingers.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use serde::Deserialize;

use crate::{DescriptionError, Placement, read_toml};

/// A robot: models to compose and the roles of their joints, actuators, sites and geoms.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotDescription {
    /// Name for people.
    pub name: String,
    /// Where its figures come from.
    pub source: String,
    /// Folder of `robot.toml`; relative model paths start here.
    pub dir: PathBuf,
    /// Models, the first on the floor, each later one attached to a site or body of an earlier one.
    pub parts: Vec<RobotPart>,
    /// The mobile base, or `None` for an arm bolted to the floor.
    pub base: Option<Base>,
    /// The lift under the arm, if it has one.
    pub lift: Option<Lift>,
    /// The arm.
    pub arm: Arm,
    /// The gripper, if it has one.
    pub gripper: Option<Gripper>,
    /// Its sensors.
    pub sensors: Sensors,
}

/// One model file of a robot.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotPart {
    /// Name for people.
    pub name: String,
    /// MJCF or URDF file; relative to `robot.toml` until loaded, then absolute or relative to the working directory.
    pub model: PathBuf,
    /// Put before every name in this part, e.g. `arm/`.
    #[serde(default)]
    pub prefix: String,
    /// Site, or else body, of an earlier part, with its prefix, that carries this part. The first part has none.
    pub attach_to: Option<String>,
    /// Offset from that frame, metres.
    #[serde(default)]
    pub offset_xyz: [f64; 3],
    /// Offset from that frame, fixed-axis roll, pitch, yaw, radians.
    #[serde(default)]
    pub offset_rpy: [f64; 3],
    /// Folders that `package://NAME/...` of a URDF may mean, relative to `robot.toml`.
    #[serde(default)]
    pub package_dirs: Vec<PathBuf>,
}

impl RobotPart {
    /// Pose of the part's root in the frame that carries it.
    pub fn carrier_from_part(&self) -> Isometry3<f64> {
        Placement {
            xyz: self.offset_xyz,
            rpy: self.offset_rpy,
        }
        .into()
    }
}

/// An omnidirectional base: two world-aligned slides and a yaw hinge, driven by velocity actuators.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Base {
    /// Slide x, slide y, hinge yaw.
    pub joints: [String; 3],
    /// Their velocity actuators, in the same order (m/s, m/s, rad/s).
    pub actuators: [String; 3],
    /// Body that moves with the base (REP-105 `base_link`).
    pub link: String,
    /// Radius of the smallest circle about `link` that holds the base, metres.
    pub footprint_radius_m: f64,
    /// Speed limit in any direction, m/s.
    #[serde(default = "base_velocity_max")]
    pub velocity_max_m_per_s: f64,
    /// Turn rate limit, rad/s.
    #[serde(default = "base_yaw_rate_max")]
    pub yaw_rate_max_rad_per_s: f64,
    /// Acceleration limit, m/s².
    #[serde(default = "base_acceleration_max")]
    pub acceleration_max_m_per_s2: f64,
}

fn base_velocity_max() -> f64 {
    0.5
}
fn base_yaw_rate_max() -> f64 {
    0.8
}
fn base_acceleration_max() -> f64 {
    0.5
}

/// A vertical slide under the arm, with a position actuator.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lift {
    /// Slide joint.
    pub joint: String,
    /// Position actuator (m).
    pub actuator: String,
    /// Height for driving, metres.
    #[serde(default)]
    pub rest_m: f64,
    /// Speed limit, m/s.
    #[serde(default = "lift_velocity_max")]
    pub velocity_max_m_per_s: f64,
}

fn lift_velocity_max() -> f64 {
    0.1
}

/// A serial arm; every list has one entry per joint, from the base outwards.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arm {
    /// Hinge joints.
    pub joints: Vec<String>,
    /// Their torque actuators (N m). Absent names are added as motors with `torque_max_nm`.
    #[serde(default)]
    pub actuators: Vec<String>,
    /// Tool frame: z approach, x closing direction.
    pub tcp_site: String,
    /// Where the tool frame is, if the models have no such site: a body of theirs and the pose in it.
    pub tcp: Option<TcpFrame>,
    /// Velocity limits, rad/s.
    pub velocity_max_rad_per_s: Vec<f64>,
    /// Acceleration limits, rad/s².
    pub acceleration_max_rad_per_s2: Vec<f64>,
    /// Torque limits, N m.
    pub torque_max_nm: Vec<f64>,
    /// Tucked posture for driving, rad.
    pub rest: Vec<f64>,
    /// Posture from which manipulation starts, rad.
    pub ready: Vec<f64>,
}

/// A tool frame given in `robot.toml` instead of in the model.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TcpFrame {
    /// Body that carries the frame, with its prefix.
    pub body: String,
    /// Position in the body, metres.
    #[serde(default)]
    pub xyz: [f64; 3],
    /// Fixed-axis roll, pitch, yaw in the body, radians.
    #[serde(default)]
    pub rpy: [f64; 3],
}

/// A gripper whose fingers are position servos; `open` and `closed` are their targets.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gripper {
    /// Finger joints, for reading.
    pub joints: Vec<String>,
    /// Finger actuators.
    pub actuators: Vec<String>,
    /// Actuator targets with the fingers open.
    pub open: Vec<f64>,
    /// Actuator targets with the fingers closed.
    pub closed: Vec<f64>,
    /// Largest object width it takes, metres.
    pub aperture_max_m: f64,
    /// Geoms that touch what is held.
    pub pads: Vec<String>,
    /// Largest force of one finger, N.
    #[serde(default = "gripper_force_max")]
    pub force_max_n: f64,
}

fn gripper_force_max() -> f64 {
    40.0
}

/// The sensors a robot may carry.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensors {
    /// Planar laser scanner.
    pub lidar: Option<Lidar>,
    /// Depth camera.
    pub camera: Option<Camera>,
}

/// A planar laser scanner; its site has x forward and z up.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lidar {
    /// Site of the scanner.
    pub site: String,
    /// Rays per scan.
    pub n_rays: usize,
    /// Field of view, centred on x, radians.
    pub fov_rad: f64,
    /// Shortest and longest range, metres.
    pub range_m: [f64; 2],
    /// Scans a second.
    #[serde(default = "lidar_rate")]
    pub rate_hz: f64,
}

fn lidar_rate() -> f64 {
    10.0
}

/// A depth camera; its site has x forward and z up (the optical frame is derived from it).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Site of the camera.
    pub site: String,
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Vertical field of view, radians.
    pub fovy_rad: f64,
    /// Shortest and longest range, metres.
    pub range_m: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRobot {
    name: String,
    #[serde(default)]
    source: String,
    parts: Vec<RobotPart>,
    base: Option<Base>,
    lift: Option<Lift>,
    arm: Arm,
    gripper: Option<Gripper>,
    #[serde(default)]
    sensors: Sensors,
}

impl RobotDescription {
    /// Radius of the circle on the floor that the base needs, metres: 0 without a base.
    pub fn footprint_radius_m(&self) -> f64 {
        let base = self.base.as_ref();
        base.map_or(0.0, |base| base.footprint_radius_m)
    }

    /// Reads `DIR/robot.toml` (or the file itself, if `path` names one).
    ///
    /// # Errors
    /// [`DescriptionError`] if the file cannot be read, has an unknown key, or its values contradict each other.
    pub fn load(path: &Path) -> Result<Self, DescriptionError> {
        let file = if path.is_dir() {
            path.join("robot.toml")
        } else {
            path.to_owned()
        };
        let mut raw: RawRobot = read_toml(&file)?;
        let dir = file.parent().map(Path::to_owned).unwrap_or_default();
        check(&file, &raw)?;
        for part in &mut raw.parts {
            part.model = dir.join(&part.model);
            for package_dir in &mut part.package_dirs {
                *package_dir = dir.join(&package_dir);
            }
        }
        if raw.arm.actuators.is_empty() {
            raw.arm.actuators.clone_from(&raw.arm.joints);
        }
        let RawRobot {
            name,
            source,
            parts,
            base,
            lift,
            arm,
            gripper,
            sensors,
        } = raw;
        Ok(Self {
            name,
            source,
            dir,
            parts,
            base,
            lift,
            arm,
            gripper,
            sensors,
        })
    }
}

fn check(file: &Path, raw: &RawRobot) -> Result<(), DescriptionError> {
    let value = |field: &str, found: String, wanted: &str| {
        Err(DescriptionError::Value {
            path: file.to_owned(),
            field: field.to_owned(),
            found,
            wanted: wanted.to_owned(),
        })
    };
    match raw.parts.split_first() {
        None => return value("parts", "empty".into(), "at least one part"),
        Some((first, rest)) => {
            if let Some(site) = &first.attach_to {
                return value(
                    "parts[0].attach_to",
                    format!("`{site}`"),
                    "nothing: the first part stands on the floor",
                );
            }
            if let Some(part) = rest.iter().find(|part| part.attach_to.is_none()) {
                return value(
                    &format!("parts.{}.attach_to", part.name),
                    "absent".into(),
                    "a site or body of an earlier part",
                );
            }
        }
    }
    let n_joints = raw.arm.joints.len();
    if n_joints == 0 {
        return value("arm.joints", "empty".into(), "at least one joint");
    }
    let lists: [(&str, usize); 5] = [
        (
            "arm.velocity_max_rad_per_s",
            raw.arm.velocity_max_rad_per_s.len(),
        ),
        (
            "arm.acceleration_max_rad_per_s2",
            raw.arm.acceleration_max_rad_per_s2.len(),
        ),
        ("arm.torque_max_nm", raw.arm.torque_max_nm.len()),
        ("arm.rest", raw.arm.rest.len()),
        ("arm.ready", raw.arm.ready.len()),
    ];
    for (field, len) in lists {
        if len != n_joints {
            return value(
                field,
                format!("{len} values"),
                &format!("{n_joints}, one per arm joint"),
            );
        }
    }
    if !raw.arm.actuators.is_empty() && raw.arm.actuators.len() != n_joints {
        return value(
            "arm.actuators",
            format!("{} names", raw.arm.actuators.len()),
            &format!("{n_joints}, one per arm joint"),
        );
    }
    for (field, limits) in [
        (
            "arm.velocity_max_rad_per_s",
            &raw.arm.velocity_max_rad_per_s,
        ),
        (
            "arm.acceleration_max_rad_per_s2",
            &raw.arm.acceleration_max_rad_per_s2,
        ),
        ("arm.torque_max_nm", &raw.arm.torque_max_nm),
    ] {
        if let Some(limit) = limits
            .iter()
            .find(|limit| !(limit.is_finite() && **limit > 0.0))
        {
            return value(field, format!("{limit}"), "positive numbers");
        }
    }
    if let Some(base) = &raw.base
        && !(base.footprint_radius_m > 0.0 && base.footprint_radius_m.is_finite())
    {
        return value(
            "base.footprint_radius_m",
            format!("{}", base.footprint_radius_m),
            "a positive length in metres",
        );
    }
    if let Some(gripper) = &raw.gripper {
        let n = gripper.actuators.len();
        for (field, len) in [
            ("gripper.open", gripper.open.len()),
            ("gripper.closed", gripper.closed.len()),
        ] {
            if len != n {
                return value(
                    field,
                    format!("{len} values"),
                    &format!("{n}, one per gripper actuator"),
                );
            }
        }
    }
    if let Some(lidar) = &raw.sensors.lidar
        && lidar.n_rays < 2
    {
        return value(
            "sensors.lidar.n_rays",
            format!("{}", lidar.n_rays),
            "at least 2",
        );
    }
    if let Some(camera) = &raw.sensors.camera
        && !(camera.fovy_rad > 0.0 && camera.fovy_rad < std::f64::consts::PI)
    {
        return value(
            "sensors.camera.fovy_rad",
            format!("{}", camera.fovy_rad),
            "an angle between 0 and pi",
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
name = "two"
[[parts]]
name = "arm"
model = "arm.xml"
[arm]
joints = ["j1", "j2"]
tcp_site = "tcp"
velocity_max_rad_per_s = [1.0, 1.0]
acceleration_max_rad_per_s2 = [2.0, 2.0]
torque_max_nm = [10.0, 5.0]
rest = [0.0, 0.0]
ready = [0.0, 1.0]
"#;

    fn load(text: &str) -> Result<RobotDescription, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("robot.toml");
        std::fs::write(&path, text).unwrap();
        RobotDescription::load(dir.path()).map_err(|error| {
            error
                .to_string()
                .replace(&path.display().to_string(), "robot.toml")
        })
    }

    #[test]
    fn reads_a_small_robot() {
        let robot = load(GOOD).unwrap();
        assert_eq!(robot.arm.actuators, ["j1", "j2"]);
        assert!(robot.parts[0].model.ends_with("arm.xml"));
        assert!(robot.base.is_none());
    }

    /// The tutorial's file is the one of its finished folder, but for paths.
    #[test]
    fn the_tutorial_says_what_its_folder_says() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/tutorials");
        let text = std::fs::read_to_string(docs.join("own-robot.md")).unwrap();
        let (_, block) = text.split_once("```toml\n").unwrap();
        let (told, _) = block.split_once("```").unwrap();
        let told = load(told).unwrap();
        let made = RobotDescription::load(&docs.join("robosuite_panda")).unwrap();
        assert_eq!(told.arm, made.arm);
        assert_eq!(told.gripper, made.gripper);
        assert_eq!(told.base, made.base);
        let frames = |robot: &RobotDescription| -> Vec<_> {
            let parts = robot.parts.iter();
            parts
                .map(|part| (part.prefix.clone(), part.attach_to.clone()))
                .collect()
        };
        assert_eq!(frames(&told), frames(&made));
    }

    #[test]
    fn a_list_of_the_wrong_length_is_refused() {
        let text = GOOD.replace("rest = [0.0, 0.0]", "rest = [0.0]");
        insta::assert_snapshot!(load(&text).unwrap_err(),
            @"`robot.toml`: `arm.rest` is 1 values, expected 2, one per arm joint");
    }

    #[test]
    fn a_second_part_needs_a_site() {
        let text = GOOD.replace(
            "[arm]",
            "[[parts]]\nname = \"hand\"\nmodel = \"hand.xml\"\n[arm]",
        );
        insta::assert_snapshot!(load(&text).unwrap_err(),
            @"`robot.toml`: `parts.hand.attach_to` is absent, expected a site or body of an earlier part");
    }

    #[test]
    fn a_negative_torque_is_refused() {
        let text = GOOD.replace("[10.0, 5.0]", "[10.0, -5.0]");
        insta::assert_snapshot!(load(&text).unwrap_err(),
            @"`robot.toml`: `arm.torque_max_nm` is -5, expected positive numbers");
    }
}
