//! Which cells of the grid of contact skills are meant, and what went wrong with them.

use std::ffi::OsStr;
use std::num::NonZero;
use std::path::Path;

use clap::Args;
use factotum_experiments::grid::GridError;
use factotum_skills::cip::setting::Ablation;

use crate::assets;
use crate::console::usage;
use crate::skill::AblationName;

/// Tasks, settings and seeds, and how many runs go on at a time.
#[derive(Debug, Args)]
pub(super) struct CellArgs {
    /// Shipped tasks.
    #[arg(
        long,
        value_name = "TASK,...",
        value_delimiter = ',',
        default_value = "door,drawer,slide,lever"
    )]
    pub(super) tasks: Vec<String>,
    /// Seeds of each task and setting.
    #[arg(long, value_name = "N", default_value_t = 5)]
    seeds: u64,
    /// The first of them. Seeds from 100 on are never used for tuning.
    #[arg(long, value_name = "BASE", default_value_t = 100)]
    seed: u64,
    /// Rollouts that judge a policy.
    #[arg(long, value_name = "N", default_value_t = 50)]
    pub(super) rollouts: u32,
    /// Runs at a time. Default: as many as there are processors.
    #[arg(long)]
    workers: Option<usize>,
}

impl CellArgs {
    /// The seeds, after a check of all that could be wrong.
    pub(super) fn checked_seeds(&self) -> anyhow::Result<Vec<u64>> {
        for (name, count) in [
            ("--seeds", self.seeds),
            ("--rollouts", self.rollouts.into()),
        ] {
            at_least_one(name, count)?;
        }
        for task in &self.tasks {
            shipped(task)?;
        }
        let past_last = self.seed.checked_add(self.seeds).ok_or_else(|| {
            usage(format!(
                "--seed {} with {} seeds: too large",
                self.seed, self.seeds
            ))
        })?;
        Ok((self.seed..past_last).collect())
    }

    pub(super) fn n_workers(&self) -> usize {
        let n_processors = std::thread::available_parallelism().map_or(1, NonZero::get);
        self.workers.unwrap_or(n_processors)
    }
}

/// The settings that were named, or all of `others` if none was.
pub(super) fn ablations(names: &[AblationName], others: &[Ablation]) -> Vec<Ablation> {
    if names.is_empty() {
        others.to_vec()
    } else {
        names.iter().map(|&name| name.into()).collect()
    }
}

/// Refuses nothing at all.
pub(super) fn at_least_one(name: &str, count: u64) -> anyhow::Result<()> {
    if count == 0 {
        return Err(usage(format!("{name} is 0, expected at least 1")));
    }
    Ok(())
}

/// A task of the grid is a shipped one by its name, which names the folders of its cells too.
fn shipped(task: &str) -> anyhow::Result<()> {
    let path = Path::new(task);
    if path.file_stem() != Some(OsStr::new(task)) {
        return Err(usage(format!(
            "--tasks: found `{task}`, expected the name of a shipped task, such as `door`"
        )));
    }
    assets::task(path).map(|_| ())
}

/// Bad input ends with another exit code than a fault of ours.
pub(super) fn of_input(error: GridError) -> anyhow::Error {
    let is_of_input = error.is_of_input();
    let error = anyhow::Error::from(error);
    if is_of_input {
        usage(format!("{error:#}"))
    } else {
        error
    }
}
