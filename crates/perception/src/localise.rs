//! Finding the robot in a stored map without any guess, as on the second day in a home.
//!
//! Each candidate is the best pose of the whole map and all headings by branch and bound (Hess et al.,
//! ICRA 2016), away from the candidates before it. It is refined by [`crate::scan_match`] and judged by its
//! *confidence*: the mean likelihood of the scan's ends times the share of rays that reach their end
//! without passing through a wall of the map. One scan may fit two like rooms: then
//! [`GlobalLocaliser`] keeps all candidates and lets driving decide.

use crate::pose_search::{Exclusion, PoseSearch, SearchWindow};
use crate::scan_match::{
    PoseGuess, ScanMatchOutcome, ScanMatchParams, ScanMatcher, WallPoint, angle_step, wall_points,
};
use crate::sensing::LaserScan;
use factotum_geometry::Pose2;
use factotum_geometry::grid::{CellState, OccupancyGrid, cells_on_segment};
use nalgebra::{Point2, Vector2};
use std::f64::consts::PI;

/// Settings of a [`GlobalLocaliser`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocaliseParams {
    /// How scans are matched.
    pub matcher: ScanMatchParams,
    /// Most candidates that are followed.
    pub n_candidates_max: usize,
    /// Least confidence of a pose. Over made-up homes the right pose had 0.89 to 0.99, the best pose in a
    /// strange home up to 0.68.
    pub confidence_min: f64,
    /// A pose is found when every other candidate has less than this share of its confidence.
    pub rival_ratio: f64,
    /// Poses nearer than this (m) and [`LocaliseParams::distinct_rad`] are one candidate.
    pub distinct_m: f64,
    /// See [`LocaliseParams::distinct_m`].
    pub distinct_rad: f64,
}

impl Default for LocaliseParams {
    fn default() -> Self {
        Self {
            matcher: ScanMatchParams::default(),
            n_candidates_max: 6,
            confidence_min: 0.75,
            rival_ratio: 0.9,
            distinct_m: 0.5,
            distinct_rad: 0.35,
        }
    }
}

/// A pose the robot may be at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseCandidate {
    /// The pose.
    pub map_from_base: Pose2,
    /// How well the scan agrees with the map from there, 0 to 1.
    pub confidence: f64,
}

/// Whether the robot knows where it is.
#[derive(Debug, Clone, PartialEq)]
pub enum Localisation {
    /// There is one pose.
    Found(PoseCandidate),
    /// There are several, best first; drive on and look again.
    Ambiguous {
        /// The poses.
        candidates: Vec<PoseCandidate>,
    },
    /// Nowhere in the map does it look like this.
    Lost {
        /// Best confidence found.
        confidence: f64,
        /// Confidence wanted.
        confidence_min: f64,
    },
}

/// Finds the robot in one map, over one or more scans.
#[derive(Debug, Clone)]
pub struct GlobalLocaliser {
    params: LocaliseParams,
    matcher: ScanMatcher,
    candidates: Vec<PoseCandidate>,
    last_odom_from_base: Option<Pose2>,
}

/// Pyramid levels of the search over a whole map: blocks of up to 32 cells.
const N_LEVELS_GLOBAL: usize = 5;

/// Scan points used in the search over the whole map; the refinement uses all.
const N_SEARCH_POINTS_MAX: usize = 120;

impl GlobalLocaliser {
    /// Localiser for a stored map.
    #[must_use]
    pub fn new(map: &OccupancyGrid, params: LocaliseParams) -> Self {
        Self {
            params,
            matcher: ScanMatcher::with_levels(map, params.matcher, N_LEVELS_GLOBAL),
            candidates: Vec::new(),
            last_odom_from_base: None,
        }
    }

    /// Where the robot is, by all scans so far; odometry and scan are of the same moment.
    ///
    /// The first scan (and any after losing all candidates) searches the whole map; later ones only follow
    /// the candidates and drop those that fit no longer.
    pub fn update(&mut self, odom_from_base: &Pose2, scan: &LaserScan) -> Localisation {
        let wall = wall_points(scan, self.params.matcher.thinning_m);
        let last = self.last_odom_from_base.replace(*odom_from_base);
        if let Some(last) = last.filter(|_| !self.candidates.is_empty()) {
            let motion = last.inverse() * odom_from_base;
            let moved: Vec<_> = self
                .candidates
                .iter()
                .map(|c| c.map_from_base * motion)
                .collect();
            let followed: Vec<_> = moved
                .iter()
                .filter_map(|pose| self.judge(&wall, scan, *pose, 0.1))
                .collect();
            self.keep_best(followed);
        }
        if self.best_confidence() < self.params.confidence_min {
            let found = self.search(&wall, scan);
            self.keep_best(found);
        }
        self.verdict()
    }

    /// Candidates of a single scan over the whole map, best first.
    fn search(&self, wall: &[WallPoint], scan: &LaserScan) -> Vec<PoseCandidate> {
        let stride = wall.len().div_ceil(N_SEARCH_POINTS_MAX).max(1);
        let places: Vec<Point2<f64>> = wall.iter().step_by(stride).map(|p| p.place).collect();
        if wall.len() < self.params.matcher.n_points_min {
            return Vec::new();
        }
        let map = self.matcher.map();
        let (width, height) = self.matcher.field().size();
        let half_m = Vector2::new(width as f64, height as f64) * (0.5 * map.resolution_m());
        let window = SearchWindow {
            center: map.world_from_grid() * Pose2::new(half_m, 0.0),
            reach_m: half_m,
            reach_rad: PI,
            step_rad: 2.0 * angle_step(&places, map.resolution_m()),
            penalty_per_m2: 0.0,
            penalty_per_rad2: 0.0,
            score_min: 0.5 * self.params.confidence_min,
        };
        let search = PoseSearch::new(self.matcher.field(), &places, &window);
        let mut score_min = window.score_min;
        let mut excluded = Vec::new();
        let mut found = Vec::new();
        while found.len() < self.params.n_candidates_max {
            let Some(best) = search.best(&excluded, score_min) else {
                break;
            };
            // Candidates far below the best are not worth the search.
            score_min = score_min.max(0.75 * best.score);
            excluded.push(Exclusion {
                pose: best.pose,
                radius_m: self.params.distinct_m,
                radius_rad: self.params.distinct_rad,
            });
            found.extend(self.judge(wall, scan, best.pose, 0.2));
            if excluded.len() >= self.params.n_candidates_max + 2 {
                break;
            }
        }
        found
    }

    /// The refined candidate near a pose, or nothing when the robot cannot stand there.
    fn judge(
        &self,
        wall: &[WallPoint],
        scan: &LaserScan,
        start: Pose2,
        sigma_m: f64,
    ) -> Option<PoseCandidate> {
        let guess = PoseGuess {
            map_from_base: start,
            sigma_m,
            sigma_rad: 0.1,
        };
        let outcome: ScanMatchOutcome = self.matcher.refine(wall, start, &guess);
        let map_from_base = outcome.fit()?.map_from_base;
        let base = Point2::from(map_from_base.translation.vector);
        if self.matcher.map().cell_at(&base).state() == CellState::Occupied {
            return None;
        }
        let places: Vec<Point2<f64>> = wall.iter().map(|p| p.place).collect();
        let confidence = self.matcher.field().mean(&places, &map_from_base)
            * clear_ray_share(self.matcher.map(), scan, &map_from_base);
        Some(PoseCandidate {
            map_from_base,
            confidence,
        })
    }

    /// Keeps the distinct candidates, best first.
    fn keep_best(&mut self, mut found: Vec<PoseCandidate>) {
        found.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
        self.candidates.clear();
        for candidate in found {
            let is_new = self.candidates.iter().all(|kept| {
                let apart = kept.map_from_base.inverse() * candidate.map_from_base;
                apart.translation.vector.norm() >= self.params.distinct_m
                    || apart.rotation.angle().abs() >= self.params.distinct_rad
            });
            if is_new && self.candidates.len() < self.params.n_candidates_max {
                self.candidates.push(candidate);
            }
        }
    }

    fn best_confidence(&self) -> f64 {
        self.candidates.first().map_or(0.0, |best| best.confidence)
    }

    fn verdict(&self) -> Localisation {
        let confidence = self.best_confidence();
        let confidence_min = self.params.confidence_min;
        let Some(best) = self
            .candidates
            .first()
            .filter(|_| confidence >= confidence_min)
        else {
            return Localisation::Lost {
                confidence,
                confidence_min,
            };
        };
        let candidates: Vec<PoseCandidate> = self
            .candidates
            .iter()
            .copied()
            .filter(|c| c.confidence >= self.params.rival_ratio * confidence)
            .collect();
        if candidates.len() == 1 {
            Localisation::Found(*best)
        } else {
            Localisation::Ambiguous { candidates }
        }
    }
}

/// Where a robot that took `scan` stands in `map`, by this scan alone.
#[must_use]
pub fn localise_globally(
    map: &OccupancyGrid,
    scan: &LaserScan,
    params: &LocaliseParams,
) -> Localisation {
    GlobalLocaliser::new(map, *params).update(&Pose2::identity(), scan)
}

/// Share of the rays that do not pass through a wall of the map before they end.
fn clear_ray_share(map: &OccupancyGrid, scan: &LaserScan, map_from_base: &Pose2) -> f64 {
    /// Rays looked at, spread over the scan.
    const N_RAYS_MAX: usize = 90;
    /// Walls this near to the ray's end are the one it hit (m).
    const END_MARGIN_M: f64 = 0.2;
    let rays: Vec<_> = scan.rays().filter(|ray| ray.is_hit).collect();
    let stride = rays.len().div_ceil(N_RAYS_MAX).max(1);
    let lidar = map_from_base * scan.origin_in_base();
    let mut n_rays = 0;
    let mut n_clear = 0;
    for ray in rays.iter().step_by(stride) {
        let end = map_from_base * ray.end_in_base;
        let along = end - lidar;
        let length_m = along.norm();
        n_rays += 1;
        if length_m <= END_MARGIN_M {
            n_clear += 1;
            continue;
        }
        let stop = lidar + along * (1.0 - END_MARGIN_M / length_m);
        let is_clear =
            cells_on_segment(&map.lattice_point(&lidar), &map.lattice_point(&stop)).all(|place| {
                map.cell_at_signed(place)
                    .is_none_or(|cell| !cell.is_occupied())
            });
        n_clear += usize::from(is_clear);
    }
    n_clear as f64 / f64::from(n_rays.max(1))
}

#[cfg(test)]
mod tests;
