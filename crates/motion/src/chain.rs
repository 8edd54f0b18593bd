//! Forward kinematics and Jacobian of the chain as a product of exponentials.
//!
//! Method: Brockett 1984; Lynch & Park, "Modern Robotics" (2017), ch. 4: with the screw axis of each
//! joint at the zero configuration, `base_from_tcp(q) = E_1(q_1) ... E_n(q_n) M`.
//! The screws are read off one Jacobian of the physics engine at the zero configuration, so every model
//! that the engine loads is served, and a query costs well under a microsecond because it visits the
//! joints of the chain only.
//!
//! Frames: everything in the base frame; the Jacobian is 6 x n at the tool point, rows 0..3 linear (m),
//! rows 3..6 angular (rad), both expressed in the base frame.

use nalgebra::{Isometry3, Matrix6xX, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::Pose;

/// How one joint of a chain moves everything after it, at the zero configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Screw {
    /// Turns about an axis through a point.
    Hinge {
        /// Axis, base frame.
        axis: Unit<Vector3<f64>>,
        /// A point on the axis, base frame, metres.
        point: Point3<f64>,
    },
    /// Slides along an axis.
    Slide {
        /// Direction, base frame.
        axis: Unit<Vector3<f64>>,
    },
}

impl Screw {
    /// The screw that gives a tool at `tcp` the linear and angular velocity of one Jacobian column.
    ///
    /// Nothing if the column is zero: the joint does not move the tool.
    pub fn from_column(
        tcp: &Point3<f64>,
        linear: &Vector3<f64>,
        angular: &Vector3<f64>,
    ) -> Option<Self> {
        const ZERO: f64 = 1e-9;
        if let Some(axis) = Unit::try_new(*angular, ZERO) {
            // linear = axis x r with r from the axis to the tool; (axis x r) x axis is r without its part along axis.
            let r = linear.cross(&axis);
            return Some(Self::Hinge {
                axis,
                point: tcp - r,
            });
        }
        Unit::try_new(*linear, ZERO).map(|axis| Self::Slide { axis })
    }

    /// Motion of what follows the joint when it moves from zero to `q`, base frame.
    fn motion(&self, q: f64) -> Pose {
        match self {
            Self::Hinge { axis, point } => {
                let rotation = UnitQuaternion::from_axis_angle(axis, q);
                let shift = point.coords - rotation * point.coords;
                Isometry3::from_parts(Translation3::from(shift), rotation)
            }
            Self::Slide { axis } => Isometry3::translation(axis.x * q, axis.y * q, axis.z * q),
        }
    }
}

/// A serial chain from the base to the tool.
#[derive(Debug, Clone, PartialEq)]
pub struct KinematicChain {
    screws: Vec<Screw>,
    base_from_tcp_at_zero: Pose,
}

impl KinematicChain {
    /// The chain with these screws, base first, and the tool pose at the zero configuration.
    pub fn new(screws: Vec<Screw>, base_from_tcp_at_zero: Pose) -> Self {
        Self {
            screws,
            base_from_tcp_at_zero,
        }
    }

    /// Number of joints.
    pub fn n(&self) -> usize {
        self.screws.len()
    }

    /// The joints at the zero configuration, base first.
    pub fn screws(&self) -> &[Screw] {
        &self.screws
    }

    /// The same chain with a tool that is fixed to the old one.
    pub fn with_tool(&self, tcp_from_tool: &Pose) -> Self {
        Self {
            screws: self.screws.clone(),
            base_from_tcp_at_zero: self.base_from_tcp_at_zero * tcp_from_tool,
        }
    }

    /// Pose of the tool.
    ///
    /// # Panics
    /// When `q` has another length than the chain.
    pub fn base_from_tcp(&self, q: &[f64]) -> Pose {
        assert_eq!(
            q.len(),
            self.n(),
            "configuration and chain differ in length"
        );
        let joints = self.screws.iter().zip(q);
        let mut pose = joints.fold(Pose::identity(), |pose, (screw, &q)| pose * screw.motion(q));
        pose *= self.base_from_tcp_at_zero;
        pose
    }

    /// Pose of the tool, and its Jacobian written to `jacobian`.
    ///
    /// # Panics
    /// When `q` or `jacobian` has another length than the chain.
    pub fn base_from_tcp_and_jacobian_into(
        &self,
        q: &[f64],
        jacobian: &mut Matrix6xX<f64>,
    ) -> Pose {
        assert_eq!(
            q.len(),
            self.n(),
            "configuration and chain differ in length"
        );
        assert_eq!(
            jacobian.ncols(),
            self.n(),
            "Jacobian and chain differ in length"
        );
        let mut pose = Pose::identity();
        // 1. Each joint's axis and point where the joints before it have moved them.
        for (i, (screw, &q)) in self.screws.iter().zip(q).enumerate() {
            let mut column = jacobian.column_mut(i);
            match screw {
                Screw::Hinge { axis, point } => {
                    column
                        .fixed_rows_mut::<3>(3)
                        .copy_from(&(pose.rotation * axis.into_inner()));
                    column
                        .fixed_rows_mut::<3>(0)
                        .copy_from(&(pose * point).coords);
                }
                Screw::Slide { axis } => {
                    column.fixed_rows_mut::<3>(3).fill(0.0);
                    column
                        .fixed_rows_mut::<3>(0)
                        .copy_from(&(pose.rotation * axis.into_inner()));
                }
            }
            pose *= screw.motion(q);
        }
        pose *= self.base_from_tcp_at_zero;
        // 2. The velocity that each hinge gives the tool point.
        let tcp = pose.translation.vector;
        for (i, screw) in self.screws.iter().enumerate() {
            if matches!(screw, Screw::Hinge { .. }) {
                let mut column = jacobian.column_mut(i);
                let axis: Vector3<f64> = column.fixed_rows::<3>(3).into_owned();
                let point: Vector3<f64> = column.fixed_rows::<3>(0).into_owned();
                column
                    .fixed_rows_mut::<3>(0)
                    .copy_from(&axis.cross(&(tcp - point)));
            }
        }
        pose
    }

    /// The tool's Jacobian.
    ///
    /// # Panics
    /// When `q` has another length than the chain.
    pub fn jacobian(&self, q: &[f64]) -> Matrix6xX<f64> {
        let mut jacobian = Matrix6xX::zeros(self.n());
        self.base_from_tcp_and_jacobian_into(q, &mut jacobian);
        jacobian
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::{self, TestArm};
    use proptest::prelude::*;

    /// Central differences of the pose at `q` along joint `i`, as (linear, angular).
    fn numeric_column(chain: &KinematicChain, q: &[f64], i: usize) -> [Vector3<f64>; 2] {
        let h = f64::EPSILON.cbrt();
        let at = |d: f64| {
            let mut q = q.to_vec();
            q[i] += d;
            chain.base_from_tcp(&q)
        };
        let (below, above) = (at(-h), at(h));
        let linear = (above.translation.vector - below.translation.vector) / (2.0 * h);
        let angular = (above.rotation * below.rotation.inverse()).scaled_axis() / (2.0 * h);
        [linear, angular]
    }

    proptest! {
        #[test]
        fn the_jacobian_is_the_derivative(seed in 0u64..1000, which in 0usize..3) {
            let arm = &test_arms::all()[which];
            let q = test_arms::sample(arm, seed);
            let jacobian = arm.chain.jacobian(&q);
            for i in 0..arm.chain.n() {
                let [linear, angular] = numeric_column(&arm.chain, &q, i);
                prop_assert!((jacobian.column(i).fixed_rows::<3>(0) - linear).norm() < 1e-8);
                prop_assert!((jacobian.column(i).fixed_rows::<3>(3) - angular).norm() < 1e-8);
            }
        }

        /// A chain read off a Jacobian is the chain that made it.
        #[test]
        fn screws_are_recovered_from_a_jacobian(seed in 0u64..1000) {
            let TestArm { chain, .. } = test_arms::lift_and_arm();
            let zero = vec![0.0; chain.n()];
            let (pose, jacobian) = (chain.base_from_tcp(&zero), chain.jacobian(&zero));
            let tcp = Point3::from(pose.translation.vector);
            let screws = (0..chain.n())
                .map(|i| {
                    let column = jacobian.column(i);
                    Screw::from_column(&tcp, &column.fixed_rows::<3>(0).into(), &column.fixed_rows::<3>(3).into()).unwrap()
                })
                .collect();
            let again = KinematicChain::new(screws, pose);
            let q = test_arms::sample(&test_arms::lift_and_arm(), seed);
            let error = chain.base_from_tcp(&q).inverse() * again.base_from_tcp(&q);
            prop_assert!(error.translation.vector.norm() < 1e-10 && error.rotation.angle() < 1e-7);
        }
    }

    #[test]
    fn a_joint_that_moves_nothing_has_no_screw() {
        let zero = Vector3::zeros();
        assert_eq!(Screw::from_column(&Point3::origin(), &zero, &zero), None);
    }
}
