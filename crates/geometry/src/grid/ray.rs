//! Cells that a segment crosses.
//!
//! Method: Amanatides & Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987.
//! Differs: the number of steps is fixed beforehand from the two end cells, so rounding can neither
//! overshoot the end nor loop.

use nalgebra::Point2;

/// A place in a grid's lattice that may lie outside the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SignedCell {
    /// Cells from the origin along x.
    pub column: i64,
    /// Cells from the origin along y.
    pub row: i64,
}

impl SignedCell {
    /// Largest coordinate used; points farther out (or not finite) are pulled in to keep sums exact.
    const COORDINATE_MAX: f64 = 1e9;

    /// The place that holds a point given in units of cells.
    #[must_use]
    pub fn containing(lattice_point: &Point2<f64>) -> Self {
        let coordinate = |v: f64| {
            // A NaN casts to 0, which `clamp` keeps out of: mark it as far outside.
            let v = if v.is_nan() { -Self::COORDINATE_MAX } else { v };
            v.floor().clamp(-Self::COORDINATE_MAX, Self::COORDINATE_MAX) as i64
        };
        Self {
            column: coordinate(lattice_point.x),
            row: coordinate(lattice_point.y),
        }
    }
}

/// The cells a segment crosses, in order, from the cell of `from` to the cell of `to`, both included.
///
/// Points are in units of cells. Successive cells share an edge, so no diagonal gap is skipped.
pub fn cells_on_segment(
    from: &Point2<f64>,
    to: &Point2<f64>,
) -> impl Iterator<Item = SignedCell> + use<> {
    let start = SignedCell::containing(from);
    let end = SignedCell::containing(to);
    let mut x = Axis::new(from.x, to.x, start.column, end.column);
    let mut y = Axis::new(from.y, to.y, start.row, end.row);
    let mut place = start;
    let mut is_first = true;
    std::iter::from_fn(move || {
        if is_first {
            is_first = false;
            return Some(place);
        }
        // The nearer border is crossed first; an axis without steps left never is.
        if x.n_left > 0 && (y.n_left == 0 || x.next_border_t <= y.next_border_t) {
            place.column += x.advance();
        } else if y.n_left > 0 {
            place.row += y.advance();
        } else {
            return None;
        }
        Some(place)
    })
}

/// Progress of the traversal along one axis; `t` runs from 0 to 1 over the segment.
struct Axis {
    step: i64,
    n_left: u64,
    next_border_t: f64,
    t_per_cell: f64,
}

impl Axis {
    fn new(from: f64, to: f64, start: i64, end: i64) -> Self {
        let n_left = start.abs_diff(end);
        if n_left == 0 {
            return Self {
                step: 0,
                n_left,
                next_border_t: f64::INFINITY,
                t_per_cell: 0.0,
            };
        }
        let length = to - from; // not 0: the end cells differ
        let border = if end > start { start + 1 } else { start } as f64;
        Self {
            step: (end - start).signum(),
            n_left,
            next_border_t: (border - from) / length,
            t_per_cell: 1.0 / length.abs(),
        }
    }

    fn advance(&mut self) -> i64 {
        self.n_left -= 1;
        self.next_border_t += self.t_per_cell;
        self.step
    }
}
