//! What learning a contact skill asks of whoever has a robot at an object.

use factotum_control::{GuardSpec, Impedance};
use factotum_descriptions::{EpisodeSpec, ObjectJoint};
use factotum_geometry::Pose;
use factotum_geometry::cloud::PointCloud;
use factotum_motion::RobotModel;
use nalgebra::{Point3, Vector3};

/// One robot at one object, to try things on: a simulated one in `worlds`, or a real one with somebody who resets it.
///
/// Everything is in the frame of the robot's base. Time passes in [`Rig::step`] alone.
pub trait Rig {
    /// Why it can go wrong.
    type Error: std::error::Error + Send + Sync + 'static;

    /// What does not change from one episode to the next.
    fn anatomy(&self) -> &Anatomy;

    /// Which guard keeps the joints from their limits from now on.
    ///
    /// # Errors
    /// When the guard makes no sense for this arm.
    fn set_guard(&mut self, guard: GuardSpec) -> Result<(), Self::Error>;

    /// Puts object and arm in their places, all at rest; whether the arm then touches nothing.
    ///
    /// # Errors
    /// When it cannot be done, such as for a posture of another arm.
    fn place(&mut self, placing: &Placing) -> Result<bool, Self::Error>;

    /// Follows a command for one control period.
    ///
    /// # Errors
    /// When the physics breaks down, or the robot does not answer.
    fn step(&mut self, command: &RigCommand) -> Result<(), Self::Error>;

    /// What was felt at the end of the last step, or of placing.
    fn reading(&self) -> &Reading;

    /// What the depth cameras see of what may be grasped, with normals.
    ///
    /// # Errors
    /// When nothing can be seen.
    fn region_cloud(&mut self) -> Result<PointCloud, Self::Error>;
}

/// What does not change from one episode to the next.
#[derive(Debug, Clone)]
pub struct Anatomy {
    /// The robot's kinematics and limits.
    pub robot: RobotModel,
    /// Limits of the arm's joints, rad; `None` for a joint that turns without end.
    pub arm_limits: Vec<Option<[f64; 2]>>,
    /// Joints of the gripper.
    pub n_finger_joints: usize,
    /// Pads that feel.
    pub n_pads: usize,
    /// Largest width between the fingers, metres.
    pub aperture_max_m: f64,
    /// How the object's joint moves what is grasped, in Λ.
    pub object_joint: ObjectJoint,
    /// How an episode runs.
    pub episode: EpisodeSpec,
}

/// Where an episode begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Placing {
    /// Pose of Λ.
    pub base_from_object: Pose,
    /// Position of the object's joint, rad or m.
    pub object_joint: f64,
    /// Configuration of the chain: lift, if any, then arm.
    pub q: Vec<f64>,
    /// Opening of the gripper, 0 closed to 1 open.
    pub opening: f64,
}

/// What the robot is to do for one control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigCommand {
    /// Where the tool should be.
    pub base_from_tcp: Pose,
    /// How stiffly.
    pub impedance: Impedance,
    /// Opening of the gripper, 0 closed to 1 open.
    pub opening: f64,
}

/// What is felt of robot and object.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Joint positions of the arm, rad.
    pub arm_positions: Vec<f64>,
    /// Joint velocities of the arm, rad/s.
    pub arm_velocities: Vec<f64>,
    /// Pose of the tool.
    pub base_from_tcp: Pose,
    /// Positions of the gripper's joints, m or rad.
    pub finger_positions: Vec<f64>,
    /// Their velocities.
    pub finger_velocities: Vec<f64>,
    /// Contact force on each pad in the tool frame, N.
    pub pad_forces_in_tcp: Vec<Vector3<f64>>,
    /// Pose of Λ.
    pub base_from_object: Pose,
    /// Middle of what may be grasped, where the joint has moved it.
    pub region: Point3<f64>,
    /// Position of the object's joint, rad or m.
    pub object_joint: f64,
    /// Whether the gripper touches what may be grasped.
    pub touching: bool,
    /// Largest contact force on a finger in the last step, over every instant of it, N.
    pub peak_force_n: f64,
    /// Smallest distance of a joint of the arm to its limit in the last step, rad.
    pub limit_distance_rad: f64,
}

/// A rig with somebody who looks on, after every placing and every step.
#[derive(Debug)]
pub struct Watched<R, W> {
    rig: R,
    watcher: W,
}

impl<R: Rig, W: FnMut(&R)> Watched<R, W> {
    /// A rig that is watched from now on.
    pub fn new(rig: R, watcher: W) -> Self {
        Self { rig, watcher }
    }
}

impl<R: Rig, W: FnMut(&R)> Rig for Watched<R, W> {
    type Error = R::Error;

    fn anatomy(&self) -> &Anatomy {
        self.rig.anatomy()
    }

    fn set_guard(&mut self, guard: GuardSpec) -> Result<(), R::Error> {
        self.rig.set_guard(guard)
    }

    fn place(&mut self, placing: &Placing) -> Result<bool, R::Error> {
        let is_clear = self.rig.place(placing)?;
        (self.watcher)(&self.rig);
        Ok(is_clear)
    }

    fn step(&mut self, command: &RigCommand) -> Result<(), R::Error> {
        self.rig.step(command)?;
        (self.watcher)(&self.rig);
        Ok(())
    }

    fn reading(&self) -> &Reading {
        self.rig.reading()
    }

    fn region_cloud(&mut self) -> Result<PointCloud, R::Error> {
        self.rig.region_cloud()
    }
}
