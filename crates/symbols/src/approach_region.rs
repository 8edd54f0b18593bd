//! A ring sector around an object from which the base faces it: the given navigation symbol.
//!
//! With object_from_base = (x, y, yaw), distance d = |(x, y)|, bearing b = atan2(y, x) and facing
//! error e = wrap(atan2(-y, -x) - yaw), a pose is inside when d and b are in their ranges and |e| is
//! within the tolerance. Kaelbling & Lozano-Pérez's geometric heuristic (dissertation 5.4) is the
//! region with all bearings.

use std::f64::consts::TAU;

use factotum_geometry::Pose2;
use nalgebra::Vector2;
use rand::{Rng, RngExt as _};

use crate::navigation_symbol::BasePoseClassifier;

/// How far outside its bounds a pose still counts as inside, in metres and radians.
///
/// Covers the rounding of a pose that is composed into the world and back; far below any sensor.
const BOUND_TOLERANCE: f64 = 1e-9;

/// Where the base may stand around an object, and how well it must face it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ApproachRegion {
    distance_m: [f64; 2],
    bearing_rad: [f64; 2],
    facing_tolerance_rad: f64,
}

/// Why bounds make no region.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ApproachRegionError {
    /// Distances that are no range away from the object.
    #[error("distance_m is [{}, {}], expected finite bounds with 0 < min <= max", found[0], found[1])]
    Distance {
        /// The refused bounds.
        found: [f64; 2],
    },
    /// Bearings that are no range.
    #[error(
        "bearing_rad is [{}, {}], expected finite bounds with min <= max <= min + 2 pi",
        found[0],
        found[1]
    )]
    Bearing {
        /// The refused bounds.
        found: [f64; 2],
    },
    /// A tolerance that allows nothing or is no angle.
    #[error("facing_tolerance_rad is {found}, expected a value in (0, pi]")]
    FacingTolerance {
        /// The refused tolerance.
        found: f64,
    },
}

impl ApproachRegion {
    /// The region within the bounds.
    ///
    /// - `distance_m`: from the object's origin to the base's, \[min, max\];
    /// - `bearing_rad`: where the base stands, as an angle in the object's frame, \[min, max\]; the range
    ///   may cross pi, as in \[3.0, 3.5\];
    /// - `facing_tolerance_rad`: how far the base may be turned away from the object's origin.
    ///
    /// # Errors
    /// Bounds that are out of order, not finite, or touch the object's origin, where no bearing exists.
    pub fn new(
        distance_m: [f64; 2],
        bearing_rad: [f64; 2],
        facing_tolerance_rad: f64,
    ) -> Result<Self, ApproachRegionError> {
        let [near, far] = distance_m;
        if !(near > 0.0 && near <= far && far.is_finite()) {
            return Err(ApproachRegionError::Distance { found: distance_m });
        }
        let width = bearing_rad[1] - bearing_rad[0];
        if !(0.0..=TAU + BOUND_TOLERANCE).contains(&width) {
            return Err(ApproachRegionError::Bearing { found: bearing_rad });
        }
        if !(facing_tolerance_rad > 0.0 && facing_tolerance_rad <= std::f64::consts::PI) {
            return Err(ApproachRegionError::FacingTolerance {
                found: facing_tolerance_rad,
            });
        }
        Ok(Self {
            distance_m,
            bearing_rad,
            facing_tolerance_rad,
        })
    }

    /// Distances from the object's origin, \[min, max\] in metres.
    pub fn distance_m(&self) -> [f64; 2] {
        self.distance_m
    }

    /// Bearings in the object's frame, \[min, max\] in radians.
    pub fn bearing_rad(&self) -> [f64; 2] {
        self.bearing_rad
    }

    /// How far the base may be turned away from the object, in radians.
    pub fn facing_tolerance_rad(&self) -> f64 {
        self.facing_tolerance_rad
    }

    /// Whether the base stands within the bounds and faces the object.
    pub fn contains(&self, object_from_base: &Pose2) -> bool {
        let place = object_from_base.translation.vector;
        let [near, far] = self.distance_m;
        let distance = place.norm();
        if !(near - BOUND_TOLERANCE..=far + BOUND_TOLERANCE).contains(&distance) {
            return false;
        }
        // The distance is positive here, so both angles below exist.
        let [from, to] = self.bearing_rad;
        let past_from = (place.y.atan2(place.x) - from + BOUND_TOLERANCE).rem_euclid(TAU);
        let facing_error = wrapped(facing_yaw(&place) - object_from_base.rotation.angle());
        past_from <= to - from + 2.0 * BOUND_TOLERANCE
            && facing_error.abs() <= self.facing_tolerance_rad + BOUND_TOLERANCE
    }
}

impl BasePoseClassifier for ApproachRegion {
    /// 1 inside, 0 outside.
    fn probability(&self, object_from_base: &Pose2) -> f64 {
        f64::from(u8::from(self.contains(object_from_base)))
    }

    /// Uniform over the region's area, turned exactly towards the object.
    fn propose(&self, rng: &mut dyn Rng) -> Pose2 {
        let [near, far] = self.distance_m;
        let [from, to] = self.bearing_rad;
        // Equal areas, not equal distances: the area within r grows with r squared.
        let u: f64 = rng.random();
        let distance = (near * near + u * (far * far - near * near)).sqrt();
        let v: f64 = rng.random();
        let bearing = from + v * (to - from);
        let place = distance * Vector2::new(bearing.cos(), bearing.sin());
        Pose2::new(place, facing_yaw(&place))
    }

    fn as_approach_region(&self) -> Option<&ApproachRegion> {
        Some(self)
    }
}

/// The heading that looks from a place to the object's origin.
fn facing_yaw(place: &Vector2<f64>) -> f64 {
    (-place.y).atan2(-place.x)
}

/// The same angle in [-pi, pi).
fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn regions() -> impl Strategy<Value = ApproachRegion> {
        (0.1..2.0, 0.0..2.0, -7.0..7.0, 0.0..TAU, 0.01..PI).prop_map(
            |(near, depth, from, width, tolerance): (f64, f64, f64, f64, f64)| {
                ApproachRegion::new([near, near + depth], [from, from + width], tolerance).unwrap()
            },
        )
    }

    /// A pose at a polar place, turned away from the object by `turn`.
    fn pose(distance: f64, bearing: f64, turn: f64) -> Pose2 {
        let place = distance * Vector2::new(bearing.cos(), bearing.sin());
        Pose2::new(place, facing_yaw(&place) + turn)
    }

    proptest! {
        #[test]
        fn what_a_region_proposes_lies_inside(region in regions(), seed: u64) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            for _ in 0..16 {
                let object_from_base = region.propose(&mut rng);
                prop_assert_eq!(region.probability(&object_from_base), 1.0, "{}", object_from_base);
            }
        }

        #[test]
        fn outside_any_bound_is_outside(region in regions(), u in 0.0..1.0, beyond in 1e-6..1.0) {
            let [near, far] = region.distance_m();
            let [from, to] = region.bearing_rad();
            let (distance, bearing) = (near + u * (far - near), from + u * (to - from));
            prop_assert!(region.contains(&pose(distance, bearing, 0.0)));
            prop_assert!(!region.contains(&pose(far + beyond, bearing, 0.0)));
            prop_assert!(!region.contains(&pose(near * (1.0 - 0.9 * beyond), bearing, 0.0)));
            let gap = TAU - (to - from);
            if gap > 1e-3 {
                prop_assert!(!region.contains(&pose(distance, to + gap * (0.1 + 0.8 * u), 0.0)));
            }
            let turn = region.facing_tolerance_rad() + beyond;
            if turn < PI {
                prop_assert!(!region.contains(&pose(distance, bearing, turn)));
                prop_assert!(!region.contains(&pose(distance, bearing, -turn)));
            }
        }

        #[test]
        fn membership_does_not_depend_on_where_full_turns_are_counted(
            region in regions(), distance in 0.05..4.0, bearing in -PI..PI, turn in -PI..PI
        ) {
            let [from, to] = region.bearing_rad();
            let turned = ApproachRegion::new(
                region.distance_m(), [from + TAU, to + TAU], region.facing_tolerance_rad()
            ).unwrap();
            let p = pose(distance, bearing, turn);
            // Poses within rounding of a bound may fall either way.
            let edge = [from, to].iter().any(|b| wrapped(bearing - b).abs() < 1e-6);
            prop_assume!(!edge);
            prop_assert_eq!(region.contains(&p), turned.contains(&p));
        }
    }

    /// The inner half of the area must get half of the samples, not half of the distances.
    #[test]
    fn samples_are_uniform_over_the_area() {
        let region = ApproachRegion::new([0.5, 1.5], [-1.0, 1.0], 0.1).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let half_area_m = ((0.5f64.powi(2) + 1.5f64.powi(2)) / 2.0).sqrt();
        let n = 4000;
        let inner = (0..n)
            .filter(|_| region.propose(&mut rng).translation.vector.norm() < half_area_m)
            .count();
        // Binomial(4000, 0.5) has standard deviation 32; five of them.
        assert!(inner.abs_diff(n / 2) < 160, "{inner} of {n}");
    }

    #[test]
    fn impossible_bounds_are_named() {
        let check = |distance, bearing, facing, wanted: &str| {
            let error = ApproachRegion::new(distance, bearing, facing).unwrap_err();
            assert!(error.to_string().contains(wanted), "{error}");
        };
        check([0.0, 1.0], [0.0, 1.0], 0.1, "distance_m is [0, 1]");
        check([2.0, 1.0], [0.0, 1.0], 0.1, "distance_m is [2, 1]");
        check([1.0, f64::INFINITY], [0.0, 1.0], 0.1, "distance_m");
        check([f64::NAN, 1.0], [0.0, 1.0], 0.1, "distance_m");
        check([1.0, 2.0], [1.0, 0.0], 0.1, "bearing_rad is [1, 0]");
        check([1.0, 2.0], [0.0, 7.0], 0.1, "bearing_rad is [0, 7]");
        check([1.0, 2.0], [0.0, 1.0], 0.0, "facing_tolerance_rad is 0");
        check([1.0, 2.0], [0.0, 1.0], 4.0, "facing_tolerance_rad is 4");
    }

    #[test]
    fn a_pose_that_is_no_number_is_outside() {
        let region = ApproachRegion::new([0.5, 1.5], [0.0, TAU], PI).unwrap();
        assert!(!region.contains(&Pose2::new(Vector2::new(f64::NAN, 1.0), 0.0)));
        assert!(!region.contains(&Pose2::new(Vector2::zeros(), 0.0)));
    }
}
