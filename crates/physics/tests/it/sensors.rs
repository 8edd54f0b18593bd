//! Rays, the depth camera and the planar lidar.

use approx::assert_relative_eq;
use factotum_physics::{
    BodyId, Model, PhysicsError, PinholeCamera, Pose, RayFilter, State, axes, depth_image,
    planar_scan,
};
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

const ROOM: &str = r#"<mujoco><worldbody>
  <geom name="floor" type="plane" size="5 5 1"/>
  <geom name="wall" type="box" pos="3 0 1" size=".1 4 1"/>
  <body name="post" pos="2 1 0.5"><geom name="post" type="cylinder" size=".2 .5" group="2"/></body>
  <body name="robot" pos="0 0 .2"><freejoint/>
    <geom name="hull" type="cylinder" size=".3 .2" mass="10"/>
    <body name="housing" pos="0 0 .1"><geom name="housing" size=".1" mass="1"/></body>
  </body>
  <body name="ghost" pos="1 0 .3"><geom name="ghost" size=".1" rgba="1 0 0 0"/></body>
</worldbody></mujoco>"#;

fn room() -> Result<(Model, State), PhysicsError> {
    let model = Model::from_mjcf_str(ROOM)?;
    let mut state = State::new(&model)?;
    state.forward_kinematics()?;
    Ok((model, state))
}

#[test]
fn rays_meet_the_nearest_visible_geom() -> Result<(), PhysicsError> {
    let (model, state) = room()?;
    let origin = Point3::new(0.0, 0.0, 0.3);
    let forward = Vector3::x();
    let inside = state
        .ray(origin, forward, &RayFilter::default())
        .expect("a hit");
    assert_eq!(inside.geom, model.geom("housing")?);
    let robot = [model.body("robot")?, model.body("housing")?];
    let hit = state
        .ray(origin, forward, &RayFilter::excluding(&robot))
        .expect("the wall");
    assert_eq!(hit.geom, model.geom("wall")?, "the ghost is not seen");
    assert_relative_eq!(hit.distance_m, 2.9, epsilon = 1e-9);
    assert_relative_eq!(hit.normal, -Vector3::x(), epsilon = 1e-9);
    assert!(
        state
            .ray(origin, Vector3::z(), &RayFilter::excluding(&robot))
            .is_none()
    );

    let towards_post = Vector3::new(2.0, 1.0, 0.0).normalize();
    let seen = state
        .ray(origin, towards_post, &RayFilter::excluding(&robot))
        .expect("the post");
    assert_eq!(seen.geom, model.geom("post")?);
    let mut filter = RayFilter::excluding(&robot);
    filter.groups[2] = false;
    let behind = state.ray(origin, towards_post, &filter).expect("the wall");
    assert_eq!(behind.geom, model.geom("wall")?);
    filter.sees_static = false;
    assert!(state.ray(origin, towards_post, &filter).is_none());
    Ok(())
}

#[test]
fn many_rays_are_as_one() -> Result<(), PhysicsError> {
    let (model, state) = room()?;
    let robot = [model.body("robot")?, model.body("housing")?];
    let origin = Point3::new(0.0, 0.0, 0.3);
    let directions: Vec<Vector3<f64>> = (0..500)
        .map(|i| {
            let (a, b) = (f64::from(i) * 0.37, f64::from(i) * 0.0061 - 1.5);
            Vector3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin())
        })
        .collect();
    for filter in [RayFilter::default(), RayFilter::excluding(&robot)] {
        let many = state.rays(origin, &directions, &filter, 20.0)?;
        for (direction, hit) in directions.iter().zip(many) {
            let one = state
                .ray(origin, *direction, &filter)
                .filter(|hit| hit.distance_m <= 20.0);
            assert_eq!(hit.map(|(_, geom)| geom), one.map(|one| one.geom));
            let (distance, expected) = (
                hit.map_or(0.0, |hit| hit.0),
                one.map_or(0.0, |one| one.distance_m),
            );
            assert_relative_eq!(distance, expected, epsilon = 1e-9);
        }
    }
    assert!(
        state
            .rays(origin, &[], &RayFilter::default(), 1.0)?
            .is_empty()
    );
    Ok(())
}

#[test]
fn a_depth_image_is_the_scene_and_its_geoms() -> Result<(), PhysicsError> {
    let (model, state) = room()?;
    let robot = [model.body("robot")?, model.body("housing")?];
    let camera = PinholeCamera::from_fovy(40, 30, 1.0)?;
    // Looking along +x, 0.5 m above the floor.
    let world_from_camera = Pose::translation(0.0, 0.0, 0.5);
    let optical = axes::world_from_optical_of_body_frame(&world_from_camera);
    let image = depth_image(&state, &camera, &optical, [0.2, 4.0], &robot)?;
    assert_eq!(image.depth_m.len(), 1200);
    let (wall, floor, post) = (
        model.geom("wall")?,
        model.geom("floor")?,
        model.geom("post")?,
    );
    let mut seen = [0; 3];
    for (i, point) in image.points_in_optical(&camera) {
        let geom = image.geom[i].expect("a return has a geom");
        let in_world = optical * point;
        // Depth is along the optical axis, and every point lies on its geom.
        if geom == wall {
            assert_relative_eq!(f64::from(image.depth_m[i]), 2.9, epsilon = 1e-5);
            seen[0] += 1;
        } else if geom == floor {
            assert_relative_eq!(in_world.z, 0.0, epsilon = 1e-5);
            seen[1] += 1;
        } else {
            assert_eq!(geom, post);
            let radius = (in_world.x - 2.0).hypot(in_world.y - 1.0);
            assert_relative_eq!(radius, 0.2, epsilon = 1e-5);
            // The post stands to the left, so in the left half of the image.
            assert!(i % 40 < 20);
            seen[2] += 1;
        }
    }
    assert!(seen.iter().all(|&n| n > 20), "{seen:?}");
    // Projection undoes the ray.
    let ray = camera.ray_in_optical(3.0, 7.0);
    let (column, row) = camera.pixel(&Point3::from(ray * 2.5)).expect("in front");
    assert_relative_eq!(column, 3.0, epsilon = 1e-9);
    assert_relative_eq!(row, 7.0, epsilon = 1e-9);
    assert!(camera.pixel(&Point3::new(0.0, 0.0, -1.0)).is_none());

    let near = depth_image(&state, &camera, &optical, [0.2, 2.0], &robot)?;
    assert!(near.geom.iter().flatten().all(|&geom| geom != wall));
    assert!(PinholeCamera::from_fovy(0, 30, 1.0).is_err());
    assert!(PinholeCamera::from_fovy(40, 30, 3.2).is_err());
    Ok(())
}

#[test]
fn a_scan_turns_counterclockwise_from_its_frame() -> Result<(), PhysicsError> {
    let (model, state) = room()?;
    let robot = [model.body("robot")?, model.body("housing")?];
    // The lidar looks along +y; its third ray, a quarter turn to the right, along +x.
    let world_from_lidar = Pose::from_parts(
        Translation3::new(0.0, 0.0, 0.5),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2),
    );
    let step = std::f64::consts::FRAC_PI_4;
    let ranges = planar_scan(
        &state,
        &world_from_lidar,
        -4.0 * step,
        step,
        8,
        [0.1, 12.0],
        &robot,
    )?;
    assert_relative_eq!(ranges[2], 2.9, epsilon = 1e-9);
    assert_eq!(ranges.iter().filter(|range| range.is_finite()).count(), 3);
    let short = planar_scan(
        &state,
        &world_from_lidar,
        -4.0 * step,
        step,
        8,
        [0.1, 2.0],
        &robot,
    )?;
    assert!(short.iter().all(|range| range.is_infinite()));
    let blocked = planar_scan(
        &state,
        &world_from_lidar,
        0.0,
        step,
        8,
        [0.1, 2.0],
        &[BodyId::WORLD],
    )?;
    assert!(
        blocked.iter().all(|range| range.is_infinite()),
        "too near is no return"
    );
    Ok(())
}

#[test]
fn a_starved_state_says_so_instead_of_seeing_nothing() -> Result<(), PhysicsError> {
    // Enough memory to compile and to step, not to sort so many geoms by angle.
    let geoms = "<geom size='.1'/>".repeat(8);
    let bodies: String = (0..50)
        .map(|i| format!("<body pos='{i} 5 0'>{geoms}</body>"))
        .collect();
    let xml = format!("<mujoco><size memory='6K'/><worldbody>{bodies}</worldbody></mujoco>");
    let model = Model::from_mjcf_str(&xml)?;
    let state = State::new(&model)?;
    let error = state.rays(
        Point3::origin(),
        &[Vector3::x()],
        &RayFilter::default(),
        9.0,
    );
    assert!(
        matches!(error, Err(PhysicsError::Engine { .. })),
        "{error:?}"
    );
    assert!(
        state
            .ray(Point3::origin(), Vector3::x(), &RayFilter::default())
            .is_none()
    );
    assert!(matches!(
        state.usable(),
        Err(PhysicsError::Discarded { .. })
    ));
    Ok(())
}

/// Primitives of all kinds with an end, strewn about.
fn clutter(seed: u64) -> Result<State, PhysicsError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut bodies = String::new();
    for kind in ["box", "sphere", "capsule", "cylinder", "ellipsoid"].repeat(8) {
        let mut draw = |low: f64, high: f64| rng.random_range(low..high);
        let place = [draw(-3.0, 3.0), draw(-3.0, 3.0), draw(0.0, 2.0)];
        let turn = [draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0), 0.4];
        let size = [draw(0.05, 1.0), draw(0.05, 0.5), draw(0.05, 0.5)];
        let [place, turn, size] = [&place[..], &turn[..], &size[..]]
            .map(|values| format!("{values:?}").replace(',', " "));
        let bare = |text: &str| text.trim_matches(['[', ']']).to_owned();
        bodies.push_str(&format!(
            "<geom type='{kind}' pos='{}' quat='{}' size='{}'/>",
            bare(&place),
            bare(&turn),
            bare(&size)
        ));
    }
    let model = Model::from_mjcf_str(&format!("<mujoco><worldbody>{bodies}</worldbody></mujoco>"))?;
    let mut state = State::new(&model)?;
    state.forward_kinematics()?;
    Ok(state)
}

#[test]
fn camera_and_lidar_see_what_single_rays_meet() -> Result<(), PhysicsError> {
    let filter = RayFilter::default();
    let mut n_seen = 0;
    for seed in 0..6 {
        let state = clutter(seed)?;
        let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
        // Some of these places are inside a geom.
        let at = Translation3::new(
            rng.random_range(-2.0..2.0),
            rng.random_range(-2.0..2.0),
            1.0,
        );
        let turn = UnitQuaternion::from_euler_angles(
            rng.random_range(-0.5..0.5),
            rng.random_range(-0.5..0.5),
            rng.random_range(-3.0..3.0),
        );
        let pose = Pose::from_parts(at, turn);
        let camera = PinholeCamera::from_fovy(44, 31, 1.2)?;
        let image = depth_image(&state, &camera, &pose, [0.1, 4.0], &[])?;
        for (i, (depth_m, geom)) in image.depth_m.iter().zip(&image.geom).enumerate() {
            let ray = camera.ray_in_optical((i % 44) as f64, (i / 44) as f64);
            let dir = pose.rotation * ray.normalize();
            let one = state
                .ray(Point3::from(at.vector), dir, &filter)
                .map(|hit| (hit.distance_m / ray.norm(), hit.geom))
                .filter(|(depth_m, _)| (0.1..=4.0).contains(depth_m));
            assert_eq!(*geom, one.map(|(_, geom)| geom), "pixel {i} of {seed}");
            let wanted_m = one.map_or(0.0, |(depth_m, _)| depth_m);
            assert_relative_eq!(f64::from(*depth_m), wanted_m, epsilon = 1e-6);
            n_seen += usize::from(one.is_some());
        }
        let ranges_m = planar_scan(&state, &pose, -1.0, 0.01, 300, [0.05, 5.0], &[])?;
        for (i, range_m) in (0..).zip(ranges_m) {
            let angle = -1.0 + 0.01 * f64::from(i);
            let dir = pose.rotation * Vector3::new(angle.cos(), angle.sin(), 0.0);
            let one = state
                .ray(Point3::from(at.vector), dir, &filter)
                .map(|hit| hit.distance_m)
                .filter(|distance_m| (0.05..=5.0).contains(distance_m))
                .unwrap_or(f64::INFINITY);
            assert!(
                range_m == one || (range_m - one).abs() < 1e-9,
                "{range_m} {one}"
            );
        }
    }
    assert!(n_seen > 2000, "{n_seen} pixels show something");
    Ok(())
}
