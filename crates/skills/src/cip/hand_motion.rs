//! Where the hand goes while the object's joint moves: the tool point with the link, the hand turning along with it, or
//! less than that where what it holds may turn between the fingers.

use factotum_descriptions::{ObjectJoint, TaskSpec};
use factotum_geometry::Pose;

/// How a hand moves with what it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct HandMotion {
    /// The object's joint, in Λ.
    pub joint: ObjectJoint,
    /// Share of the link's turn that the hand takes part in, 0 to 1.
    pub turns: f64,
}

impl HandMotion {
    /// How the hand of a task's robot moves with the joint.
    pub fn of(joint: &ObjectJoint, task: &TaskSpec) -> Self {
        Self {
            joint: joint.clone(),
            turns: task.hand_turns,
        }
    }

    /// The tool pose once the joint has gone `from` one position `to` another, where `held` is that of a tool that is held
    /// fast, for a motion of the link in Λ.
    pub fn tool(&self, [from, to]: [f64; 2], held: impl Fn(&Pose) -> Pose) -> Pose {
        let moved = held(&self.joint.motion(from, to));
        if self.turns >= 1.0 {
            return moved;
        }
        let turned = held(&self.joint.motion(from, from + (to - from) * self.turns));
        Pose::from_parts(moved.translation, turned.rotation)
    }
}

#[cfg(test)]
mod tests {
    use factotum_descriptions::JointKind;

    use super::*;

    #[test]
    fn the_tool_point_goes_with_the_link_and_the_hand_turns_by_its_share() {
        let hinge = ObjectJoint {
            name: "hinge".to_owned(),
            kind: JointKind::Revolute,
            axis: [0.0, 0.0, 1.0],
            origin: [0.2, 0.0, 0.0],
            range: [0.0, 2.0],
            link: "leaf".to_owned(),
        };
        let object_from_tcp = Pose::translation(1.2, 0.0, 1.0);
        let quarter = std::f64::consts::FRAC_PI_2;
        for turns in [0.0, 0.5, 1.0] {
            let motion = HandMotion {
                joint: hinge.clone(),
                turns,
            };
            let moved = motion.tool([0.3, 0.3 + quarter], |moved| moved * object_from_tcp);
            let wanted = nalgebra::Vector3::new(0.2, 1.0, 1.0);
            assert!((moved.translation.vector - wanted).norm() < 1e-12);
            assert!((moved.rotation.angle() - turns * quarter).abs() < 1e-9);
        }
    }
}
