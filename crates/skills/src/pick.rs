//! Pick: take a movable object into the gripper (thesis 6.2.1, attribute "grasp").
//!
//! I: some grasp of the class can be reached, approached and lifted from. π: open, go before the grasp, approach along
//! the tool's z axis, close, lift. β: the fingers stopped on something and still hold it after the lift.

use factotum_control::{Robot, RobotState};
use factotum_geometry::Pose;
use factotum_motion::PlanningScene;
use factotum_motion::grasps::expand_grasp;
use nalgebra::Translation3;
use rand_chacha::ChaCha8Rng;

use crate::arm::{ArmMotion, Stop, ToolWay, find_tool_way, report, tool_line};
use crate::{Failure, Initiation, Outcome, Situation, Skill, SkillError};

/// How far before the grasp the approach begins, metres.
const STANDOFF_M: f64 = 0.10;
/// How far the object is lifted before the skill ends, metres.
const LIFT_M: f64 = 0.10;
/// Turns tried for a grasp that may be turned about the object's z axis.
const N_TURNS: usize = 16;
/// Enough good grasps to choose from.
const N_WAYS: usize = 3;
/// Opening below which the gripper holds nothing, as a fraction.
const EMPTY_OPENING: f64 = 0.06;

/// Takes the object of the situation into the gripper.
#[derive(Debug, Clone, Default)]
pub struct Pick {
    /// Name of a grasp to leave out, because it failed before.
    pub without: Vec<usize>,
}

struct GraspWay {
    base_from_tcp: Pose,
    approach: ToolWay,
}

impl Pick {
    fn ways(
        &self,
        situation: &Situation,
        seed: &[f64],
        rng: &mut ChaCha8Rng,
    ) -> Result<Result<Vec<GraspWay>, Failure>, SkillError> {
        let object = &situation.object;
        if object.class.grasps.is_empty() {
            return Ok(Err(Failure::NotDescribed {
                class: object.class.name.clone(),
                what: "grasp".to_owned(),
            }));
        }
        let (mut free, mut near) = scenes(situation)?;
        let mut seeds = vec![seed.to_vec(), situation.robot.q_ready()];
        let mut ways: Vec<GraspWay> = Vec::new();
        let mut detail = String::new();
        let candidates = object
            .class
            .grasps
            .iter()
            .flat_map(|grasp| expand_grasp(grasp, N_TURNS));
        for (index, candidate) in candidates.enumerate() {
            if self.without.contains(&index) {
                continue;
            }
            let grasp = candidate.base_from_tcp(&object.base_from_object);
            let before = grasp * Translation3::new(0.0, 0.0, -STANDOFF_M);
            let lifted = Translation3::new(0.0, 0.0, LIFT_M) * grasp;
            match find_tool_way(&mut free, &mut near, &[before, grasp, lifted], &seeds, rng) {
                Ok(approach) => {
                    seeds.push(approach.start.clone());
                    ways.push(GraspWay {
                        base_from_tcp: grasp,
                        approach,
                    });
                }
                Err(reason) => detail = reason,
            }
            if ways.len() == N_WAYS {
                break;
            }
        }
        if ways.is_empty() {
            return Ok(Err(Failure::OutOfReach {
                object: object.name.clone(),
                detail,
            }));
        }
        ways.sort_by(|a, b| {
            b.approach
                .manipulability
                .total_cmp(&a.approach.manipulability)
        });
        Ok(Ok(ways))
    }

    fn attempt(
        &self,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, Stop> {
        let name = &situation.object.name;
        let state = robot.state()?;
        let seed = situation
            .robot
            .q_from_state(state.lift_m, &state.arm_positions);
        let ways = self.ways(situation, &seed, rng)??;
        let (mut free, mut near) = scenes(situation)?;
        let mut arm = ArmMotion::new(robot, &situation.robot, rng);
        arm.grip(1.0, grip_force(situation))?;
        let mut refused = None;
        for way in ways {
            match arm.go(&mut free, std::slice::from_ref(&way.approach.start), name) {
                Ok(()) => {}
                Err(Stop::Failed(failure @ Failure::NoWay { .. })) => {
                    refused = Some(failure);
                    continue;
                }
                Err(stop) => return Err(stop),
            }
            let q = arm.configuration()?;
            let lifted = Translation3::new(0.0, 0.0, LIFT_M) * way.base_from_tcp;
            let to_grasp = tool_line(&mut near, &q, &[way.base_from_tcp], name)?;
            arm.follow_near(&to_grasp, &format!("approach {name}"))?;
            if arm.grip(0.0, grip_force(situation))? < EMPTY_OPENING {
                arm.grip(1.0, grip_force(situation))?;
                return Err(Failure::Missed {
                    object: name.clone(),
                }
                .into());
            }
            let q = arm.configuration()?;
            let up = tool_line(&mut near, &q, &[lifted], name)?;
            arm.follow_near(&up, &format!("lift {name}"))?;
            if arm.state()?.gripper_opening < EMPTY_OPENING {
                return Err(Failure::Slipped {
                    object: name.clone(),
                }
                .into());
            }
            let tcp_from_object = way.base_from_tcp.inverse() * situation.object.base_from_object;
            return Ok(Outcome::Done {
                tcp_from_held: Some(tcp_from_object),
                joints: Default::default(),
            });
        }
        Err(refused
            .unwrap_or_else(|| Failure::NoWay {
                object: name.clone(),
                detail: String::new(),
            })
            .into())
    }
}

impl Skill for Pick {
    fn name(&self) -> &str {
        "pick"
    }

    fn initiation(
        &self,
        situation: &Situation,
        state: &RobotState,
        rng: &mut ChaCha8Rng,
    ) -> Result<Initiation, SkillError> {
        let seed = situation
            .robot
            .q_from_state(state.lift_m, &state.arm_positions);
        Ok(match self.ways(situation, &seed, rng)? {
            Ok(_) => Initiation::Possible,
            Err(failure) => Initiation::Impossible(failure),
        })
    }

    fn run(
        &self,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, SkillError> {
        report(self.attempt(robot, situation, rng))
    }
}

/// The scene in which the object must not be touched, and the one in which the tool may touch it.
pub(crate) fn scenes(situation: &Situation) -> Result<(PlanningScene, PlanningScene), SkillError> {
    let mut obstacles = situation.obstacles.clone();
    obstacles.push(situation.object.as_obstacle());
    let mut free = PlanningScene::new(&situation.robot, &obstacles, None)?;
    free.set_gripper(1.0);
    let mut near = PlanningScene::new(&situation.robot, &obstacles, None)?;
    near.set_gripper(1.0);
    near.allow_contact(&situation.object.name);
    Ok((free, near))
}

pub(crate) fn grip_force(situation: &Situation) -> f64 {
    situation
        .robot
        .description()
        .gripper
        .as_ref()
        .map_or(0.0, |gripper| gripper.force_max_n)
}
