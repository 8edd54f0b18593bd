//! What survives when the process does not: killed at any moment, or out of room on the disk.
//!
//! The process that dies is this test binary again, told by an environment variable what to do.

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use factotum_geometry::Pose;
use factotum_semantic_map::{Edit, Home, MapError, home_folder};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::home::{execution, new_home, small_grid};
use super::household;

const TASK: &str = "FACTOTUM_TEST_CHILD_TASK";
const FOLDER: &str = "FACTOTUM_TEST_CHILD_FOLDER";

/// Makes the journal entry of that number. It depends on nothing else, so that another process can make the same.
fn make_entry(home: &mut Home, number: i64) -> Result<(), MapError> {
    let when = number as f64;
    match number % 8 {
        3 => home.undo("ada", when).map(drop),
        4 => home.redo("ada", when).map(drop),
        5 => home.record_execution(&execution(), "robot", when).map(drop),
        6 => home
            .edit(
                &Edit::SetMap(small_grid(9, number as usize / 8 % 9)),
                "robot",
                when,
            )
            .map(drop),
        7 => {
            let joints = BTreeMap::from([("toggle".to_owned(), when / 1e6)]);
            home.edit(
                &Edit::SetJoints {
                    name: "light_switch_1".to_owned(),
                    joints,
                },
                "ada",
                when,
            )
            .map(drop)
        }
        _ => {
            let map_from_object = Pose::translation(when, 0.5, 0.3);
            home.edit(
                &Edit::MoveObject {
                    name: "bottle_1".to_owned(),
                    map_from_object,
                },
                "ada",
                when,
            )
            .map(drop)
        }
    }
}

fn n_entries(home: &Home) -> i64 {
    home.history(1).unwrap()[0].id
}

/// The child's part: not a test of its own, so it does nothing when nobody asks.
#[test]
fn child() {
    let Ok(task) = std::env::var(TASK) else {
        return;
    };
    let dir = std::env::var(FOLDER).unwrap();
    let dir = Path::new(&dir);
    let mut stdout = std::io::stdout().lock();
    if task == "create" {
        drop(new_home(dir));
        return;
    }
    let mut home = Home::open(dir, 0.0).unwrap();
    for number in n_entries(&home) + 1.. {
        let before = home.aosm().clone();
        if let Err(error) = make_entry(&mut home, number) {
            assert_eq!(home.aosm(), &before);
            writeln!(stdout, "refused: {error}").unwrap();
            return;
        }
        writeln!(stdout, "accepted {number}").unwrap();
    }
}

fn start(mut command: Command, task: &str, dir: &Path) -> Child {
    command
        .args(["--exact", "crash::child", "--nocapture"])
        .env(TASK, task)
        .env(FOLDER, dir)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn this_binary() -> Command {
    Command::new(std::env::current_exe().unwrap())
}

/// Number of the last entry that the child said was accepted, and its last line.
fn last_accepted(child: &mut Child) -> (i64, String) {
    let mut accepted = 0;
    let mut last = String::new();
    for line in BufReader::new(child.stdout.take().unwrap()).lines() {
        // The harness writes around the child's lines, on the same line at first.
        let line = line.unwrap();
        if let Some((_, number)) = line.split_once("accepted ") {
            accepted = number.parse().unwrap();
        }
        if let Some(at) = line.find("refused") {
            last = line[at..].to_owned();
        }
    }
    (accepted, last)
}

fn text_files(dir: &Path) -> Vec<Vec<u8>> {
    [
        "objects.toml",
        "map.yaml",
        "map.pgm",
        "home.toml",
        "domain.pddl",
    ]
    .map(|file| std::fs::read(dir.join(file)).unwrap())
    .to_vec()
}

/// Makes in `reference` the entries that `home` has, and compares the two.
fn assert_as_if_never_stopped(home: &Home, reference: &mut Home) {
    for number in n_entries(reference) + 1..=n_entries(home) {
        make_entry(reference, number).unwrap();
    }
    assert_eq!(
        home.history(usize::MAX).unwrap(),
        reference.history(usize::MAX).unwrap()
    );
    assert_eq!(home.aosm().objects, reference.aosm().objects);
    assert_eq!(home.aosm().grid, reference.aosm().grid);
    assert_eq!(text_files(home.dir()), text_files(reference.dir()));
}

#[test]
fn killed_at_random_moments_a_home_keeps_every_accepted_edit() {
    let (dir, reference_dir) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    drop(new_home(dir.path()));
    let mut reference = new_home(reference_dir.path());
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut n_kept = 0;
    for round in 0..10 {
        let mut child = start(this_binary(), "edit", dir.path());
        std::thread::sleep(Duration::from_micros(rng.random_range(10_000..200_000)));
        child.kill().unwrap();
        child.wait().unwrap();
        let (accepted, _) = last_accepted(&mut child);
        let home =
            Home::open(dir.path(), 0.0).unwrap_or_else(|error| panic!("round {round}: {error}"));
        let n = n_entries(&home);
        // At most the one entry that was under way may be there without having been accepted.
        assert!(
            accepted == 0 || (accepted..=accepted + 1).contains(&n),
            "{n} entries, {accepted} accepted"
        );
        assert!(n >= n_kept, "{n} entries, {n_kept} before");
        n_kept = n;
        assert_as_if_never_stopped(&home, &mut reference);
    }
    assert!(
        n_kept > 10,
        "only {n_kept} entries in all rounds: the child never got to work"
    );
}

#[test]
fn killed_while_it_is_made_a_home_opens_or_can_be_made_again() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    for _ in 0..10 {
        let dir = tempfile::tempdir().unwrap();
        let mut child = start(this_binary(), "create", dir.path());
        std::thread::sleep(Duration::from_micros(rng.random_range(2_000..60_000)));
        child.kill().unwrap();
        child.wait().unwrap();
        let home = if dir.path().join("journal.sqlite").exists() {
            Home::open(dir.path(), 1.0).unwrap()
        } else {
            new_home(dir.path())
        };
        assert_eq!(home.aosm().objects.len(), household().objects.len());
        assert_eq!(&home_folder::read(dir.path()).unwrap().1, home.aosm());
    }
}

#[test]
fn text_files_that_lag_behind_the_journal_are_written_again() {
    let (dir, copy) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut home = new_home(dir.path());
    let old = text_files(dir.path());
    make_entry(&mut home, 2).unwrap();
    let new = text_files(dir.path());
    assert_ne!(old, new);
    // As a crash right after the transaction leaves it: the journal is ahead, the open journal's log beside it.
    let entries = std::fs::read_dir(dir.path())
        .unwrap()
        .map(|entry| entry.unwrap());
    for entry in entries.filter(|entry| entry.path().is_file()) {
        std::fs::copy(entry.path(), copy.path().join(entry.file_name())).unwrap();
    }
    std::fs::write(copy.path().join("objects.toml"), &old[0]).unwrap();
    let again = Home::open(copy.path(), 3.0).unwrap();
    assert_eq!(again.aosm().objects, home.aosm().objects);
    assert_eq!(
        again.history(9).unwrap(),
        home.history(9).unwrap(),
        "nothing was taken for a change by hand"
    );
    assert_eq!(text_files(copy.path()), new);
}

/// No file of the child can grow beyond a limit, as on a full disk.
#[cfg(unix)]
#[test]
fn without_room_an_edit_is_refused_and_the_accepted_ones_are_kept() {
    let (dir, reference_dir) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    drop(new_home(dir.path()));
    let mut reference = new_home(reference_dir.path());
    let binary = std::env::current_exe().unwrap();
    let mut limited = Command::new("sh");
    // Without the trap the signal of the limit would end the child.
    limited
        .args(["-c", "trap '' XFSZ; ulimit -f 400; exec \"$0\" \"$@\""])
        .arg(binary);
    let mut child = start(limited, "edit", dir.path());
    let (accepted, last) = last_accepted(&mut child);
    assert!(child.wait().unwrap().success());
    assert!(
        last.starts_with("refused: journal `") && last.contains("journal.sqlite"),
        "{last}"
    );
    assert!(accepted > 2, "{accepted}");
    let home = Home::open(dir.path(), 0.0).unwrap();
    assert_eq!(n_entries(&home), accepted);
    assert_as_if_never_stopped(&home, &mut reference);
}
