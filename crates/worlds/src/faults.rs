//! Faults that a run may ask for: events from outside that the robot must notice and recover from.
//!
//! | fault | when | what |
//! |---|---|---|
//! | [`Fault::MovedObject`] | the robot sets off to a place within reach of a movable object | a person moves the object on its table: its free body is set down elsewhere, at rest, while nobody holds it |
//! | [`Fault::BlockedPath`] | the robot sets off on a path of some length | a person puts a packing case down on the path, where there is room to pass beside it |
//! | [`Fault::GraspSlip`] | the robot has carried an object for a while | the gripper's drive gives way until the object is out of it: its target opens |
//!
//! Each happens at most once, and only after the fault was armed ([`FaultSwitch::arm`]): whoever runs the robot arms it
//! when the map is made, since "moved after mapping" means nothing before. These events are the only ones that set a
//! pose instead of applying forces; the robot itself never moves but by its drives.

use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use factotum_geometry::frames::planar_from_pose;
use factotum_geometry::{Pose, Pose2};
use factotum_physics::{GeomId, PhysicsError, RayFilter, State};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use crate::assembly::{Assembly, OBSTACLE_HALF_M, ObjectIds};
use crate::random::{Purpose, stream};

/// An event from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// An object is moved after it was mapped.
    MovedObject,
    /// A new obstacle stands on the robot's path.
    BlockedPath,
    /// The gripper loses what it holds.
    GraspSlip,
}

impl Fault {
    /// All faults.
    pub const ALL: [Self; 3] = [Self::MovedObject, Self::BlockedPath, Self::GraspSlip];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::MovedObject => "moved-object",
            Self::BlockedPath => "blocked-path",
            Self::GraspSlip => "grasp-slip",
        }
    }
}

/// A name that is no fault.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("fault `{found}` is not known; available: `moved-object`, `blocked-path`, `grasp-slip`")]
pub struct UnknownFault {
    /// The name given.
    pub found: String,
}

impl FromStr for Fault {
    type Err = UnknownFault;

    fn from_str(name: &str) -> Result<Self, UnknownFault> {
        Self::ALL
            .into_iter()
            .find(|fault| fault.name() == name)
            .ok_or_else(|| UnknownFault {
                found: name.to_owned(),
            })
    }
}

/// Arms the fault of a world from elsewhere, e.g. from the thread that watches a run.
#[derive(Debug, Clone, Default)]
pub struct FaultSwitch(Arc<AtomicBool>);

impl FaultSwitch {
    /// From now on the fault may happen.
    pub fn arm(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Shortest path worth blocking, metres.
const BLOCKED_PATH_MIN_M: f64 = 1.5;

/// How far the packing case stays from the robot and from the end of the path, metres.
const BLOCKED_DISTANCE_MIN_M: f64 = 0.9;

/// Room beside the robot when it passes the case, metres.
const PASSING_ROOM_M: f64 = 0.15;

/// How near the end of a path must be to an object for the robot to be on its way to it, metres.
const REACH_M: f64 = 1.6;

/// How far an object is moved, metres.
const MOVED_M: std::ops::RangeInclusive<f64> = 0.12..=0.30;

/// Attempts to find a free place for an object.
const N_ATTEMPTS: usize = 100;

/// How long an object is carried before it slips, seconds.
const CARRIED_SECS: f64 = 6.0;

/// How long the gripper gives way after it last touched an object, seconds: the object is to fall out of it.
const SLIP_SECS: f64 = 0.6;

/// The fault of a world, if it has one, and how far it has come.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FaultState {
    pub(crate) fault: Option<Fault>,
    pub(crate) happened: Option<String>,
    pub(crate) carried_secs: f64,
    pub(crate) slips_until_secs: Option<f64>,
    pub(crate) rng: ChaCha8Rng,
}

impl FaultState {
    pub(crate) fn new(fault: Option<Fault>, seed: u64) -> Self {
        Self {
            fault,
            happened: None,
            carried_secs: 0.0,
            slips_until_secs: None,
            rng: stream(seed, Purpose::Fault),
        }
    }

    fn may(&self, fault: Fault) -> bool {
        self.fault == Some(fault) && self.happened.is_none()
    }

    /// The robot sets off along a path in the world. Poses must be fresh.
    pub(crate) fn on_base_path(
        &mut self,
        assembly: &Assembly,
        state: &mut State,
        world_path: &[Pose2],
        footprint_radius_m: f64,
    ) -> Result<(), PhysicsError> {
        if self.may(Fault::MovedObject) {
            self.move_object(assembly, state, world_path)?;
        } else if self.may(Fault::BlockedPath) {
            self.block_path(assembly, state, world_path, footprint_radius_m)?;
        }
        Ok(())
    }

    /// The gripper's target for this step, given the one its controller wants; `carrying` says whether it holds an
    /// object that touches nothing else, `touching` whether the robot touches an object at all.
    pub(crate) fn on_grip(
        &mut self,
        now_secs: f64,
        carrying: bool,
        touching: bool,
        target: f64,
        dt_secs: f64,
    ) -> f64 {
        if let Some(until_secs) = &mut self.slips_until_secs {
            if touching {
                *until_secs = now_secs + SLIP_SECS;
            }
            if now_secs < *until_secs {
                return 1.0;
            }
            self.slips_until_secs = None;
        }
        if self.may(Fault::GraspSlip) && carrying {
            self.carried_secs += dt_secs;
            if self.carried_secs > CARRIED_SECS {
                self.slips_until_secs = Some(now_secs + SLIP_SECS);
                self.happened = Some(format!("the gripper gave way at {now_secs:.1} s"));
            }
        }
        target
    }

    fn move_object(
        &mut self,
        assembly: &Assembly,
        state: &mut State,
        world_path: &[Pose2],
    ) -> Result<(), PhysicsError> {
        let Some(end) = world_path.last() else {
            return Ok(());
        };
        let object = assembly.objects.iter().find(|object| {
            let place = state.world_from_body(object.root).translation.vector.xy();
            object.movable
                && (place - end.translation.vector).norm() < REACH_M
                && !state.are_touching(&assembly.robot.geoms, &object.geoms)
        });
        let Some(object) = object else {
            return Ok(());
        };
        let before = state.world_from_body(object.root);
        for _ in 0..N_ATTEMPTS {
            let direction = self.rng.random_range(0.0..std::f64::consts::TAU);
            let distance = self.rng.random_range(MOVED_M);
            let shift = Vector3::new(direction.cos(), direction.sin(), 0.0) * distance;
            let after =
                Pose::from_parts((before.translation.vector + shift).into(), before.rotation);
            if is_supported(assembly, state, object, &before, &after)
                && is_free(state, object, &after)?
            {
                state.set_free_body_pose(object.root, &after)?;
                state.forward_kinematics()?;
                self.happened = Some(format!(
                    "{} was moved by {distance:.2} m to ({:.2}, {:.2}) m",
                    object.name, after.translation.x, after.translation.y
                ));
                return Ok(());
            }
        }
        Ok(())
    }

    fn block_path(
        &mut self,
        assembly: &Assembly,
        state: &mut State,
        world_path: &[Pose2],
        footprint_radius_m: f64,
    ) -> Result<(), PhysicsError> {
        let robot = planar_from_pose(&state.world_from_body(assembly.robot.link));
        let mut points = vec![Point2::from(robot.translation.vector)];
        points.extend(
            world_path
                .iter()
                .map(|pose| Point2::from(pose.translation.vector)),
        );
        let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) else {
            return Ok(());
        };
        if length(&points) < BLOCKED_PATH_MIN_M {
            return Ok(());
        }
        let room = OBSTACLE_HALF_M[0] + 2.0 * footprint_radius_m + PASSING_ROOM_M;
        let mut best: Option<(f64, Point2<f64>, Vector2<f64>)> = None;
        for (point, direction) in samples(&points) {
            let far = |other: &Point2<f64>| (point - other).norm() > BLOCKED_DISTANCE_MIN_M;
            if !far(&first) || !far(&last) {
                continue;
            }
            let left = Vector2::new(-direction.y, direction.x);
            let sides = [left, -left].map(|side| free_distance(assembly, state, &point, &side));
            let (narrow, wide) = (sides[0].min(sides[1]), sides[0].max(sides[1]));
            if narrow > OBSTACLE_HALF_M[0] + 0.02
                && wide > room
                && best.is_none_or(|(width, ..)| wide > width)
            {
                best = Some((wide, point, direction));
            }
        }
        if let Some((_, point, direction)) = best {
            let yaw = direction.y.atan2(direction.x);
            let pose = Pose::new(
                Vector3::new(point.x, point.y, OBSTACLE_HALF_M[2]),
                Vector3::z() * yaw,
            );
            state.set_mocap(assembly.obstacle, &pose)?;
            state.forward_kinematics()?;
            self.happened = Some(format!(
                "a packing case was put down at ({:.2}, {:.2}) m",
                point.x, point.y
            ));
        }
        Ok(())
    }
}

fn length(points: &[Point2<f64>]) -> f64 {
    points
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).norm())
        .sum()
}

/// Points every 10 cm along a polyline, with the direction there.
fn samples(points: &[Point2<f64>]) -> Vec<(Point2<f64>, Vector2<f64>)> {
    const SPACING_M: f64 = 0.1;
    let mut samples = Vec::new();
    for pair in points.windows(2) {
        let step = pair[1] - pair[0];
        let distance = step.norm();
        if distance < 1e-6 {
            continue;
        }
        let n = (distance / SPACING_M).ceil();
        let mut i = 0.0;
        while i < n {
            samples.push((pair[0] + step * (i / n), step / distance));
            i += 1.0;
        }
    }
    samples
}

/// Free distance from a point on the floor along a direction, as the lidar would see it, metres.
fn free_distance(
    assembly: &Assembly,
    state: &State,
    point: &Point2<f64>,
    direction: &Vector2<f64>,
) -> f64 {
    const HEIGHT_M: f64 = 0.2;
    const FAR_M: f64 = 10.0;
    let origin = Point3::new(point.x, point.y, HEIGHT_M);
    let filter = RayFilter::excluding(&assembly.robot.bodies);
    state
        .ray(origin, Vector3::new(direction.x, direction.y, 0.0), &filter)
        .map_or(FAR_M, |hit| hit.distance_m)
}

/// Whether the same surface carries the object at both poses, under its middle and around it.
fn is_supported(
    assembly: &Assembly,
    state: &State,
    object: &ObjectIds,
    before: &Pose,
    after: &Pose,
) -> bool {
    const AROUND_M: f64 = 0.06;
    const ABOVE_M: f64 = 0.02;
    const SAME_HEIGHT_M: f64 = 0.01;
    let filter = RayFilter::excluding(&assembly.model.bodies_of_subtree(object.root));
    let below = |pose: &Pose, x: f64, y: f64| -> Option<(GeomId, f64)> {
        let origin = Point3::from(pose.translation.vector + Vector3::new(x, y, ABOVE_M));
        let hit = state.ray(origin, -Vector3::z(), &filter)?;
        Some((hit.geom, hit.distance_m))
    };
    let Some((carrier, _)) = below(before, 0.0, 0.0) else {
        return false;
    };
    [
        (0.0, 0.0),
        (AROUND_M, 0.0),
        (-AROUND_M, 0.0),
        (0.0, AROUND_M),
        (0.0, -AROUND_M),
    ]
    .iter()
    .all(|&(x, y)| {
        below(after, x, y).is_some_and(|(geom, distance)| {
            geom == carrier && (distance - ABOVE_M).abs() < SAME_HEIGHT_M
        })
    })
}

/// Whether the object at `pose` sinks into nothing.
fn is_free(state: &State, object: &ObjectIds, pose: &Pose) -> Result<bool, PhysicsError> {
    const TOUCH_M: f64 = -0.002;
    let mut trial = state.try_clone()?;
    trial.set_free_body_pose(object.root, pose)?;
    trial.detect_collisions()?;
    Ok(trial.contacts().all(|contact| {
        let mine = object.geoms.contains(&contact.geom_a) || object.geoms.contains(&contact.geom_b);
        !mine || contact.distance_m > TOUCH_M
    }))
}
