//! Driving: a path on the map, sent in the odometry frame, watched for drift and for things in the way.

use factotum_control::{BasePath, Command, MotionStatus, Robot};
use factotum_geometry::Pose2;
use factotum_motion::{BaseOutcome, BasePathOptions, InflatedGrid, plan_base};
use nalgebra::Point2;

use crate::AgentError;

/// How a drive ended.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Drive {
    /// At the goal, as far as the robot knows.
    Arrived,
    /// Something stands on the path that was not on the map.
    Blocked(Point2<f64>),
    /// No path, or the base gave up.
    Failed(String),
}

/// Fraction of the speed limits used for driving.
const SPEED: f64 = 0.9;
/// How long a drive may take beyond its expected duration, as a factor and seconds.
const PATIENCE: (f64, f64) = (3.0, 10.0);

/// A path on the inflated grid, or why there is none, in words.
pub(crate) fn path_on(
    grid: &InflatedGrid,
    map_from_start: &Pose2,
    map_from_goal: &Pose2,
) -> Result<(Vec<Pose2>, f64), String> {
    match plan_base(
        grid,
        map_from_start,
        map_from_goal,
        &BasePathOptions::default(),
    ) {
        BaseOutcome::Solved { path, length_m, .. } => Ok((path, length_m)),
        BaseOutcome::StartBlocked => {
            Err("the robot stands too near to an obstacle to start".to_owned())
        }
        BaseOutcome::GoalBlocked => {
            Err("the goal is too near to an obstacle or off the map".to_owned())
        }
        _ => Err("no free way on the map leads there".to_owned()),
    }
}

/// What a watcher makes of a drive under way.
pub(crate) enum Watch {
    /// Go on.
    GoOn,
    /// The odometry frame lies elsewhere in the map than was thought: send the rest of the path anew.
    Drifted(Pose2),
    /// Something stands in the way.
    Blocked(Point2<f64>),
    /// There is no point in going on, for this reason.
    GiveUp(String),
}

/// Sends a path and waits until the drive is over; `watch` is asked ten times a second.
pub(crate) fn follow(
    robot: &mut dyn Robot,
    mut map_from_odom: Pose2,
    path: &[Pose2],
    length_m: f64,
    watch: &mut dyn FnMut(&mut dyn Robot) -> Result<Watch, AgentError>,
) -> Result<Drive, AgentError> {
    const PERIOD_SECS: f64 = 0.1;
    let speed_m_per_s = robot
        .description()
        .base
        .as_ref()
        .map_or(0.1, |base| base.velocity_max_m_per_s);
    let timeout_secs = PATIENCE.0 * length_m / speed_m_per_s + PATIENCE.1;
    let started_secs = robot.state()?.time_secs;
    let mut id = robot.send(command(&map_from_odom, path))?;
    loop {
        robot.wait(PERIOD_SECS)?;
        match robot.progress(id)? {
            MotionStatus::Done | MotionStatus::Guarded => return Ok(Drive::Arrived),
            MotionStatus::Aborted(reason) => return Ok(Drive::Failed(reason)),
            MotionStatus::Preempted => return Ok(Drive::Failed("stopped".to_owned())),
            MotionStatus::Active => {}
        }
        match watch(robot)? {
            Watch::GoOn => {}
            Watch::Drifted(now) => {
                map_from_odom = now;
                let map_from_base = map_from_odom * robot.state()?.odom_from_base;
                id = robot.send(command(&map_from_odom, rest_of(path, &map_from_base)))?;
            }
            Watch::Blocked(place) => {
                robot.stop()?;
                return Ok(Drive::Blocked(place));
            }
            Watch::GiveUp(reason) => {
                robot.stop()?;
                return Ok(Drive::Failed(reason));
            }
        }
        if robot.state()?.time_secs - started_secs > timeout_secs {
            robot.stop()?;
            return Ok(Drive::Failed(format!(
                "not there after {timeout_secs:.0} s"
            )));
        }
    }
}

fn command(map_from_odom: &Pose2, path: &[Pose2]) -> Command {
    let odom_from_map = map_from_odom.inverse();
    let odom_from_base = path.iter().map(|pose| odom_from_map * pose).collect();
    Command::BasePath(BasePath {
        odom_from_base,
        speed: SPEED,
    })
}

/// The part of a path that still lies ahead: what follows its nearest pose, or at least its end.
pub(crate) fn rest_of<'a>(path: &'a [Pose2], map_from_base: &Pose2) -> &'a [Pose2] {
    let distance =
        |pose: &Pose2| (pose.translation.vector - map_from_base.translation.vector).norm();
    let nearest =
        (0..path.len()).min_by(|a, b| distance(&path[*a]).total_cmp(&distance(&path[*b])));
    let next = nearest.map_or(0, |nearest| nearest + 1);
    &path[next.min(path.len().saturating_sub(1))..]
}
