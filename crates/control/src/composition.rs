//! Putting a described robot together in a physics scene.
//!
//! The parts of `robot.toml` are attached in order, the first at a pose in the world, each later one at a site of an
//! earlier one. What a model lacks and the description supplies is added: a tool frame ([`Arm::tcp`]) as a site, and
//! a torque motor for each arm joint without an actuator.
//!
//! [`Arm::tcp`]: factotum_descriptions::Arm::tcp

use factotum_descriptions::{Placement, RobotDescription, RobotPart};
use factotum_geometry::Pose;
use factotum_physics::{
    AttachOptions, AttachPoint, Model, NewActuator, NewSite, Part, PhysicsError, SceneBuilder,
    Servo, UrdfOptions, urdf_to_mjcf,
};

/// Attaches all parts of a robot to a scene, its first part's root at `world_from_root`.
///
/// # Errors
/// [`PhysicsError`] if a model file is missing or broken, or a site to attach to does not exist.
pub fn attach_robot(
    scene: &mut SceneBuilder,
    robot: &RobotDescription,
    world_from_root: &Pose,
) -> Result<(), PhysicsError> {
    for part in &robot.parts {
        let at = match &part.attach_to {
            None => AttachPoint::World(*world_from_root),
            Some(site) => AttachPoint::Site {
                name: site.clone(),
                offset: part.site_from_part(),
            },
        };
        let urdf = UrdfOptions {
            package_dirs: part.package_dirs.clone(),
        };
        let model = load_part(part, &urdf)?;
        let options = AttachOptions {
            actuators: missing_motors(robot, part, &model),
            sites: missing_tool_frame(robot, part, &model),
            urdf,
            ..AttachOptions::default()
        };
        let file = Part {
            file: part.model.clone(),
            prefix: part.prefix.clone(),
        };
        scene.attach_with(&file, &at, &options)?;
    }
    Ok(())
}

fn load_part(part: &RobotPart, urdf: &UrdfOptions) -> Result<Model, PhysicsError> {
    let is_urdf = part
        .model
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("urdf"));
    if is_urdf {
        Model::from_mjcf_str(&urdf_to_mjcf(&part.model, urdf)?)
    } else {
        Model::from_mjcf_file(&part.model)
    }
}

/// Motors for the arm joints of this part that have no actuator.
fn missing_motors(robot: &RobotDescription, part: &RobotPart, model: &Model) -> Vec<NewActuator> {
    let arm = &robot.arm;
    let named = arm
        .joints
        .iter()
        .zip(&arm.actuators)
        .zip(&arm.torque_max_nm);
    named
        .filter_map(|((joint, actuator), &torque)| {
            let joint = joint.strip_prefix(&part.prefix)?;
            let name = actuator.strip_prefix(&part.prefix)?;
            (model.joint(joint).is_ok() && model.actuator(name).is_err()).then(|| NewActuator {
                name: name.to_owned(),
                joint: joint.to_owned(),
                servo: Servo::Motor,
                ctrl_range: Some([-torque, torque]),
                force_range: None,
            })
        })
        .collect()
}

/// The tool frame, if the description gives it in a body of this part and the part has no such site.
fn missing_tool_frame(robot: &RobotDescription, part: &RobotPart, model: &Model) -> Vec<NewSite> {
    let Some(tcp) = &robot.arm.tcp else {
        return Vec::new();
    };
    let names = (
        robot.arm.tcp_site.strip_prefix(&part.prefix),
        tcp.body.strip_prefix(&part.prefix),
    );
    match names {
        (Some(site), Some(body)) if model.body(body).is_ok() && model.site(site).is_err() => {
            vec![NewSite {
                name: site.to_owned(),
                body: body.to_owned(),
                body_from_site: Placement {
                    xyz: tcp.xyz,
                    rpy: tcp.rpy,
                }
                .into(),
            }]
        }
        _ => Vec::new(),
    }
}
