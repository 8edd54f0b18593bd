//! Putting a described robot together in a physics scene.
//!
//! The parts of `robot.toml` are attached in order, the first at a pose in the world, each later one at a site
//! or body of an earlier one. What a model lacks and the description supplies is added: a tool frame ([`Arm::tcp`]) as a site, and
//! a torque motor for each arm joint without an actuator.
//!
//! [`Arm::tcp`]: factotum_descriptions::Arm::tcp

use factotum_descriptions::{Placement, RobotDescription, RobotPart};
use factotum_physics::{
    AttachOptions, AttachPoint, NewActuator, NewSite, Part, PartNames, PhysicsError, SceneBuilder,
    Servo, UrdfOptions,
};

/// Attaches all parts of a robot to a scene, its first part's root at `root`.
///
/// # Errors
/// [`PhysicsError`] if a model file is missing or broken, or a site to attach to does not exist.
pub fn attach_robot(
    scene: &mut SceneBuilder,
    robot: &RobotDescription,
    root: &AttachPoint,
) -> Result<(), PhysicsError> {
    for part in &robot.parts {
        let at = match &part.attach_to {
            None => root.clone(),
            Some(site) => AttachPoint::Frame {
                name: site.clone(),
                offset: part.carrier_from_part(),
            },
        };
        let urdf = UrdfOptions {
            package_dirs: part.package_dirs.clone(),
        };
        let names = PartNames::read(&part.model, &urdf)?;
        let options = AttachOptions {
            actuators: missing_motors(robot, part, &names),
            sites: missing_tool_frame(robot, part, &names),
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

fn has(names: &[String], name: &str) -> bool {
    names.iter().any(|known| known == name)
}

/// Motors for the arm joints of this part that have no actuator.
fn missing_motors(
    robot: &RobotDescription,
    part: &RobotPart,
    names: &PartNames,
) -> Vec<NewActuator> {
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
            (has(&names.joints, joint) && !has(&names.actuators, name)).then(|| NewActuator {
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
fn missing_tool_frame(
    robot: &RobotDescription,
    part: &RobotPart,
    names: &PartNames,
) -> Vec<NewSite> {
    let Some(tcp) = &robot.arm.tcp else {
        return Vec::new();
    };
    let wanted = (
        robot.arm.tcp_site.strip_prefix(&part.prefix),
        tcp.body.strip_prefix(&part.prefix),
    );
    match wanted {
        (Some(site), Some(body)) if has(&names.bodies, body) && !has(&names.sites, site) => {
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
