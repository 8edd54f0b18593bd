//! Interleaved navigation: where to stand for an option, and how to get there (thesis 5.3).

use factotum_geometry::Pose2;
use factotum_geometry::frames::planar_from_pose;
use factotum_motion::{InflatedGrid, InflationOptions};
use factotum_semantic_map::{GraphNode, OptionSpec, TopologicalGraph};
use factotum_skills::Initiation;
use factotum_symbols::ground;
use nalgebra::Point2;

use crate::act::skill_for;
use crate::drive::{self, Drive};
use crate::{AgentError, Executive};

impl Executive<'_> {
    /// The nearest base pose of the option's navigation symbol from which its skill could start.
    pub(crate) fn choose_base(
        &mut self,
        option: &OptionSpec,
        spent: &[Pose2],
        reason: &mut String,
    ) -> Result<Option<Pose2>, AgentError> {
        /// Poses nearer than this to one that failed are not tried again, metres.
        const APART_M: f64 = 0.08;
        let grid = self.inflated()?;
        let here = self.map_from_base()?;
        let poses = self.grounded(option, &grid);
        if poses.is_empty() {
            *reason = format!("no free place to stand for {} at `{}`", option.step.name, option.object);
            return Ok(None);
        }
        let mut reachable: Vec<(f64, Pose2)> = poses
            .into_iter()
            .filter(|pose| spent.iter().all(|old| (old.translation.vector - pose.translation.vector).norm() > APART_M))
            .map(|pose| ((pose.translation.vector - here.translation.vector).norm(), pose))
            .collect();
        reachable.sort_by(|a, b| a.0.total_cmp(&b.0));
        let skill = skill_for(option);
        let state = self.robot.state()?;
        let stride = (reachable.len() / self.settings.n_base_checks).max(1);
        for (_, pose) in reachable.into_iter().step_by(stride) {
            if let Err(why) = drive::path_on(&grid, &here, &pose) {
                *reason = why;
                continue;
            }
            let situation = self.situation(option, &pose)?;
            match skill.initiation(&situation, &state, &mut self.rng)? {
                Initiation::Possible => return Ok(Some(pose)),
                Initiation::Impossible(failure) => *reason = failure.to_string(),
            }
        }
        Ok(None)
    }

    /// Base poses of an option's navigation symbol, in free space.
    fn grounded(&mut self, option: &OptionSpec, grid: &InflatedGrid) -> Vec<Pose2> {
        ground(
            &option.anchor.symbol,
            planar_from_pose(&option.anchor.map_from_object),
            |pose| grid.is_free_at(&Point2::from(pose.translation.vector)),
            &mut self.rng,
            self.settings.n_base_samples,
        )
    }

    /// Grounds the navigation symbols of all options and finds which regions are connected.
    pub(crate) fn ground_graph(&mut self) -> Result<(), AgentError> {
        /// Poses kept per region, enough to draw it.
        const N_SHOWN: usize = 40;
        let grid = self.inflated()?;
        let nodes = self
            .aosm
            .options()
            .into_iter()
            .map(|option| {
                let mut poses = self.grounded(&option, &grid);
                poses.truncate(N_SHOWN);
                GraphNode { option: option.step, map_from_base: poses }
            })
            .collect();
        self.graph = TopologicalGraph::build(nodes, |from, to| {
            drive::path_on(&grid, from, to).ok().map(|(_, length_m)| length_m)
        });
        self.show_map()
    }

    fn inflated(&self) -> Result<InflatedGrid, AgentError> {
        let radius_m = self.model.description().base.as_ref().map_or(0.0, |base| base.footprint_radius_m);
        let options = InflationOptions::for_radius(radius_m + self.settings.clearance_m);
        Ok(InflatedGrid::new(&self.aosm.grid, &options))
    }

    /// Where the robot believes to stand.
    pub(crate) fn map_from_base(&mut self) -> Result<Pose2, AgentError> {
        Ok(self.map_from_odom * self.robot.state()?.odom_from_base)
    }

    pub(crate) fn drive_to(&mut self, map_from_goal: &Pose2) -> Result<Result<(), String>, AgentError> {
        let grid = self.inflated()?;
        let here = self.map_from_base()?;
        let (path, length_m) = match drive::path_on(&grid, &here, map_from_goal) {
            Ok(found) => found,
            Err(why) => return Ok(Err(why)),
        };
        match drive::follow(self.robot, &self.map_from_odom, &path, length_m, &mut |_| Ok(None))? {
            Drive::Arrived => Ok(Ok(())),
            Drive::Blocked(at) => Ok(Err(format!("something stands in the way at ({:.1}, {:.1}) m", at.x, at.y))),
            Drive::Failed(why) => Ok(Err(why)),
        }
    }
}
