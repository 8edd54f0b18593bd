//! What is kept of a run as it goes: the home with its journal, and snapshots to go on from.
//!
//! At each checkpoint the home comes first, then the snapshot that names the home's entry. A crash between the two
//! leaves a home that is ahead of the newest snapshot; whoever resumes takes the home back to it.

use std::time::Instant;

use factotum_agent::{Checkpoint, RunReport, Stage};
use factotum_experiments::run_folder::Snapshots;
use factotum_geometry::Pose2;
use factotum_semantic_map::{Aosm, Edit, Execution, Home, MapError};
use factotum_task_planning::operator::GroundAction;
use factotum_worlds::SimRobot;

use crate::audience::Audience;
use crate::console::now;
use crate::snapshot::{Progress, Snapshot};

/// Author of what a robot learns, in the journal.
const AUTHOR: &str = "robot";

/// Keeps the home and the snapshots of a run. What cannot be kept is a trouble of the audience, and tried again at the
/// next checkpoint.
pub(crate) struct Keeper {
    pub(crate) progress: Progress,
    home: Option<Home>,
    snapshots: Option<Snapshots>,
    clock: Instant,
    /// Steps of the chore under way that are in the journal.
    n_executed: usize,
}

impl Keeper {
    /// Keeps in `home` and `snapshots`, as far as there are such, from what was done before on.
    pub(crate) fn new(
        home: Option<Home>,
        snapshots: Option<Snapshots>,
        before: Option<&Snapshot>,
        clock: Instant,
    ) -> Self {
        Self {
            progress: before
                .map(|before| before.progress.clone())
                .unwrap_or_default(),
            home,
            snapshots,
            clock,
            n_executed: before.map_or(0, |before| before.checkpoint.report.executed.len()),
        }
    }

    /// A chore is over.
    pub(crate) fn end_chore(&mut self, report: RunReport) {
        self.progress.reports.push(report);
        self.n_executed = 0;
    }

    /// Seconds that the run has taken, before it was resumed and since.
    pub(crate) fn wall_secs(&self) -> f64 {
        self.progress.wall_secs + self.clock.elapsed().as_secs_f64()
    }

    /// Keeps the map alone, as at an end that no checkpoint foresaw.
    pub(crate) fn keep_map(&mut self, aosm: &Aosm, audience: &Audience) {
        if let Err(error) = self.journal(aosm, &[]) {
            audience.add_trouble(error.into());
        }
    }

    /// Keeps everything at a checkpoint.
    pub(crate) fn keep(
        &mut self,
        aosm: &Aosm,
        checkpoint: &Checkpoint,
        world: &SimRobot,
        world_from_map: Pose2,
        audience: &Audience,
    ) {
        // Between chores, the report is of one that is over.
        let executed: Vec<Execution> = match checkpoint.stage {
            Stage::Between => Vec::new(),
            Stage::Planning | Stage::Acting { .. } => checkpoint
                .report
                .executed
                .iter()
                .skip(self.n_executed)
                .map(|step| Execution {
                    step: GroundAction::new(step.action.clone(), &step.args),
                    outcome: step.outcome.clone(),
                    robot_secs: step.robot_secs,
                })
                .collect(),
        };
        let kept = self
            .journal(aosm, &executed)
            .map_err(anyhow::Error::from)
            .and_then(|home_entry| {
                let Some(snapshots) = &self.snapshots else {
                    return Ok(());
                };
                let world = match world.snapshot().to_bytes() {
                    Ok(world) => world,
                    Err(error) => {
                        // A motion is still under way. There will be another checkpoint.
                        tracing::warn!(%error, "no snapshot");
                        return Ok(());
                    }
                };
                let snapshot = Snapshot {
                    progress: Progress {
                        wall_secs: self.wall_secs(),
                        ..self.progress.clone()
                    },
                    home_entry,
                    world_from_map,
                    checkpoint: checkpoint.clone(),
                    told: audience.told(),
                    world,
                };
                snapshots.save(&snapshot.to_bytes()?)?;
                Ok(())
            });
        if let Err(error) = kept {
            audience.add_trouble(error);
        }
    }

    /// Brings the home up to date, and answers the number of its last entry.
    fn journal(&mut self, aosm: &Aosm, executed: &[Execution]) -> Result<i64, MapError> {
        let Some(home) = &mut self.home else {
            return Ok(0);
        };
        let when_secs = now().unix_secs() as f64;
        home.edit(&Edit::SetAll(Box::new(aosm.clone())), AUTHOR, when_secs)?;
        for execution in executed {
            home.record_execution(execution, AUTHOR, when_secs)?;
            self.n_executed += 1;
        }
        home.last_entry()
    }
}
