//! Robot and home put together in one physics model, with everything looked up once.

use std::collections::BTreeMap;

use factotum_control::composition::attach_robot;
use factotum_descriptions::{ObjectClass, RobotDescription};
use factotum_geometry::frames::pose_from_planar;
use factotum_geometry::{Pose, Pose2};
use factotum_physics::{
    ActuatorId, AttachPoint, BodyId, GeomId, JointId, Model, Motion, Part, PhysicsError, Primitive,
    SceneBuilder, SceneOptions, Shape, SiteId, State,
};

use crate::WorldError;
use crate::scene::{HomeScene, Placed};

/// Length of a physics step, seconds.
pub(crate) const STEP_SECS: f64 = 0.002;

/// Name of the obstacle that the blocked-path fault puts down.
const OBSTACLE: &str = "obstacle";

/// Half extents of that obstacle, metres: a packing case that the lidar sees and the robot cannot push through.
pub(crate) const OBSTACLE_HALF_M: [f64; 3] = [0.15, 0.15, 0.25];

/// Where it waits, far below the floor.
const OBSTACLE_PARKED_Z_M: f64 = -20.0;

/// The base's joints and drives.
#[derive(Debug, Clone)]
pub(crate) struct BaseIds {
    pub(crate) joints: [JointId; 3],
    pub(crate) actuators: [ActuatorId; 3],
}

/// The lift's joint and drive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LiftIds {
    pub(crate) joint: JointId,
    pub(crate) actuator: ActuatorId,
}

/// The gripper's joints, drives and pads.
#[derive(Debug, Clone)]
pub(crate) struct GripperIds {
    pub(crate) joints: Vec<JointId>,
    pub(crate) actuators: Vec<ActuatorId>,
    pub(crate) pads: Vec<GeomId>,
    /// Geoms of the body that carries each pad.
    pub(crate) fingers: Vec<Vec<GeomId>>,
}

/// Everything of the robot that the simulation reads or drives.
#[derive(Debug, Clone)]
pub(crate) struct RobotIds {
    pub(crate) root: BodyId,
    pub(crate) link: BodyId,
    pub(crate) bodies: Vec<BodyId>,
    pub(crate) geoms: Vec<GeomId>,
    pub(crate) base: Option<BaseIds>,
    pub(crate) lift: Option<LiftIds>,
    pub(crate) tcp: SiteId,
    pub(crate) arm_joints: Vec<JointId>,
    pub(crate) arm_actuators: Vec<ActuatorId>,
    pub(crate) gripper: Option<GripperIds>,
    pub(crate) lidar: Option<SiteId>,
    pub(crate) camera: Option<SiteId>,
}

/// An object in the model.
#[derive(Debug, Clone)]
pub(crate) struct ObjectIds {
    pub(crate) name: String,
    pub(crate) class: String,
    pub(crate) root: BodyId,
    pub(crate) movable: bool,
    pub(crate) geoms: Vec<GeomId>,
    pub(crate) joints: BTreeMap<String, JointId>,
}

/// The compiled world.
#[derive(Debug, Clone)]
pub(crate) struct Assembly {
    pub(crate) model: Model,
    pub(crate) robot: RobotIds,
    pub(crate) objects: Vec<ObjectIds>,
    pub(crate) obstacle: BodyId,
}

impl Assembly {
    /// Composes and compiles.
    pub(crate) fn new(
        robot: &RobotDescription,
        scene: &HomeScene,
        placed: &Placed,
    ) -> Result<Self, WorldError> {
        Self::build(robot, scene, placed)
            .map_err(WorldError::physics("composing the robot and its home"))
    }

    fn build(
        robot: &RobotDescription,
        scene: &HomeScene,
        placed: &Placed,
    ) -> Result<Self, PhysicsError> {
        let mut builder = SceneBuilder::new();
        builder.name(&format!("{} in {}", robot.name, scene.name()));
        builder.options(SceneOptions {
            timestep_secs: STEP_SECS,
            ..SceneOptions::default()
        });
        // A mobile base drives to its start along its own joints; a fixed one is bolted down there.
        let world_from_root = match robot.base {
            Some(_) => Pose::identity(),
            None => pose_from_planar(&placed.world_from_base, 0.0),
        };
        attach_robot(&mut builder, robot, &AttachPoint::World(world_from_root))?;
        let house = Part {
            file: scene.structure().to_owned(),
            prefix: "home/".to_owned(),
        };
        builder.attach(&house, &AttachPoint::World(Pose::identity()), false)?;
        for object in &placed.objects {
            let class = &scene.classes()[&object.class];
            let part = Part {
                file: class.model.clone(),
                prefix: format!("{}/", object.name),
            };
            let at = AttachPoint::World(object.world_from_object);
            builder.attach(&part, &at, class.movable)?;
        }
        builder.add_shape(Shape {
            name: OBSTACLE.to_owned(),
            primitive: Primitive::Box {
                half: OBSTACLE_HALF_M,
            },
            world_from_shape: Pose::translation(0.0, 0.0, OBSTACLE_PARKED_Z_M),
            rgba: [0.72, 0.53, 0.32, 1.0],
            collides: true,
            motion: Motion::Mocap,
        });
        let model = builder.compile()?;
        let objects = placed
            .objects
            .iter()
            .map(|object| object_ids(&model, &object.name, &scene.classes()[&object.class]))
            .collect::<Result<Vec<_>, _>>()?;
        let robot_ids = robot_ids(&model, robot)?;
        Ok(Self {
            obstacle: model.body(OBSTACLE)?,
            robot: robot_ids,
            objects,
            model,
        })
    }

    /// A state with everything where the draw put it and the robot at rest in its driving posture.
    pub(crate) fn initial_state(
        &self,
        robot: &RobotDescription,
        placed: &Placed,
    ) -> Result<State, WorldError> {
        let what = WorldError::physics("placing the robot and the objects");
        let mut state = State::new(&self.model).map_err(what)?;
        if let Some(base) = &self.robot.base {
            let start = &placed.world_from_base;
            let values = [
                start.translation.x,
                start.translation.y,
                start.rotation.angle(),
            ];
            for (joint, value) in base.joints.iter().zip(values) {
                state.set_joint_position(*joint, value);
            }
        }
        if let (Some(lift), Some(description)) = (&self.robot.lift, &robot.lift) {
            state.set_joint_position(lift.joint, description.rest_m);
            state.set_ctrl(lift.actuator, description.rest_m);
        }
        for (joint, position) in self.robot.arm_joints.iter().zip(&robot.arm.rest) {
            state.set_joint_position(*joint, *position);
        }
        for (ids, object) in self.objects.iter().zip(&placed.objects) {
            for (name, position) in &object.joints {
                state.set_joint_position(ids.joints[name], *position);
            }
        }
        Ok(state)
    }

    /// The object of that name.
    pub(crate) fn object(&self, name: &str) -> Option<&ObjectIds> {
        self.objects.iter().find(|object| object.name == name)
    }

    /// The base in the world, in the plane; needs no recomputed poses for a mobile base.
    pub(crate) fn world_from_base(&self, state: &State) -> Pose2 {
        match &self.robot.base {
            Some(base) => {
                let [x, y, yaw] = base.joints.map(|joint| state.joint_position(joint));
                Pose2::new(nalgebra::Vector2::new(x, y), yaw)
            }
            None => {
                factotum_geometry::frames::planar_from_pose(&state.world_from_body(self.robot.root))
            }
        }
    }
}

fn object_ids(model: &Model, name: &str, class: &ObjectClass) -> Result<ObjectIds, PhysicsError> {
    let prefix = format!("{name}/");
    let root = root_body(model, &prefix)?;
    let joints = class
        .joints
        .iter()
        .map(|joint| {
            Ok((
                joint.name.clone(),
                model.joint(&format!("{prefix}{}", joint.name))?,
            ))
        })
        .collect::<Result<BTreeMap<_, _>, PhysicsError>>()?;
    Ok(ObjectIds {
        name: name.to_owned(),
        class: class.name.clone(),
        root,
        movable: class.movable,
        geoms: model.geoms_of_subtree(root),
        joints,
    })
}

/// The first body whose name has a prefix: Λ of an object, as models have one root body.
fn root_body(model: &Model, prefix: &str) -> Result<BodyId, PhysicsError> {
    model
        .bodies()
        .find(|&body| model.body_name(body).starts_with(prefix))
        .map_or_else(|| model.body(prefix), Ok)
}

fn robot_ids(model: &Model, robot: &RobotDescription) -> Result<RobotIds, PhysicsError> {
    let base = robot
        .base
        .as_ref()
        .map(|base| -> Result<_, PhysicsError> {
            let ids = BaseIds {
                joints: three(&base.joints, |name| model.joint(name))?,
                actuators: three(&base.actuators, |name| model.actuator(name))?,
            };
            Ok((ids, model.body(&base.link)?))
        })
        .transpose()?;
    let first_joint = match &base {
        Some((ids, _)) => ids.joints[0],
        None => model.joint(&robot.arm.joints[0])?,
    };
    // The robot's parts hang below the body that hangs on the world and carries the first joint.
    let mut root = model.joint_body(first_joint);
    while let Some(parent) = model.body_parent(root) {
        if parent == BodyId::WORLD {
            break;
        }
        root = parent;
    }
    let lift = robot
        .lift
        .as_ref()
        .map(|lift| -> Result<_, PhysicsError> {
            Ok(LiftIds {
                joint: model.joint(&lift.joint)?,
                actuator: model.actuator(&lift.actuator)?,
            })
        })
        .transpose()?;
    let gripper = robot
        .gripper
        .as_ref()
        .map(|gripper| -> Result<_, PhysicsError> {
            Ok(GripperIds {
                joints: all(&gripper.joints, |name| model.joint(name))?,
                actuators: all(&gripper.actuators, |name| model.actuator(name))?,
                pads: all(&gripper.pads, |name| model.geom(name))?,
                fingers: all(&gripper.pads, |name| {
                    Ok(model.geoms_of_body(model.geom_body(model.geom(name)?)))
                })?,
            })
        })
        .transpose()?;
    let site = |name: Option<&String>| name.map(|name| model.site(name)).transpose();
    let sensors = &robot.sensors;
    Ok(RobotIds {
        root,
        link: base.as_ref().map_or(root, |(_, link)| *link),
        bodies: model.bodies_of_subtree(root),
        geoms: model.geoms_of_subtree(root),
        base: base.map(|(ids, _)| ids),
        lift,
        tcp: model.site(&robot.arm.tcp_site)?,
        arm_joints: all(&robot.arm.joints, |name| model.joint(name))?,
        arm_actuators: all(&robot.arm.actuators, |name| model.actuator(name))?,
        gripper,
        lidar: site(sensors.lidar.as_ref().map(|lidar| &lidar.site))?,
        camera: site(sensors.camera.as_ref().map(|camera| &camera.site))?,
    })
}

fn all<T>(
    names: &[String],
    find: impl Fn(&str) -> Result<T, PhysicsError>,
) -> Result<Vec<T>, PhysicsError> {
    names.iter().map(|name| find(name)).collect()
}

fn three<T>(
    names: &[String; 3],
    find: impl Fn(&str) -> Result<T, PhysicsError>,
) -> Result<[T; 3], PhysicsError> {
    let [x, y, yaw] = names;
    Ok([find(x)?, find(y)?, find(yaw)?])
}
