//! Samples: points of a state space in rows, and what repeats among them.
//!
//! Recorded states repeat: a robot stands at the same place again and again, and a variable that an
//! option does not touch keeps its value to the bit. [`Distinct`] keeps each point once with its
//! weight, so that clustering, classifiers and densities work on as many points as there are to see.

use std::cmp::Ordering;

/// Points in rows, one variable a column.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    n_variables: usize,
    values: Vec<f64>,
    n_rows: usize,
}

impl Samples {
    /// No points yet, of so many variables.
    pub fn new(n_variables: usize) -> Self {
        Self {
            n_variables,
            values: Vec::new(),
            n_rows: 0,
        }
    }

    /// The points of an iterator of rows.
    ///
    /// # Panics
    /// If a row has another length.
    pub fn from_rows<R: AsRef<[f64]>>(
        n_variables: usize,
        rows: impl IntoIterator<Item = R>,
    ) -> Self {
        let mut samples = Self::new(n_variables);
        for row in rows {
            samples.push(row.as_ref());
        }
        samples
    }

    /// Adds a point.
    ///
    /// # Panics
    /// If the row has another length.
    pub fn push(&mut self, row: &[f64]) {
        assert_eq!(row.len(), self.n_variables, "values in a row");
        self.values.extend_from_slice(row);
        self.n_rows += 1;
    }

    /// How many points.
    pub fn len(&self) -> usize {
        self.n_rows
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.n_rows == 0
    }

    /// How many variables a point has.
    pub fn n_variables(&self) -> usize {
        self.n_variables
    }

    /// A point.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.n_variables..(i + 1) * self.n_variables]
    }

    /// The points in order.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        (0..self.n_rows).map(|i| self.row(i))
    }

    /// The chosen points.
    pub fn select(&self, rows: &[usize]) -> Self {
        Self::from_rows(self.n_variables, rows.iter().map(|&i| self.row(i)))
    }

    /// The chosen variables of all points.
    pub fn project(&self, variables: &[usize]) -> Self {
        self.project_rows(0..self.n_rows, variables)
    }

    /// The chosen variables of the chosen points.
    pub fn project_rows(&self, rows: impl IntoIterator<Item = usize>, variables: &[usize]) -> Self {
        let mut out = Self::new(variables.len());
        for i in rows {
            let row = self.row(i);
            out.values.extend(variables.iter().map(|&v| row[v]));
            out.n_rows += 1;
        }
        out
    }

    /// The standard deviation of each variable; 1 for one that does not vary.
    pub fn spreads(&self) -> Vec<f64> {
        let n = self.len().max(1) as f64;
        let spread = |m: usize| {
            let mean = self.rows().map(|row| row[m]).sum::<f64>() / n;
            let squares = self.rows().map(|row| (row[m] - mean).powi(2));
            let variance = squares.sum::<f64>() / n;
            if variance > 0.0 { variance.sqrt() } else { 1.0 }
        };
        (0..self.n_variables).map(spread).collect()
    }

    /// The least and greatest value of each variable; `None` without points.
    pub fn bounds(&self) -> Option<Bounds> {
        let first = self.rows().next()?;
        let mut bounds = Bounds {
            min: first.to_vec(),
            max: first.to_vec(),
        };
        for row in self.rows() {
            bounds.include(row);
        }
        Some(bounds)
    }
}

/// A box along the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// The least value of each variable.
    pub min: Vec<f64>,
    /// The greatest value of each variable.
    pub max: Vec<f64>,
}

impl Bounds {
    /// Grows the box to hold a point.
    pub fn include(&mut self, point: &[f64]) {
        for ((min, max), &x) in self.min.iter_mut().zip(&mut self.max).zip(point) {
            *min = min.min(x);
            *max = max.max(x);
        }
    }

    /// The squared distance between the boxes; 0 where they meet.
    pub fn distance_squared(&self, other: &Self) -> f64 {
        let gaps = (self.min.iter().zip(&self.max)).zip(other.min.iter().zip(&other.max));
        gaps.map(|((a_min, a_max), (b_min, b_max))| {
            (a_min - b_max).max(b_min - a_max).max(0.0).powi(2)
        })
        .sum()
    }
}

/// The squared Euclidean distance, or some number above `limit` where it is above it.
pub(crate) fn distance_squared_up_to(a: &[f64], b: &[f64], limit: f64) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.chunks(8).zip(b.chunks(8)) {
        sum += a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        if sum > limit {
            break;
        }
    }
    sum
}

/// Each point once, with how often it came.
#[derive(Debug, Clone, PartialEq)]
pub struct Distinct {
    /// The points, in lexicographic order.
    pub points: Samples,
    /// How often each came.
    pub weights: Vec<f64>,
    /// The point of each row that went in.
    pub point_of_row: Vec<usize>,
}

impl Distinct {
    /// Collapses what is equal to the bit.
    pub fn of(samples: &Samples) -> Self {
        let mut order: Vec<usize> = (0..samples.len()).collect();
        order.sort_unstable_by(|&a, &b| {
            lexicographic(samples.row(a), samples.row(b)).then(a.cmp(&b))
        });
        let mut points = Samples::new(samples.n_variables());
        let mut weights: Vec<f64> = Vec::new();
        let mut point_of_row = vec![0; samples.len()];
        let mut before: Option<usize> = None;
        for row in order {
            let repeats =
                before.is_some_and(|b| lexicographic(samples.row(b), samples.row(row)).is_eq());
            match weights.last_mut() {
                Some(weight) if repeats => *weight += 1.0,
                _ => {
                    points.push(samples.row(row));
                    weights.push(1.0);
                }
            }
            point_of_row[row] = points.len() - 1;
            before = Some(row);
        }
        Self {
            points,
            weights,
            point_of_row,
        }
    }

    /// How many rows went in.
    pub fn n_rows(&self) -> usize {
        self.point_of_row.len()
    }
}

fn lexicographic(a: &[f64], b: &[f64]) -> Ordering {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.total_cmp(b))
        .find(|order| order.is_ne())
        .unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Nothing is lost: each row finds its point again, and the weights count the rows.
        #[test]
        fn distinct_points_stand_for_all_rows(rows in prop::collection::vec([0_i8..3, 0..3], 0..40)) {
            let rows: Vec<_> = rows.iter().map(|r| r.map(f64::from)).collect();
            let samples = Samples::from_rows(2, &rows);
            let distinct = Distinct::of(&samples);
            prop_assert_eq!(distinct.weights.iter().sum::<f64>(), rows.len() as f64);
            for (i, row) in rows.iter().enumerate() {
                prop_assert_eq!(distinct.points.row(distinct.point_of_row[i]), row);
            }
            let ascending = (1..distinct.points.len())
                .all(|i| lexicographic(distinct.points.row(i - 1), distinct.points.row(i)).is_lt());
            prop_assert!(ascending);
        }
    }

    #[test]
    fn a_projection_keeps_the_chosen_variables_in_their_order() {
        let samples = Samples::from_rows(3, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        assert_eq!(
            samples.project(&[2, 0]),
            Samples::from_rows(2, [[3.0, 1.0], [6.0, 4.0]])
        );
        assert_eq!(samples.project(&[]).len(), 2);
        assert_eq!(samples.select(&[1]).row(0), [4.0, 5.0, 6.0]);
    }

    #[test]
    fn boxes_know_how_far_apart_they_are() {
        let bounds = |rows: &[[f64; 2]]| Samples::from_rows(2, rows).bounds().unwrap();
        let a = bounds(&[[0.0, 0.0], [1.0, 1.0]]);
        assert_eq!(a.distance_squared(&bounds(&[[4.0, 5.0]])), 25.0);
        assert_eq!(a.distance_squared(&bounds(&[[0.5, 3.0], [0.5, 0.5]])), 0.0);
        assert!(Samples::new(2).bounds().is_none());
    }
}
