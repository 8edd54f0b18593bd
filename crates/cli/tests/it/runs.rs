//! Runs: a chore from nothing known to the judge's word, an interruption, and what they leave.

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::repository;

/// A run that is asked to stop ends with exit code 1, says why, and leaves a folder in which everything opens.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_a_whole_folder() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let child = Command::new(env!("CARGO_BIN_EXE_factotum"))
        .args([
            "run",
            "--headless",
            "--json",
            "--goal",
            "turn-light-off",
            "--out",
        ])
        .arg(&out)
        .current_dir(dir.path())
        .env("FACTOTUM_ASSETS", repository().join("assets"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The log of events begins with the exploring, when all is set up.
    while !out.join("events.jsonl").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let interrupted = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupted.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(
        output.status.code(),
        Some(1),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );

    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let keys: Vec<&str> = document
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    for key in [
        "achieved",
        "goal",
        "plan",
        "executed",
        "replans",
        "aosm",
        "map_iou",
        "wall_secs",
        "sim_secs",
        "peak_rss_mb",
    ] {
        assert!(keys.contains(&key), "no `{key}` in {keys:?}");
    }
    assert_eq!(document["achieved"], false);
    assert_eq!(document["reason"], "stopped on request");

    let read = |name: &str| {
        std::fs::read(out.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    assert_eq!(
        serde_json::from_slice::<serde_json::Value>(&read("result.json")).unwrap(),
        document
    );
    let manifest: serde_json::Value = serde_json::from_slice(&read("manifest.json")).unwrap();
    assert_eq!(manifest["exit_code"], 1);
    assert!(read("report.html").starts_with(b"<!"));
    const MCAP_MAGIC: &[u8] = b"\x89MCAP0\r\n";
    let recording = read("recording.mcap");
    assert!(recording.starts_with(MCAP_MAGIC) && recording.ends_with(MCAP_MAGIC));
    let shown = crate::factotum_in(&out, &["home", "show", "home", "--json"]);
    assert_eq!(shown.code, Some(0), "{}", shown.stderr);
    assert_eq!(shown.json()["home"], "household");
}

/// The main job: explore, map, plan, act, and be judged by physics, with nothing of the home given.
#[test]
fn the_light_is_turned_off_in_a_home_the_robot_has_never_seen() {
    let dir = tempfile::tempdir().unwrap();
    let said = crate::factotum_in(
        dir.path(),
        &[
            "run",
            "--headless",
            "--json",
            "--goal",
            "turn-light-off",
            "--seed",
            "1",
            "--out",
            "run",
        ],
    );
    let document = said.json();
    assert_eq!(document["achieved"], true, "{document:#}");
    assert_eq!(document["plan"][0]["action"], "turn_off");
    assert!(document["map_iou"].as_f64().unwrap() > 0.8, "{document:#}");
    for kept in [
        "result.json",
        "report.html",
        "recording.mcap",
        "events.jsonl",
        "home/map.pgm",
        "home/objects.toml",
    ] {
        assert!(
            dir.path().join("run").join(kept).is_file(),
            "{kept} is missing"
        );
    }
}
