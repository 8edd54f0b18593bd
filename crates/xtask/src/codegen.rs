//! `cargo x codegen`: the page's TypeScript types, written from the `protocol` crate.

use anyhow::Result;

use crate::process;
use crate::workspace::Workspace;

pub(crate) fn run(workspace: &Workspace, arguments: &[String]) -> Result<()> {
    process::run(
        workspace
            .cargo(&[
                "run",
                "--quiet",
                "--package",
                "factotum-protocol",
                "--example",
                "codegen",
                "--",
            ])
            .args(arguments),
    )
}
