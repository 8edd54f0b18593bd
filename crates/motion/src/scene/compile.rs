//! From belief to a model of physics.

use std::collections::BTreeSet;

use factotum_descriptions::Gripper;
use factotum_physics::{
    AttachOptions, AttachPoint, BodyId, Model, Motion, Part, Primitive, SceneBuilder, Shape, State,
};

use super::{
    CLEARANCE_SEEN_M, GripperJoint, HeldObject, Obstacle, ObstacleShape, Owner, PlanningScene,
};
use crate::error::MotionError;
use crate::robot::{Groups, RobotModel, add_robot};

const HELD_PREFIX: &str = "held object/";
const RGBA: [f32; 4] = [0.6, 0.6, 0.6, 1.0];

/// Prefix of an obstacle's names; a single body of a primitive has the prefix as its name.
fn prefix_of(obstacle: &str) -> String {
    format!("obstacle {obstacle}/")
}

pub(super) fn compile(
    robot: &RobotModel,
    obstacles: &[Obstacle],
    held: Option<&HeldObject>,
    margin_m: f64,
) -> Result<PlanningScene, MotionError> {
    if !(margin_m >= 0.0 && margin_m.is_finite()) {
        return Err(MotionError::Value {
            what: "margin_m",
            found: margin_m.to_string(),
            wanted: "zero or positive",
        });
    }
    // 1. Compose robot, obstacles and held object.
    let mut scene = SceneBuilder::new();
    scene.visuals(false);
    add_robot(&mut scene, robot.description())?;
    let mut names = BTreeSet::new();
    for obstacle in obstacles {
        if !names.insert(obstacle.name.as_str()) {
            return Err(MotionError::DuplicateName {
                name: obstacle.name.clone(),
            });
        }
        add_obstacle(&mut scene, obstacle)?;
    }
    if let Some(held) = held {
        add_held(&mut scene, held, &robot.description().arm.tcp_site)?;
    }
    let model = scene.compile()?;
    // 2. Let only those pairs collide that depend on the configuration.
    let joints = robot
        .chain_joints()
        .iter()
        .map(|name| model.joint(name))
        .collect::<Result<Vec<_>, _>>()?;
    let groups = Groups::of(&model, &joints)?;
    let owners: Vec<Owner> = model
        .geoms()
        .map(|geom| owner(&model, &groups, obstacles, model.geom_body(geom)))
        .collect();
    let model = model.edited(|edit| {
        for geom in model.geoms().filter(|&geom| model.geom_collides(geom)) {
            let (contype, conaffinity) = match owners[geom.index()] {
                Owner::Obstacle { .. } => Groups::OBSTACLE_BITS,
                Owner::Robot { .. } | Owner::Held => groups.contact_bits(model.geom_body(geom)),
            };
            edit.set_geom_contact_bits(geom, contype, conaffinity);
            edit.set_geom_margin(geom, margin_m + CLEARANCE_SEEN_M);
        }
        Ok(())
    })?;
    // 3. A state with the obstacles' joints and the gripper in place.
    let mut state = State::new(&model)?;
    for obstacle in obstacles {
        set_joints(&mut state, &obstacle.shape, &prefix_of(&obstacle.name))?;
    }
    if let Some(held) = held {
        set_joints(&mut state, &held.shape, HELD_PREFIX)?;
    }
    let gripper = match &robot.description().gripper {
        Some(gripper) => gripper_joints(&model, gripper)?,
        None => Vec::new(),
    };
    let mut scene = PlanningScene {
        robot: robot.clone(),
        state,
        joints,
        gripper,
        owners,
        margin_m,
        allowed: BTreeSet::new(),
    };
    scene.set_gripper(1.0);
    Ok(scene)
}

fn add_obstacle(scene: &mut SceneBuilder, obstacle: &Obstacle) -> Result<(), MotionError> {
    let prefix = prefix_of(&obstacle.name);
    let world_from_shape = obstacle.base_from_obstacle;
    let primitive = match &obstacle.shape {
        ObstacleShape::Model { file, .. } => {
            let part = Part {
                file: file.clone(),
                prefix,
            };
            let options = AttachOptions::default();
            scene.attach_with(&part, &AttachPoint::World(world_from_shape), &options)?;
            return Ok(());
        }
        &ObstacleShape::Box { half_extents_m } => Primitive::Box {
            half: half_extents_m,
        },
        &ObstacleShape::Cylinder {
            radius_m,
            half_length_m,
        } => Primitive::Cylinder {
            r: radius_m,
            half: half_length_m,
        },
        &ObstacleShape::Sphere { radius_m } => Primitive::Sphere { r: radius_m },
    };
    scene.add_shape(Shape {
        name: prefix,
        primitive,
        world_from_shape,
        rgba: RGBA,
        collides: true,
        motion: Motion::Fixed,
    });
    Ok(())
}

fn add_held(
    scene: &mut SceneBuilder,
    held: &HeldObject,
    tcp_site: &str,
) -> Result<(), MotionError> {
    let at = AttachPoint::Frame {
        name: tcp_site.to_owned(),
        offset: held.tcp_from_object,
    };
    let (kind, size) = match &held.shape {
        ObstacleShape::Model { file, .. } => {
            let part = Part {
                file: file.clone(),
                prefix: HELD_PREFIX.to_owned(),
            };
            scene.attach_with(&part, &at, &AttachOptions::default())?;
            return Ok(());
        }
        ObstacleShape::Box {
            half_extents_m: [x, y, z],
        } => ("box", format!("{x} {y} {z}")),
        ObstacleShape::Cylinder {
            radius_m,
            half_length_m,
        } => ("cylinder", format!("{radius_m} {half_length_m}")),
        ObstacleShape::Sphere { radius_m } => ("sphere", format!("{radius_m}")),
    };
    let xml = format!(
        r#"<mujoco><worldbody><body name="body"><geom type="{kind}" size="{size}"/></body></worldbody></mujoco>"#
    );
    scene.attach_text(
        super::HELD_OBJECT,
        &xml,
        HELD_PREFIX,
        &at,
        &AttachOptions::default(),
    )?;
    Ok(())
}

/// What a body belongs to: found on the way to the root by the prefixes that we gave.
fn owner(model: &Model, groups: &Groups, obstacles: &[Obstacle], body: BodyId) -> Owner {
    let name = model.body_name(body);
    let carriers = std::iter::successors(Some(body), |&body| model.body_parent(body));
    for carrier in carriers {
        let carrier = model.body_name(carrier);
        if carrier.starts_with(HELD_PREFIX) {
            return Owner::Held;
        }
        let obstacle = obstacles
            .iter()
            .filter(|obstacle| carrier.starts_with(&prefix_of(&obstacle.name)))
            .max_by_key(|obstacle| obstacle.name.len());
        if let Some(obstacle) = obstacle {
            return Owner::Obstacle {
                name: obstacle.name.clone(),
            };
        }
    }
    Owner::Robot {
        body: name.to_owned(),
        is_tool: groups.is_tool(body),
    }
}

fn set_joints(state: &mut State, shape: &ObstacleShape, prefix: &str) -> Result<(), MotionError> {
    if let ObstacleShape::Model {
        joint_positions, ..
    } = shape
    {
        for (name, position) in joint_positions {
            let joint = state.model().joint(&format!("{prefix}{name}"))?;
            state.set_joint_position(joint, *position);
        }
    }
    Ok(())
}

/// Finger joints with their positions: one actuator for each joint, or one for all.
fn gripper_joints(model: &Model, gripper: &Gripper) -> Result<Vec<GripperJoint>, MotionError> {
    let target =
        |targets: &[f64], idx: usize| targets.get(idx).or(targets.last()).copied().unwrap_or(0.0);
    gripper
        .joints
        .iter()
        .enumerate()
        .map(|(idx, name)| {
            let joint = model.joint(name)?;
            Ok(GripperJoint {
                joint,
                closed: target(&gripper.closed, idx),
                open: target(&gripper.open, idx),
            })
        })
        .collect()
}
