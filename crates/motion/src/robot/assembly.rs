//! A robot's parts put together by physics.

use factotum_descriptions::RobotDescription;
use factotum_physics::{AttachOptions, AttachPoint, NewSite, Part, SceneBuilder, UrdfOptions};

use crate::Pose;
use crate::error::MotionError;

/// A scene with nothing but the robot, without what only draws, its first part's root at the world's origin.
///
/// # Errors
/// [`MotionError`] if a part cannot be read or the tool frame names no part's body.
pub fn scene_of_robot(description: &RobotDescription) -> Result<SceneBuilder, MotionError> {
    let mut scene = SceneBuilder::new();
    scene.name(&description.name).visuals(false);
    add_robot(&mut scene, description)?;
    Ok(scene)
}

/// Adds the robot's parts to a scene.
pub(crate) fn add_robot(
    scene: &mut SceneBuilder,
    description: &RobotDescription,
) -> Result<(), MotionError> {
    let tcp = tcp_site_to_add(description)?;
    for (idx, part) in description.parts.iter().enumerate() {
        let at = match &part.attach_to {
            Some(site) => AttachPoint::Frame {
                name: site.clone(),
                offset: part.carrier_from_part(),
            },
            None => AttachPoint::World(Pose::identity()),
        };
        let mut options = AttachOptions {
            urdf: UrdfOptions {
                package_dirs: part.package_dirs.clone(),
            },
            ..AttachOptions::default()
        };
        if let Some((tcp_idx, site)) = &tcp
            && *tcp_idx == idx
        {
            options.sites.push(site.clone());
        }
        let part = Part {
            file: part.model.clone(),
            prefix: part.prefix.clone(),
        };
        scene.attach_with(&part, &at, &options)?;
    }
    Ok(())
}

/// The tool site that the description gives instead of the model, and the part it belongs to.
fn tcp_site_to_add(
    description: &RobotDescription,
) -> Result<Option<(usize, NewSite)>, MotionError> {
    let arm = &description.arm;
    let Some(tcp) = &arm.tcp else {
        return Ok(None);
    };
    // The part with the longest prefix that both names have; an empty prefix fits all.
    let fitting = description
        .parts
        .iter()
        .enumerate()
        .filter_map(|(idx, part)| {
            let site = arm.tcp_site.strip_prefix(&part.prefix)?;
            let body = tcp.body.strip_prefix(&part.prefix)?;
            Some((part.prefix.len(), idx, site, body))
        });
    let Some((_, idx, site, body)) = fitting.max_by_key(|&(len, idx, ..)| (len, idx)) else {
        return Err(MotionError::Value {
            what: "arm.tcp.body",
            found: format!("`{}` with tcp_site `{}`", tcp.body, arm.tcp_site),
            wanted: "a body and a site name with the prefix of one part",
        });
    };
    let body_from_site = factotum_geometry::frames::pose_from_xyz_rpy(tcp.xyz, tcp.rpy);
    let site = NewSite {
        name: site.to_owned(),
        body: body.to_owned(),
        body_from_site,
    };
    Ok(Some((idx, site)))
}
