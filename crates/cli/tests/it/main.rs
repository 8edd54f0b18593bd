//! The program as its user meets it: exit codes, messages that name the thing, one JSON document on standard output.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod bad_input;
mod demonstrated;
mod driven;
mod help;
mod homes;
mod honesty;
mod known_home;
mod planning;
mod remote;
mod resume;
mod runs;
mod skill;
mod small_home;
mod studio;
mod symbols;
mod taught;

use std::path::{Path, PathBuf};
use std::process::Command;

/// What the program said.
struct Said {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Said {
    /// Standard output as the one JSON document it must be.
    fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("{error} in {:?}", self.stdout))
    }
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap()
}

/// Runs the program in the folder `dir`.
fn factotum_in(dir: &Path, arguments: &[&str]) -> Said {
    factotum_with(dir, arguments, &[])
}

/// Runs the program in the folder `dir` with more environment variables.
fn factotum_with(dir: &Path, arguments: &[&str], variables: &[(&str, &Path)]) -> Said {
    let output = Command::new(env!("CARGO_BIN_EXE_factotum"))
        .args(arguments)
        .current_dir(dir)
        .env("FACTOTUM_ASSETS", repository().join("assets"))
        .env("NO_COLOR", "1")
        .env("COLUMNS", "100")
        .envs(variables.iter().copied())
        .output()
        .unwrap();
    Said {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

fn factotum(arguments: &[&str]) -> Said {
    factotum_in(&std::env::temp_dir(), arguments)
}

/// Asserts that the program refused its input with a message that holds all of `words`, and printed nothing else.
#[track_caller]
fn assert_refused(said: &Said, words: &[&str]) {
    assert_eq!(said.code, Some(2), "{}", said.stderr);
    assert_eq!(said.stdout, "");
    for word in words {
        assert!(
            said.stderr.contains(word),
            "no `{word}` in: {}",
            said.stderr
        );
    }
}
