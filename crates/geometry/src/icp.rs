//! Registration of a cloud to a surface without known correspondences.
//!
//! Minimises `Σ w_i (n_iᵀ (T s_i - t_i))²` over rigid motions `T`, pairing each source point with the
//! nearest target point. Method: point-to-plane ICP (Chen & Medioni, "Object modelling by registration
//! of multiple range images", IVC 10(3), 1992) with the small-angle linear solve of Low (UNC TR04-004,
//! 2004), trimming of the worst pairs (Chetverikov et al., ICPR 2002) and Huber weights on the rest
//! with a scale from their median.
//!
//! Differs: the normal equations are solved in their eigenbasis, and directions the data do not constrain
//! (sliding along a wall, turning a bottle about its axis) are left as they were and counted, after
//! Zhang, Kaess & Singh, "On degeneracy of optimization-based state estimation problems", ICRA 2016.
//! Lengths are divided by the cloud's radius first, so that one threshold serves angles and distances.
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | s, t, n | source point, target point, target normal | m, m, - |
//! | x = (ω, v) | small rotation and translation in the target frame | rad, radii |

use crate::Pose;
use crate::cloud::{NearestPoints, PointCloud};
use nalgebra::{Matrix6, Point3, Translation3, Unit, UnitQuaternion, Vector3, Vector6};

/// Settings of [`IcpTarget::register`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IcpParams {
    /// Most iterations.
    pub n_iterations_max: usize,
    /// Pairs farther apart than this are no pairs (m).
    pub pair_distance_max_m: f64,
    /// Share of the closest pairs that is kept; below 1 when part of the source is not on the target.
    pub keep_ratio: f64,
    /// Residual, in robust standard deviations, beyond which a pair's pull stops growing.
    pub huber_sigmas: f64,
    /// Converged when a step moves less than this (m)...
    pub step_translation_m: f64,
    /// ...and turns less than this (rad).
    pub step_rotation_rad: f64,
    /// Fewest pairs to work with.
    pub n_pairs_min: usize,
    /// Curvature of a direction, relative to the largest, below which it counts as unconstrained.
    pub constraint_ratio_min: f64,
    /// Which motions are tried.
    pub freedom: IcpFreedom,
}

/// The motions a registration may make, in the target's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IcpFreedom {
    /// All six.
    Full,
    /// Translations and turns about the target's z axis: both sides are known to stand upright.
    Upright,
    /// Translations only.
    Translation,
}

impl IcpFreedom {
    /// How many of the three rotations, x first, are held.
    fn n_held(self) -> usize {
        match self {
            Self::Full => 0,
            Self::Upright => 2,
            Self::Translation => 3,
        }
    }
}

impl Default for IcpParams {
    fn default() -> Self {
        Self {
            n_iterations_max: 50,
            pair_distance_max_m: 0.5,
            keep_ratio: 1.0,
            huber_sigmas: 2.5,
            step_translation_m: 1e-6,
            step_rotation_rad: 1e-6,
            n_pairs_min: 10,
            constraint_ratio_min: 1e-4,
            freedom: IcpFreedom::Full,
        }
    }
}

/// Why the iterations ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IcpStop {
    /// The last step was smaller than both thresholds.
    Converged,
    /// [`IcpParams::n_iterations_max`] was reached.
    IterationCap,
}

/// Where the source lies on the target, and how sure that is.
#[derive(Debug, Clone, PartialEq)]
pub struct IcpResult {
    /// Lays source points onto the target.
    pub target_from_source: Pose,
    /// Iterations done.
    pub n_iterations: usize,
    /// Which condition ended them.
    pub stop: IcpStop,
    /// Root mean square distance of the kept pairs, along the target's normal (m).
    pub rms_m: f64,
    /// Share of all source points with a target point within [`IcpParams::pair_distance_max_m`].
    pub fitness: f64,
    /// Pairs kept in the last iteration.
    pub n_pairs: usize,
    /// How many of the free directions (six in [`IcpFreedom::Full`]) the data do not fix: 0 for a corner, 3 for a flat plane,
    /// 1 for a turned body such as a bottle. The result keeps the initial guess along them.
    pub n_unconstrained: usize,
}

impl IcpResult {
    /// Whether the iterations ended by themselves.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.stop == IcpStop::Converged
    }
}

/// Clouds that cannot be registered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IcpError {
    /// The target has no normals.
    #[error("registration target of {n_points} points has no normals; estimate them first")]
    NoNormals {
        /// Points of the target.
        n_points: usize,
    },
    /// A cloud has too few points.
    #[error("registration {cloud} has {found} points, expected at least {wanted}")]
    TooFewPoints {
        /// `source` or `target`.
        cloud: &'static str,
        /// Points there are.
        found: usize,
        /// Points needed.
        wanted: usize,
    },
    /// A cloud has a coordinate that is NaN or infinite.
    #[error("registration {cloud} has a coordinate that is not finite at point {point}")]
    NotFinite {
        /// `source` or `target`.
        cloud: &'static str,
        /// Index of the point.
        point: usize,
    },
    /// The clouds do not meet.
    #[error(
        "{found} pairs of points within {distance_max_m} m at iteration {iteration}, expected at least {wanted}"
    )]
    TooFewPairs {
        /// Pairs found.
        found: usize,
        /// Pairs needed.
        wanted: usize,
        /// Largest distance of a pair (m).
        distance_max_m: f64,
        /// Iteration, from 0.
        iteration: usize,
    },
}

/// A surface to register clouds to: points with normals and their search tree.
#[derive(Debug)]
pub struct IcpTarget {
    points: Vec<Point3<f64>>,
    normals: Vec<Unit<Vector3<f64>>>,
    tree: NearestPoints,
}

struct Pair {
    /// Source point, already moved.
    source: Point3<f64>,
    normal: Unit<Vector3<f64>>,
    /// Signed distance along the normal (m).
    residual_m: f64,
    distance_m2: f64,
}

impl IcpTarget {
    /// Prepares a cloud with normals as a target.
    ///
    /// # Errors
    /// [`IcpError`] when it is empty, has no normals or is not finite.
    pub fn new(cloud: &PointCloud) -> Result<Self, IcpError> {
        if cloud.is_empty() {
            return Err(IcpError::TooFewPoints {
                cloud: "target",
                found: 0,
                wanted: 1,
            });
        }
        let normals = cloud
            .normals()
            .ok_or(IcpError::NoNormals {
                n_points: cloud.len(),
            })?
            .to_vec();
        check_finite("target", cloud.points())?;
        let points = cloud.points().to_vec();
        let tree = NearestPoints::new(&points);
        Ok(Self {
            points,
            normals,
            tree,
        })
    }

    /// The target's points.
    #[must_use]
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// The target's search tree; indices are those of [`IcpTarget::points`].
    #[must_use]
    pub fn tree(&self) -> &NearestPoints {
        &self.tree
    }

    /// Lays `source` onto this surface, starting at `initial_target_from_source`.
    ///
    /// # Errors
    /// [`IcpError`] when there are too few points or pairs, or a coordinate is not finite.
    pub fn register(
        &self,
        source: &[Point3<f64>],
        initial_target_from_source: &Pose,
        params: &IcpParams,
    ) -> Result<IcpResult, IcpError> {
        let wanted = params.n_pairs_min.max(1);
        if source.len() < wanted {
            return Err(IcpError::TooFewPoints {
                cloud: "source",
                found: source.len(),
                wanted,
            });
        }
        check_finite("source", source)?;
        let mut pose = *initial_target_from_source;
        let mut stop = IcpStop::IterationCap;
        let mut n_iterations = 0;
        let mut n_unconstrained = 0;
        while n_iterations < params.n_iterations_max && stop != IcpStop::Converged {
            let pairs = self.checked_pairs(source, &pose, params, n_iterations)?;
            let step = solve_step(&pairs, params);
            n_unconstrained = step.n_unconstrained;
            pose = step.motion * pose;
            pose.rotation.renormalize();
            n_iterations += 1;
            if (step.motion * step.center - step.center).norm() < params.step_translation_m
                && step.motion.rotation.angle() < params.step_rotation_rad
            {
                stop = IcpStop::Converged;
            }
        }
        let pairs = self.checked_pairs(source, &pose, params, n_iterations)?;
        let mean_square = pairs
            .iter()
            .map(|pair| pair.residual_m.powi(2))
            .sum::<f64>()
            / pairs.len() as f64;
        Ok(IcpResult {
            target_from_source: pose,
            n_iterations,
            stop,
            rms_m: mean_square.sqrt(),
            fitness: self.fitness(source, &pose, params.pair_distance_max_m),
            n_pairs: pairs.len(),
            n_unconstrained,
        })
    }

    /// Share of the source points that have a target point within `distance_max_m`; 0 without points.
    #[must_use]
    pub fn fitness(
        &self,
        source: &[Point3<f64>],
        target_from_source: &Pose,
        distance_max_m: f64,
    ) -> f64 {
        let is_near = |point: &&Point3<f64>| {
            self.tree
                .nearest_within(&(target_from_source * *point), distance_max_m)
                .is_some()
        };
        source.iter().filter(is_near).count() as f64 / source.len().max(1) as f64
    }

    fn checked_pairs(
        &self,
        source: &[Point3<f64>],
        pose: &Pose,
        params: &IcpParams,
        iteration: usize,
    ) -> Result<Vec<Pair>, IcpError> {
        let pairs = self.pairs(source, pose, params);
        if pairs.len() < params.n_pairs_min.max(1) {
            return Err(IcpError::TooFewPairs {
                found: pairs.len(),
                wanted: params.n_pairs_min.max(1),
                distance_max_m: params.pair_distance_max_m,
                iteration,
            });
        }
        Ok(pairs)
    }

    /// Nearest-point pairs within the distance, the farthest trimmed.
    fn pairs(&self, source: &[Point3<f64>], pose: &Pose, params: &IcpParams) -> Vec<Pair> {
        let mut pairs: Vec<Pair> = source
            .iter()
            .filter_map(|point| {
                let moved = pose * point;
                let (index, distance_m2) = self
                    .tree
                    .nearest_within(&moved, params.pair_distance_max_m)?;
                let normal = self.normals[index];
                Some(Pair {
                    source: moved,
                    normal,
                    residual_m: normal.dot(&(moved - self.points[index])),
                    distance_m2,
                })
            })
            .collect();
        let keep_ratio = params.keep_ratio.clamp(0.0, 1.0);
        if keep_ratio < 1.0 {
            // Stable, so equal distances keep their order.
            pairs.sort_by(|a, b| a.distance_m2.total_cmp(&b.distance_m2));
            pairs.truncate((pairs.len() as f64 * keep_ratio).ceil() as usize);
        }
        pairs
    }
}

struct Step {
    motion: Pose,
    center: Point3<f64>,
    n_unconstrained: usize,
}

/// One weighted, linearised least-squares step about the centre of the pairs.
fn solve_step(pairs: &[Pair], params: &IcpParams) -> Step {
    let n = pairs.len() as f64;
    let center = Point3::from(
        pairs
            .iter()
            .fold(Vector3::zeros(), |sum, p| sum + p.source.coords)
            / n,
    );
    let radius_m = (pairs
        .iter()
        .map(|p| (p.source - center).norm_squared())
        .sum::<f64>()
        / n)
        .sqrt()
        .max(f64::MIN_POSITIVE.sqrt());
    let huber_m = params.huber_sigmas * robust_sigma(pairs);

    let n_held = params.freedom.n_held();
    let mut normal_matrix = Matrix6::zeros();
    let mut right_side = Vector6::zeros();
    for pair in pairs {
        let arm = (pair.source - center) / radius_m;
        let turn = arm.cross(&pair.normal);
        let mut row = Vector6::new(
            turn.x,
            turn.y,
            turn.z,
            pair.normal.x,
            pair.normal.y,
            pair.normal.z,
        );
        row.rows_mut(0, n_held).fill(0.0);
        let residual_m = pair.residual_m.abs();
        let weight = if residual_m > huber_m {
            huber_m / residual_m
        } else {
            1.0
        };
        normal_matrix += weight * row * row.transpose();
        right_side -= weight * row * (pair.residual_m / radius_m);
    }
    let eigen = normal_matrix.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut x = Vector6::zeros();
    let mut n_unconstrained = 0;
    for (i, &curvature) in eigen.eigenvalues.iter().enumerate() {
        if curvature > params.constraint_ratio_min * largest && curvature > 0.0 {
            let direction = eigen.eigenvectors.column(i);
            x += direction * (direction.dot(&right_side) / curvature);
        } else {
            n_unconstrained += 1;
        }
    }
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(x[0], x[1], x[2]));
    let shift = Vector3::new(x[3], x[4], x[5]) * radius_m;
    // Turn about the centre, then shift.
    let motion =
        Translation3::from(center.coords + shift) * rotation * Translation3::from(-center.coords);
    Step {
        motion,
        center,
        // Held directions have no curvature, but not for want of data.
        n_unconstrained: n_unconstrained - n_held,
    }
}

/// Standard deviation of the residuals (m) from their median absolute value, never zero.
fn robust_sigma(pairs: &[Pair]) -> f64 {
    /// Ratio of standard deviation to median absolute deviation of a normal distribution.
    const SIGMA_PER_MAD: f64 = 1.4826;
    /// Below this residuals are rounding, and all weigh alike (m).
    const SIGMA_MIN_M: f64 = 1e-9;
    let mut residuals: Vec<f64> = pairs.iter().map(|pair| pair.residual_m.abs()).collect();
    let middle = residuals.len() / 2;
    let (_, median, _) = residuals.select_nth_unstable_by(middle, f64::total_cmp);
    (*median * SIGMA_PER_MAD).max(SIGMA_MIN_M)
}

fn check_finite(cloud: &'static str, points: &[Point3<f64>]) -> Result<(), IcpError> {
    match points.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        Some(point) => Err(IcpError::NotFinite { cloud, point }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
