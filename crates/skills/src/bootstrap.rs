//! A robot's own demonstrations: motion plans from kinematics alone (thesis Chapter 4, Algorithm 2).
//!
//! ```text
//! T_O    = MotionPlanner(C_O, q_O*)            the object's way, in its own configuration space
//! g      = EstimateGrasp(C_O, f_O)             where the tool touches it
//! eepath = GraspPath(T_O, C_O, f_O, g)         the tool's way with the object
//! T_R    = MotionPlanner(C_R, eepath, f_R⁻¹)   the arm's way: to the object through free space, then along eepath
//! ```
//!
//! An object has one joint, so that its way is the line from start to goal. g comes with the task, as the pose of the
//! handle does in the thesis. Of many postures at g the one is taken from which the arm follows the object's way
//! farthest; where it cannot follow to the end, as with a door that shuts out of its reach, the part that it can is the
//! demonstration. The object's kinematics are what the robot believes ([`KinematicError`]); nothing here knows of mass,
//! friction or speed.

use factotum_descriptions::ObjectJoint;
use factotum_geometry::Pose;
use factotum_motion::{
    IkOptions, MotionError, PlanLimits, PlanningScene, TimingOptions, ToolLineOptions, plan_joints,
    plan_tool_line, solve_ik_many, time_path_with,
};
use nalgebra::{DVector, Translation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use thiserror::Error;

use crate::arm::{in_words, solved};

/// How far before the contact the tool comes to, metres.
const STANDOFF_M: f64 = 0.08;

/// Postures at the contact that are compared.
const N_POSTURES: usize = 24;

/// Tool poses along the object's way.
const N_POSES: usize = 40;

/// Postures are told apart by how far the arm can follow from them to within one part in this many.
const FRACTION_STEPS: f64 = 20.0;

/// Waypoints nearer than this to the line through their neighbours are left out, rad: the close ones that follow the
/// object to the millimetre would each slow the arm down.
const SIMPLIFY_RAD: f64 = 0.01;

/// Less of the object's way than this is no demonstration.
const FRACTION_MIN: f64 = 0.02;

/// Why there is no demonstration.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BootstrapError {
    /// A model or path that cannot be used.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// No posture at the contact leads anywhere.
    #[error(
        "the tool cannot be brought to the object at ({x_m:.3}, {y_m:.3}, {z_m:.3}) m in the base frame so that it can move \
         it ({n_postures} postures; {detail}); move `placement` nearer, or check `motor.contact`"
    )]
    NoContact {
        /// Where the tool should touch.
        x_m: f64,
        /// Where the tool should touch.
        y_m: f64,
        /// Where the tool should touch.
        z_m: f64,
        /// Postures that reach it.
        n_postures: usize,
        /// What stood against the best.
        detail: String,
    },
    /// No way through free space to the contact.
    #[error("no free way for the arm to the object ({detail})")]
    NoWay {
        /// How the search ended.
        detail: String,
    },
}

/// By how much the believed kinematics of an object are off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KinematicError {
    /// Standard deviation of the origin of its joint, and of where the object stands, along each axis, metres.
    pub position_m: f64,
    /// Standard deviation of the direction of its joint's axis about each axis, rad.
    pub axis_rad: f64,
    /// Standard deviation of the way from start to goal, as a share of it.
    pub range: f64,
}

/// What is believed of the object that is to be moved.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectKinematics {
    /// Pose of Λ in the base frame.
    pub base_from_object: Pose,
    /// Its joint.
    pub joint: ObjectJoint,
    /// Where the joint is, rad or m.
    pub start: f64,
    /// Where it should be.
    pub goal: f64,
    /// Where the tool touches: its pose in Λ, with the joint at `start`.
    pub object_from_contact: Pose,
}

impl ObjectKinematics {
    /// The same, as one who errs believes it.
    #[must_use]
    pub fn mistaken(&self, error: &KinematicError, rng: &mut ChaCha8Rng) -> Self {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let mut three = |std: f64| Vector3::new(normal(), normal(), normal()) * std;
        let shift = Translation3::from(three(error.position_m));
        let origin = Vector3::from(self.joint.origin) + three(error.position_m);
        let turn = UnitQuaternion::from_scaled_axis(three(error.axis_rad));
        let longer = 1.0 + error.range * normal();
        Self {
            base_from_object: shift * self.base_from_object,
            joint: ObjectJoint {
                origin: origin.into(),
                axis: (turn * Vector3::from(self.joint.axis)).into(),
                ..self.joint.clone()
            },
            goal: self.start + (self.goal - self.start) * longer,
            ..self.clone()
        }
    }

    /// Where the joint is while the tool goes along `places` and moves it from the one numbered `from` on.
    fn along(&self, tool_way: &[Pose], places: &[Pose], from: usize) -> Vec<f64> {
        let mut at = 0;
        let mut joint = Vec::with_capacity(places.len());
        for (k, place) in places.iter().enumerate() {
            let off = |i: usize| {
                tool_way.get(i).map_or(f64::INFINITY, |pose| {
                    (pose.translation.vector - place.translation.vector).norm()
                })
            };
            while k >= from && off(at + 1) <= off(at) && at + 1 < tool_way.len() {
                at += 1;
            }
            let share = at as f64 / (N_POSES - 1) as f64;
            joint.push(self.start + (self.goal - self.start) * share);
        }
        joint
    }

    /// The tool's poses along the object's way, the contact first; in the base frame.
    fn tool_way(&self) -> Vec<Pose> {
        (0..N_POSES)
            .map(|i| {
                let share = i as f64 / (N_POSES - 1) as f64;
                let to = self.start + (self.goal - self.start) * share;
                let moved = self.joint.motion(self.start, to);
                self.base_from_object * moved * self.object_from_contact
            })
            .collect()
    }
}

/// A motion of the arm, and what the object does meanwhile.
#[derive(Debug, Clone, PartialEq)]
pub struct JointDemo {
    /// Configurations of the chain at equal steps of time.
    pub positions: Vec<DVector<f64>>,
    /// Where the object's joint is then, rad or m.
    pub object: Vec<f64>,
    /// The step, seconds.
    pub step_secs: f64,
}

/// What the robot shows itself.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedDemo {
    /// The motion; of the object what is believed of it.
    pub motion: JointDemo,
    /// How much of the object's way the arm can follow, 0 to 1.
    pub fraction: f64,
    /// What ended it, if not the goal.
    pub stopped_by: Option<String>,
}

/// Plans a demonstration (Algorithm 2) from where the arm is. `free` is the scene in which nothing may be touched,
/// `near` the one in which the tool may touch the object; the plan is timed with a fraction of the joints' speed limits.
///
/// # Errors
/// [`BootstrapError`] where the arm cannot come to the object at all.
pub fn initial_demo(
    free: &mut PlanningScene,
    near: &mut PlanningScene,
    q_start: &[f64],
    object: &ObjectKinematics,
    speed: f64,
    step_secs: f64,
    rng: &mut ChaCha8Rng,
) -> Result<PlannedDemo, BootstrapError> {
    let tool_way = object.tool_way();
    let contact = Contact::best(free, near, q_start, &tool_way, rng)?;
    let goals = std::slice::from_ref(&contact.before);
    let outcome = plan_joints(free, q_start, goals, &PlanLimits::default(), rng);
    let to_contact = solved(outcome).map_err(|detail| BootstrapError::NoWay { detail })?;
    let touch = contact.way.first().cloned().unwrap_or_default();
    let mut path = to_contact.path;
    path.extend(contact.approach.iter().skip(1).cloned());
    path.extend(contact.way.iter().skip(1).cloned());
    let robot = free.robot().clone();
    let timing = TimingOptions {
        speed_scale: speed,
        simplify_rad: SIMPLIFY_RAD,
        ..TimingOptions::default()
    };
    let trajectory = time_path_with(&robot, &path, &timing)?;
    let n_steps = (trajectory.duration_secs() / step_secs).ceil().max(3.0);
    let step = trajectory.duration_secs() / n_steps;
    let positions: Vec<DVector<f64>> = (0..=n_steps as usize)
        .map(|k| DVector::from_vec(trajectory.sample(k as f64 * step).positions))
        .collect();
    let places = positions
        .iter()
        .map(|q| robot.chain().base_from_tcp(q.as_slice()));
    let places: Vec<Pose> = places.collect();
    let from = nearest(&positions, &DVector::from_vec(touch));
    Ok(PlannedDemo {
        motion: JointDemo {
            object: object.along(&tool_way, &places, from),
            positions,
            step_secs: step,
        },
        fraction: contact.fraction,
        stopped_by: contact.stopped_by,
    })
}

/// Which of the configurations is nearest to one.
fn nearest(positions: &[DVector<f64>], q: &DVector<f64>) -> usize {
    let off = |k: &usize| (&positions[*k] - q).norm();
    let nearest = (0..positions.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.unwrap_or(0)
}

/// Sum of what the joints must move, rad.
fn way_in_joints(from: &[f64], to: &[f64]) -> f64 {
    from.iter().zip(to).map(|(a, b)| (a - b).abs()).sum()
}

/// A posture at the contact, with the ways to and from it.
struct Contact {
    before: Vec<f64>,
    approach: Vec<Vec<f64>>,
    way: Vec<Vec<f64>>,
    fraction: f64,
    stopped_by: Option<String>,
}

impl Contact {
    /// The posture from which the arm follows the tool's way farthest, of those that do so as far the one nearest to where
    /// the arm is.
    fn best(
        free: &mut PlanningScene,
        near: &mut PlanningScene,
        q_start: &[f64],
        tool_way: &[Pose],
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, BootstrapError> {
        let contact = tool_way.first().copied().unwrap_or_else(Pose::identity);
        let options = IkOptions {
            avoid_collision: true,
            n_candidates: N_POSTURES,
            ..IkOptions::default()
        };
        let postures = solve_ik_many(near, &contact, &[], &options, N_POSTURES, rng);
        let mut best: Option<Self> = None;
        let mut detail = "none reaches it".to_owned();
        for q in &postures {
            match Self::from_posture(free, near, q, tool_way) {
                Ok(found) => {
                    let rank = |contact: &Self| {
                        let far = way_in_joints(q_start, &contact.before);
                        ((FRACTION_STEPS * contact.fraction).floor(), -far)
                    };
                    if best.as_ref().is_none_or(|best| rank(&found) > rank(best)) {
                        best = Some(found);
                    }
                }
                Err(reason) => detail = reason,
            }
        }
        best.ok_or(BootstrapError::NoContact {
            x_m: contact.translation.x,
            y_m: contact.translation.y,
            z_m: contact.translation.z,
            n_postures: postures.len(),
            detail,
        })
    }

    fn from_posture(
        free: &mut PlanningScene,
        near: &mut PlanningScene,
        q: &[f64],
        tool_way: &[Pose],
    ) -> Result<Self, String> {
        let options = ToolLineOptions::default();
        let (contact, rest) = tool_way.split_first().ok_or("no way")?;
        let before = contact * Translation3::new(0.0, 0.0, -STANDOFF_M);
        let mut approach =
            plan_tool_line(near, q, &[before], &options).map_err(|failure| in_words(&failure))?;
        approach.reverse();
        let start = approach.first().cloned().unwrap_or_default();
        if let Some((a, b)) = free.collision(&start) {
            return Err(format!("before the contact, `{a}` would touch `{b}`"));
        }
        let (way, fraction, stopped_by) = match plan_tool_line(near, q, rest, &options) {
            Ok(way) => (way, 1.0, None),
            Err(failure) => {
                let reason = in_words(&failure);
                (failure.path, failure.fraction_done, Some(reason))
            }
        };
        if fraction < FRACTION_MIN {
            return Err(stopped_by.unwrap_or_default());
        }
        Ok(Self {
            before: start,
            approach,
            way,
            fraction,
            stopped_by,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use factotum_descriptions::{JointKind, RobotDescription};
    use factotum_motion::RobotModel;
    use rand::SeedableRng as _;

    use super::*;

    fn arm() -> RobotModel {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots/iiwa7");
        RobotModel::load(&RobotDescription::load(&assets).unwrap()).unwrap()
    }

    /// Something on a rail that leads away from the robot, touched from above.
    fn on_a_rail(x_m: f64, goal_m: f64) -> ObjectKinematics {
        let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
        ObjectKinematics {
            base_from_object: Pose::translation(x_m, 0.1, 0.2),
            joint: ObjectJoint {
                name: "rail".to_owned(),
                kind: JointKind::Prismatic,
                axis: [1.0, 0.0, 0.0],
                origin: [0.0; 3],
                range: [0.0, 2.0],
                link: "slider".to_owned(),
            },
            start: 0.0,
            goal: goal_m,
            object_from_contact: Pose::from_parts(Translation3::identity(), down),
        }
    }

    fn plan(object: &ObjectKinematics) -> Result<PlannedDemo, BootstrapError> {
        let robot = arm();
        let mut free = PlanningScene::new(&robot, &[], None).unwrap();
        let mut near = PlanningScene::new(&robot, &[], None).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        initial_demo(
            &mut free,
            &mut near,
            &robot.q_ready(),
            object,
            1.0,
            0.05,
            &mut rng,
        )
    }

    #[test]
    fn what_is_within_reach_is_shown_to_the_end() {
        let object = on_a_rail(0.5, 0.15);
        let demo = plan(&object).unwrap();
        assert!((demo.fraction - 1.0).abs() < 1e-9 && demo.stopped_by.is_none());
        let robot = arm();
        let first = demo.motion.positions.first().unwrap();
        let start = robot.q_ready();
        assert!(first.iter().zip(&start).all(|(a, b)| (a - b).abs() < 1e-6));
        let last = demo.motion.positions.last().unwrap();
        let tool = robot.chain().base_from_tcp(last.as_slice());
        let off = tool.translation.vector - Vector3::new(0.65, 0.1, 0.2);
        assert!(off.norm() < 1e-3, "{off}");
        // The object is moved from the contact on, and then all the way.
        let joint = &demo.motion.object;
        assert!((joint[0] - 0.0).abs() < 1e-12 && joint.is_sorted());
        assert!((joint.last().unwrap() - 0.15).abs() < 0.005, "{joint:?}");
        // No joint is asked for more than it can do.
        for pair in demo.motion.positions.windows(2) {
            for (limit, (a, b)) in robot.limits().iter().zip(pair[0].iter().zip(&pair[1])) {
                assert!((b - a).abs() <= 1.01 * limit.velocity * demo.motion.step_secs);
            }
        }
    }

    #[test]
    fn what_goes_out_of_reach_is_shown_in_part_and_what_never_was_in_reach_is_refused() {
        let demo = plan(&on_a_rail(0.5, 1.5)).unwrap();
        assert!((0.05..0.5).contains(&demo.fraction), "{}", demo.fraction);
        assert!(demo.stopped_by.is_some());
        let error = plan(&on_a_rail(2.0, 2.2)).unwrap_err();
        let said = error.to_string();
        assert!(said.contains("(2.000, 0.100, 0.200)"), "{said}");
    }

    #[test]
    fn a_mistake_of_nothing_changes_nothing_and_others_are_as_large_as_asked_for() {
        let object = on_a_rail(0.5, 0.15);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        assert_eq!(
            object.mistaken(&KinematicError::default(), &mut rng),
            object
        );
        let error = KinematicError {
            position_m: 0.02,
            axis_rad: 0.1,
            range: 0.0,
        };
        let n = 400;
        let (mut shift, mut turn) = (0.0, 0.0);
        for _ in 0..n {
            let off = object.mistaken(&error, &mut rng);
            let moved = off.base_from_object.translation.vector
                - object.base_from_object.translation.vector;
            shift += moved.norm_squared() / 3.0;
            let axis = Vector3::from(off.joint.axis);
            turn += axis.angle(&Vector3::x()).powi(2) / 2.0;
        }
        let [shift, turn] = [shift, turn].map(|sum: f64| (sum / f64::from(n)).sqrt());
        assert!((0.018..0.022).contains(&shift), "{shift}");
        assert!((0.09..0.11).contains(&turn), "{turn}");
    }
}
