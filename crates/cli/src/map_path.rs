//! `factotum map path`: a path of the base in a stored map.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use factotum_geometry::Pose2;
use factotum_motion::{BaseOutcome, BasePathOptions, InflatedGrid, InflationOptions, plan_base};
use serde_json::json;

use crate::console::{Answer, Console, usage};
use crate::{home, robot};

/// Arguments of `factotum map path`.
#[derive(Debug, Args)]
pub(crate) struct PathArgs {
    /// The home folder.
    home: PathBuf,
    /// Where the base starts, metres in the map.
    #[arg(long, num_args = 2, value_names = ["X", "Y"], allow_negative_numbers = true, required = true)]
    from: Vec<f64>,
    /// Where it is to go, metres in the map.
    #[arg(long, num_args = 2, value_names = ["X", "Y"], allow_negative_numbers = true, required = true)]
    to: Vec<f64>,
    /// Robot whose base it is: a folder with `robot.toml`, or the name of a shipped one.
    #[arg(long, default_value = "movo")]
    robot: PathBuf,
}

/// Plans the path and tells its length, how near it passes to obstacles, and how long planning took. That there is no
/// path is an answer.
pub(crate) fn path(args: &PathArgs, console: &Console) -> anyhow::Result<Answer> {
    let (name, aosm) = home::read(&args.home)?;
    let robot = robot::load(&args.robot)?;
    let Some(base) = &robot.description().base else {
        let problem = format!("robot `{}` has no mobile base", robot.description().name);
        return Err(usage(problem));
    };
    let [from, to] = [pose("--from", &args.from)?, pose("--to", &args.to)?];
    let started = Instant::now();
    let options = InflationOptions::for_radius(base.footprint_radius_m);
    let grid = InflatedGrid::new(&aosm.grid, &options);
    let inflate_ms = 1e3 * started.elapsed().as_secs_f64();
    let started = Instant::now();
    let outcome = plan_base(&grid, &from, &to, &BasePathOptions::default());
    let plan_ms = 1e3 * started.elapsed().as_secs_f64();
    let timings = json!({"inflate_ms": rounded(inflate_ms), "plan_ms": rounded(plan_ms)});
    let reason = match outcome {
        BaseOutcome::Solved {
            path,
            length_m,
            clearance_m,
        } => {
            let poses: Vec<[f64; 3]> = path
                .iter()
                .map(|pose| {
                    let at = pose.translation.vector;
                    [rounded(at.x), rounded(at.y), rounded(pose.rotation.angle())]
                })
                .collect();
            console.answer(
                &json!({"home": name, "solved": true, "length_m": rounded(length_m),
                        "clearance_m": rounded(clearance_m), "timings": timings, "map_from_base": poses}),
                || {
                    format!(
                        "{name}: {length_m:.1} m in {} poses, at least {clearance_m:.2} m from obstacles; planned in \
                         {plan_ms:.1} ms, and {inflate_ms:.1} ms to grow obstacles by {:.2} m",
                        poses.len(),
                        base.footprint_radius_m
                    )
                },
            )?;
            return Ok(Answer::Yes);
        }
        BaseOutcome::StartBlocked => "the start is off the map or too near to an obstacle",
        BaseOutcome::GoalBlocked => "the goal is off the map or too near to an obstacle",
        BaseOutcome::Unreachable => "no free way leads there",
        BaseOutcome::LimitReached => "the search reached its limit",
    };
    console.answer(
        &json!({"home": name, "solved": false, "reason": reason, "timings": timings}),
        || format!("{name}: no path: {reason}"),
    )?;
    Ok(Answer::No)
}

fn pose(option: &str, xy: &[f64]) -> anyhow::Result<Pose2> {
    match xy {
        &[x, y] if x.is_finite() && y.is_finite() => {
            Ok(Pose2::new(nalgebra::Vector2::new(x, y), 0.0))
        }
        _ => Err(usage(format!(
            "{option} is {xy:?}; expected two numbers, metres"
        ))),
    }
}

/// To thousandths: finer is noise.
fn rounded(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}
