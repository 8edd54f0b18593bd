//! `factotum skill`: learning a contact skill, going on with it, judging it.

use std::path::Path;

use crate::{assert_refused, factotum_in, repository};

/// The lines of the metrics as JSON.
fn metrics(dir: &Path) -> Vec<serde_json::Value> {
    let text = std::fs::read_to_string(dir.join("skill/metrics.jsonl")).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// Trains the lever in `dir`, without shaking every grasp.
fn train(dir: &Path, more: &[&str]) -> crate::Said {
    let arguments = ["--json", "skill", "train"];
    factotum_in(dir, &[&arguments, more].concat())
}

#[test]
fn a_skill_is_learned_gone_on_with_and_judged() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let said = train(
        dir,
        &[
            "lever",
            "--ablation",
            "fast",
            "--episodes",
            "3",
            "--seed",
            "7",
            "--out",
            "skill",
        ],
    );
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let document = said.json();
    assert_eq!(document["episodes"], 3);
    assert_eq!(document["complete"], true);
    assert_eq!(document["training_violations"], 0);
    assert!(document["split_secs"]["physics"].as_f64().unwrap() > 0.0);
    let lines = metrics(dir);
    assert_eq!(lines.len(), 4, "three episodes and an evaluation");
    for key in [
        "episode",
        "env_steps",
        "success",
        "violation",
        "steps",
        "peak_force_n",
        "grasp",
    ] {
        assert!(lines[0].get(key).is_some(), "{key} in {}", lines[0]);
    }
    for key in [
        "episode",
        "success_rate",
        "violation_rate",
        "peak_force_n",
        "time_to_success_secs",
    ] {
        assert!(lines[3].get(key).is_some(), "{key} in {}", lines[3]);
    }

    // The folder is taken, and can be gone on with; half a line, as of a crash, does no harm.
    let again = train(dir, &["door", "--out", "skill"]);
    assert_refused(
        &again,
        &["`skill`", "`lever`", "fast", "seed 7", "--resume"],
    );
    let file = dir.join("skill/metrics.jsonl");
    let whole = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, format!("{whole}{{\"episode\":4,\"suc")).unwrap();
    let resumed = train(dir, &["--resume", "skill", "--episodes", "5"]);
    assert_eq!(resumed.code, Some(0), "{}", resumed.stderr);
    let lines = metrics(dir);
    let episodes: Vec<u64> = lines
        .iter()
        .map(|line| line["episode"].as_u64().unwrap())
        .collect();
    assert_eq!(episodes, [1, 2, 3, 3, 4, 5, 5]);

    for policy in ["best", "last"] {
        let judged = factotum_in(
            dir,
            &[
                "--json",
                "skill",
                "eval",
                "skill",
                "--rollouts",
                "3",
                "--seed",
                "1",
                "--policy",
                policy,
            ],
        );
        assert_eq!(judged.code, Some(0), "{}", judged.stderr);
        let document = judged.json();
        assert_eq!(document["success_rate"], 1.0, "{document}");
        assert_eq!(document["violation_rate"], 0.0);
        assert!(document["peak_force_n"].as_f64().unwrap() > 0.0);
        assert!(document["time_to_success_secs"].as_f64().unwrap() > 0.0);
    }

    // Errors of what it believes are felt.
    let under = |error: &[&str]| {
        let arguments = ["--json", "skill", "eval", "skill", "--rollouts", "2"];
        let judged = factotum_in(dir, &[&arguments, error].concat());
        assert_eq!(judged.code, Some(0), "{}", judged.stderr);
        judged.stdout
    };
    let plain = under(&[]);
    for error in [
        ["--pose-error-mm", "3"],
        ["--pose-error-deg", "2"],
        ["--grasp-error-mm", "3"],
        ["--grasp-error-deg", "5"],
    ] {
        assert_ne!(under(&error), plain, "{error:?}");
    }
    let refused = factotum_in(dir, &["skill", "eval", "skill", "--friction", "-1"]);
    assert_eq!(refused.code, Some(2));

    // A policy of one task is none of another.
    let record = dir.join("skill/skill.toml");
    let text = std::fs::read_to_string(&record).unwrap();
    std::fs::write(&record, text.replace("\"lever\"", "\"door\"")).unwrap();
    let other = factotum_in(dir, &["skill", "eval", "skill"]);
    assert_refused(&other, &["policy.safetensors", "`lever`", "`door`"]);
}

#[test]
fn what_cannot_be_trained_is_said_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    assert_refused(&train(dir, &["gate"]), &["`gate`", "door, drawer"]);
    assert_refused(&train(dir, &[]), &["no task"]);
    assert_refused(
        &train(dir, &["door", "--episodes", "0"]),
        &["--episodes is 0"],
    );
    assert_refused(
        &train(dir, &["--resume", "nothing"]),
        &["nothing/skill.toml"],
    );
    let shipped = repository().join("assets/tasks/door.toml");
    let text = std::fs::read_to_string(&shipped).unwrap();
    let models = shipped.parent().unwrap();
    let text = text
        .replace(
            "models/door.xml",
            &models.join("models/door.xml").display().to_string(),
        )
        .replace(
            "../robots/panda",
            &models.join("../robots/panda").display().to_string(),
        );
    let refused = |from: &str, to: &str, words: &[&str]| {
        std::fs::write(dir.join("mine.toml"), text.replace(from, to)).unwrap();
        assert_refused(&train(dir, &["mine.toml", "--out", "mine"]), words);
    };
    refused(
        "joint = \"hinge\"",
        "joint = \"hing\"",
        &["mine.toml", "`hing`", "`hinge`"],
    );
    refused(
        "goal = 0.3",
        "goal = 3.0",
        &["mine.toml", "`goal`", "3", "range"],
    );
    refused(
        "goal = 0.3",
        "gaol = 0.3",
        &["mine.toml", "`gaol`", "`goal`"],
    );
    refused(
        "\"handle\"",
        "\"knob\"",
        &["mine.toml", "`knob`", "`handle`"],
    );
    assert!(
        !dir.join("mine").exists(),
        "nothing is left of a run that never began"
    );
}

#[test]
fn a_motor_skill_begins_with_a_plan_and_options_of_the_other_kind_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let said = train(
        dir,
        &[
            "drawer-heavy",
            "--epochs",
            "1",
            "--rollouts",
            "2",
            "--out",
            "skill",
        ],
    );
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let document = said.json();
    assert_eq!(document["rollouts"], 2);
    assert_eq!(document["init"], "plan");
    let first = document["first"]["object_state"].as_f64().unwrap();
    assert!((0.1..0.285).contains(&first), "{first}");
    let lines = metrics(dir);
    assert_eq!(lines.len(), 2);
    for key in [
        "epoch",
        "rollouts",
        "return",
        "success_rate",
        "object_state",
    ] {
        assert!(lines[1].get(key).is_some(), "{key} in {}", lines[1]);
    }
    let judged = factotum_in(
        dir,
        &["--json", "skill", "eval", "skill", "--video", "seen"],
    );
    assert_eq!(judged.code, Some(0), "{}", judged.stderr);
    assert_eq!(judged.json()["object_state"], lines[1]["object_state"]);
    assert!(dir.join("seen/rollout-1.png").is_file() && dir.join("seen/rollout-1.mcap").is_file());
    let begun = factotum_in(dir, &["--json", "skill", "eval", "skill", "--first"]);
    assert_eq!(begun.code, Some(0), "{}", begun.stderr);
    assert_eq!(begun.json()["object_state"], lines[0]["object_state"]);
    let contact = factotum_in(dir, &["skill", "eval", "movo-door", "--first"]);
    assert_refused(&contact, &["--first", "movo-door"]);

    let contact = train(
        dir,
        &["drawer-heavy", "--ablation", "fast", "--out", "other"],
    );
    assert_refused(&contact, &["drawer-heavy", "--ablation", "--init"]);
    let motor = train(dir, &["door", "--epochs", "3", "--out", "other"]);
    assert_refused(&motor, &["--epochs", "[motor]"]);
    let follows = [
        "door",
        "--init",
        "plan",
        "--ablation",
        "fast",
        "--out",
        "other",
    ];
    assert_refused(&train(dir, &follows), &["--init plan", "`fast`"]);
    let shown = train(dir, &["door", "--init", "demo:a", "--out", "other"]);
    assert_refused(&shown, &["--init demo"]);
    let nobody = train(dir, &["t-ball", "--init", "people", "--out", "other"]);
    assert_refused(&nobody, &["demo:FILE"]);
    let one = train(dir, &["drawer-heavy", "--rollouts", "1", "--out", "other"]);
    assert_refused(&one, &["--rollouts is 1"]);
    let negative = train(
        dir,
        &["drawer-heavy", "--model-error-mm=-1", "--out", "other"],
    );
    assert_refused(&negative, &["--model-error-mm is -1"]);
}

#[test]
fn shipped_skills_are_done_one_after_the_other() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let run = |more: &[&str]| factotum_in(dir, &[&["--json", "skill", "run"], more].concat());
    let said = run(&["door", "slide", "--seed", "1"]);
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let document = said.json();
    let skills = document["skills"].as_array().unwrap();
    let names: Vec<&str> = skills
        .iter()
        .map(|skill| skill["skill"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["door", "slide"]);
    for skill in skills {
        let [at, goal] = ["joint_at_end", "goal"].map(|key| skill[key].as_f64().unwrap());
        assert!(at >= goal, "{skill}");
    }
    // The same seed, the same world.
    assert_eq!(run(&["door", "slide", "--seed", "1"]).json(), document);

    assert_refused(&run(&["lever"]), &["lever", "knob-and-door", "door_1"]);
    assert_refused(&run(&["movo-drawer"]), &["movo-drawer"]);
    assert_refused(&run(&["door", "nothing"]), &["`nothing`", "slide"]);
}

#[test]
fn motions_are_made_by_keys_listed_and_begun_with() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let keys = |keys: &str, file: &str| {
        std::process::Command::new(env!("CARGO_BIN_EXE_factotum"))
            .args(["--json", "demo", "record", "t-ball", "--out", file])
            .current_dir(dir)
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::piped())
            .spawn()
            .and_then(|mut child| {
                use std::io::Write as _;
                child.stdin.take().unwrap().write_all(keys.as_bytes())?;
                child.wait_with_output()
            })
            .unwrap()
    };
    // The first joint by a fifth of a second, twice; the ball stays.
    let made = keys("1]]x]]]", "demos/a.jsonl");
    assert_eq!(made.status.code(), Some(1));
    let listed = factotum_in(dir, &["--json", "demo", "list"]);
    assert_eq!(listed.code, Some(0), "{}", listed.stderr);
    let motion = &listed.json()["motions"][0];
    assert_eq!(motion["task"], "t-ball");
    assert_eq!(motion["success"], false);
    assert!((motion["duration_secs"].as_f64().unwrap() - 0.4).abs() < 1e-9);
    let text = std::fs::read_to_string(dir.join("demos/a.jsonl")).unwrap();
    let turned = |line: Option<&str>| {
        let sample: serde_json::Value = serde_json::from_str(line.unwrap()).unwrap();
        sample["positions"][0].as_f64().unwrap()
    };
    let turned = turned(text.lines().last()) - turned(text.lines().nth(1));
    assert!((0.15..0.3).contains(&turned), "{turned}");

    // It is not written over, it failed, and a broken one is named.
    assert_eq!(keys("x", "demos/a.jsonl").status.code(), Some(2));
    let train = |init: &str| train(dir, &["t-ball", "--init", init, "--out", "other"]);
    assert_refused(&train("demo:demos"), &["none of 1", "--failed-demos"]);
    let replayed = factotum_in(dir, &["--json", "demo", "replay", "demos/a.jsonl"]);
    assert_eq!(replayed.code, Some(0), "{}", replayed.stderr);
    let broken = text.lines().take(3).chain(text.lines().skip(6));
    let broken: Vec<&str> = broken.collect();
    std::fs::write(dir.join("broken.jsonl"), broken.join("\n")).unwrap();
    assert_refused(
        &train("demo:broken.jsonl"),
        &["broken.jsonl", "line 4", "gap"],
    );
    assert_refused(&train("demo:nowhere"), &["nowhere"]);
}

#[test]
fn ways_of_learning_a_motor_skill_are_compared_and_reported() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let run = |experiment: &str| {
        let arguments = [
            "--json",
            "experiment",
            "run",
            experiment,
            "--tasks",
            "t-ball",
        ];
        let more = [
            "--seeds",
            "1",
            "--epochs",
            "1",
            "--workers",
            "2",
            "--out",
            "study",
        ];
        factotum_in(dir, &[&arguments[..], &more].concat())
    };
    let said = run("bootstrap-matrix");
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    assert_eq!(said.json()["n_done"], 5);
    let results = std::fs::read_to_string(dir.join("study/results.jsonl")).unwrap();
    assert_eq!(results.lines().count(), 5, "{results}");
    let report = |experiment: &str| {
        let arguments = [
            "--json",
            "experiment",
            "report",
            experiment,
            "--from",
            "study",
        ];
        factotum_in(dir, &arguments)
    };
    let said = report("bootstrap-matrix");
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let rows = said.json()["table"]["rows"].as_array().unwrap().clone();
    assert_eq!(rows.len(), 5);
    assert!(rows[0]["area_difference"].is_null(), "{}", rows[0]);
    assert!(
        rows[1]["area_difference"]["mean"].is_number(),
        "{}",
        rows[1]
    );
    let figure = std::fs::read_to_string(dir.join("study/returns.svg")).unwrap();
    assert!(figure.contains("cloned network, DAPG"), "{figure}");

    // Results of another question are none of this one.
    let said = run("bootstrap-noise");
    assert_refused(&said, &["bootstrap-matrix", "bootstrap-noise"]);
    let said = report("bootstrap-noise");
    assert_refused(&said, &["plan-dmp-pi2cma", "20mm-5deg"]);
}
