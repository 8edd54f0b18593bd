//! The rigid motion that best lays paired points onto each other.
//!
//! Minimises `Σ |target_i - T source_i|²` over rotations and translations (no scale). Method: Umeyama,
//! "Least-squares estimation of transformation parameters between two point patterns", PAMI 13(4), 1991,
//! equations 38 to 43 with c = 1: singular value decomposition of the cross-covariance, with the sign of
//! the least singular direction fixed so that mirrored data still give a proper rotation.

use crate::{Pose, Pose2};
use nalgebra::{
    Matrix2, Matrix3, Point2, Point3, Rotation2, Rotation3, UnitComplex, UnitQuaternion,
};

/// Least spread of the points across their main direction, relative to the spread along it.
const COLLINEAR_RATIO: f64 = 1e-4;

/// Pairs that fix no rigid motion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AlignmentError {
    /// Points without a partner.
    #[error(
        "alignment of {n_source} source points with {n_target} target points, expected as many of each"
    )]
    Unpaired {
        /// Source points.
        n_source: usize,
        /// Target points.
        n_target: usize,
    },
    /// Too few to fix the motion.
    #[error("alignment from {found} pairs of points, expected at least {wanted}")]
    TooFewPairs {
        /// Pairs given.
        found: usize,
        /// Pairs needed.
        wanted: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("pair {pair} has a coordinate that is not finite")]
    NotFinite {
        /// Index of the pair.
        pair: usize,
    },
    /// The turn about the line of the points is not fixed.
    #[error(
        "the {points} points lie on one line: {spread_m} m across it, {length_m} m along it; choose points off the line"
    )]
    Collinear {
        /// Which side, `source` or `target`.
        points: &'static str,
        /// Root-mean-square extent along the main direction (m).
        length_m: f64,
        /// Root-mean-square extent across it (m).
        spread_m: f64,
    },
    /// All points are one point.
    #[error("the {points} points all lie in one place")]
    Coincident {
        /// Which side, `source` or `target`.
        points: &'static str,
    },
}

/// A rigid motion and how well it fits.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment<P> {
    /// Lays source points onto target points.
    pub target_from_source: P,
    /// Distance left between the points of each pair (m).
    pub residuals_m: Vec<f64>,
    /// Root mean square of the residuals (m).
    pub rms_m: f64,
}

impl<P> Alignment<P> {
    fn new(target_from_source: P, residuals_m: Vec<f64>) -> Self {
        let mean_square = residuals_m.iter().map(|r| r * r).sum::<f64>() / residuals_m.len() as f64;
        Self {
            target_from_source,
            residuals_m,
            rms_m: mean_square.sqrt(),
        }
    }

    /// The pair that fits worst and its residual (m).
    #[must_use]
    pub fn worst_pair(&self) -> Option<(usize, f64)> {
        self.residuals_m
            .iter()
            .copied()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Best rigid motion from at least three pairs of points not on one line.
///
/// # Errors
/// [`AlignmentError`] when the pairs fix no motion.
///
/// # Examples
/// ```
/// use factotum_geometry::alignment::align_points;
/// use nalgebra::{Point3, Vector3};
///
/// let source = [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
/// let target = source.map(|p| p + Vector3::new(0.0, 0.0, 2.0));
/// let alignment = align_points(&source, &target)?;
/// assert!((alignment.target_from_source.translation.z - 2.0).abs() < 1e-12);
/// # Ok::<(), factotum_geometry::alignment::AlignmentError>(())
/// ```
pub fn align_points(
    source: &[Point3<f64>],
    target: &[Point3<f64>],
) -> Result<Alignment<Pose>, AlignmentError> {
    check_pairs(source, target, 3)?;
    let (source_mean, target_mean) = (mean(source), mean(target));
    for (points, side, center) in [
        (source, "source", source_mean),
        (target, "target", target_mean),
    ] {
        let mut scatter = Matrix3::zeros();
        for p in points {
            scatter += (p - center) * (p - center).transpose() / points.len() as f64;
        }
        check_spread(side, scatter.symmetric_eigenvalues().as_slice())?;
    }
    let mut covariance = Matrix3::zeros();
    for (s, t) in source.iter().zip(target) {
        covariance += (t - target_mean) * (s - source_mean).transpose();
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&nearest_rotation3(covariance));
    let translation = target_mean.coords - rotation * source_mean.coords;
    let target_from_source = Pose::from_parts(translation.into(), rotation);
    let residuals_m = source
        .iter()
        .zip(target)
        .map(|(s, t)| (target_from_source * s - t).norm())
        .collect();
    Ok(Alignment::new(target_from_source, residuals_m))
}

/// Best planar motion from at least two distinct pairs of points.
///
/// # Errors
/// [`AlignmentError`] when the pairs fix no motion.
pub fn align_points_2d(
    source: &[Point2<f64>],
    target: &[Point2<f64>],
) -> Result<Alignment<Pose2>, AlignmentError> {
    check_pairs(source, target, 2)?;
    let (source_mean, target_mean) = (mean(source), mean(target));
    for (points, side, center) in [
        (source, "source", source_mean),
        (target, "target", target_mean),
    ] {
        if points
            .iter()
            .all(|p| (p - center).norm() <= f64::EPSILON * (1.0 + center.coords.norm()))
        {
            return Err(AlignmentError::Coincident { points: side });
        }
    }
    let mut covariance = Matrix2::zeros();
    for (s, t) in source.iter().zip(target) {
        covariance += (t - target_mean) * (s - source_mean).transpose();
    }
    // In the plane the proper rotation that maximises tr(Rᵀ C) has a closed form.
    let yaw =
        (covariance[(1, 0)] - covariance[(0, 1)]).atan2(covariance[(0, 0)] + covariance[(1, 1)]);
    let rotation = UnitComplex::from_rotation_matrix(&Rotation2::new(yaw));
    let translation = target_mean.coords - rotation * source_mean.coords;
    let target_from_source = Pose2::from_parts(translation.into(), rotation);
    let residuals_m = source
        .iter()
        .zip(target)
        .map(|(s, t)| (target_from_source * s - t).norm())
        .collect();
    Ok(Alignment::new(target_from_source, residuals_m))
}

/// The proper rotation `R` that maximises `tr(Rᵀ covariance)`.
fn nearest_rotation3(covariance: Matrix3<f64>) -> Rotation3<f64> {
    let svd = covariance.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return Rotation3::identity(); // never: both factors were asked for
    };
    let sign = (u.determinant() * v_t.determinant()).signum();
    // nalgebra sorts singular values in decreasing order, so the last is the least.
    let d = Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, sign));
    Rotation3::from_matrix_unchecked(u * d * v_t)
}

fn check_pairs<const D: usize>(
    source: &[nalgebra::OPoint<f64, nalgebra::Const<D>>],
    target: &[nalgebra::OPoint<f64, nalgebra::Const<D>>],
    wanted: usize,
) -> Result<(), AlignmentError> {
    let (n_source, n_target) = (source.len(), target.len());
    if n_source != n_target {
        return Err(AlignmentError::Unpaired { n_source, n_target });
    }
    if n_source < wanted {
        return Err(AlignmentError::TooFewPairs {
            found: n_source,
            wanted,
        });
    }
    let is_finite = |pair: usize| {
        source[pair]
            .iter()
            .chain(target[pair].iter())
            .all(|v| v.is_finite())
    };
    match (0..n_source).find(|&pair| !is_finite(pair)) {
        Some(pair) => Err(AlignmentError::NotFinite { pair }),
        None => Ok(()),
    }
}

fn check_spread(points: &'static str, variances: &[f64]) -> Result<(), AlignmentError> {
    let mut extents: Vec<f64> = variances.iter().map(|v| v.max(0.0).sqrt()).collect();
    extents.sort_by(f64::total_cmp);
    let &[_, spread_m, length_m] = extents.as_slice() else {
        return Ok(());
    };
    if length_m <= f64::EPSILON {
        Err(AlignmentError::Coincident { points })
    } else if spread_m <= COLLINEAR_RATIO * length_m {
        Err(AlignmentError::Collinear {
            points,
            length_m,
            spread_m,
        })
    } else {
        Ok(())
    }
}

fn mean<const D: usize>(
    points: &[nalgebra::OPoint<f64, nalgebra::Const<D>>],
) -> nalgebra::OPoint<f64, nalgebra::Const<D>> {
    let sum = points
        .iter()
        .fold(nalgebra::SVector::<f64, D>::zeros(), |sum, p| {
            sum + p.coords
        });
    nalgebra::OPoint::from(sum / points.len() as f64)
}

#[cfg(test)]
mod tests;
