//! `factotum demo`: motions of the arm that a person makes by keys, to begin a motor skill with.

mod keys;

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use factotum_descriptions::{RecordedMotion, TaskSpec};
use factotum_experiments::motor::{MotorError, MotorRig};
use serde_json::{Value, json};

use crate::assets;
use crate::console::{Answer, Console, usage};
use crate::skill::filmed;
use keys::Keyboard;

/// What a recorded motion is called on disk.
const EXTENSION: &str = "jsonl";

/// Arguments of `factotum demo`.
#[derive(Debug, Subcommand)]
pub(crate) enum DemoCommand {
    /// Move the arm by keys, before the object of a task, and keep the motion.
    Record(RecordArgs),
    /// Say what recorded motions a folder holds.
    List(ListArgs),
    /// Play a recorded motion in the simulation again.
    Replay(ReplayArgs),
}

/// Arguments of `factotum demo record`.
#[derive(Debug, Args)]
#[command(after_help = keys::HELP)]
pub(crate) struct RecordArgs {
    /// Task: a task file, or the name of a shipped one.
    task: PathBuf,
    /// File of the motion. Default: the next free `demos/<task>-<n>.jsonl`.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// How it is made, in words; it is kept with the motion.
    #[arg(long, value_name = "WORDS", default_value = "keyboard")]
    made_by: String,
}

/// Arguments of `factotum demo list`.
#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// Folder of motions.
    #[arg(default_value = "demos")]
    dir: PathBuf,
}

/// Arguments of `factotum demo replay`.
#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// The motion.
    file: PathBuf,
    /// Task, if it is not a shipped one of the motion's name.
    #[arg(long, value_name = "TASK")]
    task: Option<PathBuf>,
    /// Leave a picture strip (PNG) and a recording (MCAP, for Foxglove) in this folder.
    #[arg(long, value_name = "DIR")]
    video: Option<PathBuf>,
}

/// Runs `factotum demo`.
pub(crate) fn demo(command: &DemoCommand, console: &Console) -> anyhow::Result<Answer> {
    match command {
        DemoCommand::Record(args) => record(args, console),
        DemoCommand::List(args) => list(args, console),
        DemoCommand::Replay(args) => replay(args, console),
    }
}

fn record(args: &RecordArgs, console: &Console) -> anyhow::Result<Answer> {
    let task = TaskSpec::load(&assets::task(&args.task)?).map_err(usage)?;
    let file = args.out.clone().unwrap_or_else(|| free_name(&task.name));
    if file.exists() {
        return Err(usage(format!(
            "`{}` is there already; choose another file",
            file.display()
        )));
    }
    let cannot =
        |error: std::io::Error| usage(format!("`{}` cannot be written: {error}", file.display()));
    // Before anything is recorded that there is no place for.
    if let Some(dir) = file.parent() {
        std::fs::create_dir_all(dir).map_err(cannot)?;
    }
    let mut rig = MotorRig::new(&task).map_err(of_input)?;
    let mut keyboard = Keyboard::new()?;
    let motion = rig
        .record(&args.made_by, &mut |rig, action| {
            keyboard.jog(rig, action, console)
        })
        .map_err(of_input)?;
    drop(keyboard);
    std::fs::write(&file, motion.to_text()).map_err(cannot)?;
    console.answer(&line_of(&file, &motion), || words_of(&file, &motion))?;
    Ok(Answer::from(motion.head().success))
}

fn free_name(task: &str) -> PathBuf {
    let name = |n: u32| Path::new("demos").join(format!("{task}-{n}.{EXTENSION}"));
    (1..)
        .map(name)
        .find(|file| !file.exists())
        .unwrap_or_default()
}

fn list(args: &ListArgs, console: &Console) -> anyhow::Result<Answer> {
    let files = motion_files(&args.dir)?;
    let mut documents = Vec::new();
    let mut lines = Vec::new();
    for file in &files {
        match RecordedMotion::load(file) {
            Ok(motion) => {
                documents.push(line_of(file, &motion));
                lines.push(words_of(file, &motion));
            }
            Err(error) => {
                documents.push(json!({"file": file, "problem": error.to_string()}));
                lines.push(error.to_string());
            }
        }
    }
    let document = json!({"motions": documents});
    console.answer(&document, || {
        if lines.is_empty() {
            return format!("no motion in `{}`", args.dir.display());
        }
        lines.join("\n")
    })?;
    Ok(Answer::Yes)
}

fn replay(args: &ReplayArgs, console: &Console) -> anyhow::Result<Answer> {
    let motion = RecordedMotion::load(&args.file).map_err(usage)?;
    let name = match &args.task {
        Some(task) => task.clone(),
        None => PathBuf::from(&motion.head().task),
    };
    let task = TaskSpec::load(&assets::task(&name)?).map_err(usage)?;
    let mut rig = MotorRig::new(&task).map_err(of_input)?;
    rig.check_demo(&args.file, &motion).map_err(usage)?;
    let rollout = filmed(args.video.as_deref(), console, |see| {
        rig.replay(&motion, see).map_err(of_input)
    })?;
    let recorded = motion.samples().last().map(|sample| sample.object);
    let document = json!({
        "return": rollout.total_reward,
        "object_state": rollout.object_state,
        "success": rollout.success,
        "recorded_object_state": recorded,
        "recorded_success": motion.head().success,
    });
    console.answer(&document, || {
        format!(
            "{}: return {:.1}, object at {:.3}, in the recording at {:.3}",
            if rollout.success {
                "success"
            } else {
                "no success"
            },
            rollout.total_reward,
            rollout.object_state,
            recorded.unwrap_or_default()
        )
    })?;
    Ok(Answer::Yes)
}

/// The recorded motions at a path: the file, or all in the folder, by name.
pub(crate) fn motion_files(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    if path.is_file() {
        return Ok(vec![path.to_owned()]);
    }
    let entries = std::fs::read_dir(path)
        .map_err(|error| usage(format!("cannot read `{}`: {error}", path.display())))?;
    let mut files = Vec::new();
    for entry in entries {
        let file = entry?.path();
        if file.extension().is_some_and(|found| found == EXTENSION) {
            files.push(file);
        }
    }
    files.sort();
    Ok(files)
}

fn line_of(file: &Path, motion: &RecordedMotion) -> Value {
    let head = motion.head();
    json!({
        "file": file,
        "task": head.task,
        "robot": head.robot,
        "made_by": head.made_by,
        "success": head.success,
        "duration_secs": motion.duration_secs(),
        "object_state": motion.samples().last().map(|sample| sample.object),
    })
}

fn words_of(file: &Path, motion: &RecordedMotion) -> String {
    let head = motion.head();
    format!(
        "`{}`: {}, by {}, {:.1} s, object at {:.3}, {}",
        file.display(),
        head.task,
        head.made_by,
        motion.duration_secs(),
        motion.samples().last().map_or(0.0, |sample| sample.object),
        if head.success {
            "does the task"
        } else {
            "does not do the task"
        }
    )
}

/// Bad input ends with another exit code than a fault of ours.
fn of_input(error: MotorError) -> anyhow::Error {
    if error.is_of_input() {
        usage(error)
    } else {
        error.into()
    }
}
