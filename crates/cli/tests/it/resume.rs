//! Runs that are killed, run out of disk, and go on; and the day after.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, SystemTime};

use factotum_semantic_map::{Entry, EntryKind, Execution, Home};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::{Said, assert_refused, factotum_in, repository};

const GOAL: [&str; 6] = [
    "--headless",
    "--json",
    "--goal",
    "turn-light-off",
    "--seed",
    "1",
];

/// Starts the program in `dir` and lets it run; `shell` is what a shell is to do before.
fn start(dir: &Path, shell: &str, arguments: &[&str]) -> Child {
    Command::new("sh")
        .args(["-c", &format!("{shell} exec \"$0\" \"$@\"")])
        .arg(env!("CARGO_BIN_EXE_factotum"))
        .args(arguments)
        .current_dir(dir)
        .env("FACTOTUM_ASSETS", repository().join("assets"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn said_by(mut child: Child) -> Said {
    let (mut stdout, mut stderr) = (String::new(), String::new());
    // Little is said on standard output before the end: reading one after the other cannot block.
    let pipes = (child.stderr.take().unwrap(), child.stdout.take().unwrap());
    { pipes.0 }.read_to_string(&mut stderr).unwrap();
    { pipes.1 }.read_to_string(&mut stdout).unwrap();
    Said {
        code: child.wait().unwrap().code(),
        stdout,
        stderr,
    }
}

/// Waits until `is_so`, or the child has ended; the answer is whether it still runs.
fn wait_until(child: &mut Child, is_so: impl Fn() -> bool) -> bool {
    while child.try_wait().unwrap().is_none() {
        if is_so() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    false
}

fn n_lines(file: &Path) -> usize {
    std::fs::read_to_string(file).map_or(0, |text| text.lines().count())
}

/// The newest snapshot.
fn newest_snapshot(run: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(run.join("snapshots")).ok()?;
    let files = entries.map(|entry| entry.unwrap().path());
    files
        .filter(|file| file.extension().is_some_and(|e| e == "snapshot"))
        .max()
}

/// The journal of a home that a dead process left, in order; it must hold all that it held `before`.
fn whole_journal(home: &Path, before: &[Entry]) -> Vec<Entry> {
    if !home.join("journal.sqlite").exists() {
        assert!(before.is_empty());
        return Vec::new();
    }
    let when_secs = SystemTime::UNIX_EPOCH.elapsed().unwrap().as_secs_f64();
    let home = Home::open(home, when_secs).unwrap();
    let mut entries = home.history(usize::MAX).unwrap();
    entries.reverse();
    for (entry, number) in entries.iter().zip(1..) {
        assert_eq!(entry.id, number);
    }
    assert!(entries.starts_with(before), "{before:?}, now {entries:?}");
    entries
}

/// Every step that the result tells of is in the journal, in that order; steps that were undone by a kill may be between.
fn assert_journaled(journal: &[Entry], document: &serde_json::Value) {
    let mut executions = journal.iter().filter_map(|entry| match &entry.kind {
        EntryKind::Execution(execution) => Some(execution),
        _ => None,
    });
    for step in document["executed"].as_array().unwrap() {
        let is_it = |execution: &Execution| {
            step["action"] == execution.step.name && step["outcome"] == execution.outcome
        };
        assert!(executions.any(is_it), "{step} is not in {journal:#?}");
    }
}

/// One run, hindered in every way: first by a full disk, then killed at ten random moments, once with its newest
/// snapshot spoilt. Each time it goes on, and in the end its light is off. Then comes another day.
#[cfg(unix)]
#[test]
fn a_run_that_is_killed_again_and_again_goes_on_and_a_second_day_follows() {
    let dir = tempfile::tempdir().unwrap();
    let run = dir.path().join("run");
    let home = run.join("home");
    let mut journal = run_out_of_disk(dir.path());

    let resume = ["run", "--headless", "--json", "--resume", "run"];
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for round in 0..10 {
        let before = newest_snapshot(&run);
        if round == 5 {
            let file = before.as_ref().unwrap();
            let len = std::fs::metadata(file).unwrap().len();
            let cut = std::fs::File::options().write(true).open(file).unwrap();
            cut.set_len(rng.random_range(0..len)).unwrap();
        }
        let mut child = start(dir.path(), "", &resume);
        // While it starts or after some progress. There must be something to spoil, and time to say that it is spoilt.
        if round < 2 || round == 5 || rng.random_bool(0.7) {
            wait_until(&mut child, || newest_snapshot(&run) > before);
        }
        std::thread::sleep(Duration::from_millis(rng.random_range(0..1500)));
        child.kill().unwrap();
        let said = said_by(child);
        if round == 5 {
            assert!(
                said.stderr.contains(".snapshot` is damaged"),
                "{}",
                said.stderr
            );
            assert!(said.stderr.contains("falling back"), "{}", said.stderr);
        }
        journal = whole_journal(&home, &journal);
    }
    let said = factotum_in(dir.path(), &resume);
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let document = said.json();
    assert_eq!(document["achieved"], true, "{document:#}");
    assert_eq!(document["plan"][0]["action"], "turn_off");
    assert!(document["resumed"].as_u64().unwrap() > 1, "{document:#}");
    assert!(document["map_iou"].as_f64().unwrap() > 0.8, "{document:#}");
    journal = whole_journal(&home, &journal);
    assert_journaled(&journal, &document);
    let report = std::fs::read_to_string(run.join("report.html")).unwrap();
    assert!(report.contains("Resumed"));

    let again = factotum_in(dir.path(), &resume);
    assert_eq!(again.code, Some(0));
    assert!(again.stderr.contains("is finished"), "{}", again.stderr);
    assert_eq!(again.json(), document);

    live_another_day(dir.path(), &journal);
}

/// No file can grow beyond what the first seconds of a recording need; answers the journal of the home that is left.
fn run_out_of_disk(dir: &Path) -> Vec<Entry> {
    let run = dir.join("run");
    let arguments = [&["run"], &GOAL[..], &["--out", "run"]].concat();
    // Without the trap the signal of the limit would end the program.
    let mut child = start(dir, "trap '' XFSZ; ulimit -f 400;", &arguments);
    let is_under_way = wait_until(&mut child, || n_lines(&run.join("events.jsonl")) >= 2);
    assert!(is_under_way, "{}", said_by(child).stderr);
    let interrupted = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupted.unwrap().success());
    let said = said_by(child);
    assert_eq!(said.code, Some(3), "{}", said.stderr);
    for word in [
        "recording.mcap",
        "0001.snapshot",
        "the run folder is not whole",
    ] {
        assert!(
            said.stderr.contains(word),
            "no `{word}` in: {}",
            said.stderr
        );
    }
    assert_eq!(said.json()["reason"], "stopped on request");
    whole_journal(&run.join("home"), &[])
}

/// From the home that is known the robot turns the light off again, without exploring.
fn live_another_day(dir: &Path, journal: &[Entry]) {
    let arguments = [
        &["run"],
        &GOAL[..],
        &["--home", "run/home", "--out", "day2"],
    ]
    .concat();
    let said = factotum_in(dir, &arguments);
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    assert!(said.stderr.contains("I am at ("), "{}", said.stderr);
    assert!(!said.stderr.contains("exploring"), "{}", said.stderr);
    let document = said.json();
    assert_eq!(document["achieved"], true, "{document:#}");
    assert!(document["map_iou"].as_f64().unwrap() > 0.8, "{document:#}");
    let n_before = journal.len();
    let journal = whole_journal(&dir.join("run/home"), journal);
    assert_journaled(&journal[n_before..], &document);
    assert!(!dir.join("day2/home").exists());
    let said = factotum_in(dir, &["home", "check", "run/home"]);
    assert_eq!(said.code, Some(0), "{}", said.stderr);
}

#[test]
fn a_robot_that_cannot_find_itself_says_so() {
    let dir = tempfile::tempdir().unwrap();
    crate::homes::write_map(dir.path());
    factotum_in(
        dir.path(),
        &["map", "import", "house.yaml", "--out", "home"],
    );
    let files = |file: &str| std::fs::read(dir.path().join("home").join(file)).unwrap();
    let before = files("objects.toml");
    let arguments = [&["run"], &GOAL[..], &["--home", "home", "--no-folder"]].concat();
    let said = factotum_in(dir.path(), &arguments);
    assert_eq!(said.code, Some(1), "{}", said.stderr);
    let document = said.json();
    assert_eq!(document["achieved"], false);
    let reason = document["reason"].as_str().unwrap();
    assert!(
        reason.starts_with("cannot find myself in the map: "),
        "{reason}"
    );
    assert_eq!(files("objects.toml"), before);
}

#[test]
fn a_resumed_run_is_not_told_again_what_to_do() {
    for given in [
        ["--seed", "3"],
        ["--goal", "turn-light-off"],
        ["--scene", "household"],
    ] {
        let said = factotum_in(
            &std::env::temp_dir(),
            &[&["run", "--resume", "run"], &given[..]].concat(),
        );
        assert_refused(&said, &["--resume", given[0]]);
    }
}

#[test]
fn what_is_no_run_folder_or_no_home_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let said = factotum_in(dir.path(), &["run", "--headless", "--resume", "nowhere"]);
    assert_refused(&said, &["nowhere/manifest.json"]);
    let said = factotum_in(dir.path(), &["run", "--headless", "--home", "nowhere"]);
    assert_refused(&said, &["nowhere/home.toml", "map explore"]);
    assert!(!dir.path().join("runs").exists(), "a run was begun");
}
