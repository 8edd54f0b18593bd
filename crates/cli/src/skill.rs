//! `factotum skill`: contact skills, learned and judged.

mod curve;
mod motor;
mod run;
mod stopwatch;
mod video;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, Subcommand, ValueEnum};
use factotum_descriptions::{RobotDescription, TaskSpec};
use factotum_experiments::skill_folder::{SkillFolder, SkillRecord};
use factotum_experiments::skill_training::{
    Judging, SkillError, Training, TrainingEvent, TrainingSummary, WhichPolicy, primitive,
};
use factotum_skills::cip::Primitive;
use factotum_skills::cip::perturbation::Perturbation;
use factotum_skills::cip::setting::Ablation;
use factotum_skills::cip::training::EvaluationRecord;
use serde_json::json;

use crate::assets;
use crate::console::{Answer, Console, tell, usage};
use curve::Curve;
use motor::MotorArgs;
use run::RunArgs;
use stopwatch::Stopwatch;
pub(crate) use video::filmed;

/// Episodes of a contact skill that are the robot's own plan, with `--init plan`: as many as the dissertation's demonstrations of
/// a motor skill.
const SHOWN: u64 = 10;

/// Arguments of `factotum skill`.
#[derive(Debug, Subcommand)]
pub(crate) enum SkillCommand {
    /// Learn a skill on a task, into a folder: a contact skill, or a motor skill if the task says so.
    Train(TrainArgs),
    /// Judge a learned skill by fresh rollouts.
    Eval(EvalArgs),
    /// Do learned skills one after the other in a scene that none of them has seen.
    Run(RunArgs),
}

/// Arguments of `factotum skill train`.
#[derive(Debug, Args)]
pub(crate) struct TrainArgs {
    /// Task: a task file, or the name of a shipped one.
    task: Option<PathBuf>,
    /// Which parts of the structure are there (thesis 3.3), or `hard-guard` and `fast`, which are ours.
    #[arg(
        long,
        value_enum,
        help = "Which parts of the structure are there [default: cip]"
    )]
    ablation: Option<AblationName>,
    /// Where the dissertation's text and its code differ, or the text says nothing: as in the code.
    #[arg(long, conflicts_with = "resume")]
    as_in_the_code: bool,
    /// Training episodes of a contact skill [default: 100].
    #[arg(long, value_name = "N")]
    episodes: Option<u64>,
    /// Seed of all that is random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder of the skill. Default: `skills/<task>-<ablation>-<seed>`.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Go on with the run in this folder from its last evaluation.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["task", "out", "seed", "ablation"])]
    resume: Option<PathBuf>,
    #[command(flatten)]
    motor: MotorArgs,
}

/// Arguments of `factotum skill eval`.
#[derive(Debug, Args)]
pub(crate) struct EvalArgs {
    /// Skill: its folder, or the name of a shipped one.
    skill: PathBuf,
    /// Rollouts.
    #[arg(long, value_name = "N", default_value_t = ROLLOUTS)]
    rollouts: u32,
    /// Seed of the rollouts.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    perturb: PerturbArgs,
    /// Which policy: that of the best evaluation while training, or that of the last.
    #[arg(long, value_enum, default_value_t = PolicyName::Best)]
    policy: PolicyName,
    /// The policy that a motor skill began with, before any search.
    #[arg(long, conflicts_with = "policy")]
    first: bool,
    /// Leave a picture strip (PNG) and a recording (MCAP, for Foxglove) of the first three rollouts in this folder.
    #[arg(long, value_name = "DIR")]
    video: Option<PathBuf>,
}

/// Rollouts that judge a contact skill.
const ROLLOUTS: u32 = 50;

impl EvalArgs {
    /// Nothing in a rollout of a motor skill is random, and it is judged as it was learned.
    fn refuse_for_motor(&self) -> anyhow::Result<()> {
        let is_usual = self.rollouts == ROLLOUTS
            && self.seed == 0
            && self.perturb.checked()? == Perturbation::default();
        if is_usual {
            return Ok(());
        }
        Err(usage(format!(
            "`{}` is a motor skill, of which every rollout is the same; --rollouts, --seed, and what is otherwise than in \
             training are for contact skills",
            self.skill.display()
        )))
    }
}

/// What may be otherwise than the skill was trained for.
#[derive(Debug, Args)]
#[command(next_help_heading = "Otherwise than it was trained for")]
struct PerturbArgs {
    /// Factor of the damping of the object's joint.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    damping: f64,
    /// Factor of the dry friction of the object's joint.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    friction: f64,
    /// Standard deviation of the error of the object's position along each axis.
    #[arg(long, value_name = "MM", default_value_t = 0.0)]
    pose_error_mm: f64,
    /// Standard deviation of the error of its orientation about each axis.
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    pose_error_deg: f64,
    /// Standard deviation of the error of the grasp's position along each axis.
    #[arg(long, value_name = "MM", default_value_t = 0.0)]
    grasp_error_mm: f64,
    /// Standard deviation of the error of its orientation about each axis.
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    grasp_error_deg: f64,
}

impl PerturbArgs {
    fn checked(&self) -> anyhow::Result<Perturbation> {
        for (name, value) in [
            ("--damping", self.damping),
            ("--friction", self.friction),
            ("--pose-error-mm", self.pose_error_mm),
            ("--pose-error-deg", self.pose_error_deg),
            ("--grasp-error-mm", self.grasp_error_mm),
            ("--grasp-error-deg", self.grasp_error_deg),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(usage(format!(
                    "{name} is {value}, expected a finite number of at least 0"
                )));
            }
        }
        Ok(Perturbation {
            damping: self.damping,
            friction: self.friction,
            pose_m: 1e-3 * self.pose_error_mm,
            pose_rad: self.pose_error_deg.to_radians(),
            grasp_m: 1e-3 * self.grasp_error_mm,
            grasp_rad: self.grasp_error_deg.to_radians(),
        })
    }
}

/// The policies that a folder keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PolicyName {
    /// Of the last evaluated episode.
    Last,
    /// Of the best evaluation.
    Best,
}

impl From<PolicyName> for WhichPolicy {
    fn from(name: PolicyName) -> Self {
        match name {
            PolicyName::Last => Self::Last,
            PolicyName::Best => Self::Best,
        }
    }
}

/// The settings there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AblationName {
    /// No structure at all.
    Unstructured,
    /// Begins in a grasp.
    Head,
    /// And keeps within the safety envelope.
    Safety,
    /// And takes the configuration of highest manipulability.
    Mv,
    /// And chooses grasps by upper confidence bounds: all of it.
    Cip,
    /// As `cip`, with a barrier in place of the envelope.
    HardGuard,
    /// Corrects the object's own motion, behind the barrier.
    Fast,
}

impl From<AblationName> for Ablation {
    fn from(name: AblationName) -> Self {
        match name {
            AblationName::Unstructured => Self::Unstructured,
            AblationName::Head => Self::Head,
            AblationName::Safety => Self::Safety,
            AblationName::Mv => Self::Mv,
            AblationName::Cip => Self::Cip,
            AblationName::HardGuard => Self::HardGuard,
            AblationName::Fast => Self::Fast,
        }
    }
}

/// Runs `factotum skill`.
pub(crate) fn skill(command: &SkillCommand, console: &Console) -> anyhow::Result<Answer> {
    match command {
        SkillCommand::Train(args) => train_command(args, console),
        SkillCommand::Eval(args) => eval_command(args, console),
        SkillCommand::Run(args) => run::run_command(args, console),
    }
}

fn train_command(args: &TrainArgs, console: &Console) -> anyhow::Result<Answer> {
    if let Some(run) = motor::motor_run(args)? {
        return run.train(console);
    }
    let n_episodes = args.episodes.unwrap_or(100);
    if n_episodes == 0 {
        return Err(usage("--episodes is 0, expected at least 1"));
    }
    let (folder, record) = match (&args.resume, &args.task) {
        (Some(dir), _) => {
            let folder = SkillFolder::at(dir);
            let record = folder.record().map_err(usage)?;
            (folder, record)
        }
        (None, Some(task)) => {
            let ablation = args.ablation.unwrap_or(AblationName::Cip).into();
            let dir = args
                .out
                .clone()
                .unwrap_or_else(|| default_folder(task, ablation, args.seed));
            let mut record = SkillRecord::new(assets::task_name(task)?, ablation, args.seed);
            if args.motor.contact_plan()? {
                if record.setting.guide.is_some() {
                    return Err(usage(format!(
                        "--init plan has nothing to show to `{}`, which follows the object's own motion anyway",
                        ablation.name()
                    )));
                }
                record.shown = SHOWN;
            }
            if args.as_in_the_code {
                record.setting = record.setting.like_the_code();
            }
            (SkillFolder::at(&dir), record)
        }
        (None, None) => {
            return Err(usage(
                "no task to train on; give a task file, the name of a shipped task, or --resume DIR",
            ));
        }
    };
    let task = load_task(&record.task)?;
    let stop = Arc::new(AtomicBool::new(false));
    let raised = stop.clone();
    ctrlc::set_handler(move || {
        raised.store(true, Ordering::Relaxed);
        tell(&"stopping after this episode");
    })?;
    let stopwatch = Stopwatch::start();
    let mut curve = Curve::default();
    let mut listen = |event| show(event, &task, &mut curve, console);
    let training = Training {
        folder: &folder,
        task: &task,
        record: &record,
        n_episodes,
        resume: args.resume.is_some(),
    };
    let summary = training
        .run(&stop, stopwatch.watch(), &mut listen)
        .map_err(of_input)?;
    let split = stopwatch.split_secs();
    let last = summary.last;
    let document = json!({
        "task": task.name,
        "ablation": record.ablation.name(),
        "seed": record.seed,
        "folder": folder.dir(),
        "episodes": summary.n_episodes,
        "env_steps": summary.n_env_steps,
        "training_violations": summary.n_violations,
        "grasps": summary.n_grasps,
        "complete": summary.complete,
        "success_rate": last.map(|last| last.success_rate),
        "violation_rate": last.map(|last| last.violation_rate),
        "peak_force_n": last.map(|last| last.peak_force_n),
        "time_to_success_secs": last.and_then(|last| last.time_to_success_secs),
        "best_success_rate": summary.best_success_rate,
        "split_secs": split,
    });
    console.answer(&document, || {
        let mut lines = vec![describe(&summary, &folder)];
        lines.extend(last.map(|last| format!("last evaluation: {}", evaluation_line(&last))));
        let parts: Vec<String> = split
            .iter()
            .map(|(phase, secs)| format!("{phase} {secs:.1}"))
            .collect();
        lines.push(format!("seconds: {}", parts.join(", ")));
        lines.push(format!(
            "judge it: factotum skill eval {}",
            folder.dir().display()
        ));
        lines.join("\n")
    })?;
    Ok(Answer::from(summary.complete))
}

fn eval_command(args: &EvalArgs, console: &Console) -> anyhow::Result<Answer> {
    if args.rollouts == 0 {
        return Err(usage("--rollouts is 0, expected at least 1"));
    }
    if motor::is_motor_skill(&args.skill) {
        args.refuse_for_motor()?;
        return motor::judge(&args.skill, args.first, args.video.as_deref(), console);
    }
    if args.first {
        return Err(usage(format!(
            "--first: only a motor skill keeps what it began with, and `{}` is none; --policy last or best",
            args.skill.display()
        )));
    }
    let folder = SkillFolder::at(&assets::skill(&args.skill)?);
    let record = folder.record().map_err(usage)?;
    let task = load_task(&record.task)?;
    console.progress(format!("{} rollouts of {}", args.rollouts, task.name));
    let perturbation = args.perturb.checked()?;
    let judging = Judging {
        folder: &folder,
        task: &task,
        record: &record,
        which: args.policy.into(),
        perturbation,
        rollouts: args.rollouts,
        seed: args.seed,
    };
    let (evaluation, _) = filmed(args.video.as_deref(), console, |see| {
        judging.run(see).map_err(of_input)
    })?;
    let document = json!({
        "success_rate": evaluation.success_rate,
        "violation_rate": evaluation.violation_rate,
        "peak_force_n": evaluation.peak_force_n,
        "time_to_success_secs": evaluation.time_to_success_secs,
        "rollouts": evaluation.rollouts,
    });
    console.answer(&document, || evaluation_line(&evaluation))?;
    Ok(Answer::Yes)
}

/// The skills in a folder, or the shipped ones, that were learned with a robot.
pub(crate) fn learned_with(
    robot: &RobotDescription,
    shelf: Option<&Path>,
) -> anyhow::Result<Vec<Primitive>> {
    let mut learned = Vec::new();
    for dir in assets::skills(shelf)? {
        let folder = SkillFolder::at(&dir);
        let record = folder.record().map_err(usage)?;
        let task = load_task(&record.task)?;
        if RobotDescription::load(&task.robot).map_err(usage)?.name == robot.name {
            learned.push(primitive(&folder, &task, &record).map_err(of_input)?);
        }
    }
    Ok(learned)
}

fn load_task(name: &Path) -> anyhow::Result<TaskSpec> {
    TaskSpec::load(&assets::task(name)?).map_err(usage)
}

fn default_folder(task: &Path, ablation: Ablation, seed: u64) -> PathBuf {
    let stem = task.file_stem().unwrap_or_default().to_string_lossy();
    PathBuf::from("skills").join(format!("{stem}-{}-{seed}", ablation.name()))
}

/// Bad input ends with another exit code than a fault of ours.
fn of_input(error: SkillError) -> anyhow::Error {
    if error.is_of_input() {
        usage(error)
    } else {
        error.into()
    }
}

fn show(event: TrainingEvent, task: &TaskSpec, curve: &mut Curve, console: &Console) {
    match event {
        TrainingEvent::Grasp { index, kept } => {
            curve.n_grasps += usize::from(kept);
            console.progress(format!(
                "{}: {} of {} grasps can be held and shaken",
                task.name,
                curve.n_grasps,
                index + 1
            ));
        }
        TrainingEvent::Episode(episode) => {
            curve.add(episode.success);
            console.progress(format!(
                "{} episode {} {} {} steps",
                task.name,
                episode.episode,
                curve.line(),
                episode.env_steps
            ));
        }
        TrainingEvent::Evaluation(evaluation) => {
            console.say(format_args!(
                "episode {:>4}  {:>6} steps  {}",
                evaluation.episode,
                evaluation.env_steps,
                evaluation_line(&evaluation)
            ));
        }
    }
}

fn evaluation_line(evaluation: &EvaluationRecord) -> String {
    let time = evaluation
        .time_to_success_secs
        .map(|secs| format!(", {secs:.2} s to succeed"))
        .unwrap_or_default();
    format!(
        "success {:>3.0} %  joint limits violated {:>3.0} %  peak force {:.0} N{time}",
        100.0 * evaluation.success_rate,
        100.0 * evaluation.violation_rate,
        evaluation.peak_force_n,
    )
}

fn describe(summary: &TrainingSummary, folder: &SkillFolder) -> String {
    format!(
        "{} after {} episodes, {} steps, {} of them with a joint near its limit; the skill is in {}",
        if summary.complete { "done" } else { "stopped" },
        summary.n_episodes,
        summary.n_env_steps,
        summary.n_violations,
        folder.dir().display()
    )
}
