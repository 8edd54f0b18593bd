//! Exploring: drive to where the known floor ends until it ends nowhere, then to where the camera has not looked yet.
//!
//! Frontiers by Yamauchi (CIRA 1997); the nearest large one is taken first. At every stop the robot turns once around
//! and looks. Then the camera's turn: places are visited from which most of the unseen floor comes into view.

use std::f64::consts::TAU;

use factotum_control::{BaseTwist, Command};
use factotum_geometry::Pose2;
use factotum_geometry::grid::frontiers;
use nalgebra::{Point2, Vector2, Vector3};
use rand::RngExt as _;

use crate::drive::path_on;
use crate::{AgentError, Executive, LogLevel};

/// Frontiers shorter than this are gaps between rays, cells.
const FRONTIER_CELLS_MIN: usize = 8;
/// Stops after which exploring ends in any case.
const N_STOPS_MAX: usize = 40;
/// The camera recognises objects up to this distance, metres.
const LOOK_RANGE_M: f64 = 2.8;
/// Edge of the squares of floor that count as looked at or not, metres.
const PATCH_M: f64 = 0.4;
/// Stops are worth their time for this many patches not looked at yet.
const N_PATCHES_MIN: usize = 9;
/// A place this near to one from which the robot has looked around shows nothing new, metres.
const APART_M: f64 = 0.9;

impl Executive<'_> {
    /// Explores until the home is known or `is_enough` says so.
    ///
    /// # Errors
    /// [`AgentError`] for faults of the robot, and [`AgentError::Stopped`] when the observer wished to stop.
    pub fn explore(
        &mut self,
        is_enough: &mut dyn FnMut(&factotum_semantic_map::Aosm) -> bool,
    ) -> Result<(), AgentError> {
        self.log(LogLevel::Info, "exploring".to_owned())?;
        self.tuck()?;
        self.look_around_here()?;
        let mut spent: Vec<Point2<f64>> = Vec::new();
        for _ in 0..N_STOPS_MAX {
            if is_enough(&self.aosm) {
                break;
            }
            let Some(goal) = (match self.next_frontier(&spent)? {
                Some(goal) => Some(goal),
                None => self.next_viewpoint(&spent)?,
            }) else {
                break;
            };
            spent.push(Point2::from(goal.translation.vector));
            self.log(
                LogLevel::Info,
                format!(
                    "driving to ({:.1}, {:.1}) m",
                    goal.translation.x, goal.translation.y
                ),
            )?;
            if let Err(why) = self.drive_to(&goal)? {
                self.log(LogLevel::Warning, format!("while exploring: {why}"))?;
                continue;
            }
            self.look_around_here()?;
        }
        self.aosm.cloud = self.senses.seen();
        let n_objects = self.aosm.objects.len();
        self.log(
            LogLevel::Info,
            format!("explored: {n_objects} objects found"),
        )
    }

    /// Turns once around, looking, if the robot has not done so near here.
    fn look_around_here(&mut self) -> Result<(), AgentError> {
        let here = Point2::from(self.map_from_base()?.translation.vector);
        if is_near(&here, &self.viewed, APART_M) {
            return Ok(());
        }
        self.look_around()?;
        self.checkpoint()
    }

    /// Turns once around, looking.
    pub(crate) fn look_around(&mut self) -> Result<(), AgentError> {
        const PERIOD_SECS: f64 = 0.1;
        /// Looks while turning by a third of the camera's view or so.
        const N_PERIODS_PER_LOOK: usize = 5;
        self.observe_home()?;
        let here = self.map_from_base()?;
        let rate_rad_per_s = self
            .model
            .description()
            .base
            .as_ref()
            .map_or(0.5, |base| base.yaw_rate_max_rad_per_s);
        let n_periods = (TAU / rate_rad_per_s / PERIOD_SECS).ceil() as usize;
        for period in 1..=n_periods {
            let velocity = Vector3::new(0.0, 0.0, rate_rad_per_s);
            self.robot.send(Command::BaseTwist(BaseTwist {
                velocity,
                valid_secs: 2.0 * PERIOD_SECS,
            }))?;
            self.robot.wait(PERIOD_SECS)?;
            self.senses.feel(self.robot)?;
            if period.is_multiple_of(N_PERIODS_PER_LOOK) {
                self.observe_home()?;
            }
        }
        self.robot.wait(3.0 * PERIOD_SECS)?;
        self.viewed.push(Point2::from(here.translation.vector));
        self.show_map()
    }

    fn next_frontier(&mut self, spent: &[Point2<f64>]) -> Result<Option<Pose2>, AgentError> {
        let grid = self.inflated();
        let here = self.map_from_base()?;
        let mut best: Option<(f64, Pose2)> = None;
        for frontier in frontiers(&self.aosm.grid, FRONTIER_CELLS_MIN) {
            let edge = self.aosm.grid.center_of(frontier.nearest_cell);
            if is_near(&edge, spent, 0.5) {
                continue;
            }
            let Some(goal) = self.stand_near(&grid, &edge, &here) else {
                continue;
            };
            if is_near(&Point2::from(goal.translation.vector), spent, 0.25) {
                continue;
            }
            let Ok((_, length_m)) = path_on(&grid, &here, &goal) else {
                continue;
            };
            let cost = length_m - 0.02 * frontier.n_cells() as f64;
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, goal));
            }
        }
        Ok(best.map(|(_, goal)| goal))
    }

    /// A free place near a point, facing it.
    fn stand_near(
        &self,
        grid: &factotum_motion::InflatedGrid,
        edge: &Point2<f64>,
        here: &Pose2,
    ) -> Option<Pose2> {
        let back = (Point2::from(here.translation.vector) - edge)
            .try_normalize(1e-6)
            .unwrap_or_else(Vector2::x);
        let mut places = Vec::new();
        for ring in 0..8 {
            for turn in 0..12 {
                let angle = TAU * f64::from(turn) / 12.0;
                let offset = nalgebra::Rotation2::new(angle) * back * (0.12 * f64::from(ring));
                places.push(edge + offset);
            }
        }
        let place = places.into_iter().find(|place| grid.is_free_at(place))?;
        let facing = edge - place;
        let yaw = if facing.norm() > 1e-3 {
            facing.y.atan2(facing.x)
        } else {
            here.rotation.angle()
        };
        Some(Pose2::new(place.coords, yaw))
    }

    /// The place from which the camera would see most of the floor it has not looked at.
    fn next_viewpoint(&mut self, spent: &[Point2<f64>]) -> Result<Option<Pose2>, AgentError> {
        const N_PLACES: usize = 120;
        let grid = self.inflated();
        let here = self.map_from_base()?;
        let patches = self.unviewed_patches();
        if patches.len() < N_PATCHES_MIN {
            return Ok(None);
        }
        let mut best: Option<(f64, Pose2)> = None;
        for _ in 0..N_PLACES {
            let patch = patches[self.rng.random_range(0..patches.len())];
            let around = Vector2::new(
                self.rng.random_range(-1.5..1.5),
                self.rng.random_range(-1.5..1.5),
            );
            let place = patch + around;
            if !grid.is_free_at(&place) || is_near(&place, spent, 0.3) {
                continue;
            }
            let n_seen = patches
                .iter()
                .filter(|patch| self.is_in_view(&place, patch))
                .count();
            if n_seen < N_PATCHES_MIN {
                continue;
            }
            let goal = Pose2::new(place.coords, here.rotation.angle());
            let Ok((_, length_m)) = path_on(&grid, &here, &goal) else {
                continue;
            };
            let gain = n_seen as f64 / (2.0 + length_m);
            if best.as_ref().is_none_or(|(most, _)| gain > *most) {
                best = Some((gain, goal));
            }
        }
        Ok(best.map(|(_, goal)| goal))
    }

    /// Patches of free floor that no stop has had in view.
    fn unviewed_patches(&self) -> Vec<Point2<f64>> {
        let stride = (PATCH_M / self.aosm.grid.resolution_m()).round().max(1.0) as usize;
        self.aosm
            .grid
            .indices()
            .filter(|index| index.column % stride == 0 && index.row % stride == 0)
            .filter(|index| self.aosm.grid.cell(*index).is_free())
            .map(|index| self.aosm.grid.center_of(index))
            .filter(|patch| !self.viewed.iter().any(|stop| self.is_in_view(stop, patch)))
            .collect()
    }

    fn is_in_view(&self, from: &Point2<f64>, patch: &Point2<f64>) -> bool {
        (patch - from).norm() < LOOK_RANGE_M && self.aosm.grid.is_line_free(from, patch)
    }
}

fn is_near(point: &Point2<f64>, others: &[Point2<f64>], distance_m: f64) -> bool {
    others
        .iter()
        .any(|other| (other - point).norm() < distance_m)
}
