//! Sequential minimal optimisation.

use super::kernel::KernelRows;

/// The optimality gap at which to stop, LIBSVM's and scikit-learn's default.
const GAP: f64 = 1e-3;

/// Stands for a curvature that is not positive (LIBSVM's TAU).
const CURVATURE_MIN: f32 = 1e-12;

/// Steps after which a solution is taken as it is, for each point; LIBSVM's bound is 100 as well.
const N_STEPS_PER_POINT: usize = 100;

/// Values that are compared together, and in how many rounds before the greatest is noted.
const LANES: usize = 8;
const N_ROUNDS: usize = 16;

/// α, and what follows from it.
#[derive(Debug, Clone)]
pub(super) struct Solution {
    pub(super) alpha: Vec<f64>,
    /// y_i − (f(x_i) − b): the objective's negative gradient along y_i α_i.
    residual: Vec<f64>,
    /// b.
    pub(super) offset: f64,
}

impl Solution {
    /// f(x_i) of any point of the kernel matrix, trained on or not.
    pub(super) fn decision(&self, i: usize, signs: &[f64]) -> f64 {
        signs[i] - self.residual[i] + self.offset
    }
}

/// Solves the problem with 0 ≤ α_i ≤ `bounds[i]`, from a solution within these bounds or from 0.
///
/// With points of one class only, α stays 0 and the offset has the sign of that class.
pub(super) fn solve(
    kernel: &KernelRows<'_>,
    signs: &[f64],
    bounds: &[f64],
    from: Option<&Solution>,
) -> Solution {
    let n = kernel.n();
    let (mut alpha, mut residual) = match from {
        Some(from) => (from.alpha.clone(), from.residual.clone()),
        None => (vec![0.0; n], signs.to_vec()),
    };
    let mut room = Room::new(signs, bounds, &alpha);
    let mut gains = Gains::new(n);
    for _ in 0..N_STEPS_PER_POINT * n.max(1000) {
        let Some((i, j)) = gains.working_set(kernel, &room, &residual) else {
            break;
        };
        // y_i α_i goes up and y_j α_j down by the same, until the optimum or a bound.
        let (row_i, row_j) = (kernel.row(i), kernel.row(j));
        let curvature = f64::from(curvature(row_i[j]));
        let (end_i, end_j) = (room.end_up(i), room.end_down(j));
        let (room_i, room_j) = ((end_i - alpha[i]).abs(), (end_j - alpha[j]).abs());
        let step = ((residual[i] - residual[j]) / curvature)
            .min(room_i)
            .min(room_j);
        // What ends at a bound ends there to the bit.
        alpha[i] = if step >= room_i {
            end_i
        } else {
            alpha[i] + signs[i] * step
        };
        alpha[j] = if step >= room_j {
            end_j
        } else {
            alpha[j] - signs[j] * step
        };
        room.update(i, alpha[i]);
        room.update(j, alpha[j]);
        for ((r, &a), &b) in residual.iter_mut().zip(row_i).zip(row_j) {
            *r -= step * f64::from(a - b);
        }
    }
    Solution {
        offset: offset(&room, &residual),
        alpha,
        residual,
    }
}

/// |φ(x_i) − φ(x_j)|² for a kernel that is 1 on the diagonal.
fn curvature(kernel: f32) -> f32 {
    let curvature = 2.0 - 2.0 * kernel;
    if curvature > CURVATURE_MIN {
        curvature
    } else {
        CURVATURE_MIN
    }
}

/// Which way each y_i α_i may still go.
struct Room<'a> {
    signs: &'a [f64],
    bounds: &'a [f64],
    /// 0 where it may go up, else −∞: to be added before a maximum is taken.
    up: Vec<f64>,
    /// 0 where it may go down, else ∞: to be added before a minimum is taken.
    down: Vec<f64>,
}

impl<'a> Room<'a> {
    fn new(signs: &'a [f64], bounds: &'a [f64], alpha: &[f64]) -> Self {
        let mut room = Self {
            signs,
            bounds,
            up: vec![0.0; signs.len()],
            down: vec![0.0; signs.len()],
        };
        for (i, &alpha) in alpha.iter().enumerate() {
            room.update(i, alpha);
        }
        room
    }

    fn update(&mut self, i: usize, alpha: f64) {
        let (grows, shrinks) = (alpha < self.bounds[i], alpha > 0.0);
        let (up, down) = if self.signs[i] > 0.0 {
            (grows, shrinks)
        } else {
            (shrinks, grows)
        };
        self.up[i] = if up { 0.0 } else { f64::NEG_INFINITY };
        self.down[i] = if down { 0.0 } else { f64::INFINITY };
    }

    /// Where α_i ends if y_i α_i goes up as far as it may.
    fn end_up(&self, i: usize) -> f64 {
        if self.signs[i] > 0.0 {
            self.bounds[i]
        } else {
            0.0
        }
    }

    fn end_down(&self, i: usize) -> f64 {
        if self.signs[i] > 0.0 {
            0.0
        } else {
            self.bounds[i]
        }
    }
}

/// Work space for the choice of a pair.
struct Gains {
    up: Vec<f64>,
    down: Vec<f64>,
    gains: Vec<f32>,
}

impl Gains {
    fn new(n: usize) -> Self {
        Self {
            up: vec![0.0; n],
            down: vec![0.0; n],
            gains: vec![0.0; n],
        }
    }

    /// The pair that promises the greatest gain, or none within [`GAP`] of the optimum.
    ///
    /// OPTIMIZATION: loops without branches, so that the compiler does several values at once. The gains only
    /// choose the pair, so single precision will do.
    fn working_set(
        &mut self,
        kernel: &KernelRows<'_>,
        room: &Room<'_>,
        residual: &[f64],
    ) -> Option<(usize, usize)> {
        let masks = room.up.iter().zip(&room.down);
        let values = self.up.iter_mut().zip(self.down.iter_mut());
        for ((r, (up, down)), (high, low)) in residual.iter().zip(masks).zip(values) {
            *high = r + up;
            *low = -(r + down);
        }
        let i = greatest(&self.up, f64::NEG_INFINITY)?;
        let least = -self.down[greatest(&self.down, f64::NEG_INFINITY)?];
        let most = self.up[i];
        if most - least < GAP {
            return None;
        }
        let pairs = self.down.iter().zip(kernel.row(i));
        for (gain, (low, &k)) in self.gains.iter_mut().zip(pairs) {
            let violation = (most + low) as f32;
            let violation = if violation > 0.0 { violation } else { 0.0 };
            *gain = violation * violation / curvature(k);
        }
        Some((i, greatest(&self.gains, 0.0)?))
    }
}

/// The place of the first of the greatest values above `floor`.
fn greatest<T: Copy + PartialOrd>(values: &[T], floor: T) -> Option<usize> {
    let mut best = (floor, None);
    for (block, values) in values.chunks(LANES * N_ROUNDS).enumerate() {
        let mut lanes = [floor; LANES];
        let rounds = values.chunks_exact(LANES);
        for (lane, &value) in lanes.iter_mut().zip(rounds.remainder()) {
            *lane = value;
        }
        for round in rounds {
            for (lane, &value) in lanes.iter_mut().zip(round) {
                *lane = if value > *lane { value } else { *lane };
            }
        }
        for value in lanes {
            if value > best.0 {
                best = (value, Some(block));
            }
        }
    }
    let begin = best.1? * LANES * N_ROUNDS;
    let place = values[begin..].iter().position(|value| *value == best.0)?;
    Some(begin + place)
}

/// b: the mean over free support vectors, or the middle of what the others allow.
fn offset(room: &Room<'_>, residual: &[f64]) -> f64 {
    let is_free = |i: &usize| room.up[*i] == 0.0 && room.down[*i] == 0.0;
    let free: Vec<f64> = (0..residual.len())
        .filter(is_free)
        .map(|i| residual[i])
        .collect();
    if !free.is_empty() {
        return free.iter().sum::<f64>() / free.len() as f64;
    }
    let up = (0..residual.len())
        .filter(|&i| room.up[i] == 0.0)
        .map(|i| residual[i]);
    let down = (0..residual.len())
        .filter(|&i| room.down[i] == 0.0)
        .map(|i| residual[i]);
    match (up.reduce(f64::max), down.reduce(f64::min)) {
        (Some(up), Some(down)) => 0.5 * (up + down),
        (up, down) => up.or(down).unwrap_or(0.0),
    }
}
