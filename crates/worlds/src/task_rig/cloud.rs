//! What depth cameras around an object see of some of its geoms.
//!
//! The cameras stand on the robot's side of the region: before it, to its left and right, above and below, each so far
//! away and with such an angle that the whole region is in view. Other geoms hide it; the robot's own bodies do not, as
//! in pictures that were taken before it reached out. Normals are fitted in each picture, turned to its camera, and
//! averaged where pictures overlap. There is no noise.

use factotum_geometry::cloud::PointCloud;
use factotum_physics::{BodyId, GeomId, PhysicsError, PinholeCamera, Pose, State, depth_image};
use nalgebra::{Point3, Vector3};

/// Least distance of the cameras from the middle of the region, metres.
const DISTANCE_MIN_M: f64 = 0.5;

/// Distance of the cameras, as a multiple of the region's radius.
const DISTANCE_RADII: f64 = 3.0;

/// Points are thinned to one in a cube of this edge, metres; a larger region has larger ones.
const VOXEL_MIN_M: f64 = 0.004;

/// Voxels along a region's radius at most.
const VOXELS_MAX: f64 = 50.0;

/// Pixels along the edge of a voxel.
const PIXELS_PER_VOXEL: f64 = 1.5;

/// Points that a surface normal is fitted to.
const N_NEIGHBOURS: usize = 12;

/// The cloud of a region with normals, in the world; empty if it is hidden. Cameras look at `focus_in_world` from
/// `camera_side`, a horizontal direction from the object to the robot.
pub(crate) fn region_cloud(
    state: &State,
    region: &[GeomId],
    robot_bodies: &[BodyId],
    focus_in_world: Point3<f64>,
    camera_side: Vector3<f64>,
) -> Result<PointCloud, PhysicsError> {
    let radius_m = radius_about(state, region, &focus_in_world);
    let distance_m = DISTANCE_MIN_M.max(DISTANCE_RADII * radius_m);
    let voxel_m = VOXEL_MIN_M.max(radius_m / VOXELS_MAX);
    let n_pixels = (2.0 * radius_m / voxel_m * PIXELS_PER_VOXEL)
        .ceil()
        .max(2.0) as usize;
    let fovy_rad = 2.0 * (radius_m / (distance_m - radius_m)).atan();
    let camera = PinholeCamera::from_fovy(n_pixels, n_pixels, fovy_rad)?;
    let mut cloud = PointCloud::new(Vec::new());
    for direction in directions(camera_side) {
        let eye = focus_in_world + direction * distance_m;
        // Optical frame: z forward, y down.
        let world_from_optical = Pose::face_towards(&eye, &focus_in_world, &-Vector3::z());
        let range_m = [0.01, distance_m + radius_m];
        let image = depth_image(state, &camera, &world_from_optical, range_m, robot_bodies)?;
        let points = image
            .points_in_optical(&camera)
            .filter(|(pixel, _)| image.geom[*pixel].is_some_and(|geom| region.contains(&geom)))
            .map(|(_, point)| world_from_optical * point)
            .collect();
        let seen = PointCloud::new(points).voxel_downsampled(voxel_m);
        // Too few points for a surface are left out.
        if let Ok(seen) = seen.with_estimated_normals(N_NEIGHBOURS, &eye) {
            cloud = cloud.merged(seen);
        }
    }
    Ok(cloud.voxel_downsampled(voxel_m))
}

/// Radius of a sphere about a point that holds all geoms, metres.
fn radius_about(state: &State, geoms: &[GeomId], middle: &Point3<f64>) -> f64 {
    let reach = |&geom: &GeomId| {
        let centre = Point3::from(state.world_from_geom(geom).translation.vector);
        (centre - middle).norm() + state.model().geom_bounding_radius_m(geom)
    };
    geoms.iter().map(reach).fold(0.0, f64::max).max(VOXEL_MIN_M)
}

/// From the region to each camera.
fn directions(camera_side: Vector3<f64>) -> [Vector3<f64>; 5] {
    let level = Vector3::new(camera_side.x, camera_side.y, 0.0);
    // The robot above or below the object: any side is as good.
    let front = level.try_normalize(1e-9).unwrap_or_else(Vector3::x);
    let left = Vector3::z().cross(&front);
    // None is vertical, so all have an up; none is shorter than 1.
    [
        front + 0.3 * Vector3::z(),
        front + left,
        front - left,
        front + 1.5 * Vector3::z(),
        front - 0.7 * Vector3::z(),
    ]
    .map(|direction| direction / direction.norm())
}

#[cfg(test)]
mod tests {
    use factotum_physics::Model;

    use super::*;

    /// A box on a post, and an arm between it and the cameras.
    const SCENE: &str = r#"<mujoco><worldbody>
      <body name="object" pos="0.6 0.1 0.4">
        <geom name="handle" type="box" size="0.02 0.06 0.03"/>
        <geom name="post" type="box" pos="0 0 -0.13" size="0.01 0.01 0.1"/>
      </body>
      <body name="arm" pos="0.45 0.1 0.4"><geom name="arm" type="sphere" size="0.05"/></body>
    </worldbody></mujoco>"#;

    const CENTRE: [f64; 3] = [0.6, 0.1, 0.4];
    const HALF: [f64; 3] = [0.02, 0.06, 0.03];

    fn cloud_of(xml: &str, side: Vector3<f64>) -> PointCloud {
        let model = Model::from_mjcf_str(xml).unwrap();
        let mut state = State::new(&model).unwrap();
        state.forward_kinematics().unwrap();
        let region = [model.geom("handle").unwrap()];
        let arm = [model.body("arm").unwrap()];
        region_cloud(&state, &region, &arm, Point3::from(CENTRE), side).unwrap()
    }

    #[test]
    fn points_lie_on_the_box_and_normals_point_out_of_its_faces() {
        let cloud = cloud_of(SCENE, -Vector3::x());
        assert!((200..2_000).contains(&cloud.len()), "{}", cloud.len());
        let mut n_on_face = [0; 6];
        for (point, normal) in cloud.points().iter().zip(cloud.normals().unwrap()) {
            let off = point - Point3::from(CENTRE);
            let depths: [f64; 3] = std::array::from_fn(|k| HALF[k] - off[k].abs());
            let depth = depths.iter().copied().fold(f64::INFINITY, f64::min);
            // A voxel at an edge holds the mean of two faces.
            assert!((-1e-6..0.003).contains(&depth), "{off}");
            // Away from edges there is one face, and its normal.
            let near = |k: usize| depths[k] < 1e-6;
            let far = |k: usize| depths[k] > 0.008;
            for k in 0..3 {
                if near(k) && (0..3).all(|other| other == k || far(other)) {
                    assert!(normal[k] * off[k].signum() > 0.99, "{off} {normal:?}");
                    n_on_face[2 * k + usize::from(off[k] > 0.0)] += 1;
                }
            }
        }
        let [back_x, front_x, left, right, below, above] = n_on_face;
        // Seen from -x: that face, both sides, above and below, but not the far face.
        assert!(
            [back_x, left, right, above, below].iter().all(|&n| n > 5),
            "{n_on_face:?}"
        );
        assert_eq!(front_x, 0);
    }

    #[test]
    fn the_cameras_stand_on_the_side_asked_for() {
        let cloud = cloud_of(SCENE, Vector3::new(0.3, 0.0, 5.0));
        let n_on_face = |sign: f64| {
            let face = CENTRE[0] + sign * HALF[0];
            let on_face = |point: &&Point3<f64>| {
                (point.x - face).abs() < 1e-6 && (point.z - CENTRE[2]).abs() < 0.02
            };
            cloud.points().iter().filter(on_face).count()
        };
        assert_eq!(n_on_face(-1.0), 0);
        assert!(n_on_face(1.0) > 20);
    }

    #[test]
    fn a_region_that_is_hidden_gives_an_empty_cloud() {
        let cage = r#"<geom name="cage" type="sphere" size="0.2"/><geom name="post""#;
        let cloud = cloud_of(&SCENE.replace(r#"<geom name="post""#, cage), -Vector3::x());
        assert!(cloud.is_empty());
    }
}
