//! Articulate: move a joint of an object from an initiation to a termination position (thesis 6.2.1, 6.3.1).
//!
//! The action is given in Λ: the tool follows the motion of the link it holds or pushes, as the object's kinematic
//! model τ says, or, where the action has a demonstration, a movement primitive learned from it, with τ giving only the
//! ends. I: a posture exists from which the arm can follow the whole arc. π: the arc under variable impedance, so that
//! errors of Γ and τ become small forces instead of large ones. β: the tool reached the end of the arc, or met more force
//! than the joint takes.

use factotum_control::Robot;
use factotum_descriptions::{ActionSpec, Contact, Demonstration, Grasp, ObjectJoint};
use factotum_geometry::Pose;
use factotum_motion::grasps::expand_grasp;
use nalgebra::Translation3;
use rand_chacha::ChaCha8Rng;

use crate::arm::{ArmMotion, Stop, ToolPathNeeds, tool_line};
use crate::way::{ToolWay, WaySkill, find_tool_way};
use crate::{Failure, ObjectView, Outcome, Situation, SkillError, demonstrated};

/// Angle (rad) or way (m) between poses of the arc.
const ARC_STEP: f64 = 0.05;
/// How far before the contact the approach begins, metres.
const STANDOFF_M: f64 = 0.08;
/// The tool may miss the end of the arc by this much, metres: the joint's own state is looked at afterwards.
const TOLERANCE_M: f64 = 0.05;
/// Turns tried for a grasp that may be turned about the object's z axis.
const N_TURNS: usize = 8;

/// Moves a joint of the situation's object as the action says.
#[derive(Debug, Clone)]
pub struct Articulate {
    /// The action, of the object's class.
    pub action: ActionSpec,
}

/// The motion of the tool with the link that it moves, in the base frame.
#[derive(Debug)]
pub(crate) struct Arc {
    before: Pose,
    poses: Vec<Pose>,
    termination: f64,
    way: ToolWay,
}

impl Articulate {
    fn joint<'a>(&self, situation: &'a Situation) -> Result<&'a ObjectJoint, Failure> {
        let class = &situation.object.class;
        let name = self.action.joint.as_deref().unwrap_or_default();
        class.joint(name).ok_or_else(|| Failure::NotDescribed {
            class: class.name.clone(),
            what: format!("joint `{name}`"),
        })
    }

    fn grasps<'a>(&self, situation: &'a Situation) -> Vec<&'a Grasp> {
        let named = |grasp: &&Grasp| {
            self.action
                .grasp
                .as_ref()
                .is_none_or(|name| *name == grasp.name)
        };
        situation.object.class.grasps.iter().filter(named).collect()
    }

    /// Poses of the tool in the base frame from one to the other, as the demonstration leads it in Λ.
    fn as_shown(
        &self,
        shown: &Demonstration,
        object: &ObjectView,
        base_from_ends: [Pose; 2],
        n_steps: usize,
    ) -> Result<Vec<Pose>, SkillError> {
        let base_from_object = object.base_from_object;
        let [start, goal] = base_from_ends.map(|end| base_from_object.inverse() * end);
        let object_from_tcp =
            demonstrated::path(shown, &start, &goal, n_steps).map_err(|source| {
                SkillError::Demonstration {
                    class: object.class.name.clone(),
                    action: self.action.name.clone(),
                    source,
                }
            })?;
        let in_base = |pose: &Pose| base_from_object * pose;
        Ok(object_from_tcp.iter().map(in_base).collect())
    }

    /// How far the gripper is open on the way: shut to push, open to grasp.
    fn opening(&self) -> f64 {
        match self.action.contact {
            Contact::Push => 0.0,
            Contact::Grasp => 1.0,
        }
    }
}

impl WaySkill for Articulate {
    type Way = Arc;

    fn name(&self) -> &str {
        &self.action.name
    }

    /// The first arc that the arm can follow.
    fn find_way(
        &self,
        situation: &Situation,
        from: &[f64],
        rng: &mut ChaCha8Rng,
    ) -> Result<Arc, Stop> {
        let object = &situation.object;
        let joint = self.joint(situation)?;
        let seeds = [from.to_vec(), situation.robot.q_ready()];
        let from = object
            .joints
            .get(&joint.name)
            .copied()
            .or(self.action.initiation)
            .unwrap_or(0.0);
        let to = self.action.termination.unwrap_or(from);
        let n_steps = ((to - from).abs() / ARC_STEP).ceil().max(1.0) as usize;
        let (mut free, mut near) = situation.scenes(self.opening())?;
        let mut detail = "its class has no grasp".to_owned();
        for grasp in self.grasps(situation) {
            for candidate in expand_grasp(grasp, N_TURNS) {
                let at = |position: f64| {
                    object.base_from_object
                        * joint.motion(0.0, position)
                        * candidate.object_from_tcp
                };
                let before = at(from) * Translation3::new(0.0, 0.0, -STANDOFF_M);
                let poses: Vec<Pose> = match &self.action.demonstration {
                    None => (0..=n_steps)
                        .map(|step| at(from + (to - from) * step as f64 / n_steps as f64))
                        .collect(),
                    Some(shown) => self.as_shown(shown, object, [at(from), at(to)], n_steps)?,
                };
                let all: Vec<Pose> = std::iter::once(before)
                    .chain(poses.iter().copied())
                    .collect();
                match find_tool_way(&mut free, &mut near, &all, &seeds, rng) {
                    Ok(way) => {
                        return Ok(Arc {
                            before,
                            poses,
                            termination: to,
                            way,
                        });
                    }
                    Err(reason) => detail = reason,
                }
            }
        }
        Err(Failure::OutOfReach {
            object: object.name.clone(),
            detail,
        }
        .into())
    }

    fn go(
        &self,
        arc: Arc,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, Stop> {
        let name = &situation.object.name;
        let joint = self.joint(situation)?.name.clone();
        let (mut free, mut near) = situation.scenes(self.opening())?;
        let is_push = self.action.contact == Contact::Push;
        let mut arm = ArmMotion::new(robot, &situation.robot, rng);
        arm.grip(self.opening())?;
        arm.go(&mut free, std::slice::from_ref(&arc.way.start), name)?;
        let q = arm.configuration()?;
        let contact = arc.poses[0];
        let to_contact = tool_line(&mut near, &q, &[contact], name)?;
        arm.follow_near(&to_contact, &format!("approach {name}"))?;
        if !is_push {
            arm.grip(0.0)?;
        }
        let needs = ToolPathNeeds::gentle(TOLERANCE_M);
        let moved = arm.tool(&arc.poses, &needs, &format!("move {joint} of {name}"));
        if !is_push {
            arm.grip(1.0)?;
        }
        // Back off even when the arc failed: a skill ends in free space (thesis 3.4.1).
        let last = arc.poses.last().copied().unwrap_or(arc.before);
        let clear = last * Translation3::new(0.0, 0.0, -STANDOFF_M);
        let gentle = ToolPathNeeds::gentle(STANDOFF_M);
        let backed_off = arm.tool(&[last, clear], &gentle, &format!("back off from {name}"));
        moved?;
        backed_off?;
        Ok(Outcome::Done {
            tcp_from_held: None,
            joints: [(joint, arc.termination)].into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use factotum_descriptions::{ObjectClass, Placement, RobotDescription};
    use factotum_geometry::frames::pose_from_planar;
    use factotum_motion::RobotModel;
    use nalgebra::{Isometry2, Vector2};
    use rand::SeedableRng as _;

    use super::*;

    /// How far aside the way is shown half way, metres.
    const ASIDE_M: f64 = 0.01;

    /// Movo before a light switch, at a distance in a direction (rad) from it.
    fn movo_at_the_switch(distance_m: f64, bearing_rad: f64) -> Situation {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        let robot = RobotDescription::load(&assets.join("robots/movo")).unwrap();
        let class = ObjectClass::load(&assets.join("objects/light_switch")).unwrap();
        let turned = Isometry2::rotation(bearing_rad);
        let object_from_base =
            turned * Isometry2::new(Vector2::new(distance_m, 0.0), std::f64::consts::PI);
        Situation {
            robot: RobotModel::load(&robot).unwrap(),
            obstacles: Vec::new(),
            object: ObjectView {
                name: "light_switch_1".to_owned(),
                class,
                base_from_object: pose_from_planar(&object_from_base.inverse(), 1.1),
                joints: [("toggle".to_owned(), 0.4)].into(),
            },
            target: None,
            held: None,
        }
    }

    /// The tool's way in Λ, if the arm can go it.
    fn way(situation: &Situation, action: &ActionSpec) -> Option<Vec<Pose>> {
        let skill = Articulate {
            action: action.clone(),
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let found = skill.find_way(situation, &situation.robot.q_ready(), &mut rng);
        let object_from_base = situation.object.base_from_object.inverse();
        let poses = found.ok()?.poses;
        Some(poses.iter().map(|pose| object_from_base * pose).collect())
    }

    /// The lever's way at rest at both ends, led aside and back.
    fn demonstration(class: &ObjectClass) -> Demonstration {
        const N_POSES: usize = 40;
        let grasp = class.grasps[0].object_from_tcp();
        let pose = |k: usize| {
            let t = k as f64 / (N_POSES - 1) as f64;
            let share = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
            let mut pose = class.joints[0].motion(0.0, 0.4 - 0.95 * share) * grasp;
            pose.translation.vector.y += ASIDE_M * (std::f64::consts::PI * share).sin().powi(2);
            Placement::from(pose)
        };
        Demonstration {
            step_secs: 0.1,
            object_from_tcp: (0..N_POSES).map(pose).collect(),
        }
    }

    #[test]
    fn the_tool_goes_with_the_joint_or_as_it_was_shown() {
        let class = movo_at_the_switch(0.7, 0.0).object.class;
        let with_joint = class.action("turn_off").unwrap().clone();
        let as_shown = ActionSpec {
            demonstration: Some(demonstration(&class)),
            ..with_joint.clone()
        };
        // The first place from which the arm can do both.
        let (situation, with_joint, as_shown) = [0.65, 0.7, 0.75, 0.8]
            .into_iter()
            .flat_map(|distance| [-0.4, 0.0, 0.4].map(|bearing| (distance, bearing)))
            .find_map(|(distance_m, bearing_rad)| {
                let situation = movo_at_the_switch(distance_m, bearing_rad);
                let with_joint = way(&situation, &with_joint)?;
                let as_shown = way(&situation, &as_shown)?;
                Some((situation, with_joint, as_shown))
            })
            .unwrap();
        // The lever turns about Λ's y axis.
        let aside = |way: &[Pose]| {
            let aside = way.iter().map(|pose| pose.translation.y.abs());
            aside.fold(0.0, f64::max)
        };
        assert!(aside(&with_joint) < 1e-9);
        assert!(
            (aside(&as_shown) - ASIDE_M).abs() < 0.1 * ASIDE_M,
            "{} m aside",
            aside(&as_shown)
        );
        for (a, b) in [
            (with_joint.first(), as_shown.first()),
            (with_joint.last(), as_shown.last()),
        ] {
            let (a, b) = (a.unwrap(), b.unwrap());
            assert!((a.translation.vector - b.translation.vector).norm() < 1e-9);
        }

        let useless = Demonstration {
            step_secs: 0.2,
            object_from_tcp: Vec::new(),
        };
        let skill = Articulate {
            action: ActionSpec {
                demonstration: Some(useless),
                ..class.action("turn_off").unwrap().clone()
            },
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let error = skill
            .find_way(&situation, &situation.robot.q_ready(), &mut rng)
            .unwrap_err();
        assert!(
            matches!(error, Stop::Error(SkillError::Demonstration { .. })),
            "{error:?}"
        );
    }
}
