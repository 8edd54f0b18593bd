//! Inverse kinematics: configurations that bring the tool to a pose, within limits and free of collision.
//!
//! Descents (damped least squares with limits) start from the seeds, then from random configurations, until
//! enough solutions are found or the restarts are used up; the preferred solution is returned.

pub(crate) mod descent;

use nalgebra::Matrix6xX;
use rand::Rng;

use crate::Pose;
use crate::manipulability::manipulability;
use crate::scene::PlanningScene;
use descent::{Descender, Descent, DescentOptions};

/// Which of several solutions is returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum IkPreference {
    /// The first found: fastest.
    First,
    /// The one with the highest manipulability (thesis Eq. 3.2).
    #[default]
    Manipulability,
    /// The one nearest to the first seed in the joint metric; without seeds, the first found.
    NearestSeed,
}

/// What counts as solved, and the caps of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IkOptions {
    /// Largest distance of the tool point, metres.
    pub position_tol_m: f64,
    /// Largest rotation error, radians.
    pub rotation_tol_rad: f64,
    /// Cap: descents from random configurations, after those from the seeds.
    pub restarts: usize,
    /// Cap: steps of one descent.
    pub iterations: usize,
    /// Solutions in collision are passed over.
    pub avoid_collision: bool,
    /// The rotation about the tool's z axis does not matter.
    pub axis_free: bool,
    /// Which solution is returned.
    pub prefer: IkPreference,
    /// How many solutions are gathered before the preferred one is chosen (not for [`IkPreference::First`]).
    pub n_candidates: usize,
}

impl Default for IkOptions {
    fn default() -> Self {
        Self {
            position_tol_m: 1e-4,
            rotation_tol_rad: 1e-3,
            restarts: 50,
            iterations: 100,
            avoid_collision: true,
            axis_free: false,
            prefer: IkPreference::Manipulability,
            n_candidates: 8,
        }
    }
}

/// What came of an inverse kinematics search.
#[derive(Debug, Clone, PartialEq)]
pub enum IkOutcome {
    /// The tool reaches the pose.
    Solved(IkSolution),
    /// The caps were used up without a solution.
    Failed(IkFailure),
}

impl IkOutcome {
    /// The solution's configuration, if there is one.
    pub fn q(&self) -> Option<&[f64]> {
        match self {
            Self::Solved(solution) => Some(&solution.q),
            Self::Failed(_) => None,
        }
    }
}

/// A configuration that reaches the pose.
#[derive(Debug, Clone, PartialEq)]
pub struct IkSolution {
    /// The configuration; turns are chosen nearest to the first seed where limits allow.
    pub q: Vec<f64>,
    /// Its manipulability (thesis Eq. 3.2).
    pub manipulability: f64,
    /// Descents from random configurations until the search ended.
    pub restarts: usize,
}

/// Why there is no solution.
#[derive(Debug, Clone, PartialEq)]
pub struct IkFailure {
    /// Position error of the descent that came nearest, metres.
    pub best_position_error_m: f64,
    /// Rotation error of that descent, radians.
    pub best_rotation_error_rad: f64,
    /// The pose was reached, but only with these in collision (the first pair met).
    pub collision: Option<(String, String)>,
    /// Descents from random configurations that were used up.
    pub restarts: usize,
}

/// Searches one configuration that brings the tool to `base_from_tcp`.
///
/// `seeds` of the wrong length are passed over.
pub fn solve_ik(
    scene: &mut PlanningScene,
    base_from_tcp: &Pose,
    seeds: &[Vec<f64>],
    options: &IkOptions,
    rng: &mut impl Rng,
) -> IkOutcome {
    let n_wanted = match options.prefer {
        IkPreference::First => 1,
        IkPreference::Manipulability | IkPreference::NearestSeed => options.n_candidates.max(1),
    };
    let (solutions, failure) = search(scene, base_from_tcp, seeds, options, n_wanted, rng);
    solutions
        .into_iter()
        .next()
        .map_or(IkOutcome::Failed(failure), IkOutcome::Solved)
}

/// Searches up to `n_wanted` different configurations, the preferred first.
pub fn solve_ik_many(
    scene: &mut PlanningScene,
    base_from_tcp: &Pose,
    seeds: &[Vec<f64>],
    options: &IkOptions,
    n_wanted: usize,
    rng: &mut impl Rng,
) -> Vec<Vec<f64>> {
    let (solutions, _) = search(scene, base_from_tcp, seeds, options, n_wanted, rng);
    solutions.into_iter().map(|solution| solution.q).collect()
}

/// Two solutions nearer than this in the joint metric count as one.
const SAME_SOLUTION: f64 = 0.05;

/// Different solutions, the preferred first, and what is to be said if there are none.
fn search(
    scene: &mut PlanningScene,
    base_from_tcp: &Pose,
    seeds: &[Vec<f64>],
    options: &IkOptions,
    n_wanted: usize,
    rng: &mut impl Rng,
) -> (Vec<IkSolution>, IkFailure) {
    let robot = scene.robot().clone();
    let (chain, space) = (robot.chain(), robot.space());
    let n = robot.n();
    let seeds: Vec<&Vec<f64>> = seeds
        .iter()
        .filter(|seed| seed.len() == n && seed.iter().all(|q| q.is_finite()))
        .collect();
    let reference = seeds
        .first()
        .map_or_else(|| robot.q_ready(), |seed| seed.to_vec());
    let descent_options = DescentOptions {
        position_tol_m: options.position_tol_m,
        rotation_tol_rad: options.rotation_tol_rad,
        iterations: options.iterations,
        axis_free: options.axis_free,
    };
    let mut descender = Descender::new(chain, space);
    let mut jacobian = Matrix6xX::zeros(n);
    let mut best = BestTry::default();
    let mut collision = None;
    let mut solutions: Vec<IkSolution> = Vec::new();
    let mut restarts = 0;
    let mut q = vec![0.0; n];
    for attempt in 0..seeds.len() + options.restarts {
        if solutions.len() >= n_wanted {
            break;
        }
        match seeds.get(attempt) {
            Some(seed) => q.copy_from_slice(seed),
            None => {
                restarts += 1;
                space.sample_into(rng, &mut q);
            }
        }
        let descent = descender.descend(base_from_tcp, &mut q, &descent_options);
        best.keep(&descent);
        if !descent.is_converged {
            continue;
        }
        let solution = space.equivalent_near(&q, &reference);
        if solutions
            .iter()
            .any(|known| space.distance(&known.q, &solution) < SAME_SOLUTION)
        {
            continue;
        }
        if options.avoid_collision
            && let Some(pair) = scene.collision(&solution)
        {
            collision.get_or_insert(pair);
            continue;
        }
        chain.base_from_tcp_and_jacobian_into(&solution, &mut jacobian);
        let manipulability = manipulability(&jacobian, space.limits(), &solution);
        solutions.push(IkSolution {
            q: solution,
            manipulability,
            restarts,
        });
    }
    for solution in &mut solutions {
        solution.restarts = restarts;
    }
    match options.prefer {
        IkPreference::First => {}
        IkPreference::Manipulability => {
            solutions.sort_by(|a, b| b.manipulability.total_cmp(&a.manipulability));
        }
        IkPreference::NearestSeed if seeds.is_empty() => {}
        IkPreference::NearestSeed => solutions.sort_by(|a, b| {
            space
                .distance(&reference, &a.q)
                .total_cmp(&space.distance(&reference, &b.q))
        }),
    }
    let failure = IkFailure {
        best_position_error_m: best.position_error_m,
        best_rotation_error_rad: best.rotation_error_rad,
        collision,
        restarts,
    };
    (solutions, failure)
}

/// The descent that came nearest, a radian counting as much as a metre.
#[derive(Debug)]
struct BestTry {
    position_error_m: f64,
    rotation_error_rad: f64,
}

impl Default for BestTry {
    fn default() -> Self {
        Self {
            position_error_m: f64::INFINITY,
            rotation_error_rad: f64::INFINITY,
        }
    }
}

impl BestTry {
    fn keep(&mut self, descent: &Descent) {
        let error = descent.position_error_m + descent.rotation_error_rad;
        if error < self.position_error_m + self.rotation_error_rad {
            self.position_error_m = descent.position_error_m;
            self.rotation_error_rad = descent.rotation_error_rad;
        }
    }
}

#[cfg(test)]
mod tests;
