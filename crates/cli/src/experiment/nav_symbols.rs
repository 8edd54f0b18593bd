//! `factotum experiment run|report nav-symbols`: how many tries it takes to learn where the base must be (thesis Fig. 5.3).

use std::num::NonZero;
use std::path::{Path, PathBuf};

use clap::Args;
use factotum_experiments::nav_symbols::{
    self, Figures, Kitchen, NavStudy, NavStudyError, Row, Table, TrialResult,
};
use factotum_experiments::sweep::{Outcome as _, Progress, RESULTS_NAME};
use factotum_worlds::action_map::{ActionMap, read_folder};
use factotum_worlds::kitchen::kitchen;
use serde_json::json;

use super::cells::at_least_one;
use super::{duration_words, stop_on_interrupt};
use crate::console::{Answer, Console, usage};

/// Where the results of the project are, a folder for each kind of kitchens.
const COMMITTED: &str = "experiments/nav-symbols";

/// Arguments of `factotum experiment run nav-symbols`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Folder of action maps, `NAME.json`. Default: generated kitchens.
    #[arg(long, value_name = "DIR")]
    maps: Option<PathBuf>,
    /// Scenes to be used. Default: all of the folder.
    #[arg(
        long,
        value_name = "SCENE,...",
        value_delimiter = ',',
        requires = "maps"
    )]
    scenes: Vec<String>,
    /// How many kitchens are generated.
    #[arg(long, value_name = "N", default_value_t = 15, conflicts_with = "maps")]
    kitchens: u64,
    /// Seed of the first of them.
    #[arg(
        long,
        value_name = "BASE",
        default_value_t = 100,
        conflicts_with = "maps"
    )]
    kitchen_seed: u64,
    /// Seeds of each method and setting.
    #[arg(long, value_name = "N", default_value_t = 5)]
    seeds: u64,
    /// The first of them.
    #[arg(long, value_name = "BASE", default_value_t = 0)]
    seed: u64,
    /// How often coffee is made.
    #[arg(long, value_name = "N", default_value_t = 20)]
    completions: usize,
    /// Trials at a time. Default: as many as there are processors.
    #[arg(long)]
    workers: Option<usize>,
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "runs/nav-symbols")]
    out: PathBuf,
}

/// Arguments of `factotum experiment report nav-symbols`.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Folder of the results, or of folders with results.
    #[arg(long, value_name = "DIR", default_value = COMMITTED)]
    from: PathBuf,
    /// Folder of figures and tables. Default: that of the results.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs `factotum experiment run nav-symbols`.
pub(super) fn run(args: &RunArgs, console: &Console) -> anyhow::Result<Answer> {
    at_least_one("--seeds", args.seeds)?;
    at_least_one("--completions", args.completions as u64)?;
    let past_last = args.seed.checked_add(args.seeds).ok_or_else(|| {
        usage(format!(
            "--seed {} with {} seeds: too large",
            args.seed, args.seeds
        ))
    })?;
    let maps = match &args.maps {
        Some(folder) => chosen(read_folder(folder).map_err(usage)?, &args.scenes)?,
        None => generated(args)?,
    };
    let (kitchens, skipped) = kitchens(maps);
    for words in &skipped {
        console.say(format_args!("left out: {words}"));
    }
    if kitchens.is_empty() {
        let words = skipped.join("; ");
        return Err(usage(format!("no kitchen to make coffee in: {words}")));
    }
    let names: Vec<String> = kitchens.iter().map(scene).collect();
    let n_processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    let study = NavStudy {
        kitchens,
        seeds: (args.seed..past_last).collect(),
        n_completions: args.completions,
        n_workers: args.workers.unwrap_or(n_processors),
        folder: args.out.clone(),
    };
    let stop = stop_on_interrupt()?;
    let tell = |result: &TrialResult, progress: Progress| {
        let tries: u32 = result.completions.iter().map(|one| one.n_tries()).sum();
        let stuck = if result.is_stuck() { ", stuck" } else { "" };
        console.say(format_args!(
            "{}: {tries} tries{stuck}; {} of {}; {} left",
            result.key(),
            progress.n_done,
            progress.n_runs,
            duration_words(progress.secs_left)
        ));
    };
    let results = study.run(&stop, tell).map_err(of_input)?;
    let n_trials = study.trials().len();
    let is_complete = results.len() == n_trials;
    let n_stuck = results.iter().filter(|result| result.is_stuck()).count();
    let file = args.out.join(RESULTS_NAME);
    let table = nav_symbols::table(&results);
    let mut document = ratios(&table);
    let rest = json!({
        "complete": is_complete,
        "n_trials": n_trials,
        "n_done": results.len(),
        "n_stuck": n_stuck,
        "kitchens": names,
        "left_out": skipped,
        "results": file,
    });
    if let (Some(document), Some(rest)) = (document.as_object_mut(), rest.as_object()) {
        document.extend(rest.clone());
    }
    console.answer(&document, || {
        let hint = if is_complete {
            let out = args.out.display();
            format!("their figure: factotum experiment report nav-symbols --from {out}")
        } else {
            "stopped; the same command goes on".to_owned()
        };
        format!(
            "{}\n{} of {n_trials} trials done; results: `{}`\n{hint}",
            table.to_markdown(),
            results.len(),
            file.display()
        )
    })?;
    Ok(Answer::from(is_complete && n_stuck == 0))
}

/// Runs `factotum experiment report nav-symbols`.
pub(super) fn report(args: &ReportArgs, console: &Console) -> anyhow::Result<Answer> {
    let mut documents = serde_json::Map::new();
    let mut words = Vec::new();
    for name in result_folders(&args.from)? {
        let out = args.out.as_ref().unwrap_or(&args.from).join(&name);
        let (table, files) = nav_symbols::report(&args.from.join(&name), &out).map_err(of_input)?;
        words.push(format!("{name}\n\n{}", table.to_markdown()));
        let mut document = ratios(&table);
        document["files"] = json!(files);
        document["table"] = json!(table);
        documents.insert(name, document);
    }
    // A folder of results itself is its own answer.
    let own = documents.remove("");
    let document = own.unwrap_or(serde_json::Value::Object(documents));
    console.answer(&document, || words.join("\n"))?;
    Ok(Answer::Yes)
}

/// The folder itself, if it holds results, or those in it that do; by name.
fn result_folders(from: &Path) -> anyhow::Result<Vec<String>> {
    if from.join(RESULTS_NAME).exists() {
        return Ok(vec![String::new()]);
    }
    let failed = |error| usage(format!("cannot read `{}`: {error}", from.display()));
    let mut names = Vec::new();
    for entry in std::fs::read_dir(from).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        if entry.path().join(RESULTS_NAME).exists() {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    if names.is_empty() {
        return Err(usage(format!(
            "`{}` holds no `{RESULTS_NAME}`, nor does a folder in it",
            from.display()
        )));
    }
    names.sort();
    Ok(names)
}

fn scene(kitchen: &Kitchen) -> String {
    kitchen.map().scene().to_owned()
}

/// Kitchens that are made up.
fn generated(args: &RunArgs) -> anyhow::Result<Vec<ActionMap>> {
    at_least_one("--kitchens", args.kitchens)?;
    let past_last = args
        .kitchen_seed
        .checked_add(args.kitchens)
        .ok_or_else(|| {
            let first = args.kitchen_seed;
            usage(format!(
                "--kitchen-seed {first} with {} kitchens: too large",
                args.kitchens
            ))
        })?;
    let maps = (args.kitchen_seed..past_last).map(kitchen);
    Ok(maps.collect::<Result<_, _>>()?)
}

/// The maps of the named scenes, or all.
fn chosen(maps: Vec<ActionMap>, scenes: &[String]) -> anyhow::Result<Vec<ActionMap>> {
    let available: Vec<&str> = maps.iter().map(ActionMap::scene).collect();
    for scene in scenes {
        if !available.contains(&&**scene) {
            let available = available.join("`, `");
            return Err(usage(format!(
                "--scenes: `{scene}` is not among the maps; available: `{available}`"
            )));
        }
    }
    let is_chosen =
        |map: &ActionMap| scenes.is_empty() || scenes.iter().any(|scene| scene == map.scene());
    Ok(maps.into_iter().filter(is_chosen).collect())
}

/// The kitchens in which coffee can be made, and why not in the others.
fn kitchens(maps: Vec<ActionMap>) -> (Vec<Kitchen>, Vec<String>) {
    let mut kitchens = Vec::new();
    let mut skipped = Vec::new();
    for map in maps {
        let scene = map.scene().to_owned();
        match Kitchen::new(map) {
            Ok(kitchen) => kitchens.push(kitchen),
            Err(step) => skipped.push(format!(
                "`{scene}`: no `{}` on which `{}` is feasible from anywhere",
                step.class, step.action
            )),
        }
    }
    (kitchens, skipped)
}

fn ratios(table: &Table) -> serde_json::Value {
    let multi = |row: &Row| row.multi.as_ref()?.ratio_to_oracle;
    let once = |row: &Row| row.multi.as_ref()?.ratio_each_kitchen_once;
    let single = |row: &Row| row.single.as_ref()?.ratio_to_oracle;
    let tries = |figures: &Option<Figures>| figures.as_ref().map(|it| it.n_tries.mean);
    json!({
        "multi_scene_ratio_to_oracle": table.ratios(multi),
        "multi_scene_ratio_each_kitchen_once": table.ratios(once),
        "single_scene_ratio_to_oracle": table.ratios(single),
        "multi_scene_tries": table.ratios(|row| tries(&row.multi)),
        "single_scene_tries": table.ratios(|row| tries(&row.single)),
    })
}

/// Bad input ends with another exit code than a fault of ours.
fn of_input(error: NavStudyError) -> anyhow::Error {
    if error.is_of_input() {
        usage(error)
    } else {
        error.into()
    }
}
