//! `cargo x test`: every test there is, with one true count at the end.
//!
//! Rust's tests go through cargo-nextest where it is installed, else through `cargo test`; documentation tests always
//! through `cargo test`, since nextest does not run them. With arguments, only Rust's tests run, those that the
//! arguments choose (`cargo x test -p factotum-motion shortcut`).

use std::io::IsTerminal as _;
use std::process::Command;

use anyhow::Result;

use crate::process;
use crate::setup::{self, Wanted};
use crate::tally::{Runner, Tally};
use crate::workspace::Workspace;

/// The page's own scripts that test something, in the order in which a failure says most.
const PAGE_SCRIPTS: [&str; 3] = ["check", "test", "test:browser"];

/// Runs the tests and prints the count.
pub(crate) fn run(workspace: &Workspace, arguments: &[String]) -> Result<Tally> {
    let choice = Choice::parse(arguments);
    setup::run(
        workspace,
        if choice.is_all() {
            Wanted::TO_TEST
        } else {
            Wanted::TO_BUILD
        },
    )?;
    let mut sum = rust_tests(workspace, &choice)?;
    if choice.is_all() {
        sum += documentation_tests(workspace)?;
        sum += page_tests(workspace)?;
    }
    println!("{sum}");
    Ok(sum)
}

/// What the arguments choose among Rust's tests.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Choice {
    /// Options for cargo, such as `-p CRATE`.
    options: Vec<String>,
    /// Parts of test names.
    filters: Vec<String>,
}

impl Choice {
    fn parse(arguments: &[String]) -> Self {
        let mut this = Self::default();
        let mut arguments = arguments.iter();
        while let Some(argument) = arguments.next() {
            if argument.starts_with('-') {
                this.options.push(argument.clone());
                if ["-p", "--package", "-E", "--test", "--bin", "--features"]
                    .contains(&argument.as_str())
                {
                    this.options.extend(arguments.next().cloned());
                }
            } else {
                this.filters.push(argument.clone());
            }
        }
        this
    }

    fn is_all(&self) -> bool {
        *self == Self::default()
    }

    fn names_package(&self) -> bool {
        self.options
            .iter()
            .any(|o| o == "-p" || o.starts_with("--package") || o.starts_with("-p="))
    }
}

fn rust_tests(workspace: &Workspace, choice: &Choice) -> Result<Tally> {
    let scope: &[&str] = if choice.names_package() {
        &[]
    } else {
        &["--workspace"]
    };
    if process::find_on_path("cargo-nextest").is_some() {
        let mut command = workspace.cargo(&["nextest", "run", "--no-fail-fast", "--no-tests=pass"]);
        command
            .args(scope)
            .args(&choice.options)
            .args(&choice.filters);
        counted(Runner::Nextest, &mut command)
    } else {
        // Libraries, programs and integration tests; documentation tests have their own turn.
        let mut command = workspace.cargo(&["test", "--no-fail-fast", "--tests"]);
        command
            .args(scope)
            .args(&choice.options)
            .arg("--")
            .args(&choice.filters);
        counted(Runner::Cargo, &mut command)
    }
}

fn documentation_tests(workspace: &Workspace) -> Result<Tally> {
    counted(
        Runner::Cargo,
        &mut workspace.cargo(&["test", "--doc", "--workspace", "--no-fail-fast"]),
    )
}

fn page_tests(workspace: &Workspace) -> Result<Tally> {
    let web = workspace.path("web");
    let Ok(manifest) = std::fs::read_to_string(web.join("package.json")) else {
        return Ok(Tally::default());
    };
    let manifest: serde_json::Value = serde_json::from_str(&manifest)?;
    let scripts = PAGE_SCRIPTS
        .into_iter()
        .filter(|script| manifest["scripts"][script].is_string());
    let mut sum = Tally::default();
    for script in scripts {
        if setup::node().is_none() {
            println!("skipped: the page's `{script}`, for want of Node.js");
            sum += Tally::ONE_SKIPPED;
            continue;
        }
        let mut npm = Command::new("npm");
        npm.args(["run", script]).current_dir(&web);
        match setup::chromium() {
            Some(browser) => {
                npm.env("CHROMIUM", browser);
            }
            None if script == "test:browser" => {
                println!("skipped: the page's `{script}`, for want of a browser");
                sum += Tally::ONE_SKIPPED;
                continue;
            }
            None => {}
        }
        sum += counted(Runner::Page, &mut npm)?;
    }
    Ok(sum)
}

/// Runs a test command and sums the counts it prints; one that prints none counts as a single test, and one that fails
/// without a failed test (it did not build, say) as one failure more.
fn counted(runner: Runner, command: &mut Command) -> Result<Tally> {
    if std::io::stderr().is_terminal() {
        command
            .env("CARGO_TERM_COLOR", "always")
            .env("FORCE_COLOR", "1");
    }
    let mut printed: Option<Tally> = None;
    let status = process::watch(command, |line| {
        if let Some(counts) = Tally::from_line(runner, line) {
            *printed.get_or_insert_default() += counts;
        }
    })?;
    Ok(settled(printed, status.success()))
}

fn settled(printed: Option<Tally>, success: bool) -> Tally {
    let mut counts = printed.unwrap_or(if success {
        Tally::ONE_PASSED
    } else {
        Tally::ONE_FAILED
    });
    if !success && counts.n_failed == 0 {
        counts += Tally::ONE_FAILED;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn arguments_choose_packages_and_names() {
        let choice = Choice::parse(&words("-p factotum-motion shortcut timing"));
        assert_eq!(choice.options, words("-p factotum-motion"));
        assert_eq!(choice.filters, words("shortcut timing"));
        assert!(choice.names_package());
        assert!(!Choice::parse(&words("shortcut")).names_package());
        assert!(Choice::parse(&[]).is_all());
    }

    #[test]
    fn a_command_that_fails_is_never_counted_as_passed() {
        assert_eq!(settled(None, false), Tally::ONE_FAILED);
        assert_eq!(settled(Some(Tally::ONE_PASSED), false).n_failed, 1);
        assert_eq!(settled(Some(Tally::ONE_FAILED), false), Tally::ONE_FAILED);
    }

    #[test]
    fn a_command_without_counts_is_one_test() {
        assert_eq!(settled(None, true), Tally::ONE_PASSED);
        assert_eq!(settled(Some(Tally::default()), true), Tally::default());
    }

    #[test]
    fn counts_are_summed_over_the_lines() {
        let mut command = Command::new("sh");
        command.args(["-c", "echo 'test result: ok. 2 passed; 0 failed'; echo 'test result: ok. 3 passed; 0 failed'"]);
        assert_eq!(
            counted(Runner::Cargo, &mut command).unwrap(),
            Tally {
                n_passed: 5,
                n_failed: 0,
                n_skipped: 0
            }
        );
    }
}
