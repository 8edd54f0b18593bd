//! Laying a lidar scan onto a map, near a guess.
//!
//! Two steps. First a correlative search over a window around the guess (Olson, "Real-time correlative scan
//! matching", ICRA 2009, sped up by branch and bound), which no local minimum can trap. Then Gauss-Newton
//! on `Σ w_i (n_iᵀ (T p_i - c_i))² / σ² + |T ⊖ guess|²_prior`, where `n_i` is the direction across the
//! wall at scan point `p_i`, seen from the scan itself, and `c_i` the locally averaged place of the wall in
//! the map (Gaussian-weighted occupied cells around `T p_i`, each where rays have ended in it if that is known, else at its
//! centre), so that the result is finer than a cell.
//! Along directions that the scan does not fix (a corridor) the guess decides.
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | p, n | scan point, unit normal of its wall, in the base frame | m, - |
//! | c | wall in the map near T p | m |
//! | T | map_from_base | m, rad |

use crate::likelihood::LikelihoodField;
use crate::pose_search::{SearchWindow, best_pose};
use crate::sensing::LaserScan;
use factotum_geometry::Pose2;
use factotum_geometry::frames::wrap_angle;
use factotum_geometry::grid::{CellState, GridMapper, OccupancyGrid, SignedCell};
use nalgebra::{Matrix3, Point2, UnitComplex, Vector2, Vector3};
use std::collections::BTreeMap;

/// Settings of a [`ScanMatcher`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanMatchParams {
    /// Width of the likelihood around walls in the search (m); about two cells.
    pub likelihood_sigma_m: f64,
    /// Scan points are thinned to one per square of this edge (m), so near walls do not drown far ones.
    pub thinning_m: f64,
    /// Error of a scan point against the map (m). Larger than the lidar's noise, for the errors of
    /// neighbouring points go together.
    pub point_sigma_m: f64,
    /// Fewest scan points on known ground to decide anything.
    pub n_points_min: usize,
    /// Least mean likelihood, over the points on known ground, of a match.
    pub score_min: f64,
    /// A match is ambiguous when the scan alone leaves the position less sure than this (m)...
    pub position_sigma_max_m: f64,
    /// ...or informs on its weakest direction less than this share of what it does on the strongest: the
    /// noise of wall directions alone makes a bare corridor look informative by about a hundredth.
    pub information_ratio_min: f64,
    /// Smallest window of the search to each side (m).
    pub window_min_m: f64,
    /// Largest window of the search to each side (m).
    pub window_max_m: f64,
    /// Most Gauss-Newton steps.
    pub n_refinements_max: usize,
}

impl Default for ScanMatchParams {
    fn default() -> Self {
        Self {
            likelihood_sigma_m: 0.1,
            thinning_m: 0.05,
            point_sigma_m: 0.05,
            n_points_min: 20,
            score_min: 0.5,
            position_sigma_max_m: 0.1,
            information_ratio_min: 0.02,
            window_min_m: 0.1,
            window_max_m: 0.8,
            n_refinements_max: 15,
        }
    }
}

/// Where the robot is thought to be before the scan is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseGuess {
    /// The guess.
    pub map_from_base: Pose2,
    /// Standard deviation of its position (m, along each axis).
    pub sigma_m: f64,
    /// Standard deviation of its heading (rad).
    pub sigma_rad: f64,
}

/// A scan laid onto a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanMatch {
    /// The robot's pose.
    pub map_from_base: Pose2,
    /// Mean likelihood of the points on known ground, 0 to 1; good matches are above 0.8.
    pub score: f64,
    /// Scan points on known ground.
    pub n_points: usize,
    /// Covariance of (x, y, yaw) in the map frame (m², m rad, rad²), the guess included.
    pub covariance: Matrix3<f64>,
}

/// What came of matching a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScanMatchOutcome {
    /// The scan fixes the pose.
    Matched(ScanMatch),
    /// The scan fits, but also when shifted along some direction; there the pose is the guess's.
    Ambiguous {
        /// The match, usable together with its guess.
        fit: ScanMatch,
        /// Standard deviation of the position along the weakest direction by the scan alone (m).
        weakest_sigma_m: f64,
    },
    /// The scan does not fit the map near the guess.
    Rejected {
        /// Best score found.
        score: f64,
        /// Score wanted.
        score_min: f64,
    },
    /// Too little of the scan lies on known ground.
    TooFewPoints {
        /// Points there are.
        found: usize,
        /// Points wanted.
        wanted: usize,
    },
}

impl ScanMatchOutcome {
    /// The match, unless the scan was rejected or too small.
    #[must_use]
    pub fn fit(&self) -> Option<&ScanMatch> {
        match self {
            Self::Matched(fit) | Self::Ambiguous { fit, .. } => Some(fit),
            Self::Rejected { .. } | Self::TooFewPoints { .. } => None,
        }
    }
}

/// A point of a scan on a wall.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WallPoint {
    pub(crate) place: Point2<f64>,
    /// Unit vector across the wall; none where neighbouring rays saw something else.
    pub(crate) normal: Option<Vector2<f64>>,
}

/// Lays scans onto one map.
#[derive(Debug, Clone)]
pub struct ScanMatcher {
    params: ScanMatchParams,
    map: OccupancyGrid,
    /// Where in each cell its wall is, cells; nothing stands for the centres.
    places_in_cells: Vec<[f32; 2]>,
    field: LikelihoodField,
}

/// Pyramid levels of the search near a guess: windows are a few tens of cells wide.
const N_LEVELS_NEAR: usize = 3;

impl ScanMatcher {
    /// Matcher for a map.
    #[must_use]
    pub fn new(map: &OccupancyGrid, params: ScanMatchParams) -> Self {
        Self::with_levels(map, params, N_LEVELS_NEAR)
    }

    /// Matcher for a map in the making, which knows where in its cells the walls are.
    pub(crate) fn of_mapper(mapper: &GridMapper, params: ScanMatchParams) -> Option<Self> {
        let matcher = Self::new(&mapper.grid()?, params);
        Some(Self {
            places_in_cells: mapper.places_in_cells(),
            ..matcher
        })
    }

    pub(crate) fn with_levels(
        map: &OccupancyGrid,
        params: ScanMatchParams,
        n_levels: usize,
    ) -> Self {
        let field = LikelihoodField::new(map, params.likelihood_sigma_m, n_levels);
        Self {
            params,
            map: map.clone(),
            places_in_cells: Vec::new(),
            field,
        }
    }

    /// The map.
    #[must_use]
    pub fn map(&self) -> &OccupancyGrid {
        &self.map
    }

    pub(crate) fn field(&self) -> &LikelihoodField {
        &self.field
    }

    /// Pose of the robot that took `scan`, near `guess`.
    #[must_use]
    pub fn match_scan(&self, scan: &LaserScan, guess: &PoseGuess) -> ScanMatchOutcome {
        let wall = wall_points(scan, self.params.thinning_m);
        let places: Vec<Point2<f64>> = wall.iter().map(|point| point.place).collect();
        let wanted = self.params.n_points_min;
        if places.len() < wanted {
            return ScanMatchOutcome::TooFewPoints {
                found: places.len(),
                wanted,
            };
        }
        let window = self.window(&places, guess);
        let start =
            best_pose(&self.field, &places, &window).map_or(guess.map_from_base, |c| c.pose);
        self.refine(&wall, start, guess)
    }

    fn window(&self, places: &[Point2<f64>], guess: &PoseGuess) -> SearchWindow {
        /// Score lost at one standard deviation from the guess; differences between good and bad
        /// poses are some tenths.
        const SCORE_PER_SIGMA2: f64 = 0.01;
        let params = &self.params;
        let reach_m = (3.0 * guess.sigma_m).clamp(params.window_min_m, params.window_max_m);
        SearchWindow {
            center: guess.map_from_base,
            reach_m: Vector2::new(reach_m, reach_m),
            reach_rad: (3.0 * guess.sigma_rad).clamp(0.05, 0.6),
            step_rad: angle_step(places, self.field.resolution_m()),
            penalty_per_m2: SCORE_PER_SIGMA2 / guess.sigma_m.max(0.01).powi(2),
            penalty_per_rad2: SCORE_PER_SIGMA2 / guess.sigma_rad.max(0.01).powi(2),
            score_min: -10.0,
        }
    }

    /// Gauss-Newton from `start`, then the verdict.
    pub(crate) fn refine(
        &self,
        wall: &[WallPoint],
        start: Pose2,
        guess: &PoseGuess,
    ) -> ScanMatchOutcome {
        /// Steps below this (m, rad) are far below the map's resolution.
        const STEP_MIN: f64 = 1e-4;
        let prior = Matrix3::from_diagonal(&Vector3::new(
            guess.sigma_m.max(1e-4).powi(-2),
            guess.sigma_m.max(1e-4).powi(-2),
            guess.sigma_rad.max(1e-4).powi(-2),
        ));
        let mut pose = start;
        for _ in 0..self.params.n_refinements_max {
            let (information, gradient) = self.normal_equations(wall, &pose);
            let offset = difference(&pose, &guess.map_from_base);
            let Some(step) = (information + prior)
                .cholesky()
                .map(|factor| factor.solve(&-(gradient + prior * offset)))
            else {
                break; // never: the prior is positive definite
            };
            pose = Pose2::from_parts(
                (pose.translation.vector + step.xy()).into(),
                UnitComplex::new(pose.rotation.angle() + step.z),
            );
            if step.xy().norm() < STEP_MIN && step.z.abs() < STEP_MIN {
                break;
            }
        }
        self.verdict(wall, pose, &prior)
    }

    fn verdict(&self, wall: &[WallPoint], pose: Pose2, prior: &Matrix3<f64>) -> ScanMatchOutcome {
        let (score, n_points) = self.score(wall, &pose);
        let wanted = self.params.n_points_min;
        if n_points < wanted {
            return ScanMatchOutcome::TooFewPoints {
                found: n_points,
                wanted,
            };
        }
        let score_min = self.params.score_min;
        if score < score_min {
            return ScanMatchOutcome::Rejected { score, score_min };
        }
        let (information, _) = self.normal_equations(wall, &pose);
        let covariance = (information + prior)
            .try_inverse()
            .unwrap_or_else(Matrix3::zeros);
        let fit = ScanMatch {
            map_from_base: pose,
            score,
            n_points,
            covariance,
        };
        let [least, most] = position_information(&information);
        let weakest_sigma_m = if least > 0.0 {
            least.sqrt().recip()
        } else {
            f64::INFINITY
        };
        if weakest_sigma_m > self.params.position_sigma_max_m
            || least < self.params.information_ratio_min * most
        {
            ScanMatchOutcome::Ambiguous {
                fit,
                weakest_sigma_m,
            }
        } else {
            ScanMatchOutcome::Matched(fit)
        }
    }

    /// Mean likelihood of the points on known ground, and how many they are.
    fn score(&self, wall: &[WallPoint], pose: &Pose2) -> (f64, usize) {
        let mut sum = 0.0;
        let mut n_points = 0;
        for point in wall {
            let place = pose * point.place;
            let (likelihood, _) = self.field.at(&place);
            // A point that hits nothing known says nothing; one in free space contradicts the map.
            if likelihood > 0.1 || self.map.cell_at(&place).state() != CellState::Unknown {
                sum += likelihood;
                n_points += 1;
            }
        }
        (sum / f64::from(n_points.max(1)), n_points as usize)
    }

    /// Information matrix and gradient of the wall distances at a pose.
    fn normal_equations(&self, wall: &[WallPoint], pose: &Pose2) -> (Matrix3<f64>, Vector3<f64>) {
        let mut information = Matrix3::zeros();
        let mut gradient = Vector3::zeros();
        for point in wall {
            let Some(normal_in_base) = point.normal else {
                continue;
            };
            let place = pose * point.place;
            let normal = pose.rotation * normal_in_base;
            let Some((wall_place, weight)) = self.wall_near(&place) else {
                continue;
            };
            let residual_m = normal.dot(&(place - wall_place));
            let arm = place.coords - pose.translation.vector;
            let row = Vector3::new(normal.x, normal.y, arm.x * normal.y - arm.y * normal.x);
            let weight = weight / self.params.point_sigma_m.powi(2);
            information += weight * row * row.transpose();
            gradient += weight * residual_m * row;
        }
        (information, gradient)
    }

    /// Where in a cell of the map its wall is, cells.
    fn place_in_cell(&self, column: i64, row: i64) -> [f64; 2] {
        let flat = row * self.map.width() as i64 + column;
        let place = usize::try_from(flat)
            .ok()
            .and_then(|flat| self.places_in_cells.get(flat));
        place.map_or([0.5, 0.5], |place| place.map(f64::from))
    }

    /// Place of the wall near a point and how much to trust it (0 to 1), or nothing when there is none.
    fn wall_near(&self, place: &Point2<f64>) -> Option<(Point2<f64>, f64)> {
        /// Cells to each side that are averaged.
        const REACH: i64 = 2;
        /// Width of the average (cells).
        const SIGMA: f64 = 1.0;
        /// Weight of one occupied cell three standard deviations away: less is no wall.
        const WEIGHT_MIN: f64 = 0.01;
        let at = self.map.lattice_point(place);
        let center = SignedCell::containing(&at);
        let mut weight_sum = 0.0;
        let mut offset_sum = Vector2::zeros();
        for row in center.row - REACH..=center.row + REACH {
            for column in center.column - REACH..=center.column + REACH {
                let Some(cell) = self.map.cell_at_signed(SignedCell { column, row }) else {
                    continue;
                };
                if !cell.is_occupied() {
                    continue;
                }
                let [x, y] = self.place_in_cell(column, row);
                let offset = Vector2::new(column as f64 + x - at.x, row as f64 + y - at.y);
                let occupancy = f64::from(cell.percent().unwrap_or(0)) / 100.0;
                let weight = occupancy * (-0.5 * offset.norm_squared() / (SIGMA * SIGMA)).exp();
                weight_sum += weight;
                offset_sum += weight * offset;
            }
        }
        let offset = offset_sum * (self.map.resolution_m() / weight_sum);
        (weight_sum > WEIGHT_MIN).then(|| {
            (
                place + self.map.world_from_grid().rotation * offset,
                weight_sum.min(1.0),
            )
        })
    }
}

/// Angle between candidates at which the farthest point moves by one cell (rad).
pub(crate) fn angle_step(places: &[Point2<f64>], resolution_m: f64) -> f64 {
    let farthest_m = places.iter().map(|p| p.coords.norm()).fold(1.0, f64::max);
    (resolution_m / farthest_m).clamp(0.004, 0.05)
}

/// `(x, y, yaw)` from `from` to `to`, in the map frame.
fn difference(to: &Pose2, from: &Pose2) -> Vector3<f64> {
    let shift = to.translation.vector - from.translation.vector;
    let turn = wrap_angle(to.rotation.angle() - from.rotation.angle());
    Vector3::new(shift.x, shift.y, turn)
}

/// Least and most information on the position over all directions (1/m²), heading unknown.
fn position_information(information: &Matrix3<f64>) -> [f64; 2] {
    // Marginal over the heading: Schur complement of the position block.
    let position = information.fixed_view::<2, 2>(0, 0).into_owned();
    let cross = information.fixed_view::<2, 1>(0, 2).into_owned();
    let heading = information[(2, 2)];
    let marginal = if heading > 0.0 {
        position - cross * cross.transpose() / heading
    } else {
        position
    };
    let eigenvalues = marginal.symmetric_eigenvalues();
    [eigenvalues.min(), eigenvalues.max()]
}

/// The hits of a scan with their walls' directions, one per square of edge `thinning_m`, in the order of
/// the squares.
pub(crate) fn wall_points(scan: &LaserScan, thinning_m: f64) -> Vec<WallPoint> {
    let rays: Vec<Option<Point2<f64>>> = scan
        .rays()
        .map(|ray| ray.is_hit.then_some(ray.end_in_base))
        .collect();
    let mut thinned: BTreeMap<[i64; 2], WallPoint> = BTreeMap::new();
    for (i, place) in rays.iter().enumerate() {
        let Some(place) = *place else {
            continue;
        };
        let point = WallPoint {
            place,
            normal: wall_normal(&rays, i, &scan.origin_in_base()),
        };
        let square = [place.x, place.y].map(|v| (v / thinning_m.max(1e-3)).floor() as i64);
        let kept = thinned.entry(square).or_insert(point);
        // A point with a known wall direction serves better than one without.
        if kept.normal.is_none() && point.normal.is_some() {
            *kept = point;
        }
    }
    thinned.into_values().collect()
}

/// Direction across the wall at ray `i`, from the points to both sides.
fn wall_normal(
    rays: &[Option<Point2<f64>>],
    i: usize,
    lidar: &Point2<f64>,
) -> Option<Vector2<f64>> {
    /// Rays to each side that are looked at.
    const REACH: usize = 4;
    /// Neighbours farther apart than this share of the range lie on another surface.
    const GAP_RATIO: f64 = 0.2;
    /// Largest spread across the wall, relative to that along it, of points on one wall.
    const THICKNESS_RATIO_MAX: f64 = 0.3;
    let place = rays[i]?;
    let gap_m = GAP_RATIO * (place - lidar).norm() + 0.05;
    let n = rays.len();
    // A full turn has neighbours across its seam, but a partial one has not: the gap tells.
    let neighbours: Vec<Point2<f64>> = (0..=2 * REACH)
        .filter_map(|k| rays[(i + n + k - REACH.min(n)) % n])
        .filter(|p| (p - place).norm() <= gap_m)
        .collect();
    if neighbours.len() < 4 {
        return None;
    }
    let mean = neighbours
        .iter()
        .fold(Vector2::zeros(), |sum, p| sum + p.coords)
        / neighbours.len() as f64;
    let scatter = neighbours
        .iter()
        .fold(nalgebra::Matrix2::zeros(), |sum, p| {
            let d = p.coords - mean;
            sum + d * d.transpose()
        });
    let eigen = scatter.symmetric_eigen();
    let (least, most) = if eigen.eigenvalues[0] < eigen.eigenvalues[1] {
        (0, 1)
    } else {
        (1, 0)
    };
    let is_thin = eigen.eigenvalues[least].max(0.0).sqrt()
        < THICKNESS_RATIO_MAX * eigen.eigenvalues[most].sqrt();
    is_thin.then(|| eigen.eigenvectors.column(least).into_owned())
}

#[cfg(test)]
mod tests;
