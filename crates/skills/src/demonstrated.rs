//! The tool's way in Λ as it was shown once, led from other starts to other goals by movement primitives (thesis 6.3.1).

use factotum_descriptions::Demonstration;
use factotum_geometry::Pose;
use factotum_learning::dmp::{DmpError, DmpParams, OrientationDmp, PositionDmp};
use nalgebra::{DVector, Translation3, UnitQuaternion};

/// Poses of the tool in Λ from `start` to `goal`, in the shape of the demonstration, at `n_steps` equal steps of its time.
pub(crate) fn path(
    shown: &Demonstration,
    start: &Pose,
    goal: &Pose,
    n_steps: usize,
) -> Result<Vec<Pose>, DmpError> {
    let poses: Vec<Pose> = shown
        .object_from_tcp
        .iter()
        .map(|pose| (*pose).into())
        .collect();
    let params = DmpParams::default();
    let params = DmpParams {
        // Each kernel needs a sample.
        n_kernels: params.n_kernels.min(poses.len()),
        ..params
    };
    let positions: Vec<DVector<f64>> = poses.iter().map(position_of).collect();
    let rotations: Vec<UnitQuaternion<f64>> = poses.iter().map(|pose| pose.rotation).collect();
    let positions = PositionDmp::learn(&positions, shown.step_secs, &params)?;
    let rotations = OrientationDmp::learn(&rotations, shown.step_secs, &params)?;

    let mut motion = positions.demonstrated();
    motion.start = position_of(start);
    motion.goal = position_of(goal);
    let mut moving = positions.run(&motion)?;
    let mut motion = rotations.demonstrated().clone();
    motion.start = start.rotation;
    motion.goal = goal.rotation;
    let mut turning = rotations.run(&motion)?;

    let n_steps = n_steps.max(1);
    let step_secs = motion.duration_s / n_steps as f64;
    let mut path = vec![*start];
    for _ in 1..n_steps {
        let position = &moving.advance(step_secs)?.position;
        let translation = Translation3::new(position[0], position[1], position[2]);
        let rotation = turning.advance(step_secs)?.rotation;
        path.push(Pose::from_parts(translation, rotation));
    }
    // Where the springs have all but arrived.
    path.push(*goal);
    Ok(path)
}

fn position_of(pose: &Pose) -> DVector<f64> {
    DVector::from_column_slice(pose.translation.vector.as_slice())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use factotum_descriptions::Placement;

    use super::*;

    const N_POSES: usize = 40;

    fn circle(angle: f64) -> Pose {
        let turned = UnitQuaternion::from_euler_angles(0.0, 0.0, angle);
        Pose::from_parts(Translation3::identity(), turned) * Translation3::new(0.5, 0.0, 0.2)
    }

    /// A quarter of a circle, at rest at both ends, with a bump upwards half way.
    fn shown(k: usize) -> Pose {
        let t = k as f64 / (N_POSES - 1) as f64;
        let share = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
        let mut pose = circle(FRAC_PI_2 * share);
        pose.translation.vector.z += 0.02 * (1.0 - (TAU * t).cos());
        pose
    }

    fn demonstration() -> Demonstration {
        Demonstration {
            step_secs: 0.1,
            object_from_tcp: (0..N_POSES).map(|k| shown(k).into()).collect(),
        }
    }

    #[test]
    fn between_its_own_ends_it_is_as_shown() {
        let n = N_POSES - 1;
        let path = path(&demonstration(), &shown(0), &shown(n), n).unwrap();
        assert_eq!(path.len(), N_POSES);
        for (k, pose) in path.iter().enumerate() {
            let off = (pose.translation.vector - shown(k).translation.vector).norm();
            assert!(off < 0.015, "step {k}: {off} m off");
            let off = pose.rotation.angle_to(&shown(k).rotation);
            assert!(off < 0.04, "step {k}: {off} rad off");
        }
    }

    #[test]
    fn to_other_ends_it_keeps_the_bump() {
        let (start, goal) = (circle(0.2), circle(1.3));
        let path = path(&demonstration(), &start, &goal, 30).unwrap();
        assert_eq!((path[0], path[30]), (start, goal));
        let highest = path
            .iter()
            .map(|pose| pose.translation.z)
            .fold(0.0, f64::max);
        assert!((0.23..0.25).contains(&highest), "{highest} m");
        for (a, b) in path.iter().zip(&path[1..]) {
            let way = (b.translation.vector - a.translation.vector).norm();
            assert!(way < 0.08, "a jump of {way} m");
        }
    }

    #[test]
    fn too_few_poses_are_an_error() {
        let few = Demonstration {
            step_secs: 0.1,
            object_from_tcp: vec![Placement::default(); 2],
        };
        let error = path(&few, &Pose::identity(), &Pose::identity(), 10).unwrap_err();
        assert!(matches!(error, DmpError::TooFewSamples { found: 2, .. }));
    }
}
