//! Counting tests from what the test runners print.
//!
//! | runner | line that is read |
//! |---|---|
//! | cargo-nextest | `Summary [ 1.2s] 12 tests run: 11 passed (1 slow), 1 failed, 2 skipped` |
//! | `cargo test` | `test result: ok. 11 passed; 1 failed; 2 ignored; 0 measured; 0 filtered out; ...` |
//! | Node's test runner | `# pass 11`, `# fail 1`, `# skipped 2`, the first character varying with the reporter |
//! | Vitest | `Tests  1 failed \| 11 passed \| 2 skipped (14)` |
//!
//! Each runner is read for its own lines alone: nextest repeats what a failed test printed, `test result:` included.

use std::fmt;
use std::ops::AddAssign;
use std::process::ExitCode;

/// How many tests there were of each outcome.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) n_passed: u64,
    pub(crate) n_failed: u64,
    pub(crate) n_skipped: u64,
}

/// Who prints the counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Runner {
    /// cargo-nextest.
    Nextest,
    /// `cargo test`.
    Cargo,
    /// The page's scripts, which use Node's runner or Vitest.
    Page,
}

impl Tally {
    pub(crate) const ONE_PASSED: Self = Self {
        n_passed: 1,
        n_failed: 0,
        n_skipped: 0,
    };
    pub(crate) const ONE_FAILED: Self = Self {
        n_passed: 0,
        n_failed: 1,
        n_skipped: 0,
    };
    pub(crate) const ONE_SKIPPED: Self = Self {
        n_passed: 0,
        n_failed: 0,
        n_skipped: 1,
    };

    pub(crate) fn exit_code(self) -> ExitCode {
        if self.n_failed == 0 {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        }
    }

    /// The counts in one line of a runner's output, if it is a line with counts.
    pub(crate) fn from_line(runner: Runner, line: &str) -> Option<Self> {
        let line = line.trim();
        match runner {
            Runner::Nextest => {
                let (_, counts) = line.strip_prefix("Summary [")?.split_once(" run: ")?;
                Some(Self::from_counts(counts))
            }
            Runner::Cargo => line.strip_prefix("test result:").map(Self::from_counts),
            Runner::Page => line
                .strip_prefix("Tests ")
                .filter(|rest| rest.ends_with(')'))
                .map(Self::from_counts)
                .or_else(|| Self::from_node_line(line)),
        }
    }

    /// Sums `N passed`, `N failed`, `N timed out`, `N skipped` and `N ignored` in a list with any separators.
    fn from_counts(counts: &str) -> Self {
        let mut tally = Self::default();
        for part in counts.split([',', ';', '|', '.']) {
            let mut words = part.split_whitespace();
            let (Some(Ok(number)), Some(word)) =
                (words.next().map(str::parse::<u64>), words.next())
            else {
                continue;
            };
            match word {
                "passed" => tally.n_passed += number,
                "failed" | "timed" => tally.n_failed += number,
                "skipped" | "ignored" => tally.n_skipped += number,
                _ => {}
            }
        }
        tally
    }

    fn from_node_line(line: &str) -> Option<Self> {
        let mut words = line.strip_prefix(['#', 'ℹ'])?.split_whitespace();
        let (word, number) = (words.next()?, words.next()?.parse().ok()?);
        let none = Self::default();
        match word {
            "pass" => Some(Self {
                n_passed: number,
                ..none
            }),
            "fail" | "cancelled" => Some(Self {
                n_failed: number,
                ..none
            }),
            "skipped" => Some(Self {
                n_skipped: number,
                ..none
            }),
            _ => None,
        }
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.n_passed += other.n_passed;
        self.n_failed += other.n_failed;
        self.n_skipped += other.n_skipped;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} passed, {} failed", self.n_passed, self.n_failed)?;
        if self.n_skipped > 0 {
            write!(f, ", {} skipped", self.n_skipped)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(runner: Runner, line: &str, n_passed: u64, n_failed: u64, n_skipped: u64) {
        let tally = Tally {
            n_passed,
            n_failed,
            n_skipped,
        };
        assert_eq!(Tally::from_line(runner, line), Some(tally), "{line}");
    }

    #[test]
    fn each_runners_counts_are_read() {
        use Runner::{Cargo, Nextest, Page};
        check(
            Nextest,
            "     Summary [   1.204s] 12 tests run: 11 passed (1 slow), 1 failed, 2 skipped",
            11,
            1,
            2,
        );
        check(
            Nextest,
            "     Summary [   0.010s] 1 test run: 1 passed, 0 skipped",
            1,
            0,
            0,
        );
        check(
            Nextest,
            "     Summary [  60.0s] 5 tests run: 3 passed, 1 failed, 1 timed out, 0 skipped",
            3,
            2,
            0,
        );
        check(
            Nextest,
            "     Summary [   9.9s] 4/5 tests run: 3 passed, 1 failed, 0 skipped",
            3,
            1,
            0,
        );
        check(
            Cargo,
            "test result: ok. 7 passed; 0 failed; 3 ignored; 0 measured; 0 filtered out",
            7,
            0,
            3,
        );
        check(
            Cargo,
            "test result: FAILED. 7 passed; 2 failed; 0 ignored; 0 measured",
            7,
            2,
            0,
        );
        check(Page, "# pass 4", 4, 0, 0);
        check(Page, "ℹ fail 1", 0, 1, 0);
        check(
            Page,
            "      Tests  1 failed | 11 passed | 2 skipped (14)",
            11,
            1,
            2,
        );
    }

    #[test]
    fn what_a_failed_test_printed_is_not_counted_again() {
        let repeated = "    test result: FAILED. 0 passed; 1 failed; 0 ignored";
        assert_eq!(Tally::from_line(Runner::Nextest, repeated), None);
    }

    #[test]
    fn other_lines_are_not_counts() {
        for (runner, line) in [
            (Runner::Nextest, ""),
            (
                Runner::Nextest,
                "PASS [ 0.1s] factotum-geometry poses_compose",
            ),
            (Runner::Cargo, "error: test failed, to rerun pass `--lib`"),
            (Runner::Page, "# tests 4"),
            (Runner::Page, "Test Files  1 passed (1)"),
        ] {
            assert_eq!(Tally::from_line(runner, line), None, "{line}");
        }
    }

    #[test]
    fn the_summary_names_skipped_tests_only_when_there_are_some() {
        let mut sum = Tally::ONE_PASSED;
        sum += Tally::ONE_FAILED;
        assert_eq!(sum.to_string(), "1 passed, 1 failed");
        sum += Tally::ONE_SKIPPED;
        assert_eq!(sum.to_string(), "1 passed, 1 failed, 1 skipped");
    }
}
