//! `factotum run --resume`: what the folder of an earlier run says of how to go on.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use factotum_experiments::run_folder::{Manifest, RunFolder};
use factotum_semantic_map::{Aosm, Home, MapError};
use serde_json::Value;

use crate::console::{Answer, Console, usage};
use crate::run::{RESULT_NAME, RunArgs};
use crate::snapshot::Snapshot;

/// Options that a resumed run has from its manifest: giving them again is an error.
pub(crate) const GIVEN_BY_MANIFEST: [&str; 10] = [
    "scene",
    "robot",
    "seed",
    "goal",
    "fault",
    "planner",
    "home",
    "skills",
    "out",
    "no_folder",
];

/// What becomes of a run that is to be resumed.
pub(crate) enum Resumed {
    /// It was finished; there is nothing to do but say so.
    Finished(Answer),
    /// It goes on.
    GoesOn(Box<Earlier>),
}

/// A run that goes on.
pub(crate) struct Earlier {
    /// What it was asked for, with the page and the pace of now.
    pub(crate) args: RunArgs,
    /// Its folder.
    pub(crate) folder: RunFolder,
    /// Its newest whole snapshot; none if it did not get that far.
    pub(crate) before: Option<Snapshot>,
}

/// What a run is asked for, for its manifest. Paths are made to hold from any working directory.
pub(crate) fn options_of(args: &RunArgs) -> anyhow::Result<BTreeMap<String, String>> {
    let path = |path: &Path| -> anyhow::Result<String> {
        let lasting = if path.exists() {
            std::path::absolute(path)?
        } else {
            path.to_owned()
        };
        Ok(lasting.to_string_lossy().into_owned())
    };
    let mut options = BTreeMap::new();
    let mut put = |name: &str, value: String| options.insert(name.to_owned(), value);
    put("scene", path(&args.world.scene)?);
    put("robot", path(&args.world.robot)?);
    put("planner", name_of(args.planner));
    if let Some(goal) = &args.goal {
        put("goal", goal.clone());
    }
    if let Some(fault) = args.fault {
        put("fault", name_of(fault));
    }
    if let Some(home) = &args.home {
        put("home", path(home)?);
    }
    if let Some(skills) = &args.skills {
        put("skills", path(skills)?);
    }
    Ok(options)
}

/// Opens the folder of an earlier run.
pub(crate) fn open(dir: &Path, args: &RunArgs, console: &Console) -> anyhow::Result<Resumed> {
    let folder =
        RunFolder::open(dir).map_err(|error| usage(format!("{:#}", anyhow::Error::from(error))))?;
    let manifest = folder.manifest();
    // A fault of ours is no end: with a better program, or more room on the disk, there is more to be done.
    if let Some(code @ (0 | 1)) = manifest.exit_code.filter(|_| !manifest.stopped) {
        console.say(format_args!(
            "the run in `{}` is finished; there is nothing to resume",
            dir.display()
        ));
        let result = std::fs::read_to_string(folder.file(RESULT_NAME))?;
        let result: Value = serde_json::from_str(&result)?;
        console.answer(&result, || format!("it ended with exit code {code}"))?;
        return Ok(Resumed::Finished(Answer::from(code == 0)));
    }
    let args = arguments(args, manifest, dir)?;
    let (before, problems) = folder.snapshots().newest(Snapshot::from_bytes)?;
    for problem in problems {
        console.say(format_args!("{problem}; falling back to the one before"));
    }
    if before.is_none() {
        console.say(format_args!(
            "`{}` has no snapshot yet: the run begins again",
            dir.display()
        ));
    }
    Ok(Resumed::GoesOn(Box::new(Earlier {
        args,
        folder,
        before,
    })))
}

/// The arguments of the run that the manifest tells of, with the page and the pace of `args`.
fn arguments(args: &RunArgs, manifest: &Manifest, dir: &Path) -> anyhow::Result<RunArgs> {
    let option = |name: &str| manifest.options.get(name);
    let needed = |name: &str| {
        option(name).map(PathBuf::from).ok_or_else(|| {
            usage(format!(
                "the manifest in `{}` has no option `{name}`; it is of a run that cannot be resumed",
                dir.display()
            ))
        })
    };
    let mut args = args.clone();
    args.world.scene = needed("scene")?;
    args.world.robot = needed("robot")?;
    args.world.seed = manifest.seed;
    args.goal = option("goal").cloned();
    args.home = option("home").map(PathBuf::from);
    args.skills = option("skills").map(PathBuf::from);
    args.fault = option("fault")
        .map(|name| value_of(name, dir))
        .transpose()?;
    if let Some(name) = option("planner") {
        args.planner = value_of(name, dir)?;
    }
    Ok(args)
}

fn name_of(value: impl ValueEnum) -> String {
    let value = value.to_possible_value();
    value.map_or_else(String::new, |value| value.get_name().to_owned())
}

fn value_of<T: ValueEnum>(name: &str, dir: &Path) -> anyhow::Result<T> {
    T::from_str(name, false).map_err(|_message| {
        let known: Vec<String> = T::value_variants().iter().cloned().map(name_of).collect();
        usage(format!(
            "the manifest in `{}` names `{name}`, expected one of: {}",
            dir.display(),
            known.join(", ")
        ))
    })
}

/// The home in a run folder: made if there is none, or none that was made whole.
pub(crate) fn open_or_create_home(
    dir: &Path,
    name: &str,
    empty: &Aosm,
    when_secs: f64,
) -> Result<Home, MapError> {
    match Home::create(dir, name, empty, when_secs) {
        Err(MapError::Exists { .. }) => Home::open(dir, when_secs),
        made => made,
    }
}
