//! Contact skills: environment steps beside robosuite, TD3 updates beside SBX and Stable-Baselines3, in turn on one
//! processor. Simulator and learners have a Python each, since their demands on numpy differ; the scripts drive our
//! benchmarks round by round. The rounds are kept under `target/peers`, a file for each script.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use serde_json::{Value, json};

use super::{built, python};
use crate::process;
use crate::setup::{self, Wanted};
use crate::workspace::Workspace;

/// Rounds of each measurement.
const N_ROUNDS: &str = "20";

const SIMULATOR_PACKAGES: [&str; 2] = ["robosuite==1.5.2", "mujoco==3.9.0"];
const LEARNER_PACKAGES: [&str; 2] = ["stable-baselines3==2.9.2", "sbx-rl==0.28.0"];

const USAGE: &str = "usage: cargo x bench peers cip [--json] [--scene DOOR_XML]";

/// Where robosuite's Door scene lies beside the repository, if it does.
const SCENE: &str = "../shared/data/robosuite_door/door.xml";

pub(super) fn run(workspace: &Workspace, arguments: &[String]) -> Result<()> {
    let mut rest = arguments;
    let (mut as_json, mut scene) = (false, workspace.path(SCENE));
    while let Some((option, after)) = rest.split_first() {
        rest = after;
        match (option.as_str(), rest.split_first()) {
            ("--json", _) => as_json = true,
            ("--scene", Some((path, after))) => {
                scene = std::path::absolute(path).context("cannot tell the working directory")?;
                rest = after;
            }
            _ => bail!("`{option}` is not understood\n{USAGE}"),
        }
    }
    if !scene.is_file() {
        bail!(
            "robosuite's Door scene is not at `{}`; save its compiled MJCF and name it with --scene",
            scene.display()
        );
    }
    setup::run(workspace, Wanted::TO_BUILD)?;
    let summary = measure(workspace, &scene)?;
    if as_json {
        println!("{summary:#}");
    } else {
        print_table(&summary);
    }
    Ok(())
}

fn measure(workspace: &Workspace, scene: &Path) -> Result<Value> {
    let simulator = python(workspace, "robosuite", &SIMULATOR_PACKAGES)?;
    let learners = python(workspace, "td3", &LEARNER_PACKAGES)?;
    let bench = |package: &str, name: &str| {
        built(
            workspace,
            &["bench", "--no-run", "--bench", name, "--package", package],
        )
    };
    let contact = bench("factotum-worlds", "contact")?;
    let td3 = bench("factotum-learning", "td3")?;
    let kept = |name: &str| workspace.path("target/peers").join(name);
    let steps = rounds(
        &kept("env_steps.jsonl"),
        workspace
            .python(&simulator, "experiments/cip-peers/env_steps.py")
            .arg(contact)
            .arg(scene)
            .arg(N_ROUNDS),
    )?;
    let updates = rounds(
        &kept("td3_updates.jsonl"),
        workspace
            .python(&learners, "experiments/td3-updates/peers.py")
            .arg(td3)
            .arg(N_ROUNDS),
    )?;
    Ok(summary(&steps, &updates))
}

/// The lines that a measurement prints, one a round, also written to a file.
fn rounds(file: &Path, command: &mut Command) -> Result<Vec<Value>> {
    let lines = process::capture(command)?;
    std::fs::write(file, &lines).with_context(|| format!("cannot write {}", file.display()))?;
    let rounds: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).with_context(|| format!("not a round: `{line}`")))
        .collect::<Result<_>>()?;
    if rounds.is_empty() {
        bail!("the measurement printed no round");
    }
    Ok(rounds)
}

/// Medians over the rounds, per second of processor time, which other programs on the machine disturb least.
fn summary(steps: &[Value], updates: &[Value]) -> Value {
    let rate =
        |rounds: &[Value], of: &str| median(rounds, |round| round[of]["per_cpu_sec"].as_f64());
    let ratio = |rounds: &[Value], of: &str, to: &str| {
        median(rounds, |round| {
            Some(round[of]["per_cpu_sec"].as_f64()? / round[to]["per_cpu_sec"].as_f64()?)
        })
    };
    json!({
        "rounds": steps.len(),
        "env_steps_per_sec": {
            "robosuite": rate(steps, "peer"),
            "factotum_robosuite_door": rate(steps, "robosuite"),
            "factotum_own_door": rate(steps, "own"),
        },
        "env_steps_ratio_robosuite": ratio(steps, "robosuite", "peer"),
        "env_steps_ratio_robosuite_own_door": ratio(steps, "own", "peer"),
        "env_overhead_over_raw": median(steps, |round| round["overhead"].as_f64()),
        "td3_updates_per_sec": {
            "factotum": rate(updates, "factotum"),
            "sbx": rate(updates, "sbx"),
            "sb3": rate(updates, "sb3"),
        },
        "td3_updates_ratio_sbx": ratio(updates, "factotum", "sbx"),
        "td3_updates_ratio_sb3": ratio(updates, "factotum", "sb3"),
    })
}

fn median(rounds: &[Value], value: impl Fn(&Value) -> Option<f64>) -> Option<f64> {
    let mut values: Vec<f64> = rounds.iter().filter_map(value).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn print_table(summary: &Value) {
    let number = |value: &Value| value.as_f64().map_or("-".to_owned(), |n| format!("{n:.2}"));
    println!(
        "| per second of one processor, median of {} rounds | |",
        summary["rounds"]
    );
    println!("|---|---|");
    for group in ["env_steps_per_sec", "td3_updates_per_sec"] {
        for (name, value) in summary[group].as_object().into_iter().flatten() {
            println!("| {group}: {name} | {} |", number(value));
        }
    }
    for name in [
        "env_steps_ratio_robosuite",
        "env_steps_ratio_robosuite_own_door",
        "env_overhead_over_raw",
        "td3_updates_ratio_sbx",
        "td3_updates_ratio_sb3",
    ] {
        println!("| {name} | {} |", number(&summary[name]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round(name: &str, rate: f64) -> (String, Value) {
        (
            name.to_owned(),
            json!({ "per_cpu_sec": rate, "per_wall_sec": 1.0 }),
        )
    }

    #[test]
    fn ratios_are_medians_of_the_rounds_ratios() {
        let steps = |ours: f64, peer: f64| {
            let rates = [("robosuite", ours), ("own", 2.0 * ours), ("peer", peer)];
            let rates = rates.iter().map(|&(name, rate)| round(name, rate));
            let overhead = ("overhead".to_owned(), json!(ours / 1e4));
            Value::Object(rates.chain([overhead]).collect())
        };
        // One round that something else disturbed.
        let found = summary(
            &[steps(800.0, 100.0), steps(900.0, 100.0), steps(10.0, 100.0)],
            &[],
        );
        assert_eq!(found["env_steps_ratio_robosuite"], 8.0);
        assert_eq!(found["env_steps_ratio_robosuite_own_door"], 16.0);
        assert_eq!(found["env_overhead_over_raw"], 0.08);
        assert!(found["td3_updates_ratio_sbx"].is_null());
    }
}
