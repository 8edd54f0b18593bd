//! Interleaved navigation: where to stand for an option, and how to get there (thesis 5.3).

use std::f64::consts::{PI, TAU};

use factotum_geometry::frames::planar_from_pose;
use factotum_geometry::grid::OccupancyGrid;
use factotum_geometry::{Pose, Pose2};
use factotum_motion::{InflatedGrid, InflationOptions};
use factotum_semantic_map::{Aosm, GraphNode, NavigationAnchor, OptionSpec, TopologicalGraph};
use factotum_skills::{Initiation, Skill, is_holding};
use factotum_symbols::ground;
use nalgebra::{Point2, Vector2};
use rand_chacha::ChaCha8Rng;

use crate::act::skill_for;
use crate::drive::{self, Drive, Watch};
use crate::learned::symbol_of;
use crate::perform::sought_by;
use crate::senses::Care;
use crate::viewed::half_view_rad;
use crate::{AgentError, Executive, LogLevel, Settings};

/// Where to stand for an option.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum BaseChoice {
    /// Its skill could start from here, as far as is known.
    Possible(Pose2),
    /// It could start from nowhere.
    None {
        /// The nearest place of its navigation symbol that a path leads to, or else one from which the object may be
        /// seen: from there, things may look different.
        nearest: Option<Pose2>,
        /// What is in the way, by the last place looked at.
        reason: String,
    },
}

impl Executive<'_> {
    /// The nearest base pose of the option's navigation symbol from which its skill could start.
    pub(crate) fn choose_base(
        &mut self,
        option: &OptionSpec,
        spent: &[Pose2],
    ) -> Result<BaseChoice, AgentError> {
        let grid = self.inflated();
        let here = self.map_from_base()?;
        let mut reason = format!(
            "no free place to stand for {} at `{}`",
            option.step.name, option.object
        );
        let mut nearest = None;
        if let Some(skill) = self.learned_for(option)? {
            let class = &option.anchor.symbol.object_class;
            let anchor = NavigationAnchor {
                map_from_object: option.anchor.map_from_object,
                symbol: symbol_of(&skill, class),
            };
            let poses = self.grounded(&anchor, &grid);
            // Where it cannot start, the given skill may.
            let mut unused = None;
            let tried = self.first_possible(option, &skill, poses, spent, &mut unused, &mut reason);
            if let Some(pose) = tried? {
                return Ok(BaseChoice::Possible(pose));
            }
            let name = &skill.task().name;
            let text = format!("no place to stand for the learned skill {name}: {reason}");
            self.log(LogLevel::Info, text)?;
        }
        let poses = self.grounded(&option.anchor, &grid);
        let skill = skill_for(option);
        let tried = self.first_possible(
            option,
            skill.as_ref(),
            poses,
            spent,
            &mut nearest,
            &mut reason,
        );
        if let Some(pose) = tried? {
            return Ok(BaseChoice::Possible(pose));
        }
        if nearest.is_none() {
            let sought = sought_by(option);
            nearest = self.place_to_see(sought, &option.anchor.map_from_object, &grid, &here);
        }
        Ok(BaseChoice::None { nearest, reason })
    }

    /// The nearest of some base poses from which a skill could start; `nearest` becomes the nearest that a path leads to and
    /// from which the object was not looked at before, `reason` what is in the way at the last one.
    fn first_possible(
        &mut self,
        option: &OptionSpec,
        skill: &dyn Skill,
        poses: Vec<Pose2>,
        spent: &[Pose2],
        nearest: &mut Option<Pose2>,
        reason: &mut String,
    ) -> Result<Option<Pose2>, AgentError> {
        /// Poses nearer than this to one that failed are not tried again, metres.
        const APART_M: f64 = 0.08;
        let here = self.map_from_base()?;
        let distance = |a: &Pose2, b: &Pose2| (a.translation.vector - b.translation.vector).norm();
        let mut reachable: Vec<(f64, Pose2)> = poses
            .into_iter()
            .filter(|pose| spent.iter().all(|old| distance(old, pose) > APART_M))
            .map(|pose| (distance(&pose, &here), pose))
            .collect();
        reachable.sort_by(|a, b| a.0.total_cmp(&b.0));
        let sought = sought_by(option);
        let state = self.robot.state()?;
        let stride = (reachable.len() / self.settings.n_base_checks).max(1);
        for (_, pose) in reachable.into_iter().step_by(stride) {
            if let Err(why) = self.path_to(&pose)? {
                *reason = why;
                continue;
            }
            if nearest.is_none()
                && !self.was_looked_at_from(sought, &Point2::from(pose.translation.vector))
            {
                *nearest = Some(pose);
            }
            let situation = self.situation(option, &pose)?;
            match skill.initiation(&situation, &state, &mut self.rng)? {
                Initiation::Possible => return Ok(Some(pose)),
                Initiation::Impossible(failure) => {
                    *reason = failure.to_string();
                }
            }
        }
        Ok(None)
    }

    /// The nearest free place that a path leads to and from which an object may be seen well, and otherwise than before.
    fn place_to_see(
        &self,
        name: &str,
        map_from_object: &Pose,
        grid: &InflatedGrid,
        here: &Pose2,
    ) -> Option<Pose2> {
        /// Far enough to have it in view, near enough to see it well, metres.
        const DISTANCES_M: [f64; 3] = [0.9, 1.2, 1.5];
        const N_TURNS: u32 = 16;
        /// What stands at the object itself does not hide it, metres.
        const AT_OBJECT_M: f64 = 0.3;
        let object = map_from_object.translation.vector.xy();
        let mut best: Option<(f64, Pose2)> = None;
        for distance_m in DISTANCES_M {
            for turn in 0..N_TURNS {
                let bearing = TAU * f64::from(turn) / f64::from(N_TURNS);
                let away = Vector2::new(bearing.cos(), bearing.sin());
                let place = Point2::from(object + distance_m * away);
                let seen = Point2::from(object + AT_OBJECT_M * away);
                if self.was_looked_at_from(name, &place) {
                    continue;
                }
                if !grid.is_free_at(&place) || !self.aosm.grid.is_line_free(&place, &seen) {
                    continue;
                }
                let pose = Pose2::new(place.coords, bearing + PI);
                let Ok((_, length_m)) = drive::path_on(grid, here, &pose) else {
                    continue;
                };
                if best.is_none_or(|(least_m, _)| length_m < least_m) {
                    best = Some((length_m, pose));
                }
            }
        }
        best.map(|(_, pose)| pose)
    }

    /// Whether the robot went about there before to see an object better: it looks the same from there.
    fn was_looked_at_from(&self, name: &str, place: &Point2<f64>) -> bool {
        const APART_M: f64 = 0.7;
        let is_near = |(of, from): &(String, Pose2)| {
            of == name && (from.translation.vector - place.coords).norm() < APART_M
        };
        self.vantages.iter().any(is_near)
    }

    /// Base poses of a navigation symbol, in free space.
    fn grounded(&mut self, anchor: &NavigationAnchor, grid: &InflatedGrid) -> Vec<Pose2> {
        poses_of(anchor, grid, self.settings.n_base_samples, &mut self.rng)
    }

    /// Grounds the navigation symbols of all options, finds which regions are connected, and shows the map.
    ///
    /// # Errors
    /// [`AgentError`] if the robot does not answer, and [`AgentError::Stopped`] when the observer wished to stop.
    pub fn ground_graph(&mut self) -> Result<(), AgentError> {
        let footprint_m = self.footprint_m();
        self.graph = ground_home(&self.aosm, footprint_m, &self.settings, &mut self.rng);
        self.show_map()
    }

    pub(crate) fn footprint_m(&self) -> f64 {
        self.model.description().footprint_radius_m()
    }

    /// The grid with obstacles grown by the footprint and `clearance_m`.
    fn inflated_by(&self, clearance_m: f64) -> InflatedGrid {
        inflated(&self.aosm.grid, self.footprint_m() + clearance_m)
    }

    pub(crate) fn inflated(&self) -> InflatedGrid {
        self.inflated_by(self.settings.clearance_m)
    }

    /// A path to a pose in the map: with ample clearance if there is one, else with as much as there is.
    pub(crate) fn path_to(
        &mut self,
        map_from_goal: &Pose2,
    ) -> Result<Result<(Vec<Pose2>, f64), String>, AgentError> {
        let here = self.map_from_base()?;
        let mut found = Err(String::new());
        for share in [1.0, 0.5, 0.0] {
            let grid = self.inflated_by(share * self.settings.clearance_m);
            found = drive::path_on(&grid, &here, map_from_goal);
            if found.is_ok() {
                break;
            }
        }
        Ok(found)
    }

    /// Where the robot believes to stand.
    pub(crate) fn map_from_base(&mut self) -> Result<Pose2, AgentError> {
        Ok(self.senses.map_from_odom() * self.robot.state()?.odom_from_base)
    }

    /// Scans and looks, and takes over what came of it into the map.
    pub(crate) fn observe_home(&mut self) -> Result<(), AgentError> {
        self.observe(Care::InPassing)
    }

    fn observe(&mut self, care: Care) -> Result<(), AgentError> {
        let base_from_held = self.base_from_held()?;
        self.senses.feel(self.robot)?;
        self.senses
            .look(self.robot, &mut self.aosm, base_from_held, care)?;
        if let Some(map) = self.senses.map() {
            self.aosm.grid.clone_from(map);
        }
        let (here, half_view_rad) = (self.map_from_base()?, self.half_view_rad());
        self.viewed.add_look(&self.aosm.grid, &here, half_view_rad);
        Ok(())
    }

    /// Half of what the camera sees from left to right, less a margin, radians.
    pub(crate) fn half_view_rad(&self) -> f64 {
        half_view_rad(self.model.description().sensors.camera.as_ref())
    }

    /// Looks a few times at rest, so that what is acted on is known as well as can be.
    pub(crate) fn look_closely(&mut self) -> Result<(), AgentError> {
        self.look_at_rest(Care::Close)
    }

    /// Looks a few times at rest, with so much care.
    pub(crate) fn look_at_rest(&mut self, care: Care) -> Result<(), AgentError> {
        const N_LOOKS: usize = 5;
        for _ in 0..N_LOOKS {
            self.robot.wait(0.1)?;
            self.observe(care)?;
        }
        Ok(())
    }

    /// Drives to a pose in the map, with the arm tucked; the answer is why not, in words, if it failed.
    pub(crate) fn drive_to(
        &mut self,
        map_from_goal: &Pose2,
    ) -> Result<Result<(), String>, AgentError> {
        self.tuck()?;
        self.observe_home()?;
        let (path, length_m) = match self.path_to(map_from_goal)? {
            Ok(found) => found,
            Err(why) => return Ok(Err(why)),
        };
        self.follow(&path, length_m)
    }

    fn follow(&mut self, path: &[Pose2], length_m: f64) -> Result<Result<(), String>, AgentError> {
        /// The path is sent anew when the map shows that odometry is off by this much.
        const DRIFT: (f64, f64) = (0.03, 0.03);
        /// A new obstacle this near to the path ahead blocks it, metres.
        const NEAR_M: f64 = 0.12;
        let base_from_held = self.base_from_held()?;
        let start_drift = self.senses.map_from_odom();
        let half_view_rad = self.half_view_rad();
        let Self {
            robot,
            senses,
            aosm,
            viewed,
            ..
        } = self;
        let footprint_m = robot.description().footprint_radius_m();
        let mut sent = start_drift;
        let mut n_looks = 0_usize;
        let ended = drive::follow(*robot, start_drift, path, length_m, &mut |robot| {
            senses.feel(robot)?;
            n_looks += 1;
            let is_look = n_looks.is_multiple_of(8);
            if is_look {
                senses.look(robot, aosm, base_from_held, Care::InPassing)?;
            }
            let state = robot.state()?;
            if base_from_held.is_some() && !is_holding(state.gripper_opening) {
                return Ok(Watch::GiveUp(
                    "the gripper has lost what it held".to_owned(),
                ));
            }
            let map_from_base = senses.map_from_odom() * state.odom_from_base;
            if let Some(map) = senses.map().filter(|_| is_look) {
                viewed.add_look(map, &map_from_base, half_view_rad);
            }
            if let Some(map) = senses.map()
                && n_looks.is_multiple_of(3)
                && let Some(place) = obstacle_on(
                    map,
                    drive::rest_of(path, &map_from_base),
                    footprint_m - NEAR_M,
                )
            {
                return Ok(Watch::Blocked(place));
            }
            let now = senses.map_from_odom();
            // Where the base is believed to be, by then and by now: far from where odometry began, the frame itself moves
            // much with a small turn.
            let change = (sent * state.odom_from_base).inverse() * map_from_base;
            if change.translation.vector.norm() > DRIFT.0 || change.rotation.angle().abs() > DRIFT.1
            {
                sent = now;
                return Ok(Watch::Drifted(now));
            }
            Ok(Watch::GoOn)
        })?;
        if let Some(map) = self.senses.map() {
            self.aosm.grid.clone_from(map);
        }
        match ended {
            Drive::Arrived => Ok(Ok(())),
            Drive::Blocked(at) => Ok(Err(format!(
                "something stands in the way at ({:.1}, {:.1}) m",
                at.x, at.y
            ))),
            Drive::Failed(why) => Ok(Err(why)),
        }
    }
}

/// Grounds the navigation symbols of all options in a home for a base with this footprint radius (m), and finds which
/// regions are connected (thesis 5.2).
pub fn ground_home(
    aosm: &Aosm,
    footprint_radius_m: f64,
    settings: &Settings,
    rng: &mut ChaCha8Rng,
) -> TopologicalGraph {
    /// Poses kept per region, enough to draw it.
    const N_SHOWN: usize = 40;
    let grid = inflated(&aosm.grid, footprint_radius_m + settings.clearance_m);
    let mut node = |option: OptionSpec| {
        let mut poses = poses_of(&option.anchor, &grid, settings.n_base_samples, rng);
        poses.truncate(N_SHOWN);
        GraphNode {
            option: option.step,
            map_from_base: poses,
        }
    };
    let nodes = aosm.options().into_iter().map(&mut node).collect();
    TopologicalGraph::build(nodes, |from, to| {
        drive::path_on(&grid, from, to)
            .ok()
            .map(|(_, length_m)| length_m)
    })
}

/// Base poses of a navigation symbol, in free space.
fn poses_of(
    anchor: &NavigationAnchor,
    grid: &InflatedGrid,
    n: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<Pose2> {
    ground(
        &anchor.symbol,
        planar_from_pose(&anchor.map_from_object),
        |pose| grid.is_free_at(&Point2::from(pose.translation.vector)),
        rng,
        n,
    )
}

fn inflated(grid: &OccupancyGrid, radius_m: f64) -> InflatedGrid {
    InflatedGrid::new(grid, &InflationOptions::for_radius(radius_m))
}

/// The first place of a path whose surroundings hold an obstacle.
fn obstacle_on(map: &OccupancyGrid, path: &[Pose2], radius_m: f64) -> Option<Point2<f64>> {
    /// Only what lies this far ahead matters now, metres.
    const AHEAD_M: f64 = 1.5;
    let n_around = 8;
    let first = path.first()?;
    path.iter()
        .take_while(|pose| (pose.translation.vector - first.translation.vector).norm() < AHEAD_M)
        .flat_map(|pose| {
            (0..n_around).map(move |i| {
                let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n_around);
                Point2::from(
                    pose.translation.vector
                        + radius_m * nalgebra::Vector2::new(angle.cos(), angle.sin()),
                )
            })
        })
        .find(|point| map.cell_at(point).is_occupied())
}
