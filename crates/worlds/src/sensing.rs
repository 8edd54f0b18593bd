//! What the simulated lidar, depth camera and instance segmenter report.
//!
//! The segmenter stands in for an off-the-shelf one: it labels the pixels of each visible instance of a known class with
//! the class's name. It never tells a pose, and it errs as [`Noise`] says.

use factotum_descriptions::{Camera, Lidar};
use factotum_geometry::frames::{body_from_optical, planar_from_pose};
use factotum_geometry::sensing::{DepthFrame, LaserScan};
use factotum_geometry::{Pose, Pose2};
use factotum_physics::{
    BodyId, DepthImage, GeomId, PhysicsError, PinholeCamera, SiteId, State, depth_image,
    planar_scan,
};
use rand::{Rng, RngExt as _};

use crate::assembly::Assembly;
use crate::noise::Noise;
use crate::random::normal;

/// Sweeps the lidar.
pub(crate) fn scan(
    assembly: &Assembly,
    state: &State,
    lidar: &Lidar,
    site: SiteId,
    noise: &Noise,
    rng: &mut impl Rng,
) -> Result<LaserScan, PhysicsError> {
    let world_from_lidar = state.world_from_site(site);
    let angle_step_rad = if lidar.fov_rad > std::f64::consts::TAU - 1e-3 {
        // A full turn: the last ray must not repeat the first.
        lidar.fov_rad / lidar.n_rays as f64
    } else {
        lidar.fov_rad / (lidar.n_rays - 1) as f64
    };
    let angle_min_rad = -lidar.fov_rad / 2.0;
    let mut ranges_m = planar_scan(
        state,
        &world_from_lidar,
        angle_min_rad,
        angle_step_rad,
        lidar.n_rays,
        lidar.range_m,
        &carrier_first(assembly, site),
    )?;
    for range_m in &mut ranges_m {
        if rng.random_bool(noise.lidar_dropout.clamp(0.0, 1.0)) {
            *range_m = f64::INFINITY;
        } else if range_m.is_finite() {
            *range_m = (*range_m + normal(rng, noise.lidar_m)).max(0.0);
        }
    }
    let [range_min_m, range_max_m] = lidar.range_m;
    Ok(LaserScan {
        angle_min_rad,
        angle_step_rad,
        ranges_m,
        range_min_m,
        range_max_m,
        base_from_lidar: base_from_site_planar(assembly, state, site),
    })
}

/// Takes a picture, with the robot itself left out: pixels on its own links carry no depth, as camera drivers with a
/// self-filter give them (the links' poses follow from the joint positions the robot feels). What it holds is seen.
pub(crate) fn look(
    assembly: &Assembly,
    state: &State,
    camera: &Camera,
    site: SiteId,
    noise: &Noise,
    rng: &mut impl Rng,
) -> Result<DepthFrame, PhysicsError> {
    let pinhole = PinholeCamera::from_fovy(camera.width, camera.height, camera.fovy_rad)?;
    let site_from_optical =
        Pose::from_parts(nalgebra::Translation3::identity(), body_from_optical());
    let world_from_optical = state.world_from_site(site) * site_from_optical;
    let carrier = assembly.model.site_body(site);
    let image = depth_image(
        state,
        &pinhole,
        &world_from_optical,
        camera.range_m,
        &[carrier],
    )?;
    let (labels, label_classes) = segment(assembly, &image, noise, rng);
    let is_own = |geom: &Option<GeomId>| {
        geom.is_some_and(|geom| {
            assembly
                .robot
                .bodies
                .contains(&assembly.model.geom_body(geom))
        })
    };
    let depth_m = image
        .depth_m
        .iter()
        .zip(&image.geom)
        .map(|(&depth, geom)| {
            let depth = if is_own(geom) { 0.0 } else { depth };
            noisy_depth(depth, camera.range_m, noise, rng)
        })
        .collect();
    let base_from_world = state.world_from_body(assembly.robot.link).inverse();
    Ok(DepthFrame {
        width: camera.width,
        height: camera.height,
        fx: pinhole.fx,
        fy: pinhole.fy,
        cx: pinhole.cx,
        cy: pinhole.cy,
        depth_m,
        labels,
        label_classes,
        base_from_optical: base_from_world * world_from_optical,
    })
}

/// Instance labels and the class of each.
fn segment(
    assembly: &Assembly,
    image: &DepthImage,
    noise: &Noise,
    rng: &mut impl Rng,
) -> (Vec<u16>, Vec<String>) {
    let mut instance_of_geom = vec![None; assembly.model.n_geoms()];
    for (instance, object) in assembly.objects.iter().enumerate() {
        for geom in &object.geoms {
            instance_of_geom[geom.index()] = Some(instance);
        }
    }
    let instances: Vec<Option<usize>> = image
        .geom
        .iter()
        .map(|geom| geom.and_then(|geom| instance_of_geom[geom.index()]))
        .collect();
    let mut n_pixels = vec![0_usize; assembly.objects.len()];
    for instance in instances.iter().flatten() {
        n_pixels[*instance] += 1;
    }
    let mut label_classes = Vec::new();
    let label_of_instance: Vec<u16> = assembly
        .objects
        .iter()
        .zip(&n_pixels)
        .map(|(object, &n)| {
            let missed = rng.random_bool(noise.label_miss.clamp(0.0, 1.0));
            if n < noise.label_pixels_min.max(1) || missed {
                return 0;
            }
            label_classes.push(object.class.clone());
            u16::try_from(label_classes.len()).unwrap_or(0)
        })
        .collect();
    let labels = instances
        .iter()
        .map(|instance| match instance {
            Some(instance) if label_of_instance[*instance] > 0 => {
                if rng.random_bool(noise.label_pixel_miss.clamp(0.0, 1.0)) {
                    0
                } else {
                    label_of_instance[*instance]
                }
            }
            _ => 0,
        })
        .collect();
    (labels, label_classes)
}

fn noisy_depth(depth_m: f32, range_m: [f64; 2], noise: &Noise, rng: &mut impl Rng) -> f32 {
    if depth_m <= 0.0 || rng.random_bool(noise.depth_dropout.clamp(0.0, 1.0)) {
        return 0.0;
    }
    let depth = f64::from(depth_m);
    let noisy = depth + normal(rng, noise.depth_m_at_1m * depth * depth);
    if (range_m[0]..=range_m[1]).contains(&noisy) {
        noisy as f32
    } else {
        0.0
    }
}

fn base_from_site_planar(assembly: &Assembly, state: &State, site: SiteId) -> Pose2 {
    let base_from_world = state.world_from_body(assembly.robot.link).inverse();
    planar_from_pose(&(base_from_world * state.world_from_site(site)))
}

/// The robot's bodies, the one that carries the sensor first: rays pass through the first at no cost.
fn carrier_first(assembly: &Assembly, site: SiteId) -> Vec<BodyId> {
    let carrier = assembly.model.site_body(site);
    let others = assembly.robot.bodies.iter().copied();
    std::iter::once(carrier)
        .chain(others.filter(|&body| body != carrier))
        .collect()
}
