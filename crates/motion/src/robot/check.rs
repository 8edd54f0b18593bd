//! What there is to know of a robot before it is trusted with a home: where its frames are, which of its bodies can
//! meet, whether its postures make sense, and how far it reaches.

use factotum_physics::{PairKind, State, self_collision_pairs};
use rand_chacha::ChaCha8Rng;

use super::{RobotModel, scene_of_robot};
use crate::Pose;
use crate::error::MotionError;
use crate::ik::{IkOptions, IkPreference, solve_ik};
use crate::scene::PlanningScene;

/// Configurations drawn to find bodies that meet.
const N_COLLISION_SAMPLES: usize = 2000;
/// Free configurations whose tool poses are to be reached again.
const N_REACH_SAMPLES: usize = 100;

/// A frame that `robot.toml` names.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedFrame {
    /// What it is for: `tool`, `lidar`, `camera`.
    pub role: &'static str,
    /// Site of the models.
    pub site: String,
    /// Body that carries it.
    pub body: String,
    /// Where it is with the robot in its posture `ready`.
    pub base_from_frame: Pose,
}

/// Two bodies that can meet.
#[derive(Debug, Clone, PartialEq)]
pub struct MeetingPair {
    /// One body.
    pub a: String,
    /// The other.
    pub b: String,
    /// Share of random configurations in which they touch; from 0.95 they are not checked.
    pub share: f64,
}

/// A posture of `robot.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct PostureCheck {
    /// `rest` or `ready`.
    pub name: &'static str,
    /// Why the robot cannot be so, or nothing.
    pub problem: Option<String>,
}

/// Where the tool comes to, over random free configurations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Largest distance from the base's z axis, metres.
    pub distance_max_m: f64,
    /// Lowest and highest place, metres above the base frame's origin.
    pub height_m: [f64; 2],
    /// Share of random configurations without self-collision.
    pub free_share: f64,
    /// Share of their tool poses that inverse kinematics reaches from elsewhere.
    pub ik_share: f64,
}

/// See the [module](self).
#[derive(Debug, Clone, PartialEq)]
pub struct RobotCheck {
    /// Frames, the tool first.
    pub frames: Vec<NamedFrame>,
    /// Bodies that can meet, the most frequent first; neighbours across a joint are left out.
    pub meeting: Vec<MeetingPair>,
    /// The postures `rest` and `ready`.
    pub postures: Vec<PostureCheck>,
    /// Reach of the tool.
    pub reach: Reach,
}

/// Examines a robot by sampling its configurations.
///
/// # Errors
/// [`MotionError`] if a site that the description names is in no model, or physics fails.
pub fn check_robot(robot: &RobotModel, rng: &mut ChaCha8Rng) -> Result<RobotCheck, MotionError> {
    let mut scene = PlanningScene::new(robot, &[], None)?;
    Ok(RobotCheck {
        frames: frames(robot)?,
        meeting: meeting(robot, rng)?,
        postures: vec![
            posture(robot, &mut scene, "rest", &robot.q_rest()),
            posture(robot, &mut scene, "ready", &robot.q_ready()),
        ],
        reach: reach(robot, &mut scene, rng),
    })
}

fn frames(robot: &RobotModel) -> Result<Vec<NamedFrame>, MotionError> {
    let description = robot.description();
    let model = scene_of_robot(description)?.compile()?;
    let mut state = State::new(&model)?;
    for (name, q) in robot.chain_joints().iter().zip(robot.q_ready()) {
        state.set_joint_position(model.joint(name)?, q);
    }
    state.forward_kinematics()?;
    let sensors = &description.sensors;
    let lidar = sensors.lidar.iter().map(|lidar| ("lidar", &lidar.site));
    let camera = sensors.camera.iter().map(|camera| ("camera", &camera.site));
    std::iter::once(("tool", &description.arm.tcp_site))
        .chain(lidar)
        .chain(camera)
        .map(|(role, name)| {
            let site = model.site(name)?;
            Ok(NamedFrame {
                role,
                site: name.clone(),
                body: model.body_name(model.site_body(site)).to_owned(),
                base_from_frame: state.world_from_site(site),
            })
        })
        .collect()
}

fn meeting(robot: &RobotModel, rng: &mut ChaCha8Rng) -> Result<Vec<MeetingPair>, MotionError> {
    let model = scene_of_robot(robot.description())?.compile()?;
    let bodies: Vec<_> = model.bodies().skip(1).collect();
    let joints = robot
        .chain_joints()
        .iter()
        .map(|name| model.joint(name))
        .collect::<Result<Vec<_>, _>>()?;
    let pairs = self_collision_pairs(&model, &bodies, &joints, N_COLLISION_SAMPLES, rng)?;
    let mut meeting: Vec<MeetingPair> = pairs
        .into_iter()
        .filter(|pair| matches!(pair.kind, PairKind::Always | PairKind::Sometimes))
        .map(|pair| MeetingPair {
            a: model.body_name(pair.a).to_owned(),
            b: model.body_name(pair.b).to_owned(),
            share: pair.share,
        })
        .collect();
    meeting.sort_by(|a, b| b.share.total_cmp(&a.share));
    Ok(meeting)
}

fn posture(
    robot: &RobotModel,
    scene: &mut PlanningScene,
    name: &'static str,
    q: &[f64],
) -> PostureCheck {
    let mut joints = robot.chain_joints().iter().zip(robot.limits()).zip(q);
    let outside = joints.find(|((_, limit), q)| !(limit.lower..=limit.upper).contains(*q));
    let problem = match outside {
        Some(((joint, limit), q)) => Some(format!(
            "joint `{joint}` is at {q:.3}, outside its limits {:.3} to {:.3}",
            limit.lower, limit.upper
        )),
        None => scene
            .collision(q)
            .map(|(a, b)| format!("`{a}` touches `{b}`")),
    };
    PostureCheck { name, problem }
}

fn reach(robot: &RobotModel, scene: &mut PlanningScene, rng: &mut ChaCha8Rng) -> Reach {
    let options = IkOptions {
        prefer: IkPreference::First,
        ..IkOptions::default()
    };
    let mut q = vec![0.0; robot.n()];
    let mut free: Vec<Pose> = Vec::new();
    for _ in 0..N_COLLISION_SAMPLES {
        robot.space().sample_into(rng, &mut q);
        if scene.is_free(&q) {
            free.push(robot.chain().base_from_tcp(&q));
        }
    }
    let tried = &free[..free.len().min(N_REACH_SAMPLES)];
    let n_solved = tried
        .iter()
        .filter(|pose| solve_ik(scene, pose, &[], &options, rng).q().is_some())
        .count();
    let places = free.iter().map(|pose| pose.translation.vector);
    let heights = places.clone().map(|place| place.z);
    Reach {
        distance_max_m: places.map(|place| place.xy().norm()).fold(0.0, f64::max),
        height_m: [
            heights.clone().fold(f64::INFINITY, f64::min),
            heights.fold(f64::NEG_INFINITY, f64::max),
        ],
        free_share: free.len() as f64 / N_COLLISION_SAMPLES as f64,
        ik_share: n_solved as f64 / tried.len().max(1) as f64,
    }
}
