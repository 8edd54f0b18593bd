//! How far a joint of an articulated object is turned or pulled, from the points seen of it.
//!
//! The object's root is known; a joint position `q` puts the moving link at `motion(0, q)`. The cost of `q`
//! is the mean squared distance of the seen points to the nearer of fixed and moving surface, truncated so
//! that strangers do not pull. It is sampled over the joint's range and refined by golden section around
//! the best sample.

use crate::detect::spread;
use factotum_descriptions::ObjectJoint;
use factotum_geometry::Pose;
use factotum_geometry::cloud::{NearestPoints, PointCloud};
use nalgebra::Point3;

/// An object with one joint, as surfaces.
#[derive(Debug)]
pub struct ArticulatedModel {
    joint: ObjectJoint,
    fixed: NearestPoints,
    moving: NearestPoints,
}

/// Settings of [`ArticulatedModel::joint_state_from_cloud`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArticulationParams {
    /// Distances are truncated here (m).
    pub outlier_m: f64,
    /// Samples over the joint's range.
    pub n_samples: usize,
    /// Fewest points to say anything.
    pub n_points_min: usize,
    /// Most points that are used, spread over those given.
    pub n_points_max: usize,
    /// Least ratio of the worst to the best cost over the range; less means the points do not tell.
    pub contrast_min: f64,
}

impl Default for ArticulationParams {
    fn default() -> Self {
        Self {
            outlier_m: 0.05,
            n_samples: 61,
            n_points_min: 10,
            n_points_max: 400,
            contrast_min: 1.5,
        }
    }
}

/// A joint position read from points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointEstimate {
    /// The position (rad or m).
    pub position: f64,
    /// Root mean square distance of the points to the surfaces, truncated (m).
    pub rms_m: f64,
    /// How much worse the worst position of the range fits than this one, as a ratio of mean squares.
    pub contrast: f64,
    /// Points used that lie on the moving link rather than the fixed one.
    pub n_moving_points: usize,
}

/// Points that do not tell the joint position.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArticulationError {
    /// The joint cannot be sampled.
    #[error(
        "joint `{joint}` has range {range:?} and axis {axis:?}, expected finite numbers, a lower limit below the upper and an axis with a length"
    )]
    Joint {
        /// The joint.
        joint: String,
        /// Its limits (rad or m).
        range: [f64; 2],
        /// Its axis.
        axis: [f64; 3],
    },
    /// The moving link has no surface.
    #[error("joint `{joint}` moves a link without surface points")]
    NoSurface {
        /// The joint.
        joint: String,
    },
    /// Too little was seen.
    #[error("{found} points seen of the object with joint `{joint}`, expected at least {wanted}")]
    TooFewPoints {
        /// The joint.
        joint: String,
        /// Points there are.
        found: usize,
        /// Points wanted.
        wanted: usize,
    },
    /// All positions explain the points about as well.
    #[error(
        "the points seen do not tell the position of joint `{joint}`: contrast {contrast}, expected at least {wanted}"
    )]
    NotObservable {
        /// The joint.
        joint: String,
        /// Contrast found.
        contrast: f64,
        /// Contrast wanted.
        wanted: f64,
    },
}

impl ArticulatedModel {
    /// Model from the surfaces of the fixed part (may be empty) and the moving link, both in Λ with the
    /// joint at zero.
    ///
    /// # Errors
    /// [`ArticulationError::Joint`] or [`ArticulationError::NoSurface`] when it cannot move.
    pub fn new(
        joint: ObjectJoint,
        fixed: &PointCloud,
        moving: &PointCloud,
    ) -> Result<Self, ArticulationError> {
        let [low, high] = joint.range;
        let axis_norm = nalgebra::Vector3::from(joint.axis).norm();
        if !(low.is_finite() && high.is_finite() && low < high && axis_norm.is_normal()) {
            let (range, axis) = (joint.range, joint.axis);
            return Err(ArticulationError::Joint {
                joint: joint.name,
                range,
                axis,
            });
        }
        if moving.is_empty() {
            return Err(ArticulationError::NoSurface { joint: joint.name });
        }
        let fixed = NearestPoints::new(fixed.points());
        Ok(Self {
            joint,
            fixed,
            moving: NearestPoints::new(moving.points()),
        })
    }

    /// The joint's position, given the points seen of the object and the pose of its root, both in one frame.
    ///
    /// # Errors
    /// [`ArticulationError`] when there are too few points or they fit any position.
    pub fn joint_state_from_cloud(
        &self,
        points: &[Point3<f64>],
        frame_from_object: &Pose,
        params: &ArticulationParams,
    ) -> Result<JointEstimate, ArticulationError> {
        let object_from_frame = frame_from_object.inverse();
        let finite: Vec<Point3<f64>> = points
            .iter()
            .filter(|p| p.iter().all(|v| v.is_finite()))
            .copied()
            .collect();
        let seen: Vec<Seen> = spread(&finite, params.n_points_max)
            .iter()
            .map(|p| {
                let in_object = object_from_frame * p;
                let fixed_m2 = self
                    .fixed
                    .nearest(&in_object)
                    .map_or(f64::INFINITY, |hit| hit.1);
                Seen {
                    in_object,
                    fixed_m2,
                }
            })
            .collect();
        let wanted = params.n_points_min.max(1);
        if seen.len() < wanted {
            let (joint, found) = (self.joint.name.clone(), seen.len());
            return Err(ArticulationError::TooFewPoints {
                joint,
                found,
                wanted,
            });
        }
        let cost = |position| self.cost(&seen, position, params.outlier_m);
        let [low, high] = self.joint.range;
        let n_samples = params.n_samples.max(3);
        let step = (high - low) / (n_samples - 1) as f64;
        let samples: Vec<(f64, f64)> = (0..n_samples)
            .map(|i| low + step * i as f64)
            .map(|position| (position, cost(position)))
            .collect();
        let by_cost = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let best = samples
            .iter()
            .min_by(by_cost)
            .map_or(low, |sample| sample.0);
        let worst_cost = samples
            .iter()
            .max_by(by_cost)
            .map_or(0.0, |sample| sample.1);
        let (position, cost) = golden_section(
            cost,
            (best - step).max(low),
            (best + step).min(high),
            step * 1e-3,
        );
        /// Mean square below which points are exactly on the surface (m²): keeps the ratio finite.
        const ROUNDING_M2: f64 = 1e-8;
        let contrast = (worst_cost + ROUNDING_M2) / (cost + ROUNDING_M2);
        if contrast < params.contrast_min {
            let (joint, wanted) = (self.joint.name.clone(), params.contrast_min);
            return Err(ArticulationError::NotObservable {
                joint,
                contrast,
                wanted,
            });
        }
        let n_moving_points = seen
            .iter()
            .filter(|seen| self.moving_m2(seen, position) < seen.fixed_m2)
            .count();
        Ok(JointEstimate {
            position,
            rms_m: cost.sqrt(),
            contrast,
            n_moving_points,
        })
    }

    fn cost(&self, seen: &[Seen], position: f64, outlier_m: f64) -> f64 {
        let back = self.joint.motion(position, 0.0);
        let sum: f64 = seen
            .iter()
            .map(|seen| {
                let moving_m2 = self
                    .moving
                    .nearest_within(&(back * seen.in_object), outlier_m)
                    .map_or(f64::INFINITY, |hit| hit.1);
                seen.fixed_m2.min(moving_m2).min(outlier_m * outlier_m)
            })
            .sum();
        sum / seen.len() as f64
    }

    fn moving_m2(&self, seen: &Seen, position: f64) -> f64 {
        let back = self.joint.motion(position, 0.0);
        self.moving
            .nearest(&(back * seen.in_object))
            .map_or(f64::INFINITY, |hit| hit.1)
    }
}

/// A point seen, with what does not depend on the joint.
struct Seen {
    in_object: Point3<f64>,
    fixed_m2: f64,
}

/// Least value of a function with one minimum in `[low, high]`, to within `tolerance`: (where, value).
fn golden_section(
    f: impl Fn(f64) -> f64,
    mut low: f64,
    mut high: f64,
    tolerance: f64,
) -> (f64, f64) {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (high - RATIO * (high - low), low + RATIO * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    while high - low > tolerance {
        if fa <= fb {
            (high, b, fb) = (b, a, fa);
            a = high - RATIO * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + RATIO * (high - low);
            fb = f(b);
        }
    }
    if fa <= fb { (a, fa) } else { (b, fb) }
}

#[cfg(test)]
mod tests;
