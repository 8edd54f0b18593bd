//! The developers' door: everything a developer of Factotum runs goes through `cargo x <command>`.
//!
//! `cargo x` is an alias (`.cargo/config.toml`) for this program, so a clone needs nothing but a Rust toolchain to
//! begin; what cargo cannot fetch, [`setup`] does. No product logic lives here.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a command-line program: results on stdout, progress on stderr"
)]

mod bench;
mod check;
mod codegen;
mod licences;
mod peers;
mod process;
mod run;
mod setup;
mod tally;
mod test;
mod tidy;
mod workspace;

use std::process::ExitCode;

use anyhow::{Result, bail};

use crate::workspace::Workspace;

const USAGE: &str = "\
Usage: cargo x <command> [arguments]

  run [ARGS]       build and start `factotum run ARGS`; first fetches what is missing
  test [FILTERS]   run every test: Rust, documentation, page and browser; ends with `N passed, N failed`
  setup            fetch what cargo cannot: MuJoCo's library, the page's packages, a browser, Fast Downward,
                   other makers' robot models
  models           fetch only those models: robosuite's Panda, iiwa and Jaco, pybullet's iiwa (260 MB)
  ci               everything CI runs: check, then test
  check            format, lints, tidy, codegen --check and licences
  tidy             the house rules: dependency direction, invariants of absence, files, documents
  licences         licences, bans and sources of every dependency
  codegen          write the page's protocol types; with --check, only say whether they are up to date
  bench [NAME]     run the benchmarks of every crate, or of the crate NAME
  bench peers NAME compare with programs of others, as JSON: bootstrap, cip (installs several GB)
";

fn main() -> ExitCode {
    match dispatch(std::env::args().skip(1).collect()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(arguments: Vec<String>) -> Result<ExitCode> {
    let workspace = Workspace::find()?;
    let Some((command, rest)) = arguments.split_first() else {
        print!("{USAGE}");
        return Ok(ExitCode::from(2));
    };
    let rest = without_separator(rest);
    match command.as_str() {
        "run" => match run::run(&workspace, rest)? {},
        "test" => return Ok(test::run(&workspace, rest)?.exit_code()),
        "setup" => setup::run(&workspace, setup::Wanted::EVERYTHING)?,
        "models" => setup::run(&workspace, setup::Wanted::MODELS)?,
        "ci" => return ci(&workspace),
        "check" => check::run(&workspace)?,
        "tidy" => tidy::run(&workspace)?,
        "licences" => licences::run(&workspace)?,
        "codegen" => codegen::run(&workspace, rest)?,
        "bench" => match rest.split_first() {
            Some((first, rest)) if first == "peers" => peers::run(&workspace, rest)?,
            _ => bench::run(&workspace, rest)?,
        },
        "help" | "--help" | "-h" => print!("{USAGE}"),
        other => bail!("there is no command `{other}`\n\n{USAGE}"),
    }
    Ok(ExitCode::SUCCESS)
}

/// `cargo x run -- --headless` and `cargo x run --headless` mean the same; cargo's alias hands the `--` on.
fn without_separator(arguments: &[String]) -> &[String] {
    match arguments {
        [separator, rest @ ..] if separator == "--" => rest,
        all => all,
    }
}

/// Runs the checks and the tests, both in any case, so that one report shows all that is wrong.
fn ci(workspace: &Workspace) -> Result<ExitCode> {
    let checks = check::run(workspace);
    let tests = test::run(workspace, &[])?;
    checks?;
    Ok(tests.exit_code())
}

#[cfg(test)]
mod tests {
    use super::without_separator;

    #[test]
    fn the_first_separator_is_cargos() {
        let words = |text: &str| -> Vec<String> { text.split(' ').map(str::to_owned).collect() };
        assert_eq!(without_separator(&words("-- --seed 1")), words("--seed 1"));
        assert_eq!(without_separator(&words("--seed 1")), words("--seed 1"));
        assert_eq!(without_separator(&words("a -- b")), words("a -- b"));
    }
}
