//! Timed joint paths.

/// One instant of a [`JointTrajectory`].
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryPoint {
    /// Time from the start, seconds.
    pub time_secs: f64,
    /// Joint positions, rad or m, one per joint.
    pub positions: Vec<f64>,
    /// Joint velocities, rad/s or m/s, one per joint.
    pub velocities: Vec<f64>,
}

/// Positions and velocities of named joints over time, cubic between points.
///
/// The same shape as ROS `trajectory_msgs/JointTrajectory`. Times start at 0 and never decrease.
#[derive(Debug, Clone, PartialEq)]
pub struct JointTrajectory {
    joints: Vec<String>,
    points: Vec<TrajectoryPoint>,
}

/// Why points are not a trajectory.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// There are no points.
    #[error("a trajectory needs at least one point, found none")]
    Empty,
    /// A point has the wrong number of values.
    #[error("trajectory point {index} has {found} values, expected {wanted}, one per joint")]
    Width {
        /// Zero-based point.
        index: usize,
        /// Values found.
        found: usize,
        /// Number of joints.
        wanted: usize,
    },
    /// Time goes backwards, or a number is not finite.
    #[error("trajectory point {index} at {time_secs} s: {problem}")]
    Point {
        /// Zero-based point.
        index: usize,
        /// Its time.
        time_secs: f64,
        /// What is wrong.
        problem: &'static str,
    },
}

impl JointTrajectory {
    /// Checks and keeps the points.
    ///
    /// # Errors
    /// [`TrajectoryError`] if there are no points, widths differ, time decreases or a number is not finite.
    pub fn new(joints: Vec<String>, points: Vec<TrajectoryPoint>) -> Result<Self, TrajectoryError> {
        if points.is_empty() {
            return Err(TrajectoryError::Empty);
        }
        let mut time_before = 0.0;
        for (index, point) in points.iter().enumerate() {
            for found in [point.positions.len(), point.velocities.len()] {
                if found != joints.len() {
                    return Err(TrajectoryError::Width {
                        index,
                        found,
                        wanted: joints.len(),
                    });
                }
            }
            let time_secs = point.time_secs;
            let all = point.positions.iter().chain(&point.velocities);
            if !time_secs.is_finite() || all.into_iter().any(|value| !value.is_finite()) {
                return Err(TrajectoryError::Point {
                    index,
                    time_secs,
                    problem: "a number is not finite",
                });
            }
            if time_secs < time_before {
                return Err(TrajectoryError::Point {
                    index,
                    time_secs,
                    problem: "time goes backwards",
                });
            }
            time_before = time_secs;
        }
        Ok(Self { joints, points })
    }

    /// Names of the joints, in the order of the values.
    pub fn joints(&self) -> &[String] {
        &self.joints
    }

    /// The points.
    pub fn points(&self) -> &[TrajectoryPoint] {
        &self.points
    }

    /// Time of the last point, seconds.
    pub fn duration_secs(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.time_secs)
    }

    /// Positions of the last point.
    pub fn end(&self) -> &[f64] {
        self.points
            .last()
            .map_or(&[], |point| point.positions.as_slice())
    }

    /// Positions and velocities at a time, held before the first point and after the last (at rest there).
    pub fn sample(&self, time_secs: f64) -> TrajectoryPoint {
        let held = |point: &TrajectoryPoint| TrajectoryPoint {
            time_secs,
            positions: point.positions.clone(),
            velocities: vec![0.0; point.velocities.len()],
        };
        let after = self
            .points
            .partition_point(|point| point.time_secs <= time_secs);
        let (Some(a), Some(b)) = (
            after.checked_sub(1).map(|before| &self.points[before]),
            self.points.get(after),
        ) else {
            return if after == 0 {
                held(&self.points[0])
            } else {
                held(&self.points[after - 1])
            };
        };
        let (positions, velocities) = (0..self.joints.len())
            .map(|i| {
                hermite(
                    b.time_secs - a.time_secs,
                    time_secs - a.time_secs,
                    [a.positions[i], b.positions[i]],
                    [a.velocities[i], b.velocities[i]],
                )
            })
            .unzip();
        TrajectoryPoint {
            time_secs,
            positions,
            velocities,
        }
    }
}

/// Cubic Hermite interpolation over `[0, duration]`: position and velocity at `time`.
fn hermite(duration: f64, time: f64, position: [f64; 2], velocity: [f64; 2]) -> (f64, f64) {
    let s = time / duration;
    let (s2, s3) = (s * s, s * s * s);
    let value = (2.0 * s3 - 3.0 * s2 + 1.0) * position[0]
        + (s3 - 2.0 * s2 + s) * duration * velocity[0]
        + (3.0 * s2 - 2.0 * s3) * position[1]
        + (s3 - s2) * duration * velocity[1];
    let rate = (6.0 * s2 - 6.0 * s) / duration * (position[0] - position[1])
        + (3.0 * s2 - 4.0 * s + 1.0) * velocity[0]
        + (3.0 * s2 - 2.0 * s) * velocity[1];
    (value, rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(time_secs: f64, position: f64, velocity: f64) -> TrajectoryPoint {
        TrajectoryPoint {
            time_secs,
            positions: vec![position],
            velocities: vec![velocity],
        }
    }

    #[test]
    fn time_must_not_go_backwards() {
        let result = JointTrajectory::new(
            vec!["j".to_owned()],
            vec![
                point(0.0, 0.0, 0.0),
                point(1.0, 0.0, 0.0),
                point(0.5, 0.0, 0.0),
            ],
        );
        assert_eq!(
            result.unwrap_err().to_string(),
            "trajectory point 2 at 0.5 s: time goes backwards"
        );
    }

    #[test]
    fn it_rests_after_its_end() {
        let trajectory = JointTrajectory::new(
            vec!["j".to_owned()],
            vec![point(0.0, 0.0, 1.0), point(1.0, 2.0, 1.0)],
        )
        .unwrap();
        assert_eq!(
            trajectory.sample(5.0),
            TrajectoryPoint {
                time_secs: 5.0,
                positions: vec![2.0],
                velocities: vec![0.0]
            }
        );
    }

    proptest! {
        #[test]
        fn passes_through_its_points_with_their_velocities(p in -2.0..2.0, q in -2.0..2.0, v in -1.0..1.0, w in -1.0..1.0, dt in 0.05..3.0) {
            let trajectory = JointTrajectory::new(vec!["j".to_owned()], vec![point(0.0, p, v), point(dt, q, w), point(2.0 * dt, p, 0.0)]).unwrap();
            let middle = trajectory.sample(dt);
            prop_assert!((middle.positions[0] - q).abs() < 1e-9 && (middle.velocities[0] - w).abs() < 1e-9);
            // velocity is the derivative of position
            let (t, h) = (0.37 * dt, 1e-6);
            let slope = (trajectory.sample(t + h).positions[0] - trajectory.sample(t - h).positions[0]) / (2.0 * h);
            prop_assert!((slope - trajectory.sample(t).velocities[0]).abs() < 1e-4 * (1.0 + slope.abs()) / dt);
        }
    }
}
