//! Motor skills on the command line: learned from the robot's own plan, or from nothing, and looked at.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, ValueEnum};
use factotum_descriptions::{MotorPolicy, RecordedMotion, TaskSpec};
use factotum_experiments::motor::{
    EpochRecord, Init, MotorError, MotorFolder, MotorRecord, MotorRig, MotorTraining, SearchName,
    demos_to_begin_with,
};
use factotum_skills::bootstrap::PlannedDemo;
use serde_json::json;

use super::video::filmed;
use super::{TrainArgs, load_task};
use crate::assets;
use crate::console::{Answer, Console, tell, usage};
use crate::demo::motion_files;

/// What a motor skill is learned with.
#[derive(Debug, Args)]
#[command(
    next_help_heading = "Motor skills (tasks with a table `[motor]`); --init for contact skills, too"
)]
pub(super) struct MotorArgs {
    /// Where the first policy is from: `plan`, the robot's own motion plan, made from kinematics alone; `random`, random
    /// weights; `demo:FILE`, a recorded motion, or `demo:DIR`, all of a folder [default: plan; contact skills: random].
    #[arg(long, value_name = "plan|random|demo:FILE")]
    init: Option<InitArg>,
    /// Recorded motions that do not do the task count, too.
    #[arg(long)]
    failed_demos: bool,
    /// Form of the policy [default: the task's].
    #[arg(long, value_enum)]
    policy: Option<PolicyForm>,
    /// How it is improved [default: pi2cma for dmp; dapg for mlp from a plan, npg from random weights].
    #[arg(long, value_enum)]
    search: Option<SearchForm>,
    /// Updates of the policy [default: 40 for dmp, 10 for mlp].
    #[arg(long, value_name = "N")]
    epochs: Option<u64>,
    /// Rollouts for each update [default: 10 for dmp, 20 for mlp].
    #[arg(long, value_name = "N")]
    rollouts: Option<u32>,
    /// Standard deviation of the error of the object's position and of its joint's origin, for the plan [default: 0].
    #[arg(long, value_name = "MM")]
    model_error_mm: Option<f64>,
    /// Standard deviation of the error of its joint's axis, for the plan [default: 0].
    #[arg(long, value_name = "DEG")]
    model_error_deg: Option<f64>,
}

/// Where a first policy can be from.
#[derive(Debug, Clone, PartialEq, Eq)]
enum InitArg {
    Plan,
    Random,
    Demo(PathBuf),
}

impl FromStr for InitArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "plan" => Ok(Self::Plan),
            "random" => Ok(Self::Random),
            _ => match text.strip_prefix("demo:") {
                Some(file) if !file.is_empty() => Ok(Self::Demo(file.into())),
                _ => Err("expected `plan`, `random` or `demo:FILE`".to_owned()),
            },
        }
    }
}

/// Forms of a policy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PolicyForm {
    /// A movement primitive for each joint.
    Dmp,
    /// A Gaussian whose mean is a network.
    Mlp,
}

/// Ways to improve one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SearchForm {
    /// PI²-CMA, for dmp.
    Pi2cma,
    /// Natural policy gradient, for mlp.
    Npg,
    /// The same with the demonstrations at its side, for mlp.
    Dapg,
}

impl From<PolicyForm> for MotorPolicy {
    fn from(form: PolicyForm) -> Self {
        match form {
            PolicyForm::Dmp => Self::Dmp,
            PolicyForm::Mlp => Self::Mlp,
        }
    }
}

impl From<SearchForm> for SearchName {
    fn from(form: SearchForm) -> Self {
        match form {
            SearchForm::Pi2cma => Self::Pi2cma,
            SearchForm::Npg => Self::Npg,
            SearchForm::Dapg => Self::Dapg,
        }
    }
}

impl MotorArgs {
    /// Whether a contact skill is to begin with the robot's own plan.
    pub(super) fn contact_plan(&self) -> anyhow::Result<bool> {
        match &self.init {
            None | Some(InitArg::Random) => Ok(false),
            Some(InitArg::Plan) => Ok(true),
            Some(InitArg::Demo(_)) => Err(usage(
                "--init demo is for motor skills; a contact skill begins with `plan` or `random`",
            )),
        }
    }

    /// The first option that was given and is for motor skills alone.
    fn given(&self) -> Option<&'static str> {
        [
            ("--failed-demos", self.failed_demos),
            ("--policy", self.policy.is_some()),
            ("--search", self.search.is_some()),
            ("--epochs", self.epochs.is_some()),
            ("--rollouts", self.rollouts.is_some()),
            ("--model-error-mm", self.model_error_mm.is_some()),
            ("--model-error-deg", self.model_error_deg.is_some()),
        ]
        .into_iter()
        .find_map(|(name, is_given)| is_given.then_some(name))
    }
}

/// A motor skill to be learned.
#[derive(Debug)]
pub(super) struct MotorRun {
    folder: MotorFolder,
    record: MotorRecord,
    recorded: Vec<RecordedMotion>,
    task: TaskSpec,
    n_epochs: u64,
    resume: bool,
}

/// Whether a folder holds a motor skill.
pub(super) fn is_motor_skill(dir: &Path) -> bool {
    MotorFolder::at(dir).has_record()
}

/// What to learn, if it is a motor skill.
pub(super) fn motor_run(args: &TrainArgs) -> anyhow::Result<Option<MotorRun>> {
    let motor = &args.motor;
    let (folder, record, recorded, task) = match (&args.resume, &args.task) {
        (Some(dir), _) => {
            let folder = MotorFolder::at(dir);
            if !folder.has_record() {
                return no_motor(args, "the skill is a contact skill");
            }
            let record = folder.record().map_err(usage)?;
            let task = load_task(&record.task)?;
            (folder, record, Vec::new(), task)
        }
        (None, Some(name)) => {
            let task = load_task(name)?;
            let Some(spec) = &task.motor else {
                return no_motor(args, "the task has no table `[motor]`");
            };
            let policy = motor.policy.map_or(spec.policy, MotorPolicy::from);
            let (init, recorded) = match &motor.init {
                None | Some(InitArg::Plan) => (Init::Plan, Vec::new()),
                Some(InitArg::Random) => (Init::Random, Vec::new()),
                Some(InitArg::Demo(path)) => {
                    (Init::Demo, recorded(path, &task, motor.failed_demos)?)
                }
            };
            let dir = args.out.clone().unwrap_or_else(|| {
                let stem = name.file_stem().unwrap_or_default().to_string_lossy();
                PathBuf::from("skills").join(format!("{stem}-{}-{}", init.name(), args.seed))
            });
            let usual = MotorRecord::new(assets::task_name(name)?, init, policy, args.seed);
            let record = MotorRecord {
                search: motor.search.map_or(usual.search, SearchName::from),
                rollouts: motor.rollouts.unwrap_or(usual.rollouts),
                model_error_m: 1e-3 * at_least_zero("--model-error-mm", motor.model_error_mm)?,
                model_error_rad: at_least_zero("--model-error-deg", motor.model_error_deg)?
                    .to_radians(),
                ..usual
            };
            (MotorFolder::at(&dir), record, recorded, task)
        }
        (None, None) => return Ok(None),
    };
    if args.ablation.is_some() || args.episodes.is_some() || args.as_in_the_code {
        return Err(usage(format!(
            "task `{}` is a motor skill; --ablation, --episodes and --as-in-the-code are for contact skills, --init, \
             --epochs and --rollouts for this one",
            task.name
        )));
    }
    /// Every rollout of an epoch is kept until its end.
    const ROLLOUTS: std::ops::RangeInclusive<u32> = 2..=10_000;
    if !ROLLOUTS.contains(&record.rollouts) {
        return Err(usage(format!(
            "--rollouts is {}, expected {} to {}",
            record.rollouts,
            ROLLOUTS.start(),
            ROLLOUTS.end()
        )));
    }
    Ok(Some(MotorRun {
        n_epochs: motor.epochs.unwrap_or(record.usual_epochs()),
        folder,
        record,
        recorded,
        task,
        resume: args.resume.is_some(),
    }))
}

/// The recorded motions at a path to begin with.
fn recorded(path: &Path, task: &TaskSpec, failed_too: bool) -> anyhow::Result<Vec<RecordedMotion>> {
    let rig = MotorRig::new(task).map_err(of_input)?;
    let mut motions = Vec::new();
    for file in motion_files(path)? {
        let motion = RecordedMotion::load(&file).map_err(usage)?;
        // A folder may hold those of other tasks, too.
        if path.is_file() || motion.head().task == task.name {
            rig.check_demo(&file, &motion).map_err(usage)?;
            motions.push(motion);
        }
    }
    demos_to_begin_with(motions, failed_too).map_err(usage)
}

fn no_motor(args: &TrainArgs, why: &str) -> anyhow::Result<Option<MotorRun>> {
    match args.motor.given() {
        Some(option) => Err(usage(format!("{option} is for motor skills, but {why}"))),
        None => Ok(None),
    }
}

fn at_least_zero(name: &str, value: Option<f64>) -> anyhow::Result<f64> {
    let value = value.unwrap_or(0.0);
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(usage(format!(
        "{name} is {value}, expected a finite number of at least 0"
    )))
}

impl MotorRun {
    /// Learns it.
    pub(super) fn train(&self, console: &Console) -> anyhow::Result<Answer> {
        let stop = Arc::new(AtomicBool::new(false));
        let raised = stop.clone();
        ctrlc::set_handler(move || {
            raised.store(true, Ordering::Relaxed);
            tell(&"stopping after this epoch");
        })?;
        let training = MotorTraining {
            folder: &self.folder,
            task: &self.task,
            record: &self.record,
            recorded: &self.recorded,
            n_epochs: self.n_epochs,
            resume: self.resume,
        };
        let mut planned = |demo: &PlannedDemo| console.say(format_args!("{}", plan_line(demo)));
        let mut told = |epoch: &EpochRecord| console.say(format_args!("{}", epoch_line(epoch)));
        let summary = training
            .run(&stop, &mut planned, &mut told)
            .map_err(of_input)?;
        let (first, last) = (summary.first, summary.last);
        let document = json!({
            "task": self.task.name,
            "init": self.record.init.name(),
            "policy": self.record.policy.name(),
            "search": self.record.search.name(),
            "seed": self.record.seed,
            "folder": self.folder.dir(),
            "epochs": last.epoch,
            "rollouts": last.rollouts,
            "complete": summary.complete,
            "start": self.task.start,
            "goal": self.task.goal,
            "still_return": summary.still_return,
            "first": first,
            "last": last,
        });
        console.answer(&document, || {
            format!(
                "{} after {} rollouts: return {:.1} at first, {:.1} now; object at {:.3} at first, {:.3} now; the skill is \
                 in {}",
                if summary.complete { "done" } else { "stopped" },
                last.rollouts,
                first.total_reward,
                last.total_reward,
                first.object_state,
                last.object_state,
                self.folder.dir().display()
            )
        })?;
        Ok(Answer::from(summary.complete))
    }
}

/// Rolls out a learned motor skill, or what it began with: nothing in it is random.
pub(super) fn judge(
    dir: &Path,
    is_first: bool,
    video: Option<&Path>,
    console: &Console,
) -> anyhow::Result<Answer> {
    let folder = MotorFolder::at(dir);
    let record = folder.record().map_err(usage)?;
    let task = load_task(&record.task)?;
    let training = MotorTraining {
        folder: &folder,
        task: &task,
        record: &record,
        recorded: &[],
        n_epochs: 0,
        resume: true,
    };
    let rollout = filmed(video, console, |see| {
        let judged = if is_first {
            training.judge_first(see)
        } else {
            training.judge(see)
        };
        judged.map_err(of_input)
    })?;
    let document = json!({
        "return": rollout.total_reward,
        "object_state": rollout.object_state,
        "success": rollout.success,
    });
    console.answer(&document, || {
        format!(
            "{}: return {:.1}, object at {:.3}",
            if rollout.success {
                "success"
            } else {
                "no success"
            },
            rollout.total_reward,
            rollout.object_state
        )
    })?;
    Ok(Answer::Yes)
}

fn plan_line(demo: &PlannedDemo) -> String {
    let motion = &demo.motion;
    let secs = motion.step_secs * (motion.positions.len().max(1) - 1) as f64;
    let how_far = match &demo.stopped_by {
        None => "the arm can follow the object all the way".to_owned(),
        Some(reason) => format!(
            "the arm can follow the object for {:.0} % of its way ({reason})",
            100.0 * demo.fraction
        ),
    };
    format!("plan of {secs:.1} s; {how_far}")
}

fn epoch_line(epoch: &EpochRecord) -> String {
    format!(
        "epoch {:>3}  {:>4} rollouts  return {:>10.1}  object at {:>6.3}  exploring: return {:>10.1}, success {:>3.0} %",
        epoch.epoch,
        epoch.rollouts,
        epoch.total_reward,
        epoch.object_state,
        epoch.explored_return,
        100.0 * epoch.success_rate
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
