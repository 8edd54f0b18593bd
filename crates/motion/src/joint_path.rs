//! Collision-free joint paths in a scene.

use rand::Rng;

use crate::sampling::{
    SearchOptions, is_motion_valid, rrt_connect, rrt_star, shortcut, unwrap_turns,
};
use crate::scene::{CLEARANCE_SEEN_M, PlanningScene};
use crate::timing::{Blend, TimingOptions};

pub use crate::sampling::SearchLimit;

/// Caps and resolution of a joint path search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanLimits {
    /// Cap: nodes of all trees together.
    pub n_nodes_max: usize,
    /// Cap: samples drawn.
    pub iterations_max: usize,
    /// Distance of collision checks along a path, in the joint metric (rad).
    pub step_rad: f64,
    /// Longest edge of a tree, in the joint metric (rad).
    pub range_rad: f64,
    /// Attempts to shorten the path.
    pub shortcut_iterations: usize,
}

impl Default for PlanLimits {
    fn default() -> Self {
        Self {
            n_nodes_max: 20_000,
            iterations_max: 20_000,
            step_rad: 0.05,
            range_rad: 1.0,
            shortcut_iterations: 200,
        }
    }
}

/// What a search did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PathStats {
    /// Nodes of all trees.
    pub n_nodes: usize,
    /// Samples drawn.
    pub iterations: usize,
    /// Configurations checked for collision.
    pub n_checks: usize,
    /// Length of the first path found, in the joint metric.
    pub length_found: f64,
    /// Length of the path returned, in the joint metric.
    pub length: f64,
}

/// A collision-free path.
#[derive(Debug, Clone, PartialEq)]
pub struct JointPathPlan {
    /// Waypoints from the start to a goal; straight in joint space between them.
    ///
    /// Continuous joints are unwrapped. A waypoint that occurs twice in a row is a stop: rounding its
    /// corner would collide (see [`crate::timing`]).
    pub path: Vec<Vec<f64>>,
    /// Which goal it reaches.
    pub goal_idx: usize,
    /// What the search did.
    pub stats: PathStats,
}

/// What came of a joint path search.
#[derive(Debug, Clone, PartialEq)]
pub enum PathOutcome {
    /// There is a path.
    Solved(JointPathPlan),
    /// The start collides (first pair).
    StartInCollision((String, String)),
    /// Every goal collides (first pair of the first goal).
    GoalInCollision((String, String)),
    /// No goal is within the joint limits; the first joint of the first goal that is not.
    GoalOutsideLimits {
        /// The joint.
        joint: String,
        /// Its position in the first goal.
        position: f64,
    },
    /// There is no goal, or each has the wrong length.
    NoGoal,
    /// A cap ended the search.
    LimitReached {
        /// Which cap.
        limit: SearchLimit,
        /// What the search did until then.
        stats: PathStats,
    },
}

impl PathOutcome {
    /// The path, if there is one.
    pub fn path(&self) -> Option<&[Vec<f64>]> {
        match self {
            Self::Solved(plan) => Some(&plan.path),
            _ => None,
        }
    }
}

/// Plans from a start to any of the goals by RRT-Connect, then shortens the path.
pub fn plan_joints(
    scene: &mut PlanningScene,
    q_start: &[f64],
    q_goals: &[Vec<f64>],
    limits: &PlanLimits,
    rng: &mut impl Rng,
) -> PathOutcome {
    plan(scene, q_start, q_goals, limits, rng, Planner::RrtConnect)
}

/// Plans from a start to any of the goals by RRT*, which spends all its iterations on a short path.
pub fn plan_joints_star(
    scene: &mut PlanningScene,
    q_start: &[f64],
    q_goals: &[Vec<f64>],
    limits: &PlanLimits,
    rng: &mut impl Rng,
) -> PathOutcome {
    plan(scene, q_start, q_goals, limits, rng, Planner::RrtStar)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Planner {
    RrtConnect,
    RrtStar,
}

/// How often the resolution is halved when a path collides between its checked configurations.
const N_RESOLUTIONS: usize = 3;
/// Smallest step of a search; keeps a zero or NaN from asking for endless checks.
const STEP_MIN_RAD: f64 = 1e-4;
/// A finished path is checked at this fraction of the search's step.
const FINAL_STEP_FRACTION: f64 = 0.1;

fn plan(
    scene: &mut PlanningScene,
    q_start: &[f64],
    q_goals: &[Vec<f64>],
    limits: &PlanLimits,
    rng: &mut impl Rng,
    planner: Planner,
) -> PathOutcome {
    let robot = scene.robot().clone();
    let space = robot.space();
    // 1. Ends: the start must be free, and at least one goal within limits and free.
    if let Some(pair) = scene.collision(q_start) {
        return PathOutcome::StartInCollision(pair);
    }
    let goals = match usable_goals(scene, q_goals) {
        Ok(goals) => goals,
        Err(outcome) => return outcome,
    };
    let goal_qs: Vec<Vec<f64>> = goals.iter().map(|&idx| q_goals[idx].clone()).collect();
    let clearance_m = clearance_to_keep(scene, q_start, &goal_qs);
    // 2. Search and shorten; where the path turns out to collide at a finer step, again with half the step.
    let mut stats = PathStats::default();
    let mut limit = SearchLimit::Resolution;
    let mut step = limits.step_rad.max(STEP_MIN_RAD);
    for _ in 0..N_RESOLUTIONS {
        let options = SearchOptions {
            n_nodes_max: limits.n_nodes_max,
            iterations_max: limits.iterations_max,
            step,
            range: limits.range_rad.max(step),
        };
        let (mut n_checks, mut n_fine_checks) = (0, 0);
        let mut validity = |q: &[f64]| {
            n_checks += 1;
            space.is_within_limits(q) && scene.is_free_by(q, clearance_m)
        };
        let search = match planner {
            Planner::RrtConnect => {
                rrt_connect(space, &mut validity, q_start, &goal_qs, &options, rng)
            }
            Planner::RrtStar => rrt_star(space, &mut validity, q_start, &goal_qs, &options, rng),
        };
        stats.n_nodes += search.n_nodes;
        stats.iterations += search.iterations;
        let mut is_solved = false;
        let mut found = None;
        match search.path {
            Ok(path) => {
                let mut waypoints = path.waypoints;
                stats.length_found = space.path_length(&waypoints);
                shortcut(
                    space,
                    &mut validity,
                    &mut waypoints,
                    step,
                    limits.shortcut_iterations,
                    rng,
                );
                unwrap_turns(space, &mut waypoints);
                stats.length = space.path_length(&waypoints);
                // Half of the clearance, so that nothing is touched between these checks either.
                let mut half_clear = |q: &[f64]| {
                    n_fine_checks += 1;
                    space.is_within_limits(q) && scene.is_free_by(q, 0.5 * clearance_m)
                };
                is_solved = waypoints.windows(2).all(|pair| {
                    let fine = FINAL_STEP_FRACTION * step;
                    is_motion_valid(space, &mut half_clear, &pair[0], &pair[1], fine)
                });
                found = Some((waypoints, goals[path.goal_idx]));
            }
            Err(cap) => limit = cap,
        }
        stats.n_checks += n_checks + n_fine_checks;
        match found {
            Some((path, goal_idx)) if is_solved => {
                let path = with_stops(scene, path, FINAL_STEP_FRACTION * step, clearance_m);
                return PathOutcome::Solved(JointPathPlan {
                    path,
                    goal_idx,
                    stats,
                });
            }
            Some(_) => step *= 0.5,
            None => break,
        }
    }
    PathOutcome::LimitReached { limit, stats }
}

/// Distance to keep from obstacles on the way, so that nothing is touched between checks: half of what the ends have.
fn clearance_to_keep(scene: &mut PlanningScene, start: &[f64], goals: &[Vec<f64>]) -> f64 {
    let mut least = scene.clearance_m(start);
    for goal in goals {
        least = least.min(scene.clearance_m(goal));
    }
    if least >= CLEARANCE_SEEN_M {
        CLEARANCE_SEEN_M
    } else {
        0.5 * least.max(0.0)
    }
}

/// The path with each waypoint doubled whose corner, rounded as [`crate::timing`] does by default, would collide.
fn with_stops(
    scene: &mut PlanningScene,
    path: Vec<Vec<f64>>,
    step: f64,
    clearance_m: f64,
) -> Vec<Vec<f64>> {
    let deviation = TimingOptions::default().blend_deviation_rad;
    let is_stop: Vec<bool> = path
        .windows(3)
        .map(|corner| {
            let Some(blend) = Blend::between(&corner[0], &corner[1], &corner[2], deviation) else {
                return false;
            };
            let n_steps = (blend.length() / step).ceil().max(1.0) as usize;
            (1..n_steps).any(|i| {
                let (q, _) = blend.at(blend.length() * i as f64 / n_steps as f64);
                !scene.is_free_by(&q, clearance_m)
            })
        })
        .collect();
    let mut stopping = Vec::with_capacity(path.len());
    for (i, q) in path.into_iter().enumerate() {
        let is_stop = i
            .checked_sub(1)
            .and_then(|i| is_stop.get(i))
            .copied()
            .unwrap_or(false);
        if is_stop {
            stopping.push(q.clone());
        }
        stopping.push(q);
    }
    stopping
}

/// Indices of the goals within limits and free, or why there is none.
fn usable_goals(
    scene: &mut PlanningScene,
    q_goals: &[Vec<f64>],
) -> Result<Vec<usize>, PathOutcome> {
    let robot = scene.robot().clone();
    let mut usable = Vec::new();
    let mut outside = None;
    let mut collision = None;
    for (idx, q) in q_goals.iter().enumerate() {
        if q.len() != robot.n() {
            continue;
        }
        if let Some(j) = robot
            .limits()
            .iter()
            .zip(q)
            .position(|(limit, &q)| !limit.allows(q))
        {
            outside.get_or_insert((robot.chain_joints()[j].clone(), q[j]));
        } else if let Some(pair) = scene.collision(q) {
            collision.get_or_insert(pair);
        } else {
            usable.push(idx);
        }
    }
    if !usable.is_empty() {
        return Ok(usable);
    }
    Err(match (collision, outside) {
        (Some(pair), _) => PathOutcome::GoalInCollision(pair),
        (None, Some((joint, position))) => PathOutcome::GoalOutsideLimits { joint, position },
        (None, None) => PathOutcome::NoGoal,
    })
}

#[cfg(test)]
mod tests;
