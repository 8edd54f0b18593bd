//! Writes the page's TypeScript types, or with `--check` says whether they are up to date.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a developer's command"
)]

use std::path::Path;
use std::process::ExitCode;

use factotum_protocol::typescript;

fn main() -> ExitCode {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(typescript::PATH);
    let wanted = typescript::module();
    let check = match std::env::args().nth(1).as_deref() {
        None => false,
        Some("--check") => true,
        Some(other) => {
            eprintln!("unknown argument `{other}`; the only one is `--check`");
            return ExitCode::from(2);
        }
    };
    if std::fs::read_to_string(&path).is_ok_and(|found| found == wanted) {
        println!("{} is up to date", typescript::PATH);
        return ExitCode::SUCCESS;
    }
    if check {
        eprintln!(
            "{} is not up to date; run `cargo run -p factotum-protocol --example codegen`",
            typescript::PATH
        );
        return ExitCode::FAILURE;
    }
    let folder = path.parent().unwrap_or(&path);
    match std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, wanted)) {
        Ok(()) => {
            println!("wrote {}", typescript::PATH);
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("cannot write {}: {error}", typescript::PATH);
            ExitCode::FAILURE
        }
    }
}
