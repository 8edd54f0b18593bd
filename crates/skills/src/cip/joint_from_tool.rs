//! Where an object's joint is, told by the tool that holds its link: no sensor of the object is asked.
//!
//! While the fingers hold, tool and link move as one, so that the tool's own motion since the grasp tells the joint. For
//! a turning joint it is the angle of the tool about the axis; near the axis, where the tool hardly travels, the angle by
//! which the tool itself has turned. A grip that slips is off by as much as it slips.

use factotum_descriptions::{JointKind, ObjectJoint};
use factotum_geometry::Pose;
use nalgebra::{Unit, Vector3};

/// Nearer to the axis than this the tool's own turn is taken, metres.
const ARM_MIN_M: f64 = 0.03;

/// Tells a joint's position from a tool that holds its link.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFromTool {
    joint: ObjectJoint,
    start: f64,
    object_from_start: Pose,
}

impl JointFromTool {
    /// From when the tool has taken hold: its pose in Λ, and the joint's position then.
    pub fn new(joint: ObjectJoint, start: f64, object_from_tcp: Pose) -> Self {
        Self {
            joint,
            start,
            object_from_start: object_from_tcp,
        }
    }

    /// Position of the joint with the tool here in Λ, rad or m.
    pub fn position(&self, object_from_tcp: &Pose) -> f64 {
        let axis = Unit::new_normalize(Vector3::from(self.joint.axis));
        let (before, now) = (
            &self.object_from_start.translation.vector,
            &object_from_tcp.translation.vector,
        );
        let moved = match self.joint.kind {
            JointKind::Prismatic => axis.dot(&(now - before)),
            JointKind::Revolute => {
                let origin = Vector3::from(self.joint.origin);
                let arm = |point: &Vector3<f64>| {
                    let from_origin = point - origin;
                    from_origin - axis.into_inner() * axis.dot(&from_origin)
                };
                let (before, now) = (arm(before), arm(now));
                if before.norm() > ARM_MIN_M {
                    axis.dot(&before.cross(&now)).atan2(before.dot(&now))
                } else {
                    let turn = object_from_tcp.rotation * self.object_from_start.rotation.inverse();
                    axis.dot(&turn.scaled_axis())
                }
            }
        };
        self.start + moved
    }
}

#[cfg(test)]
mod tests {
    use factotum_descriptions::ObjectJoint;
    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;

    fn joint(kind: JointKind) -> ObjectJoint {
        ObjectJoint {
            name: "joint".to_owned(),
            kind,
            axis: [0.6, 0.0, -0.8],
            origin: [0.1, -0.3, 0.2],
            range: [-2.0, 2.0],
            link: "link".to_owned(),
        }
    }

    #[test]
    fn a_tool_that_moves_with_the_joint_tells_where_it_is() {
        let far = Pose::from_parts(
            Translation3::new(0.5, 0.2, 0.1),
            UnitQuaternion::from_euler_angles(0.4, -1.0, 2.0),
        );
        let on_the_axis = Pose::from_parts(
            Translation3::new(0.1 + 0.06, -0.3, 0.2 - 0.08),
            far.rotation,
        );
        for kind in [JointKind::Prismatic, JointKind::Revolute] {
            for grasp in [far, on_the_axis] {
                let joint = joint(kind);
                let told = JointFromTool::new(joint.clone(), 0.3, grasp);
                for position in [-0.9, 0.3, 0.31, 1.7] {
                    let moved = joint.motion(0.3, position) * grasp;
                    assert!(
                        (told.position(&moved) - position).abs() < 1e-9,
                        "{kind:?}: {} for {position}",
                        told.position(&moved)
                    );
                }
            }
        }
    }

    #[test]
    fn what_the_tool_does_beside_the_joint_says_nothing_of_it() {
        let joint = joint(JointKind::Prismatic);
        let told = JointFromTool::new(joint, 0.0, Pose::identity());
        let aside = Pose::from_parts(
            Translation3::new(0.08, 0.5, 0.06),
            UnitQuaternion::from_euler_angles(0.4, -1.0, 2.0),
        );
        assert!(told.position(&aside).abs() < 1e-12);
    }
}
