//! `cargo x bench`: the benchmarks that lie beside the crates they measure.

use anyhow::{Result, bail};

use crate::process;
use crate::setup::{self, Wanted};
use crate::workspace::Workspace;

/// Runs `cargo bench` for the named crate, or for each crate with a `benches` folder.
pub(crate) fn run(workspace: &Workspace, arguments: &[String]) -> Result<()> {
    setup::run(workspace, Wanted::TO_BUILD)?;
    let with_benches: Vec<String> = workspace
        .crates()?
        .into_iter()
        .map(|member| member.folder)
        .filter(|folder| {
            workspace
                .path("crates")
                .join(folder)
                .join("benches")
                .is_dir()
        })
        .collect();
    let (chosen, rest) = match arguments.split_first() {
        Some((name, rest)) if !name.starts_with('-') => {
            if !with_benches.contains(name) {
                bail!(
                    "crate `{name}` has no benchmarks; those that have: {}",
                    with_benches.join(", ")
                );
            }
            (vec![name.clone()], rest)
        }
        _ => (with_benches, arguments),
    };
    for folder in &chosen {
        let package = format!("factotum-{}", folder.replace('_', "-"));
        process::run(
            workspace
                .cargo(&["bench", "--package", &package, "--bench", "*"])
                .args(rest),
        )?;
    }
    Ok(())
}
