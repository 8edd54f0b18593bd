//! What depth cameras around an object see of some of its geoms.

use factotum_geometry::cloud::PointCloud;
use factotum_physics::{BodyId, GeomId, PhysicsError, PinholeCamera, Pose, State, depth_image};
use nalgebra::{Isometry3, Point3, Vector3};

/// Distance of the cameras from the middle of the region, metres.
const DISTANCE_M: f64 = 0.5;

/// Points are thinned to one in a cube of this edge, metres.
const VOXEL_M: f64 = 0.004;

/// Points that a surface normal is fitted to.
const N_NEIGHBOURS: usize = 12;

/// The cloud of a region with normals, in the world, from cameras before, beside and above it; empty if it is hidden.
pub(crate) fn region_cloud(
    state: &State,
    region: &[GeomId],
    robot_bodies: &[BodyId],
    world_from_focus: Point3<f64>,
    camera_side: Vector3<f64>,
) -> Result<PointCloud, PhysicsError> {
    let camera = PinholeCamera::from_fovy(160, 120, 0.7)?;
    let front = camera_side.normalize();
    let left = Vector3::z().cross(&front);
    let directions = [
        front + 0.3 * Vector3::z(),
        front + left,
        front - left,
        front + 1.5 * Vector3::z(),
        front - 0.7 * Vector3::z(),
    ];
    let mut whole: Option<PointCloud> = None;
    for direction in directions {
        let eye = world_from_focus + direction.normalize() * DISTANCE_M;
        // Optical frame: z forward, y down.
        let world_from_optical: Pose =
            Isometry3::face_towards(&eye, &world_from_focus, &-Vector3::z());
        let image = depth_image(
            state,
            &camera,
            &world_from_optical,
            [0.05, 2.0],
            robot_bodies,
        )?;
        let points: Vec<Point3<f64>> = image
            .points_in_optical(&camera)
            .filter(|(pixel, _)| image.geom[*pixel].is_some_and(|geom| region.contains(&geom)))
            .map(|(_, point)| world_from_optical * point)
            .collect();
        let seen = PointCloud::new(points).voxel_downsampled(VOXEL_M);
        let Ok(seen) = seen.with_estimated_normals(N_NEIGHBOURS, &eye) else {
            continue;
        };
        whole = Some(match whole {
            None => seen,
            Some(cloud) => cloud.merged(seen),
        });
    }
    Ok(whole.map_or_else(
        || PointCloud::new(Vec::new()),
        |cloud| cloud.voxel_downsampled(VOXEL_M),
    ))
}
