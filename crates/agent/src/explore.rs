//! Exploring: drive to where the known floor ends until it ends nowhere, then to where the camera has not looked yet.
//!
//! Frontiers by Yamauchi (CIRA 1997); the nearest large one is taken first. The camera looks all the time, and at every
//! stop the robot turns as far as there is something that it has not had in view. Then places are visited from which
//! most of the unseen floor comes into view.

use std::f64::consts::TAU;

use factotum_control::{BaseTwist, Command};
use factotum_geometry::Pose2;
use factotum_geometry::grid::frontiers;
use nalgebra::{Point2, Vector2, Vector3};
use rand::RngExt as _;

use crate::drive::path_on;
use crate::viewed::LOOK_RANGE_M;
use crate::{AgentError, Executive, LogLevel};

/// Frontiers shorter than this are gaps between rays, cells.
const FRONTIER_CELLS_MIN: usize = 8;
/// Stops after which exploring ends in any case.
const N_STOPS_MAX: usize = 40;
/// Stops are worth their time for this many patches not looked at yet.
const N_PATCHES_MIN: u32 = 9;

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
        self.conclude("explored")
    }

    /// The home is known now as well as it will be: tells so.
    pub(crate) fn conclude(&mut self, how: &str) -> Result<(), AgentError> {
        self.aosm.cloud = self.senses.seen();
        let n_objects = self.aosm.objects.len();
        self.log(LogLevel::Info, format!("{how}: {n_objects} objects found"))
    }

    /// Turns as far as it takes to have everything around in view that has not been yet.
    fn look_around_here(&mut self) -> Result<(), AgentError> {
        self.observe_home()?;
        let here = self.map_from_base()?;
        let turns = self
            .viewed
            .turns_to_see(&self.aosm.grid, &here, self.half_view_rad());
        if turns.is_empty() {
            return Ok(());
        }
        for turn_rad in turns {
            self.turn_looking(turn_rad)?;
        }
        self.show_map()?;
        self.checkpoint()
    }

    /// Turns once around, looking.
    pub(crate) fn look_around(&mut self) -> Result<(), AgentError> {
        self.observe_home()?;
        self.turn_looking(TAU)?;
        self.show_map()
    }

    /// Turns by an angle, looking.
    fn turn_looking(&mut self, turn_rad: f64) -> Result<(), AgentError> {
        const PERIOD_SECS: f64 = 0.1;
        /// Looks while turning by a third of the camera's view or so.
        const N_PERIODS_PER_LOOK: usize = 5;
        let rate_rad_per_s = self
            .model
            .description()
            .base
            .as_ref()
            .map_or(0.5, |base| base.yaw_rate_max_rad_per_s);
        let velocity = Vector3::new(0.0, 0.0, rate_rad_per_s.copysign(turn_rad));
        let expected = (turn_rad.abs() / rate_rad_per_s / PERIOD_SECS).ceil() as usize;
        // Getting up to speed takes time, and a base that is held does not turn at all.
        let n_periods_max = expected + expected / 2 + 10;
        let (mut turned_rad, mut before) = (0.0, self.robot.state()?.odom_from_base.rotation);
        for period in 1..=n_periods_max {
            self.robot.send(Command::BaseTwist(BaseTwist {
                velocity,
                valid_secs: 2.0 * PERIOD_SECS,
            }))?;
            self.robot.wait(PERIOD_SECS)?;
            self.senses.feel(self.robot)?;
            let now = self.robot.state()?.odom_from_base.rotation;
            turned_rad += before.angle_to(&now);
            before = now;
            if turned_rad.abs() >= turn_rad.abs() {
                break;
            }
            if period.is_multiple_of(N_PERIODS_PER_LOOK) {
                self.observe_home()?;
            }
        }
        self.robot.wait(3.0 * PERIOD_SECS)?;
        self.observe_home()
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
        let patches = self.viewed.missing(&self.aosm.grid);
        if patches.len() < N_PATCHES_MIN as usize {
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
            let seen = patches
                .iter()
                .filter(|patch| self.is_in_view(&place, patch));
            let (mut n_seen, mut ahead) = (0_u32, Vector2::zeros());
            for patch in seen {
                n_seen += 1;
                ahead += patch - place;
            }
            if n_seen < N_PATCHES_MIN {
                continue;
            }
            let goal = Pose2::new(place.coords, ahead.y.atan2(ahead.x));
            let Ok((_, length_m)) = path_on(&grid, &here, &goal) else {
                continue;
            };
            let gain = f64::from(n_seen) / (2.0 + length_m);
            if best.as_ref().is_none_or(|(most, _)| gain > *most) {
                best = Some((gain, goal));
            }
        }
        Ok(best.map(|(_, goal)| goal))
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
