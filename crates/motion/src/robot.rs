//! The robot as planning sees it: its chain, limits, postures and which of its bodies can meet.

mod assembly;
mod check;
mod groups;

use std::collections::BTreeSet;
use std::sync::Arc;

use factotum_descriptions::RobotDescription;
use factotum_physics::{BodyId, JointId, JointKind, Model, State};
use nalgebra::Unit;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::chain::{KinematicChain, Screw};
use crate::error::MotionError;
use crate::joint_space::{JointLimit, JointSpace};

pub(crate) use assembly::add_robot;
pub use assembly::scene_of_robot;
pub use check::{MeetingPair, NamedFrame, PostureCheck, Reach, RobotCheck, check_robot};
pub(crate) use groups::Groups;

/// A robot compiled for planning. Cheap to clone.
#[derive(Debug, Clone)]
pub struct RobotModel {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    description: RobotDescription,
    joints: Vec<String>,
    chain: KinematicChain,
    space: JointSpace,
    always_touching: BTreeSet<(String, String)>,
}

/// Time in which a joint reaches its acceleration limit: jerk limits are not published for most arms.
const ACCELERATION_RISE_SECS: f64 = 0.05;
/// Time in which a lift reaches its speed limit.
const LIFT_RISE_SECS: f64 = 0.5;
/// Configurations sampled to find bodies that always touch.
const N_SELF_COLLISION_SAMPLES: usize = 300;
/// Share of the samples from which two bodies count as always touching: their shapes overlap by construction.
const ALWAYS_SHARE: f64 = 0.95;

impl RobotModel {
    /// Composes the robot's parts and reads its chain, limits and the bodies that always touch.
    ///
    /// # Errors
    /// [`MotionError`] if a model does not load, a name of the description is not in it, or a chain joint is not
    /// a hinge or a limited slide between base and tool.
    pub fn load(description: &RobotDescription) -> Result<Self, MotionError> {
        let model = scene_of_robot(description)?.compile()?;
        let arm = &description.arm;
        let joints: Vec<String> = description
            .lift
            .iter()
            .map(|lift| lift.joint.clone())
            .chain(arm.joints.iter().cloned())
            .collect();
        let ids = joints
            .iter()
            .map(|name| model.joint(name))
            .collect::<Result<Vec<_>, _>>()?;
        let chain = read_chain(&model, &joints, &ids, &arm.tcp_site)?;
        let limits = read_limits(description, &model, &joints, &ids)?;
        let space = JointSpace::new(limits);
        let always_touching = find_always_touching(&model, &ids, &space)?;
        let inner = Inner {
            description: description.clone(),
            joints,
            chain,
            space,
            always_touching,
        };
        Ok(Self {
            inner: Arc::new(inner),
        })
    }

    /// What the robot was loaded from.
    pub fn description(&self) -> &RobotDescription {
        &self.inner.description
    }

    /// Names of the chain's joints: the lift, if any, then the arm.
    pub fn chain_joints(&self) -> &[String] {
        &self.inner.joints
    }

    /// Number of chain joints.
    pub fn n(&self) -> usize {
        self.inner.joints.len()
    }

    /// What each chain joint may do.
    pub fn limits(&self) -> &[JointLimit] {
        self.inner.space.limits()
    }

    /// The space of configurations.
    pub fn space(&self) -> &JointSpace {
        &self.inner.space
    }

    /// Forward kinematics of the chain.
    pub fn chain(&self) -> &KinematicChain {
        &self.inner.chain
    }

    /// The tucked posture for driving.
    pub fn q_rest(&self) -> Vec<f64> {
        self.q_from_state(self.lift_rest_m(), &self.inner.description.arm.rest)
    }

    /// The posture from which manipulation starts, with the lift at its rest height.
    pub fn q_ready(&self) -> Vec<f64> {
        self.q_from_state(self.lift_rest_m(), &self.inner.description.arm.ready)
    }

    /// A configuration from a lift height (ignored without a lift) and arm positions.
    pub fn q_from_state(&self, lift_m: f64, arm: &[f64]) -> Vec<f64> {
        let lift = self.inner.description.lift.as_ref().map(|_| lift_m);
        lift.into_iter().chain(arm.iter().copied()).collect()
    }

    /// Pairs of bodies whose shapes overlap in nearly every configuration; they are not checked.
    pub fn always_touching(&self) -> impl Iterator<Item = (&str, &str)> {
        self.inner
            .always_touching
            .iter()
            .map(|(a, b)| (a.as_str(), b.as_str()))
    }

    pub(crate) fn always_touch(&self, a: &str, b: &str) -> bool {
        let key = if a <= b { (a, b) } else { (b, a) };
        self.inner
            .always_touching
            .contains(&(key.0.to_owned(), key.1.to_owned()))
    }

    fn lift_rest_m(&self) -> f64 {
        self.inner
            .description
            .lift
            .as_ref()
            .map_or(0.0, |lift| lift.rest_m)
    }
}

/// Reads the screws off the model with all joints at zero, base joints included: the world is then the base frame.
fn read_chain(
    model: &Model,
    names: &[String],
    joints: &[JointId],
    tcp_site: &str,
) -> Result<KinematicChain, MotionError> {
    let site = model.site(tcp_site)?;
    let mut state = State::new(model)?;
    for &joint in joints {
        state.set_joint_position(joint, 0.0);
    }
    state.forward_kinematics()?;
    let carriers = bodies_to_root(model, model.site_body(site));
    let mut screws = Vec::with_capacity(joints.len());
    let mut depth_before = usize::MAX;
    for (name, &joint) in names.iter().zip(joints) {
        let kind = model.joint_kind(joint);
        let axis = Unit::try_new(state.joint_axis_in_world(joint), 1e-9);
        let screw = match (kind, axis) {
            (JointKind::Hinge, Some(axis)) => Screw::Hinge {
                axis,
                point: state.joint_anchor_in_world(joint),
            },
            (JointKind::Slide, Some(axis)) => Screw::Slide { axis },
            _ => {
                return Err(MotionError::NotHingeOrSlide {
                    joint: name.clone(),
                    n_dofs: kind.n_v(),
                });
            }
        };
        // `carriers` runs from the tool to the root: joints must come root first.
        let depth = carriers
            .iter()
            .position(|&body| body == model.joint_body(joint));
        let Some(depth) = depth.filter(|&depth| depth <= depth_before) else {
            return Err(MotionError::NotInChain {
                joint: name.clone(),
                tcp_site: tcp_site.to_owned(),
            });
        };
        depth_before = depth;
        screws.push(screw);
    }
    Ok(KinematicChain::new(screws, state.world_from_site(site)))
}

fn bodies_to_root(model: &Model, body: BodyId) -> Vec<BodyId> {
    std::iter::successors(Some(body), |&body| model.body_parent(body)).collect()
}

fn read_limits(
    description: &RobotDescription,
    model: &Model,
    names: &[String],
    joints: &[JointId],
) -> Result<Vec<JointLimit>, MotionError> {
    let arm = &description.arm;
    let lift = description.lift.iter().map(|lift| {
        (
            lift.velocity_max_m_per_s,
            lift.velocity_max_m_per_s / LIFT_RISE_SECS,
        )
    });
    let arm = arm
        .velocity_max_rad_per_s
        .iter()
        .copied()
        .zip(arm.acceleration_max_rad_per_s2.iter().copied());
    let rates = lift.chain(arm);
    names
        .iter()
        .zip(joints)
        .zip(rates)
        .map(|((name, &joint), (velocity, acceleration))| {
            let range = model.joint_range(joint);
            let slide = model.joint_kind(joint) == JointKind::Slide;
            if slide && range.is_none() {
                return Err(MotionError::Value {
                    what: "range of a slide of the chain",
                    found: format!("absent for `{name}`"),
                    wanted: "a range in the model",
                });
            }
            let [lower, upper] = range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let jerk = acceleration / ACCELERATION_RISE_SECS;
            let continuous = range.is_none();
            Ok(JointLimit {
                lower,
                upper,
                velocity,
                acceleration,
                jerk,
                continuous,
                slide,
            })
        })
        .collect()
}

/// Names of body pairs that touch in nearly every of many random configurations.
fn find_always_touching(
    model: &Model,
    joints: &[JointId],
    space: &JointSpace,
) -> Result<BTreeSet<(String, String)>, MotionError> {
    let groups = Groups::of(model, joints)?;
    let mut state = State::new(model)?;
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut q = vec![0.0; joints.len()];
    let mut counts = std::collections::BTreeMap::<(BodyId, BodyId), usize>::new();
    for _ in 0..N_SELF_COLLISION_SAMPLES {
        space.sample_into(&mut rng, &mut q);
        for (&joint, &q) in joints.iter().zip(&q) {
            state.set_joint_position(joint, q);
        }
        state.detect_collisions()?;
        let touching: BTreeSet<(BodyId, BodyId)> = state
            .contacts()
            .filter(|contact| contact.distance_m < 0.0)
            .map(|contact| {
                (
                    model.geom_body(contact.geom_a),
                    model.geom_body(contact.geom_b),
                )
            })
            .filter(|&(a, b)| groups.may_meet(a, b))
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        for pair in touching {
            *counts.entry(pair).or_default() += 1;
        }
    }
    let n_always = (ALWAYS_SHARE * N_SELF_COLLISION_SAMPLES as f64) as usize;
    Ok(counts
        .into_iter()
        .filter(|&(_, n)| n >= n_always)
        .map(|((a, b), _)| {
            let (a, b) = (model.body_name(a).to_owned(), model.body_name(b).to_owned());
            if a <= b { (a, b) } else { (b, a) }
        })
        .collect())
}

#[cfg(test)]
mod real_models;
#[cfg(test)]
mod tests;
