//! `factotum skill run`: learned skills one after the other (thesis 3.4.1).

use std::path::PathBuf;

use clap::Args;
use factotum_experiments::composition::{Composition, CompositionError, CompositionResult};
use factotum_experiments::skill_folder::SkillFolder;
use factotum_experiments::skill_training::primitive;
use factotum_skills::cip::Primitive;
use factotum_worlds::HomeScene;
use serde_json::json;

use super::{load_task, of_input};
use crate::assets;
use crate::console::{Answer, Console, usage};

/// Arguments of `factotum skill run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Skills in the order in which they are done: folders, or names of shipped ones.
    #[arg(required = true, value_name = "SKILL")]
    skills: Vec<PathBuf>,
    /// Scene with an object for each: a folder with `scene.toml`, or the name of a shipped one.
    #[arg(long, default_value = "knob_and_door")]
    scene: PathBuf,
    /// Draws where the objects stand.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub(super) fn run_command(args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    let scene = HomeScene::load(&assets::scene(&args.scene)?).map_err(usage)?;
    let skills = args
        .skills
        .iter()
        .map(|name| {
            let folder = SkillFolder::at(&assets::skill(name)?);
            let record = folder.record().map_err(usage)?;
            let task = load_task(&record.task)?;
            primitive(&folder, &task, &record).map_err(of_input)
        })
        .collect::<anyhow::Result<Vec<Primitive>>>()?;
    let composition = Composition {
        scene: &scene,
        skills: &skills,
        seed: args.seed,
    };
    let mut robot = composition.world().map_err(|error| match error {
        CompositionError::NoObject { .. } | CompositionError::Robots { .. } => usage(error),
        error => error.into(),
    })?;
    let result = composition.run(&mut robot, &mut |skill, object| {
        console.progress(format!("{} at {object}", skill.task().name));
    })?;
    let document = json!({
        "success": result.success,
        "scene": scene.name(),
        "seed": args.seed,
        "skills": result.skills,
        "not_ready": result.not_ready,
        "robot_secs": result.robot_secs,
    });
    console.answer(&document, || describe(&result))?;
    Ok(Answer::from(result.success))
}

fn describe(result: &CompositionResult) -> String {
    let mut lines: Vec<String> = result
        .skills
        .iter()
        .map(|skill| {
            let how = match &skill.failure {
                Some(failure) => format!("failed: {failure}"),
                None if skill.success => "done".to_owned(),
                None => "done by its own word, but physics says otherwise".to_owned(),
            };
            format!(
                "{} at {}: {how}; joint at {:.3}, goal {:.3}, {:.1} s",
                skill.skill, skill.object, skill.joint_at_end, skill.goal, skill.robot_secs
            )
        })
        .collect();
    lines.push(match &result.not_ready {
        Some(failure) => format!("the arm did not get back to its ready posture: {failure}"),
        None => format!(
            "{} in {:.1} s of robot time",
            if result.success {
                "achieved"
            } else {
                "not achieved"
            },
            result.robot_secs
        ),
    });
    lines.join("\n")
}
