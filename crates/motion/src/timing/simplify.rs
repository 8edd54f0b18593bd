//! Fewer waypoints for the same path.
//!
//! Method: Douglas & Peucker 1973, between the stops of the path.

/// Leaves out waypoints within `tolerance` of the lines that remain; says which remaining ones are stops.
///
/// Both ends, and waypoints that occur twice in a row (nearer than `same`), are stops.
pub(super) fn simplify(path: &[Vec<f64>], tolerance: f64, same: f64) -> (Vec<Vec<f64>>, Vec<bool>) {
    // 1. Repeated waypoints become one that is a stop.
    let mut distinct: Vec<&Vec<f64>> = Vec::new();
    let mut is_stop: Vec<bool> = Vec::new();
    for q in path {
        match distinct.last() {
            Some(last) if distance(last, q) <= same => {
                if let Some(stop) = is_stop.last_mut() {
                    *stop = true;
                }
            }
            _ => {
                distinct.push(q);
                is_stop.push(false);
            }
        }
    }
    if let [first, .., last] = is_stop.as_mut_slice() {
        *first = true;
        *last = true;
    }
    // 2. Between stops, keep the farthest waypoint from the line until all are near.
    let mut is_kept = is_stop.clone();
    let stops: Vec<usize> = (0..is_stop.len()).filter(|&i| is_stop[i]).collect();
    let mut open: Vec<(usize, usize)> = stops.windows(2).map(|pair| (pair[0], pair[1])).collect();
    while let Some((a, b)) = open.pop() {
        let farthest = (a + 1..b)
            .map(|i| {
                (
                    distance_to_segment(distinct[i], distinct[a], distinct[b]),
                    i,
                )
            })
            .max_by(|x, y| x.0.total_cmp(&y.0));
        if let Some((d, i)) = farthest
            && d > tolerance
        {
            is_kept[i] = true;
            open.push((a, i));
            open.push((i, b));
        }
    }
    let kept: Vec<usize> = (0..distinct.len()).filter(|&i| is_kept[i]).collect();
    (
        kept.iter().map(|&i| distinct[i].clone()).collect(),
        kept.iter().map(|&i| is_stop[i]).collect(),
    )
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b) * (a - b))
        .sum::<f64>()
        .sqrt()
}

/// Distance of a point from the segment between two others.
fn distance_to_segment(p: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let along: f64 = (0..p.len()).map(|i| (p[i] - a[i]) * (b[i] - a[i])).sum();
    let length_squared: f64 = a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum();
    let t = if length_squared > 0.0 {
        (along / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (0..p.len())
        .map(|i| (p[i] - a[i] - t * (b[i] - a[i])).powi(2))
        .sum::<f64>()
        .sqrt()
}
