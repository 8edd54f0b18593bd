//! `factotum experiment run cip-compose`: two skills that were learned apart, one after the other, in either order
//! (thesis 3.4.1).

use std::path::PathBuf;

use clap::Args;
use serde_json::{Map, json};

use super::seeds::Seeds;
use super::stop_on_interrupt;
use crate::console::{Answer, Console};

/// Arguments of `factotum experiment run cip-compose`.
#[derive(Debug, Args)]
pub(crate) struct ComposeArgs {
    /// The two skills: folders, or names of shipped ones.
    #[arg(long, num_args = 2, value_name = "SKILL", default_values = ["slide", "door"])]
    skills: Vec<PathBuf>,
    /// Runs seeds 0 to N - 1 in either order.
    #[arg(long, value_name = "N", default_value_t = 20)]
    seeds: u64,
    /// Scene: a folder with `scene.toml`, or the name of a shipped one.
    #[arg(long, default_value = "knob_and_door")]
    scene: PathBuf,
    /// Runs at a time.
    #[arg(long, default_value_t = 1)]
    workers: usize,
    /// Folder of the results, one below it for each order.
    #[arg(long, default_value = "runs/cip-compose")]
    out: PathBuf,
}

/// Runs `factotum experiment run cip-compose`.
pub(super) fn compose(args: &ComposeArgs, console: &Console) -> anyhow::Result<Answer> {
    let stop = stop_on_interrupt()?;
    let mut orders = Map::new();
    let mut words = Vec::new();
    let mut answer = true;
    let turned: Vec<&PathBuf> = args.skills.iter().rev().collect();
    for order in [args.skills.iter().collect(), turned] {
        let names: Vec<String> = order
            .iter()
            .map(|skill| {
                skill
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        let name = names.join("-");
        console.say(format_args!("{}", names.join(", then ")));
        let seeds = Seeds {
            arguments: ["skill".to_owned(), "run".to_owned()]
                .into_iter()
                .chain(order.iter().map(|skill| skill.display().to_string()))
                .chain(["--scene".to_owned(), args.scene.display().to_string()])
                .chain(["--json".to_owned()])
                .collect(),
            n: args.seeds,
            n_workers: args.workers,
            folder: args.out.join(&name),
        };
        let swept = seeds.run(&stop, console)?;
        answer &= swept.is_success();
        words.push(format!(
            "{}: {}",
            names.join(", then "),
            seeds.describe(&swept)
        ));
        let document = json!({"complete": swept.is_complete, "summary": swept.summary});
        orders.insert(name, document);
    }
    console.answer(&json!({ "orders": orders }), || words.join("\n"))?;
    Ok(Answer::from(answer))
}
