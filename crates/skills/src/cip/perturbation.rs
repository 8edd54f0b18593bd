//! What is otherwise than the skill was trained for: to see what a policy stands.

use factotum_geometry::Pose;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Errors of what the robot believes, and changes of the object's joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perturbation {
    /// Factor of the joint's damping.
    pub damping: f64,
    /// Factor of its dry friction.
    pub friction: f64,
    /// Standard deviation of the error of the object's pose, along each axis, metres.
    pub pose_m: f64,
    /// And about each axis through the middle of its grasps, radians.
    pub pose_rad: f64,
    /// Standard deviation of the error of the grasp, along each axis of the tool, metres.
    pub grasp_m: f64,
    /// And about each axis, radians.
    pub grasp_rad: f64,
}

impl Default for Perturbation {
    fn default() -> Self {
        Self {
            damping: 1.0,
            friction: 1.0,
            pose_m: 0.0,
            pose_rad: 0.0,
            grasp_m: 0.0,
            grasp_rad: 0.0,
        }
    }
}

impl Perturbation {
    /// Where the object is, from where it is believed to be; it is turned about `middle`, in Λ, where it is grasped.
    pub fn believed_from_true(&self, middle: Vector3<f64>, rng: &mut ChaCha8Rng) -> Pose {
        let off = error(self.pose_m, self.pose_rad, rng);
        if off == Pose::identity() {
            return off;
        }
        Translation3::from(middle) * off * Translation3::from(-middle)
    }

    /// Where the tool comes to be, from where the grasp should be.
    pub fn grasp_from_tcp(&self, rng: &mut ChaCha8Rng) -> Pose {
        error(self.grasp_m, self.grasp_rad, rng)
    }
}

/// A pose off the identity; no random number is drawn where nothing errs.
fn error(deviation_m: f64, deviation_rad: f64, rng: &mut ChaCha8Rng) -> Pose {
    let mut draw = |deviation: f64| -> Vector3<f64> {
        if deviation > 0.0 {
            Vector3::from_fn(|_, _| deviation * rng.sample::<f64, _>(StandardNormal))
        } else {
            Vector3::zeros()
        }
    };
    let shift = draw(deviation_m);
    let turn = draw(deviation_rad);
    Pose::from_parts(
        Translation3::from(shift),
        UnitQuaternion::from_scaled_axis(turn),
    )
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;

    #[test]
    fn errors_have_the_size_asked_for_and_none_is_none() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let untouched = rng.clone();
        let none = Perturbation::default();
        let middle = Vector3::new(0.5, -0.3, 0.1);
        assert_eq!(none.believed_from_true(middle, &mut rng), Pose::identity());
        assert_eq!(rng, untouched);
        let some = Perturbation {
            pose_m: 0.01,
            grasp_rad: 0.1,
            ..none
        };
        let n = 2000;
        let (mut squares, mut angles) = (0.0, 0.0);
        for _ in 0..n {
            squares += some
                .believed_from_true(middle, &mut rng)
                .translation
                .vector
                .norm_squared();
            angles += some
                .grasp_from_tcp(&mut rng)
                .rotation
                .scaled_axis()
                .norm_squared();
        }
        let deviation = |sum: f64| (sum / f64::from(3 * n)).sqrt();
        assert!((deviation(squares) - 0.01).abs() < 0.0005);
        assert!((deviation(angles) - 0.1).abs() < 0.005);
    }
}
