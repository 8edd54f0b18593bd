//! Other makers' robot models, in `.deps/robosuite` and `.deps/pybullet`: optional. Tests load them unchanged, and the
//! tutorial on one's own robot mounts one of them on the mobile base.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};

use super::Outcome;
use super::wheel::{self, Wheel};
use crate::workspace::Workspace;

/// A Python package with models in its wheel.
struct Package {
    /// Folder in `.deps`.
    folder: &'static str,
    wheel: Wheel,
    /// Folders of the wheel that are kept; the rest goes.
    kept: &'static [&'static str],
}

const PACKAGES: [Package; 2] = [
    Package {
        folder: "robosuite",
        wheel: Wheel {
            requirement: "robosuite==1.5.2",
            python: "3.12",
            platforms: &["any"],
            sha256: "b9e02df55de8949739de6ba1d196d2ba59cf33c51a76efcfbe5c2f73cdcf99ce",
        },
        kept: &[
            "robosuite/models/assets/robots/panda",
            "robosuite/models/assets/robots/iiwa",
            "robosuite/models/assets/robots/jaco",
            "robosuite/models/assets/grippers",
        ],
    },
    // Its data are the same in every wheel; this one is fetched on any machine.
    Package {
        folder: "pybullet",
        wheel: Wheel {
            requirement: "pybullet==3.2.7",
            python: "3.9",
            platforms: &["manylinux_2_17_x86_64", "manylinux2014_x86_64"],
            sha256: "438a95e9d53af5b2e9bbf7b12e1846485e58532b57580c5290dee305fa8b4a6b",
        },
        kept: &["pybullet_data/kuka_iiwa"],
    },
];

/// Sees to the models; never an error, since nothing but their own tests needs them.
pub(super) fn ensure(workspace: &Workspace) -> Outcome {
    let mut fetched = Vec::new();
    for package in &PACKAGES {
        let place = workspace.deps().join(package.folder);
        if package.kept.iter().all(|kept| place.join(kept).is_dir()) {
            continue;
        }
        if let Err(error) = fetch(package, &place) {
            return Outcome::Missing {
                leaves_out: "the tests that load other makers' robot models skip".to_owned(),
                get: format!("see that pip can reach its package index ({error:#})"),
            };
        }
        fetched.push(package.wheel.requirement);
    }
    if fetched.is_empty() {
        Outcome::Found("those of robosuite 1.5.2 and pybullet 3.2.7 are in .deps".to_owned())
    } else {
        Outcome::Fetched(format!(
            "those of {} fetched into .deps",
            fetched.join(", ")
        ))
    }
}

fn fetch(package: &Package, place: &Path) -> Result<()> {
    let workshop = wheel::workshop(place)?;
    let unpacked = workshop.join("wheel");
    fs::create_dir_all(&unpacked)
        .with_context(|| format!("cannot create {}", unpacked.display()))?;
    wheel::fetch_into(&package.wheel, &unpacked)?;
    for kept in package.kept {
        let (from, to) = (unpacked.join(kept), workshop.join(kept));
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder)
                .with_context(|| format!("cannot create {}", folder.display()))?;
        }
        fs::rename(&from, &to).with_context(|| format!("the wheel has no {kept}"))?;
    }
    fs::remove_dir_all(&unpacked)
        .with_context(|| format!("cannot remove {}", unpacked.display()))?;
    wheel::put_in_place(&workshop, place)
}
