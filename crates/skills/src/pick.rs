//! Pick: take a movable object into the gripper (thesis 6.2.1, attribute "grasp").
//!
//! I: some grasp of the class can be reached, approached and lifted from. π: open, go before the grasp, approach along
//! the tool's z axis, close, lift. β: the fingers stopped on something and still hold it after the lift.

use factotum_control::Robot;
use factotum_geometry::Pose;
use factotum_motion::grasps::{expand_grasp, fit_grasp};
use nalgebra::Translation3;
use rand_chacha::ChaCha8Rng;

use crate::arm::{ArmMotion, Stop, is_holding, tool_line};
use crate::way::{ToolWay, WaySkill, find_tool_way};
use crate::{Failure, Outcome, Situation};

/// How far before the grasp the approach begins, metres.
const STANDOFF_M: f64 = 0.10;
/// How far the object is lifted before the skill ends, metres.
const LIFT_M: f64 = 0.10;
/// Turns tried for a grasp that may be turned about the object's z axis.
const N_TURNS: usize = 16;
/// Enough good grasps to choose from.
const N_WAYS: usize = 3;

/// Takes the object of the situation into the gripper.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pick;

/// A grasp, and the way to it.
#[derive(Debug)]
pub(crate) struct GraspWay {
    base_from_tcp: Pose,
    approach: ToolWay,
}

impl WaySkill for Pick {
    /// The best first.
    type Way = Vec<GraspWay>;

    fn name(&self) -> &str {
        "pick"
    }

    fn find_way(
        &self,
        situation: &Situation,
        from: &[f64],
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<GraspWay>, Stop> {
        let object = &situation.object;
        let mut grasps = Vec::new();
        for grasp in &object.class.grasps {
            grasps.extend(fit_grasp(&situation.robot, &object.shape(), grasp)?);
        }
        if grasps.is_empty() {
            return Err(Failure::NotDescribed {
                class: object.class.name.clone(),
                what: "grasp that fits this hand".to_owned(),
            }
            .into());
        }
        let (mut free, mut near) = situation.scenes(1.0)?;
        let mut seeds = vec![from.to_vec(), situation.robot.q_ready()];
        let mut ways: Vec<GraspWay> = Vec::new();
        let mut detail = String::new();
        let candidates = grasps.iter().flat_map(|grasp| expand_grasp(grasp, N_TURNS));
        for candidate in candidates {
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
            return Err(Failure::OutOfReach {
                object: object.name.clone(),
                detail,
            }
            .into());
        }
        ways.sort_by(|a, b| {
            b.approach
                .manipulability
                .total_cmp(&a.approach.manipulability)
        });
        Ok(ways)
    }

    fn go(
        &self,
        ways: Vec<GraspWay>,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, Stop> {
        let name = &situation.object.name;
        let (mut free, mut near) = situation.scenes(1.0)?;
        let mut arm = ArmMotion::new(robot, &situation.robot, rng);
        arm.grip(1.0)?;
        let mut refused = None;
        for way in ways {
            match arm.go(&mut free, std::slice::from_ref(&way.approach.start), name) {
                Ok(_) => {}
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
            if !is_holding(arm.grip(0.0)?) {
                arm.grip(1.0)?;
                return Err(Failure::Missed {
                    object: name.clone(),
                }
                .into());
            }
            let q = arm.configuration()?;
            let up = tool_line(&mut near, &q, &[lifted], name)?;
            arm.follow_near(&up, &format!("lift {name}"))?;
            if !is_holding(arm.state()?.gripper_opening) {
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
