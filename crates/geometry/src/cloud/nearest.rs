//! Nearest-neighbour queries over a fixed set of points.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Point3, Vector3};
use std::num::NonZero;

/// A k-d tree over points; indices refer to the slice it was built from.
pub struct NearestPoints {
    tree: Option<ImmutableKdTree<f64, 3>>,
    n_points: usize,
    /// Lowest and highest corner of the box about the points; empty without points.
    bounds: [Point3<f64>; 2],
}

impl std::fmt::Debug for NearestPoints {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NearestPoints")
            .field("n_points", &self.n_points)
            .finish_non_exhaustive()
    }
}

impl NearestPoints {
    /// Builds the tree. Points that are not finite make the result undefined but safe.
    #[must_use]
    pub fn new(points: &[Point3<f64>]) -> Self {
        let entries: Vec<[f64; 3]> = points.iter().map(|p| [p.x, p.y, p.z]).collect();
        let tree = if entries.is_empty() {
            None
        } else {
            ImmutableKdTree::new_from_slice(&entries).ok()
        };
        let nowhere = Point3::from([f64::INFINITY; 3]);
        let bounds = points.iter().fold([nowhere, -nowhere], |[low, high], p| {
            [low.inf(p), high.sup(p)]
        });
        Self {
            n_points: if tree.is_some() { points.len() } else { 0 },
            tree,
            bounds,
        }
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.n_points
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.n_points == 0
    }

    /// Index of the nearest point and the squared distance to it (m²), or nothing when there is no point.
    #[must_use]
    pub fn nearest(&self, point: &Point3<f64>) -> Option<(usize, f64)> {
        let hit = self
            .tree
            .as_ref()?
            .query(&[point.x, point.y, point.z])
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        Some((hit.item as usize, hit.distance))
    }

    /// As [`nearest`](Self::nearest), if it is within `radius_m`; points far from all are told at once.
    #[must_use]
    pub fn nearest_within(&self, point: &Point3<f64>, radius_m: f64) -> Option<(usize, f64)> {
        let [low, high] = &self.bounds;
        let off = (low - point).sup(&(point - high)).sup(&Vector3::zeros());
        let square_m2 = radius_m * radius_m;
        if off.norm_squared() > square_m2 {
            return None;
        }
        self.nearest(point)
            .filter(|(_, distance_m2)| *distance_m2 <= square_m2)
    }

    /// Indices of the `k` nearest points, nearest first; ties by index. Fewer when there are not as many.
    #[must_use]
    pub fn nearest_k(&self, point: &Point3<f64>, k: usize) -> Vec<usize> {
        let (Some(tree), Some(k)) = (self.tree.as_ref(), NonZero::new(k.min(self.n_points))) else {
            return Vec::new();
        };
        let mut hits: Vec<(f64, usize)> = tree
            .query(&[point.x, point.y, point.z])
            .nearest_n::<SquaredEuclidean<f64>>(k)
            .execute()
            .into_iter()
            .map(|hit| (hit.distance, hit.item as usize))
            .collect();
        hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        hits.into_iter().map(|(_, index)| index).collect()
    }

    /// Indices of all points within `radius_m`, in increasing order.
    #[must_use]
    pub fn within(&self, point: &Point3<f64>, radius_m: f64) -> Vec<usize> {
        let Some(tree) = self.tree.as_ref() else {
            return Vec::new();
        };
        let mut hits: Vec<usize> = tree
            .query(&[point.x, point.y, point.z])
            .within::<SquaredEuclidean<f64>>(radius_m * radius_m)
            .execute()
            .into_iter()
            .map(|hit| hit.item as usize)
            .collect();
        hits.sort_unstable();
        hits
    }
}
