//! How well one map agrees with another, for example a mapped home with its true floor plan.

use super::{CellState, DistanceField, OccupancyGrid};
use crate::Pose2;

/// Agreement of an estimated map with a reference.
///
/// All figures are taken over the centres of the reference's *known* cells: where the reference knows
/// nothing, the estimate is neither praised nor blamed. A ratio with nothing in its denominator is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapOverlap {
    /// Free floor: |free in both| / |free in either|.
    pub free_iou: f64,
    /// Obstacles: |occupied in both| / |occupied in either|. Walls are a cell thick, so this falls fast
    /// with half a cell of misalignment.
    pub occupied_iou: f64,
    /// Share of the estimate's occupied cells within the tolerance of a reference obstacle.
    pub occupied_precision: f64,
    /// Share of the reference's occupied cells within the tolerance of an estimated obstacle.
    pub occupied_recall: f64,
    /// Share of the reference's known cells that the estimate knows, rightly or wrongly.
    pub coverage: f64,
}

/// Overlap of `estimate` with `reference`, the estimate's world being at `reference_from_estimate`.
///
/// `tolerance_m` is the distance within which obstacles count as found in precision and recall.
#[must_use]
pub fn map_overlap(
    estimate: &OccupancyGrid,
    reference: &OccupancyGrid,
    reference_from_estimate: &Pose2,
    tolerance_m: f64,
) -> MapOverlap {
    let estimate_from_reference = reference_from_estimate.inverse();
    let to_estimate = DistanceField::of(estimate, super::UnknownCells::Passable);
    let to_reference = DistanceField::of(reference, super::UnknownCells::Passable);
    let near = |d: Option<f64>| d.is_some_and(|d| d <= tolerance_m);

    let mut free = Ratio::default();
    let mut occupied = Ratio::default();
    let mut recall = Ratio::default();
    let mut coverage = Ratio::default();
    for index in reference.indices() {
        let truth = reference.cell(index).state();
        if truth == CellState::Unknown {
            continue;
        }
        let point_in_estimate = estimate_from_reference * reference.center_of(index);
        let guess = estimate.cell_at(&point_in_estimate).state();
        coverage.count(true, guess != CellState::Unknown);
        let is = |state| (truth == state, guess == state);
        let (a, b) = is(CellState::Free);
        free.count(a || b, a && b);
        let (a, b) = is(CellState::Occupied);
        occupied.count(a || b, a && b);
        recall.count(a, near(to_estimate.distance_at(&point_in_estimate)));
    }
    let mut precision = Ratio::default();
    for index in estimate.indices() {
        let point_in_reference = reference_from_estimate * estimate.center_of(index);
        let is_judged = reference.cell_at(&point_in_reference).state() != CellState::Unknown
            && estimate.cell(index).is_occupied();
        precision.count(
            is_judged,
            near(to_reference.distance_at(&point_in_reference)),
        );
    }
    MapOverlap {
        free_iou: free.value(),
        occupied_iou: occupied.value(),
        occupied_precision: precision.value(),
        occupied_recall: recall.value(),
        coverage: coverage.value(),
    }
}

#[derive(Default)]
struct Ratio {
    n_hit: usize,
    n_all: usize,
}

impl Ratio {
    fn count(&mut self, in_all: bool, in_hit: bool) {
        self.n_all += usize::from(in_all);
        self.n_hit += usize::from(in_all && in_hit);
    }

    fn value(&self) -> f64 {
        if self.n_all == 0 {
            1.0
        } else {
            self.n_hit as f64 / self.n_all as f64
        }
    }
}
