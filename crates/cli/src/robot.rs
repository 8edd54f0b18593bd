//! `factotum robot check`: is a robot.toml right?

use std::path::{Path, PathBuf};

use clap::Subcommand;
use factotum_descriptions::RobotDescription;
use factotum_motion::RobotModel;
use serde_json::json;

use crate::assets;
use crate::console::{Answer, Console, usage};

/// Arguments of `factotum robot`.
#[derive(Debug, Subcommand)]
pub(crate) enum RobotCommand {
    /// Load a robot and report its joints, limits and what is missing.
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

/// Runs `factotum robot`.
pub(crate) fn robot(command: &RobotCommand, console: &Console) -> anyhow::Result<Answer> {
    let RobotCommand::Check { dir } = command;
    let model = load(dir)?;
    let description = model.description();
    let joints: Vec<_> = model
        .chain_joints()
        .iter()
        .zip(model.limits())
        .map(|(name, limit)| {
            let range = limit
                .lower
                .is_finite()
                .then_some([limit.lower, limit.upper]);
            json!({"name": name, "range": range, "velocity_max": limit.velocity})
        })
        .collect();
    let missing: Vec<&str> = [
        (description.base.is_none(), "mobile base: it cannot drive"),
        (description.gripper.is_none(), "gripper: it cannot pick"),
        (description.sensors.lidar.is_none(), "lidar: it cannot map"),
        (
            description.sensors.camera.is_none(),
            "camera: it cannot find objects",
        ),
    ]
    .into_iter()
    .filter_map(|(is_missing, what)| is_missing.then_some(what))
    .collect();
    let document = json!({"robot": description.name, "chain": joints, "tcp": description.arm.tcp_site, "missing": missing});
    console.answer(&document, || {
        let mut lines = vec![format!(
            "{}: loads; tool frame `{}`",
            description.name, description.arm.tcp_site
        )];
        for (name, limit) in model.chain_joints().iter().zip(model.limits()) {
            let range = if limit.lower.is_finite() {
                format!("{:7.3} .. {:7.3}", limit.lower, limit.upper)
            } else {
                "continuous".to_owned()
            };
            lines.push(format!(
                "  {name:<20} {range}  at most {:.2} per second",
                limit.velocity
            ));
        }
        lines.extend(missing.iter().map(|what| format!("  missing: {what}")));
        lines.join("\n")
    })?;
    Ok(Answer::Yes)
}
