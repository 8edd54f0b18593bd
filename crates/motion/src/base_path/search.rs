//! A* over the cells.
//!
//! Eight neighbours; a step costs its length times the mean cost of its two cells, in integers. The octile
//! distance in the open is a consistent estimate of the rest, so each cell is expanded once. The open list is
//! a ring of buckets by total cost (Dial, CACM 12(11), 1969): a step raises the total by a bounded amount.

use super::grid::{BLOCKED, CellIdx, InflatedGrid, UNIT};

/// What came of the search.
#[derive(Debug)]
pub(super) enum CellPath {
    Found(Vec<CellIdx>),
    Unreachable,
    LimitReached,
}

/// √2 is slightly more than 181 / 128, so the cost of a diagonal is never below its estimate.
const DIAGONAL_NUMERATOR: u32 = 181;
const DIAGONAL_SHIFT: u32 = 7;

/// Cost of a step between two neighbours from the costs of their cells.
pub(super) fn step_cost(a: u16, b: u16, is_diagonal: bool) -> u32 {
    let sum = u32::from(a) + u32::from(b);
    if is_diagonal {
        (sum * DIAGONAL_NUMERATOR) >> (DIAGONAL_SHIFT + 1)
    } else {
        sum >> 1
    }
}

/// Searches the cheapest path between two free cells.
pub(super) fn search(
    grid: &InflatedGrid,
    start: CellIdx,
    goal: CellIdx,
    n_expansions_max: usize,
) -> CellPath {
    let costs = grid.costs();
    let neighbours = Neighbours::new(grid.width());
    let estimate = Octile::to(grid, goal);
    // 1. Buffers: cost so far, direction of arrival, and whether a cell is done.
    let mut so_far = vec![u32::MAX; costs.len()];
    let mut arrived_by = vec![0u8; costs.len()];
    let mut is_done = vec![false; costs.len()];
    let cost_max = costs
        .iter()
        .copied()
        .filter(|&cost| cost != BLOCKED)
        .max()
        .unwrap_or(UNIT);
    let step_max = step_cost(cost_max, cost_max, true);
    let mut open = BucketRing::new(2 * step_max as usize + 1);
    so_far[start as usize] = 0;
    open.push(estimate.of(grid, start), start);
    // 2. Expand the cell with the lowest total until it is the goal.
    let mut n_expansions = 0;
    while let Some(cell) = open.pop() {
        let idx = cell as usize;
        if is_done[idx] {
            continue;
        }
        if cell == goal {
            return CellPath::Found(trace(start, goal, &arrived_by, &neighbours));
        }
        if n_expansions >= n_expansions_max {
            return CellPath::LimitReached;
        }
        n_expansions += 1;
        is_done[idx] = true;
        neighbours.for_each_free(costs, cell, |direction, next| {
            let next_idx = next as usize;
            let cost = so_far[idx] + step_cost(costs[idx], costs[next_idx], direction >= 4);
            if cost < so_far[next_idx] {
                so_far[next_idx] = cost;
                arrived_by[next_idx] = direction as u8;
                open.push(cost + estimate.of(grid, next), next);
            }
        });
    }
    CellPath::Unreachable
}

fn trace(
    start: CellIdx,
    goal: CellIdx,
    arrived_by: &[u8],
    neighbours: &Neighbours,
) -> Vec<CellIdx> {
    let mut cells = vec![goal];
    let mut cell = goal;
    while cell != start {
        let direction = usize::from(arrived_by[cell as usize]);
        cell = neighbours.before(direction, cell);
        cells.push(cell);
    }
    cells.reverse();
    cells
}

/// Steps to the eight neighbours: right, up, left, down, then the diagonals between them.
struct Neighbours {
    offsets: [i64; 8],
}

impl Neighbours {
    fn new(width: usize) -> Self {
        let w = width as i64;
        Self {
            offsets: [1, w, -1, -w, w + 1, w - 1, -w - 1, 1 - w],
        }
    }

    /// Calls with each neighbour that may be entered; diagonals only where both sides are free.
    ///
    /// The outermost cells of the grid are never free, so no neighbour is outside it.
    fn for_each_free(&self, costs: &[u16], cell: CellIdx, mut visit: impl FnMut(usize, CellIdx)) {
        let at = |direction: usize| (i64::from(cell) + self.offsets[direction]) as CellIdx;
        let is_free = |cell: CellIdx| costs[cell as usize] != BLOCKED;
        let sides = [0, 1, 2, 3].map(|direction| is_free(at(direction)));
        for (direction, &is_side_free) in sides.iter().enumerate() {
            if is_side_free {
                visit(direction, at(direction));
            }
        }
        for direction in 4..8 {
            let (a, b) = (direction - 4, (direction - 3) % 4);
            if sides[a] && sides[b] && is_free(at(direction)) {
                visit(direction, at(direction));
            }
        }
    }

    fn before(&self, direction: usize, cell: CellIdx) -> CellIdx {
        (i64::from(cell) - self.offsets[direction]) as CellIdx
    }
}

/// Octile distance to a goal in the open.
struct Octile {
    column: u32,
    row: u32,
}

impl Octile {
    fn to(grid: &InflatedGrid, goal: CellIdx) -> Self {
        let (column, row) = grid.column_row(goal);
        Self {
            column: column as u32,
            row: row as u32,
        }
    }

    fn of(&self, grid: &InflatedGrid, cell: CellIdx) -> u32 {
        let width = grid.width() as u32;
        let (dx, dy) = (
            (cell % width).abs_diff(self.column),
            (cell / width).abs_diff(self.row),
        );
        let (long, short) = (dx.max(dy), dx.min(dy));
        (long - short) * step_cost(UNIT, UNIT, false) + short * step_cost(UNIT, UNIT, true)
    }
}

/// Cells by total cost, cheapest first, last in first out within a cost.
struct BucketRing {
    buckets: Vec<Vec<CellIdx>>,
    mask: usize,
    current: usize,
    n: usize,
}

impl BucketRing {
    /// A ring for totals that never exceed the current one by `span` or more.
    fn new(span: usize) -> Self {
        let n_buckets = span.next_power_of_two();
        Self {
            buckets: vec![Vec::new(); n_buckets],
            mask: n_buckets - 1,
            current: 0,
            n: 0,
        }
    }

    fn push(&mut self, total: u32, cell: CellIdx) {
        if self.n == 0 || (total as usize) < self.current {
            self.current = total as usize;
        }
        self.buckets[total as usize & self.mask].push(cell);
        self.n += 1;
    }

    fn pop(&mut self) -> Option<CellIdx> {
        if self.n == 0 {
            return None;
        }
        loop {
            if let Some(cell) = self.buckets[self.current & self.mask].pop() {
                self.n -= 1;
                return Some(cell);
            }
            self.current += 1;
        }
    }
}
