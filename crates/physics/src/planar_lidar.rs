//! A planar lidar by ray casting.

use nalgebra::{Point3, Vector3};

use crate::Pose;
use crate::error::PhysicsError;
use crate::ids::BodyId;
use crate::ray_fan::RayFan;
use crate::rays::RayFilter;
use crate::state::State;

/// Ranges in the xy-plane of a lidar (x forward, z up), counterclockwise from `angle_min_rad` in steps
/// of `angle_step_rad`; infinite where there is no return within `range_m`.
///
/// # Errors
/// As [`State::rays`].
pub fn planar_scan(
    state: &State,
    world_from_lidar: &Pose,
    angle_min_rad: f64,
    angle_step_rad: f64,
    n_rays: usize,
    range_m: [f64; 2],
    exclude: &[BodyId],
) -> Result<Vec<f64>, PhysicsError> {
    state.usable()?;
    let directions: Vec<Vector3<f64>> = (0..n_rays)
        .map(|i| {
            let angle = angle_min_rad + i as f64 * angle_step_rad;
            world_from_lidar.rotation * Vector3::new(angle.cos(), angle.sin(), 0.0)
        })
        .collect();
    let origin = Point3::from(world_from_lidar.translation.vector);
    let hits = match RayFan::new(state, origin, exclude, range_m[1]) {
        Some(fan) => {
            state.count_rays(n_rays as u64);
            let ray = |dir| fan.first(fan.targets().iter(), dir, range_m[1]);
            directions.iter().map(ray).collect()
        }
        None => state.rays(
            origin,
            &directions,
            &RayFilter::excluding(exclude),
            range_m[1],
        )?,
    };
    Ok(hits
        .into_iter()
        .map(|hit| match hit {
            Some((range, _)) if range >= range_m[0] => range,
            _ => f64::INFINITY,
        })
        .collect())
}
