//! Driving with a map: following the pose in a given one, or building one on the way.
//!
//! Between scans odometry carries the pose, with an uncertainty that grows with the way; each scan is then
//! matched to the map ([`crate::scan_match`]). [`Slam2d`] adds scans to its own map at key frames, every so
//! many metres or radians. There is no loop closure: scans are matched to the whole map so far, which
//! holds a home together; a building with long loops needs more.

use crate::scan_match::{PoseGuess, ScanMatchOutcome, ScanMatchParams, ScanMatcher};
use crate::sensing::LaserScan;
use factotum_geometry::Pose2;
use factotum_geometry::grid::{GridError, GridMapper, GridMapperParams, OccupancyGrid};
use nalgebra::{Matrix3, Vector3};

/// How odometry errs: standard deviations per way driven and turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryNoise {
    /// Position error per metre driven (m/m).
    pub position_per_m: f64,
    /// Position error per radian turned (m/rad).
    pub position_per_rad: f64,
    /// Heading error per radian turned (rad/rad).
    pub heading_per_rad: f64,
    /// Heading error per metre driven (rad/m).
    pub heading_per_m: f64,
}

impl Default for OdometryNoise {
    /// About twice what wheels on a home's floor do, since too small values blind the matcher.
    fn default() -> Self {
        Self {
            position_per_m: 0.08,
            position_per_rad: 0.03,
            heading_per_rad: 0.08,
            heading_per_m: 0.05,
        }
    }
}

/// How a pose was arrived at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseSource {
    /// First scan: the given start.
    Start,
    /// A scan that fixed it.
    Scan,
    /// A scan that fixed some directions, odometry the others.
    ScanAndOdometry,
    /// Odometry alone: the scan did not fit or said nothing.
    Odometry,
}

/// The pose after an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseUpdate {
    /// The robot's pose.
    pub map_from_base: Pose2,
    /// Covariance of (x, y, yaw) in the map frame.
    pub covariance: Matrix3<f64>,
    /// How it was arrived at.
    pub source: PoseSource,
    /// Score of the scan match, 0 to 1; 0 where none was made.
    pub score: f64,
    /// Scans in a row that did not fit.
    pub n_rejected_in_row: usize,
}

/// Odometry and scan matching joined; the map comes from outside.
#[derive(Debug, Clone)]
struct PoseFilter {
    noise: OdometryNoise,
    last_odom_from_base: Option<Pose2>,
    map_from_base: Pose2,
    /// Of (x, y, yaw) since the last scan that fixed the pose.
    sigma_m: f64,
    sigma_rad: f64,
    n_rejected_in_row: usize,
}

/// Uncertainty that remains right after a match (m, rad): half a cell, and what that is over a room.
const MATCHED_SIGMA_M: f64 = 0.02;
const MATCHED_SIGMA_RAD: f64 = 0.01;

impl PoseFilter {
    fn new(map_from_base: Pose2, noise: OdometryNoise) -> Self {
        Self {
            noise,
            last_odom_from_base: None,
            map_from_base,
            sigma_m: MATCHED_SIGMA_M,
            sigma_rad: MATCHED_SIGMA_RAD,
            n_rejected_in_row: 0,
        }
    }

    /// Moves the pose as odometry moved.
    fn predict(&mut self, odom_from_base: &Pose2) -> PoseGuess {
        let last = self
            .last_odom_from_base
            .replace(*odom_from_base)
            .unwrap_or(*odom_from_base);
        let motion = last.inverse() * odom_from_base;
        let (way_m, turn_rad) = (
            motion.translation.vector.norm(),
            motion.rotation.angle().abs(),
        );
        self.map_from_base *= motion;
        self.sigma_m += self.noise.position_per_m * way_m + self.noise.position_per_rad * turn_rad;
        self.sigma_rad += self.noise.heading_per_rad * turn_rad + self.noise.heading_per_m * way_m;
        PoseGuess {
            map_from_base: self.map_from_base,
            sigma_m: self.sigma_m,
            sigma_rad: self.sigma_rad,
        }
    }

    fn correct(&mut self, guess: &PoseGuess, outcome: &ScanMatchOutcome) -> PoseUpdate {
        let source = match outcome {
            ScanMatchOutcome::Matched(_) => PoseSource::Scan,
            ScanMatchOutcome::Ambiguous { .. } => PoseSource::ScanAndOdometry,
            ScanMatchOutcome::Rejected { .. } | ScanMatchOutcome::TooFewPoints { .. } => {
                PoseSource::Odometry
            }
        };
        if let Some(fit) = outcome.fit() {
            self.map_from_base = fit.map_from_base;
            self.sigma_rad = MATCHED_SIGMA_RAD;
            if source == PoseSource::Scan {
                self.sigma_m = MATCHED_SIGMA_M;
            }
            self.n_rejected_in_row = 0;
        } else {
            self.n_rejected_in_row += 1;
        }
        let covariance = outcome
            .fit()
            .map_or_else(|| covariance_of(guess), |fit| fit.covariance);
        self.update(
            covariance,
            source,
            outcome.fit().map_or(0.0, |fit| fit.score),
        )
    }

    fn update(&self, covariance: Matrix3<f64>, source: PoseSource, score: f64) -> PoseUpdate {
        PoseUpdate {
            map_from_base: self.map_from_base,
            covariance,
            source,
            score,
            n_rejected_in_row: self.n_rejected_in_row,
        }
    }
}

fn covariance_of(guess: &PoseGuess) -> Matrix3<f64> {
    let (m2, rad2) = (guess.sigma_m.powi(2), guess.sigma_rad.powi(2));
    Matrix3::from_diagonal(&Vector3::new(m2, m2, rad2))
}

/// Follows the robot's pose in a map that does not change.
#[derive(Debug, Clone)]
pub struct PoseTracker {
    matcher: ScanMatcher,
    filter: PoseFilter,
}

impl PoseTracker {
    /// Scans in a row that must not fit before the robot counts as lost.
    pub const N_REJECTED_LOST: usize = 10;

    /// Tracker that starts at `map_from_base`.
    #[must_use]
    pub fn new(
        map: &OccupancyGrid,
        map_from_base: Pose2,
        params: ScanMatchParams,
        noise: OdometryNoise,
    ) -> Self {
        Self {
            matcher: ScanMatcher::new(map, params),
            filter: PoseFilter::new(map_from_base, noise),
        }
    }

    /// The pose after odometry and a scan taken at the same moment.
    pub fn update(&mut self, odom_from_base: &Pose2, scan: &LaserScan) -> PoseUpdate {
        let guess = self.filter.predict(odom_from_base);
        let outcome = self.matcher.match_scan(scan, &guess);
        self.filter.correct(&guess, &outcome)
    }

    /// The last pose.
    #[must_use]
    pub fn map_from_base(&self) -> Pose2 {
        self.filter.map_from_base
    }

    /// Whether so many scans did not fit that the pose should be searched anew ([`crate::localise`]).
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.filter.n_rejected_in_row >= Self::N_REJECTED_LOST
    }

    /// The map.
    #[must_use]
    pub fn map(&self) -> &OccupancyGrid {
        self.matcher.map()
    }
}

/// Settings of [`Slam2d`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlamParams {
    /// The map.
    pub mapper: GridMapperParams,
    /// The matcher.
    pub matcher: ScanMatchParams,
    /// The odometry.
    pub odometry: OdometryNoise,
    /// A scan is added to the map after driving this far (m)...
    pub keyframe_distance_m: f64,
    /// ...or turning this much (rad).
    pub keyframe_turn_rad: f64,
}

impl Default for SlamParams {
    fn default() -> Self {
        Self {
            mapper: GridMapperParams::default(),
            matcher: ScanMatchParams::default(),
            odometry: OdometryNoise::default(),
            keyframe_distance_m: 0.2,
            keyframe_turn_rad: 0.25,
        }
    }
}

/// Builds a map from odometry and scans.
#[derive(Debug, Clone)]
pub struct Slam2d {
    params: SlamParams,
    mapper: GridMapper,
    filter: PoseFilter,
    matcher: Option<ScanMatcher>,
    last_keyframe: Option<Pose2>,
}

impl Slam2d {
    /// An empty map in which the robot stands at `map_from_base`.
    ///
    /// # Errors
    /// [`GridError::Resolution`] when the map's resolution is not a positive number.
    pub fn new(map_from_base: Pose2, params: SlamParams) -> Result<Self, GridError> {
        Ok(Self {
            params,
            mapper: GridMapper::new(params.mapper)?,
            filter: PoseFilter::new(map_from_base, params.odometry),
            matcher: None,
            last_keyframe: None,
        })
    }

    /// Goes on with a stored map in which the robot stands at `map_from_base`.
    ///
    /// # Errors
    /// As [`GridMapper::from_grid`].
    pub fn resume(
        map: &OccupancyGrid,
        map_from_base: Pose2,
        params: SlamParams,
    ) -> Result<Self, GridError> {
        let mapper = GridMapper::from_grid(map, params.mapper)?;
        let matcher = ScanMatcher::of_mapper(&mapper, params.matcher);
        let filter = PoseFilter::new(map_from_base, params.odometry);
        Ok(Self {
            params,
            mapper,
            filter,
            matcher,
            last_keyframe: None,
        })
    }

    /// Adds odometry and a scan taken at the same moment.
    ///
    /// # Errors
    /// [`GridError`] when the scan cannot be put into the map; the pose is up to date all the same.
    pub fn update(
        &mut self,
        odom_from_base: &Pose2,
        scan: &LaserScan,
    ) -> Result<PoseUpdate, GridError> {
        let guess = self.filter.predict(odom_from_base);
        let update = match &self.matcher {
            None => self
                .filter
                .update(covariance_of(&guess), PoseSource::Start, 0.0),
            Some(matcher) => self
                .filter
                .correct(&guess, &matcher.match_scan(scan, &guess)),
        };
        if self.is_keyframe(&update) {
            self.mapper.integrate(&update.map_from_base, scan)?;
            self.matcher = ScanMatcher::of_mapper(&self.mapper, self.params.matcher);
            self.last_keyframe = Some(update.map_from_base);
        }
        Ok(update)
    }

    /// The robot's last pose.
    #[must_use]
    pub fn map_from_base(&self) -> Pose2 {
        self.filter.map_from_base
    }

    /// The map so far; nothing before the first scan.
    #[must_use]
    pub fn map(&self) -> Option<&OccupancyGrid> {
        self.matcher.as_ref().map(ScanMatcher::map)
    }

    /// Scans in the map.
    #[must_use]
    pub fn n_keyframes(&self) -> u32 {
        self.mapper.n_scans()
    }

    /// Whether an update's scan belongs into the map: it is new, and its place is known.
    fn is_keyframe(&self, update: &PoseUpdate) -> bool {
        if update.source == PoseSource::Odometry {
            return false;
        }
        self.last_keyframe.is_none_or(|last| {
            let motion = last.inverse() * update.map_from_base;
            motion.translation.vector.norm() >= self.params.keyframe_distance_m
                || motion.rotation.angle().abs() >= self.params.keyframe_turn_rad
        })
    }
}

#[cfg(test)]
mod tests;
