//! The best pose of a scan in a map over a whole window of poses, by branch and bound.
//!
//! Maximises `mean L(T p) - penalty(T)` over planar poses `T`, exactly on a lattice of one cell and one
//! angle step. Method: Hess et al., ICRA 2016, algorithm 3 (depth-first branch and bound over blocks of
//! shifts, bounded by the pyramid of the likelihood field). Differs: a quadratic penalty draws the result
//! towards a guess (its least value over a block enters the bound), and discs around known solutions can be
//! left out, to find the second best one.

use crate::likelihood::LikelihoodField;
use factotum_geometry::Pose2;
use factotum_geometry::frames::wrap_angle;
use nalgebra::{Point2, Vector2};

/// A lattice of poses about a centre.
#[derive(Debug, Clone)]
pub(crate) struct SearchWindow {
    /// Middle of the window.
    pub(crate) center: Pose2,
    /// Farthest shift along each axis of the grid (m).
    pub(crate) reach_m: Vector2<f64>,
    /// Farthest turn (rad); π searches all headings.
    pub(crate) reach_rad: f64,
    /// Angle between neighbouring candidates (rad).
    pub(crate) step_rad: f64,
    /// Score lost per m² from the centre.
    pub(crate) penalty_per_m2: f64,
    /// Score lost per rad² from the centre.
    pub(crate) penalty_per_rad2: f64,
    /// Candidates with a lower score are not wanted.
    pub(crate) score_min: f64,
}

/// Poses that are not wanted again.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exclusion {
    pub(crate) pose: Pose2,
    pub(crate) radius_m: f64,
    pub(crate) radius_rad: f64,
}

impl Exclusion {
    fn holds(&self, place: &Point2<f64>, yaw: f64) -> bool {
        (place.coords - self.pose.translation.vector).norm() < self.radius_m
            && wrap_angle(yaw - self.pose.rotation.angle()).abs() < self.radius_rad
    }
}

/// A pose and its score.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) pose: Pose2,
    /// Mean likelihood less the penalty.
    pub(crate) score: f64,
}

/// The window's best pose with at least [`SearchWindow::score_min`], if there is one.
pub(crate) fn best_pose(
    field: &LikelihoodField,
    points_in_base: &[Point2<f64>],
    window: &SearchWindow,
) -> Option<Candidate> {
    PoseSearch::new(field, points_in_base, window).best(&[], window.score_min)
}

/// A window prepared for one or more searches.
pub(crate) struct PoseSearch<'a> {
    field: &'a LikelihoodField,
    window: &'a SearchWindow,
    reach: Vector2<i32>,
    rotated: Vec<Rotated>,
    block_level: usize,
    /// Upper bound, turn and first shift of each block, best first.
    blocks: Vec<(f64, usize, [i32; 2])>,
}

impl<'a> PoseSearch<'a> {
    pub(crate) fn new(
        field: &'a LikelihoodField,
        points_in_base: &[Point2<f64>],
        window: &'a SearchWindow,
    ) -> Self {
        let n_turns = (window.reach_rad / window.step_rad).ceil() as i32;
        let reach = window
            .reach_m
            .map(|m| (m / field.resolution_m()).ceil() as i32);
        let block_level = block_level(reach, field.level_max());
        let rotated = (-n_turns..=n_turns)
            .map(|i| f64::from(i) * window.step_rad)
            .map(|turn| Rotated::new(field, points_in_base, &window.center, turn))
            .collect();
        let mut search = Self {
            field,
            window,
            reach,
            rotated,
            block_level,
            blocks: Vec::new(),
        };
        // Without points there is nothing to search.
        if !points_in_base.is_empty() {
            search.blocks = search.bounded_blocks();
        }
        search
    }

    /// The best pose outside `excluded` with at least `score_min`, if there is one.
    pub(crate) fn best(&self, excluded: &[Exclusion], score_min: f64) -> Option<Candidate> {
        let mut descent = Descent {
            search: self,
            excluded,
            best: None,
            bound: score_min,
        };
        for &(bound, turn_idx, shift) in &self.blocks {
            if descent.is_hopeless(bound) {
                break;
            }
            descent.descend(turn_idx, shift, self.block_level);
        }
        descent.best
    }

    /// Promising blocks first: the sooner a good score is known, the more is cut.
    fn bounded_blocks(&self) -> Vec<(f64, usize, [i32; 2])> {
        let step = 1 << self.block_level;
        let mut blocks = Vec::new();
        for turn_idx in 0..self.rotated.len() {
            for row in (-self.reach.y..=self.reach.y).step_by(step) {
                for column in (-self.reach.x..=self.reach.x).step_by(step) {
                    let bound = self.bound_of(turn_idx, [column, row], self.block_level);
                    if bound >= self.window.score_min {
                        blocks.push((bound, turn_idx, [column, row]));
                    }
                }
            }
        }
        blocks.sort_by(|a, b| b.0.total_cmp(&a.0));
        blocks
    }

    /// Upper bound of the score over the block of `2^level` shifts from `shift` up and right.
    fn bound_of(&self, turn_idx: usize, shift: [i32; 2], level: usize) -> f64 {
        let rotated = &self.rotated[turn_idx];
        let last = (1 << level) - 1;
        let least = shift.map(|first| {
            if first > 0 {
                first
            } else {
                (first + last).min(0).abs()
            }
        });
        self.field.mean_at_level(&rotated.cells, shift, level)
            - self.penalty(f64::from(least[0]), f64::from(least[1]), rotated.turn_rad)
    }

    fn penalty(&self, columns: f64, rows: f64, turn_rad: f64) -> f64 {
        let shift_m2 = (columns * columns + rows * rows) * self.field.resolution_m().powi(2);
        self.window.penalty_per_m2 * shift_m2 + self.window.penalty_per_rad2 * turn_rad * turn_rad
    }
}

/// Blocks about a quarter as wide as the window.
fn block_level(reach: Vector2<i32>, level_max: usize) -> usize {
    let width = 2 * reach.x.min(reach.y).max(0) + 1;
    let level = (f64::from(width).log2() - 1.0).max(0.0) as usize;
    level.min(level_max)
}

struct Rotated {
    turn_rad: f64,
    yaw: f64,
    /// The scan's points turned about the base and put at the window's centre, in cells of the grid.
    cells: Vec<[i32; 2]>,
}

impl Rotated {
    fn new(
        field: &LikelihoodField,
        points_in_base: &[Point2<f64>],
        center: &Pose2,
        turn_rad: f64,
    ) -> Self {
        let yaw = center.rotation.angle() + turn_rad;
        let map_from_base = Pose2::new(center.translation.vector, yaw);
        let grid_from_base = field.map_from_grid().inverse() * map_from_base;
        let cells = points_in_base
            .iter()
            .map(|p| {
                let p = grid_from_base * p / field.resolution_m();
                [p.x.floor() as i32, p.y.floor() as i32]
            })
            .collect();
        Self {
            turn_rad,
            yaw,
            cells,
        }
    }
}

/// One search: the best so far.
struct Descent<'a> {
    search: &'a PoseSearch<'a>,
    excluded: &'a [Exclusion],
    best: Option<Candidate>,
    bound: f64,
}

impl Descent<'_> {
    fn is_hopeless(&self, bound: f64) -> bool {
        bound < self.bound || (self.best.is_some() && bound <= self.bound)
    }

    fn descend(&mut self, turn_idx: usize, shift: [i32; 2], level: usize) {
        if level == 0 {
            self.take(turn_idx, shift);
            return;
        }
        let half = 1 << (level - 1);
        let mut children: Vec<(f64, [i32; 2])> = [(0, 0), (half, 0), (0, half), (half, half)]
            .into_iter()
            .map(|(dc, dr)| [shift[0] + dc, shift[1] + dr])
            .filter(|child| child[0] <= self.search.reach.x && child[1] <= self.search.reach.y)
            .map(|child| (self.search.bound_of(turn_idx, child, level - 1), child))
            .collect();
        children.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (bound, child) in children {
            if !self.is_hopeless(bound) {
                self.descend(turn_idx, child, level - 1);
            }
        }
    }

    fn take(&mut self, turn_idx: usize, shift: [i32; 2]) {
        let score = self.search.bound_of(turn_idx, shift, 0);
        if self.is_hopeless(score) {
            return;
        }
        let yaw = self.search.rotated[turn_idx].yaw;
        let cells = Vector2::new(f64::from(shift[0]), f64::from(shift[1]));
        let shift_in_map =
            self.search.field.map_from_grid().rotation * (cells * self.search.field.resolution_m());
        let place = Point2::from(self.search.window.center.translation.vector + shift_in_map);
        if self
            .excluded
            .iter()
            .any(|exclusion| exclusion.holds(&place, yaw))
        {
            return;
        }
        self.best = Some(Candidate {
            pose: Pose2::new(place.coords, yaw),
            score,
        });
        self.bound = score;
    }
}
