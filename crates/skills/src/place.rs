//! Place: release the held object at a pose in another object's frame (thesis 6.3.1, "throw away").
//!
//! I: the gripper holds the object, and some turn of the release pose can be reached. π: go there, open, back off along
//! the tool's z axis. β: the fingers are open and the tool is clear.

use factotum_control::Robot;
use factotum_geometry::Pose;
use factotum_motion::PlanningScene;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::arm::{ArmMotion, Stop, tool_line};
use crate::way::{ToolWay, WaySkill, find_tool_way};
use crate::{Failure, Outcome, Situation, SkillError};

/// Turns of the object about the target's z axis that are tried.
const N_TURNS: usize = 12;
/// Extra heights tried above the taught one: dropping from a little higher is better than not at all, metres.
const EXTRA_HEIGHTS_M: [f64; 3] = [0.0, 0.06, 0.12];
/// Enough ways to choose from: to one posture the way may be barred and to another not.
const N_WAYS: usize = 4;
/// How far the tool backs off after the release, metres.
const BACK_OFF_M: f64 = 0.08;

/// Releases what the gripper holds at `target_from_object`, a pose in the frame of the situation's target.
#[derive(Debug, Clone)]
pub struct Place {
    /// Λ of the held object in Λ of the target at release; its turn about the target's z axis is free.
    pub target_from_object: Pose,
}

impl Place {
    fn release_poses(&self, situation: &Situation) -> Result<Vec<Pose>, Failure> {
        let (Some(target), Some(held)) = (&situation.target, &situation.held) else {
            return Err(Failure::NotDescribed {
                class: situation.object.class.name.clone(),
                what: "target, or nothing is held".to_owned(),
            });
        };
        let mut poses = Vec::with_capacity(N_TURNS * EXTRA_HEIGHTS_M.len());
        for extra_m in EXTRA_HEIGHTS_M {
            for turn in 0..N_TURNS {
                let yaw = std::f64::consts::TAU * turn as f64 / N_TURNS as f64;
                let spin = Isometry3::from_parts(
                    Translation3::new(0.0, 0.0, extra_m),
                    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw),
                );
                let at = Isometry3::from_parts(
                    self.target_from_object.translation,
                    spin.rotation * self.target_from_object.rotation,
                );
                let raised = Translation3::new(0.0, 0.0, extra_m) * at;
                poses.push(target.base_from_object * raised * held.tcp_from_object.inverse());
            }
        }
        Ok(poses)
    }

    fn scene(situation: &Situation) -> Result<PlanningScene, SkillError> {
        let mut obstacles = situation.obstacles.clone();
        obstacles.extend(situation.target.iter().map(crate::ObjectView::as_obstacle));
        let held = situation.held.as_ref().map(crate::HeldView::as_held);
        Ok(PlanningScene::new(
            &situation.robot,
            &obstacles,
            held.as_ref(),
        )?)
    }
}

impl WaySkill for Place {
    /// Ways, each with the pose of release at its end.
    type Way = Vec<(ToolWay, Pose)>;

    fn name(&self) -> &str {
        "place"
    }

    fn find_way(
        &self,
        situation: &Situation,
        from: &[f64],
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<(ToolWay, Pose)>, Stop> {
        let poses = self.release_poses(situation)?;
        let mut scene = Self::scene(situation)?;
        let mut again = Self::scene(situation)?;
        let seeds = [from.to_vec(), situation.robot.q_ready()];
        let mut detail = String::new();
        let mut ways = Vec::new();
        for pose in poses {
            match find_tool_way(&mut scene, &mut again, &[pose], &seeds, rng) {
                Ok(way) => ways.push((way, pose)),
                Err(reason) => detail = reason,
            }
            if ways.len() == N_WAYS {
                break;
            }
        }
        if !ways.is_empty() {
            return Ok(ways);
        }
        let object = situation
            .target
            .as_ref()
            .map_or_else(String::new, |target| target.name.clone());
        Err(Failure::OutOfReach { object, detail }.into())
    }

    fn go(
        &self,
        ways: Vec<(ToolWay, Pose)>,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, Stop> {
        let target = situation
            .target
            .as_ref()
            .map_or("the target", |target| target.name.as_str());
        let mut scene = Self::scene(situation)?;
        let mut arm = ArmMotion::new(robot, &situation.robot, rng);
        let starts: Vec<Vec<f64>> = ways.iter().map(|(way, _)| way.start.clone()).collect();
        let (_, pose) = ways[arm.go(&mut scene, &starts, target)?];
        arm.grip(1.0)?;
        let mut empty = PlanningScene::new(&situation.robot, &situation.obstacles, None)?;
        empty.set_gripper(1.0);
        let q = arm.configuration()?;
        let back = pose * Translation3::new(0.0, 0.0, -BACK_OFF_M);
        let up = Translation3::new(0.0, 0.0, BACK_OFF_M) * pose;
        for retreat in [back, up] {
            if let Ok(path) = tool_line(&mut empty, &q, &[retreat], target) {
                arm.follow_near(&path, "back off")?;
                break;
            }
        }
        Ok(Outcome::Done {
            tcp_from_held: None,
            joints: Default::default(),
        })
    }
}
