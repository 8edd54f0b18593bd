//! Cost of what planning, control and sensing ask of a state.

use divan::{Bencher, black_box};
use factotum_physics::{
    Model, PinholeCamera, Pose, SceneBuilder, State, axes, depth_image, planar_scan,
};
use nalgebra::{DMatrix, Isometry3, Translation3, UnitQuaternion, Vector3};

/// A seven-joint arm of capsules between furniture of boxes.
fn arm_in_a_room() -> State {
    let mut body = String::new();
    for i in 0..7 {
        let axis = if i % 2 == 0 { "0 0 1" } else { "0 1 0" };
        body.push_str(&format!(
            "<body pos='0 0 .15'><joint name='j{i}' axis='{axis}' range='-2.5 2.5'/>\
             <geom type='capsule' fromto='0 0 .02 0 0 .13' size='.04'/>"
        ));
    }
    body.push_str("<site name='tcp' pos='0 0 .15'/>");
    body.push_str(&"</body>".repeat(7));
    let arm = format!("<mujoco><compiler angle='radian'/><worldbody>{body}</worldbody></mujoco>");
    let mut scene = SceneBuilder::new();
    scene.add_floor("floor", [1.0; 4]);
    for i in 0..30_u8 {
        let angle = f64::from(i) * 0.7;
        let far = 1.5 + f64::from(i) * 0.1;
        let at = Translation3::new(far * angle.cos(), far * angle.sin(), 0.4);
        let pose = Isometry3::from_parts(at, UnitQuaternion::from_euler_angles(0.0, 0.0, angle));
        scene.add_box(&format!("box {i}"), &pose, [0.2, 0.3, 0.4], [1.0; 4], true);
    }
    let at = factotum_physics::AttachPoint::World(Pose::translation(0.0, 0.0, 0.3));
    let plain = factotum_physics::AttachOptions::default();
    scene
        .attach_text("arm", &arm, "arm/", &at, &plain)
        .expect("valid");
    let model: Model = scene.compile().expect("valid");
    let mut state = State::new(&model).expect("memory");
    state.forward().expect("sound");
    state
}

#[divan::bench]
fn detect_collisions(bencher: Bencher<'_, '_>) {
    let mut state = arm_in_a_room();
    let mut turn = 0.0;
    bencher.bench_local(|| {
        turn += 0.1;
        state.qpos_mut().fill(f64::sin(turn));
        state.detect_collisions().expect("sound");
        black_box(state.n_contacts())
    });
}

#[divan::bench]
fn forward_kinematics_and_jacobian(bencher: Bencher<'_, '_>) {
    let mut state = arm_in_a_room();
    let tcp = state.model().site("arm/tcp").expect("there");
    let mut jac = DMatrix::zeros(6, 7);
    let mut turn = 0.0;
    bencher.bench_local(|| {
        turn += 0.1;
        state.qpos_mut().fill(f64::sin(turn));
        state.forward_kinematics().expect("sound");
        state.site_jacobian_into(tcp, &mut jac);
        black_box(&jac);
    });
}

#[divan::bench]
fn dynamics_and_mass_matrix(bencher: Bencher<'_, '_>) {
    let mut state = arm_in_a_room();
    let mut mass = DMatrix::zeros(7, 7);
    bencher.bench_local(|| {
        state.dynamics().expect("sound");
        state.mass_matrix_into(&mut mass);
        black_box(&mass);
    });
}

#[divan::bench]
fn depth_image_160_by_120(bencher: Bencher<'_, '_>) {
    let state = arm_in_a_room();
    let camera = PinholeCamera::from_fovy(160, 120, 1.0).expect("valid");
    let optical = axes::world_from_optical_of_body_frame(&Pose::translation(-0.5, 0.0, 1.0));
    bencher.bench_local(|| {
        black_box(depth_image(&state, &camera, &optical, [0.2, 5.0], &[]).expect("memory"))
    });
}

#[divan::bench]
fn planar_scan_of_360(bencher: Bencher<'_, '_>) {
    let state = arm_in_a_room();
    let lidar = Pose::from_parts(
        Translation3::new(-0.5, 0.0, 0.3),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.0),
    );
    let step = std::f64::consts::TAU / 360.0;
    bencher.bench_local(|| {
        black_box(planar_scan(&state, &lidar, 0.0, step, 360, [0.1, 12.0], &[]).expect("memory"))
    });
}

fn main() {
    divan::main();
}
