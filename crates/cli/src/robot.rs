//! `factotum robot check`: is a robot.toml right?

use std::path::{Path, PathBuf};

use clap::Subcommand;
use factotum_descriptions::RobotDescription;
use factotum_motion::{RobotCheck, RobotModel, check_robot};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use serde_json::json;

use crate::assets;
use crate::console::{Answer, Console, usage};

/// Arguments of `factotum robot`.
#[derive(Debug, Subcommand)]
pub(crate) enum RobotCommand {
    /// Load a robot and report its joints, frames, postures, reach, which of its bodies can meet, and what is missing.
    Check {
        /// Folder with `robot.toml`, or the name of a shipped robot.
        dir: PathBuf,
    },
}

/// The robot in a folder, or a shipped one, with every joint and frame that its `robot.toml` names for the arm found in its
/// model.
pub(crate) fn load(name: &Path) -> anyhow::Result<RobotModel> {
    let dir = assets::robot(name)?;
    let description = RobotDescription::load(&dir).map_err(usage)?;
    let named = |error| usage(format!("robot `{}`: {error}", dir.display()));
    RobotModel::load(&description).map_err(named)
}

/// Runs `factotum robot`; the answer is negative if a posture of `robot.toml` is not possible.
pub(crate) fn robot(command: &RobotCommand, console: &Console) -> anyhow::Result<Answer> {
    let RobotCommand::Check { dir } = command;
    let model = load(dir)?;
    console.progress("trying its postures");
    let check = check_robot(&model, &mut ChaCha8Rng::seed_from_u64(0)).map_err(usage)?;
    let missing = missing(model.description());
    console.answer(&document(&model, &check, &missing), || {
        lines(&model, &check, &missing).join("\n")
    })?;
    Ok(Answer::from(
        check
            .postures
            .iter()
            .all(|posture| posture.problem.is_none()),
    ))
}

fn missing(description: &RobotDescription) -> Vec<&'static str> {
    let sensors = &description.sensors;
    [
        (description.base.is_none(), "mobile base: it cannot drive"),
        (description.gripper.is_none(), "gripper: it cannot pick"),
        (sensors.lidar.is_none(), "lidar: it cannot map"),
        (sensors.camera.is_none(), "camera: it cannot find objects"),
    ]
    .into_iter()
    .filter_map(|(is_missing, what)| is_missing.then_some(what))
    .collect()
}

fn document(model: &RobotModel, check: &RobotCheck, missing: &[&str]) -> serde_json::Value {
    let description = model.description();
    let chain: Vec<_> = model
        .chain_joints()
        .iter()
        .zip(model.limits())
        .map(|(name, limit)| {
            let range = limit
                .lower
                .is_finite()
                .then_some([limit.lower, limit.upper]);
            json!({"name": name, "range": range, "velocity_max": limit.velocity, "acceleration_max": limit.acceleration})
        })
        .collect();
    let frames: Vec<_> = check
        .frames
        .iter()
        .map(|frame| {
            let (roll, pitch, yaw) = frame.base_from_frame.rotation.euler_angles();
            let place = frame.base_from_frame.translation.vector;
            json!({"role": frame.role, "site": frame.site, "body": frame.body, "xyz": [place.x, place.y, place.z], "rpy": [roll, pitch, yaw]})
        })
        .collect();
    let postures: Vec<_> = check
        .postures
        .iter()
        .map(|posture| json!({"name": posture.name, "problem": posture.problem}))
        .collect();
    let meeting: Vec<_> = check
        .meeting
        .iter()
        .map(|pair| json!({"a": pair.a, "b": pair.b, "share": pair.share}))
        .collect();
    let reach = &check.reach;
    json!({
        "robot": description.name,
        "chain": chain,
        "tcp": description.arm.tcp_site,
        "frames": frames,
        "postures": postures,
        "meeting": meeting,
        "reach": {
            "distance_max_m": reach.distance_max_m,
            "height_m": reach.height_m,
            "free_share": reach.free_share,
            "ik_share": reach.ik_share,
        },
        "missing": missing,
    })
}

/// A direction to one digit, which is enough to see whether a frame is turned the wrong way.
fn direction(axis: Vector3<f64>) -> String {
    let [x, y, z] = [axis.x, axis.y, axis.z].map(|value| (value * 10.0).round() / 10.0 + 0.0);
    format!("({x}, {y}, {z})")
}

/// The most pairs of bodies that are named.
const N_PAIRS_NAMED: usize = 12;

fn lines(model: &RobotModel, check: &RobotCheck, missing: &[&str]) -> Vec<String> {
    let mut lines = vec![format!("{}: loads", model.description().name)];
    lines.push("joints, from the base outwards (rad, m):".to_owned());
    for (name, limit) in model.chain_joints().iter().zip(model.limits()) {
        let range = if limit.lower.is_finite() {
            format!("{:7.3} .. {:7.3}", limit.lower, limit.upper)
        } else {
            "continuous".to_owned()
        };
        lines.push(format!(
            "  {name:<20} {range:<18}  at most {:.2}/s, {:.2}/s²",
            limit.velocity, limit.acceleration
        ));
    }
    lines.push("frames in the posture `ready`, in the base frame (m):".to_owned());
    for frame in &check.frames {
        let pose = &frame.base_from_frame;
        let place = pose.translation.vector;
        let [x, z] = [pose.rotation * Vector3::x(), pose.rotation * Vector3::z()].map(direction);
        lines.push(format!(
            "  {:<7} `{}` on `{}` at ({:.3}, {:.3}, {:.3}), x to {x}, z to {z}",
            frame.role, frame.site, frame.body, place.x, place.y, place.z
        ));
    }
    for posture in &check.postures {
        let verdict = posture.problem.as_deref().unwrap_or("free");
        lines.push(format!("posture `{}`: {verdict}", posture.name));
    }
    let reach = &check.reach;
    lines.push(format!(
        "reach: {:.2} m from the base's axis, {:.2} to {:.2} m high; {:.0} % of random postures are free, and {:.0} % of \
         their tool poses are found again",
        reach.distance_max_m,
        reach.height_m[0],
        reach.height_m[1],
        100.0 * reach.free_share,
        100.0 * reach.ik_share
    ));
    lines.push(format!("{} pairs of bodies can meet:", check.meeting.len()));
    for pair in check.meeting.iter().take(N_PAIRS_NAMED) {
        let (a, b, percent) = (&pair.a, &pair.b, 100.0 * pair.share);
        lines.push(format!("  {percent:5.1} %  `{a}` and `{b}`"));
    }
    if check.meeting.len() > N_PAIRS_NAMED {
        lines.push("  ... (all with --json)".to_owned());
    }
    for (a, b) in model.always_touching() {
        lines.push(format!("  `{a}` and `{b}` always touch: not checked"));
    }
    lines.extend(missing.iter().map(|what| format!("missing: {what}")));
    lines
}
