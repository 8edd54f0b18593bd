//! Bad input: exit code 2 and a message that names what was found and what was wanted.

use std::path::{Path, PathBuf};

use crate::{assert_refused, factotum, factotum_in, repository};

#[test]
fn an_unknown_goal_is_named_with_those_there_are() {
    let said = factotum(&["run", "--headless", "--no-folder", "--goal", "wash-car"]);
    assert_refused(
        &said,
        &[
            "wash-car",
            "throw-away-bottle",
            "turn-light-off",
            "close-faucet",
        ],
    );
}

#[test]
fn an_unknown_scene_or_robot_is_named_with_those_there_are() {
    let said = factotum(&["run", "--headless", "--no-folder", "--scene", "castle"]);
    assert_refused(&said, &["scene `castle`", "household"]);
    let said = factotum(&["run", "--headless", "--no-folder", "--robot", "r2d2"]);
    assert_refused(&said, &["robot `r2d2`", "movo", "panda"]);
}

/// The panda's folder in `dir`, to be spoiled. Its model includes the hand's, from the folder beside it.
fn panda_in(dir: &Path) -> PathBuf {
    for robot in ["panda", "franka_hand"] {
        std::fs::create_dir(dir.join(robot)).unwrap();
        for entry in std::fs::read_dir(repository().join("assets/robots").join(robot))
            .unwrap()
            .flatten()
        {
            std::fs::copy(entry.path(), dir.join(robot).join(entry.file_name())).unwrap();
        }
    }
    dir.join("panda")
}

/// Asserts that both who checks and who uses the robot refuse it.
#[track_caller]
fn assert_robot_refused(robot: &Path, words: &[&str]) {
    let robot = robot.to_str().unwrap();
    assert_refused(&factotum(&["robot", "check", robot]), words);
    let run = ["run", "--headless", "--no-folder", "--robot", robot];
    assert_refused(&factotum(&run), words);
}

#[test]
fn a_joint_that_the_model_lacks_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let panda = panda_in(dir.path());
    let file = panda.join("robot.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("\"joint4\"", "\"elbow\"")).unwrap();
    let words = [
        panda.to_str().unwrap(),
        "joint `elbow` is not in model `panda`",
        "available: `joint1`, `joint2`",
    ];
    assert_robot_refused(&panda, &words);
}

#[test]
fn a_broken_model_is_named_with_the_line() {
    let dir = tempfile::tempdir().unwrap();
    let panda = panda_in(dir.path());
    let file = panda.join("panda.xml");
    let text = std::fs::read_to_string(&file).unwrap();
    let (whole, _) = text.split_once("</worldbody>").unwrap();
    std::fs::write(&file, whole).unwrap();
    assert_robot_refused(
        &panda,
        &[
            "panda/panda.xml cannot be read: line ",
            "is not well-formed XML",
        ],
    );
    std::fs::remove_file(&file).unwrap();
    assert_robot_refused(&panda, &["panda/panda.xml cannot be read", "No such file"]);
}

#[test]
fn a_speed_out_of_range_is_refused() {
    for speed in ["-1", "1e-25", "inf"] {
        let option = format!("--speed={speed}");
        let said = factotum(&["run", "--headless", "--no-folder", &option]);
        assert_refused(&said, &["--speed is", "expected 0 or 0.05 to 1000"]);
    }
}

#[test]
fn a_robot_that_cannot_drive_and_see_gets_no_chores() {
    let said = factotum(&["run", "--headless", "--no-folder", "--robot", "panda"]);
    assert_refused(
        &said,
        &[
            "robot `panda` has no",
            "a mobile base, a lidar and a camera",
        ],
    );
}

#[test]
fn a_run_folder_in_use_is_not_taken() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("thesis.txt"), "years of work").unwrap();
    let said = factotum(&["run", "--headless", "--out", dir.path().to_str().unwrap()]);
    assert_refused(&said, &["not empty"]);
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn a_sweep_folder_of_another_command_is_not_taken() {
    let dir = tempfile::tempdir().unwrap();
    let other = r#"{"arguments": ["run", "--headless", "--json", "--no-folder", "--goal", "close-faucet"]}"#;
    std::fs::write(dir.path().join("sweep.json"), other).unwrap();
    let out = dir.path().to_str().unwrap();
    let goal = ["--goal", "turn-light-off"];
    let arguments = [&["experiment", "run", "chores", "--out", out], &goal[..]].concat();
    assert_refused(
        &factotum(&arguments),
        &[
            "there `--goal close-faucet`, here `--goal turn-light-off`",
            "another folder",
        ],
    );
}

#[test]
fn cells_of_no_task_or_setting_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("grid");
    let run = [
        "experiment",
        "run",
        "cip-ablation",
        "--out",
        out.to_str().unwrap(),
    ];
    let check = |more: &[&str], wanted: &[&str]| {
        assert_refused(&factotum(&[&run[..], more].concat()), wanted);
        assert!(!out.exists());
    };
    check(
        &["--tasks", "door,windows"],
        &["task `windows`", "shipped: door, drawer"],
    );
    check(
        &["--tasks", "rooms/door"],
        &["found `rooms/door`", "name of a shipped task"],
    );
    check(
        &["--settings", "cip,slow"],
        &["'slow'", "unstructured", "fast"],
    );
    check(&["--seeds", "0"], &["--seeds is 0"]);
}

#[test]
fn a_skill_that_was_not_learned_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("trials");
    let [skills, out_arg] = [dir.path(), &out].map(|path| path.to_str().unwrap());
    let run = ["experiment", "run", "cip-robustness", "--skills", skills];
    let wanted = [
        "door-cip-100/policy.safetensors",
        "door cip seed 100",
        "cip-ablation",
    ];
    assert_refused(
        &factotum(&[&run[..], &["--out", out_arg]].concat()),
        &wanted,
    );
    assert!(!out.exists());
}

#[test]
fn a_report_of_a_corrupt_line_names_it() {
    let dir = tempfile::tempdir().unwrap();
    let from = dir.path().to_str().unwrap();
    let report = ["experiment", "report", "cip-ablation", "--from", from];
    assert_refused(&factotum(&report), &["cannot read", "results.jsonl"]);
    std::fs::write(dir.path().join("results.jsonl"), "{\"task\": \"door\"}\n").unwrap();
    assert_refused(
        &factotum(&report),
        &["results.jsonl", "line 1", "missing field"],
    );
}

#[test]
fn a_map_cut_short_is_named() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("map.pgm"), b"P5\n4 4\n255\n\xfe\xfe\x00").unwrap();
    std::fs::write(
        dir.path().join("map.yaml"),
        "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
    )
    .unwrap();
    let said = factotum_in(dir.path(), &["map", "import", "map.yaml", "--out", "home"]);
    assert_refused(
        &said,
        &["map.pgm", "truncated", "found 3 bytes", "wanted 16 (4 x 4"],
    );
    assert!(!dir.path().join("home/home.toml").exists());
}

#[test]
fn a_folder_that_is_no_home_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let said = factotum_in(dir.path(), &["home", "check", "nowhere"]);
    assert_refused(&said, &["nowhere"]);
}
