//! Poses, Jacobians, dynamics, contacts and snapshots.

use approx::assert_relative_eq;
use factotum_physics::{Model, PhysicsError, Pose, State};
use nalgebra::{DMatrix, DVector, Matrix6xX, Point3, UnitQuaternion, Vector3, Vector6};
use proptest::prelude::*;

use crate::models::ARM_AND_BALL;

/// A state with positions and velocities drawn from `seed`, as a test needs no distribution.
fn moved(model: &Model, seed: u64) -> Result<State, PhysicsError> {
    let mut state = State::new(model)?;
    let mut draw = seed;
    let mut next = || {
        // A linear congruential generator, Knuth's constants.
        draw = draw
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (draw >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    };
    let velocity: Vec<f64> = (0..model.n_v()).map(|_| next()).collect();
    let mut qpos = state.qpos().to_vec();
    state.integrate_positions(&mut qpos, &velocity, 0.9)?;
    state.qpos_mut().copy_from_slice(&qpos);
    for v in state.qvel_mut() {
        *v = next();
    }
    Ok(state)
}

/// The twist that leads from one pose to another in `dt`: linear then angular, in world axes.
fn twist(from: &Pose, to: &Pose, dt: f64) -> Vector6<f64> {
    let linear = (to.translation.vector - from.translation.vector) / dt;
    let angular = (to.rotation * from.rotation.inverse()).scaled_axis() / dt;
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// J v is the velocity of the site, by central differences, in a model with nq != nv.
    #[test]
    fn jacobians_match_finite_differences(seed in any::<u64>(), on_ball in any::<bool>()) {
        let model = Model::from_mjcf_str(ARM_AND_BALL).expect("valid");
        let mut state = moved(&model, seed).expect("valid");
        let site = model.site(if on_ball { "ball_mark" } else { "tcp" }).expect("there");
        state.dynamics().expect("sound");
        let mut jac = DMatrix::zeros(0, 0);
        state.site_jacobian_into(site, &mut jac);
        prop_assert_eq!(jac.shape(), (6, model.n_v()));
        // Some columns of it, in another order.
        let dofs: Vec<usize> = (0..model.n_v()).rev().step_by(2).collect();
        let mut columns = Matrix6xX::zeros(1);
        state.chain_jacobian_into(&model.site_chain(site, &dofs), &mut columns);
        prop_assert_eq!(DMatrix::from_fn(6, dofs.len(), |i, j| jac[(i, dofs[j])]), columns);
        let start = state.snapshot();
        let (linear, angular) = state.site_velocity(site);
        let velocity = DVector::from_column_slice(state.qvel());

        const H: f64 = 1e-5;
        let mut pose_at = |dt: f64| {
            state.restore(&start).expect("same model");
            let mut qpos = state.qpos().to_vec();
            let qvel = state.qvel().to_vec();
            state.integrate_positions(&mut qpos, &qvel, dt).expect("sizes");
            state.qpos_mut().copy_from_slice(&qpos);
            state.forward_kinematics().expect("sound");
            state.world_from_site(site)
        };
        let numeric = twist(&pose_at(-H), &pose_at(H), 2.0 * H);
        let analytic = &jac * &velocity;
        prop_assert!((&analytic - numeric).norm() < 1e-6, "{analytic} {numeric}");
        prop_assert!((linear - analytic.fixed_rows::<3>(0)).norm() < 1e-9);
        prop_assert!((angular - analytic.fixed_rows::<3>(3)).norm() < 1e-9);
    }

    /// M qacc + bias = forces, where nothing touches and nothing is damped.
    #[test]
    fn the_equation_of_motion_holds(seed in any::<u64>()) {
        let xml = ARM_AND_BALL
            .replace("damping=\"1\"", "")
            .replace("damping=\"20\"", "")
            .replace("damping=\"0.5\"", "")
            .replace("damping=\"0.3\"", "")
            .replace("<worldbody>", "<option><flag constraint=\"disable\"/></option><worldbody>");
        let model = Model::from_mjcf_str(&xml).expect("valid");
        let mut state = moved(&model, seed).expect("valid");
        state.ctrl_mut().copy_from_slice(&[4.0, -30.0]);
        state.dynamics().expect("sound");
        let mut mass = DMatrix::zeros(0, 0);
        state.mass_matrix_into(&mut mass);
        let dofs: Vec<usize> = (0..model.n_v()).rev().step_by(2).collect();
        let mut block = DMatrix::zeros(1, 1);
        let site = model.site("tcp").expect("there");
        state.chain_mass_into(&model.site_chain(site, &dofs), &mut block);
        let picked = DMatrix::from_fn(dofs.len(), dofs.len(), |i, j| mass[(dofs[i], dofs[j])]);
        prop_assert_eq!(picked, block);
        let bias = DVector::from_column_slice(state.bias_forces());
        state.forward().expect("sound");
        let residual = &mass * DVector::from_column_slice(state.qacc()) + &bias
            - DVector::from_column_slice(state.qfrc_actuator());
        prop_assert!(residual.norm() < 1e-8, "{residual}");
        // The cheap way gives what the whole computation gives.
        let mut mass_again = DMatrix::zeros(1, 1);
        state.mass_matrix_into(&mut mass_again);
        prop_assert!((mass - mass_again).norm() < 1e-12);
        prop_assert!((bias - DVector::from_column_slice(state.bias_forces())).norm() < 1e-12);
    }

    /// Gravity is the bias at zero velocity, and asking for it changes nothing.
    #[test]
    fn gravity_is_the_bias_at_rest(seed in any::<u64>()) {
        let model = Model::from_mjcf_str(ARM_AND_BALL).expect("valid");
        let mut state = moved(&model, seed).expect("valid");
        state.dynamics().expect("sound");
        let bias = state.bias_forces().to_vec();
        let before = state.snapshot();
        let gravity = state.gravity_forces().expect("sound");
        prop_assert_eq!(&before, &state.snapshot());
        prop_assert_eq!(&bias[..], state.bias_forces());
        state.qvel_mut().fill(0.0);
        state.dynamics().expect("sound");
        prop_assert!((gravity - DVector::from_column_slice(state.bias_forces())).norm() < 1e-12);
    }

    /// Positions to velocities and back, through free and ball joints.
    #[test]
    fn positions_differentiate_and_integrate(a in any::<u64>(), b in any::<u64>()) {
        let model = Model::from_mjcf_str(ARM_AND_BALL).expect("valid");
        let (state, other) = (moved(&model, a).expect("valid"), moved(&model, b).expect("valid"));
        let velocity =
            state.differentiate_positions(state.qpos(), other.qpos(), 0.5).expect("sizes");
        let mut qpos = state.qpos().to_vec();
        state.integrate_positions(&mut qpos, &velocity, 0.5).expect("sizes");
        let left = state.differentiate_positions(&qpos, other.qpos(), 1.0).expect("sizes");
        prop_assert!(DVector::from_vec(left).norm() < 1e-9);
    }

    /// A restored state steps to the same bits.
    #[test]
    fn snapshots_restore_every_bit(seed in any::<u64>(), n_before in 0_usize..60) {
        let model = Model::from_mjcf_str(ARM_AND_BALL).expect("valid");
        let mut state = moved(&model, seed).expect("valid");
        state.ctrl_mut()[0] = 5.0;
        let ball = model.body("ball").expect("there");
        state.xfrc_applied_mut(ball)[2] = 3.0;
        for _ in 0..n_before {
            state.step().expect("sound");
        }
        let snapshot = state.snapshot();
        let run = |state: &mut State| {
            for _ in 0..40 {
                state.step().expect("sound");
            }
            state.snapshot()
        };
        let first = run(&mut state);
        state.restore(&snapshot).expect("same model");
        prop_assert_eq!(&state.snapshot(), &snapshot);
        prop_assert_eq!(&run(&mut state), &first);
        let mut fresh = State::new(&model).expect("valid");
        fresh.restore(&snapshot).expect("same model");
        prop_assert_eq!(&run(&mut fresh), &first);
        let mut clone = state.try_clone().expect("memory");
        prop_assert_eq!(run(&mut clone), run(&mut state));
    }
}

/// Free joints: linear velocity in the world, angular velocity in the body.
#[test]
fn free_joint_velocities_are_as_documented() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(ARM_AND_BALL)?;
    let mut state = State::new(&model)?;
    let body = model.body("ball")?;
    let quarter = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    let placed = Pose::from_parts([0.0, 0.0, 5.0].into(), quarter);
    state.set_free_body_pose(body, &placed)?;
    state.qvel_mut()[..6].copy_from_slice(&[1.0, 2.0, 3.0, 0.0, 0.0, 4.0]);
    state.dynamics()?;
    let (linear, angular) = state.body_velocity(body);
    assert_relative_eq!(linear, Vector3::new(1.0, 2.0, 3.0), epsilon = 1e-12);
    // Turning about the body's z, which lies along −y of the world.
    assert_relative_eq!(angular, Vector3::new(0.0, -4.0, 0.0), epsilon = 1e-12);
    Ok(())
}

#[test]
fn cameras_look_along_their_optical_axis() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(
        r#"<mujoco><worldbody><camera name="up" pos="0 0 1" xyaxes="1 0 0 0 -1 0" fovy="60"/>
           <camera name="plain" pos="0 0 2"/></worldbody></mujoco>"#,
    )?;
    let mut state = State::new(&model)?;
    state.forward_kinematics()?;
    let plain = state.world_from_camera(model.camera("plain")?);
    // MuJoCo's camera looks down; image right is +x, image down is −y.
    assert_relative_eq!(plain * Vector3::z(), -Vector3::z(), epsilon = 1e-12);
    assert_relative_eq!(plain * Vector3::x(), Vector3::x(), epsilon = 1e-12);
    assert_relative_eq!(plain * Vector3::y(), -Vector3::y(), epsilon = 1e-12);
    let up = state.world_from_camera(model.camera("up")?);
    assert_relative_eq!(up * Vector3::z(), Vector3::z(), epsilon = 1e-12);
    assert_relative_eq!(
        model.camera_fovy_rad(model.camera("up")?),
        60_f64.to_radians(),
        epsilon = 1e-12
    );
    Ok(())
}

const RESTING: &str = r#"<mujoco><option cone="elliptic" impratio="10"/><worldbody>
  <geom name="floor" type="plane" size="1 1 1"/>
  <body name="box" pos="0 0 .1"><freejoint/>
    <geom name="box" type="box" size=".1 .1 .1" mass="3"/></body>
  <body name="ball" pos="0 0 .3"><freejoint/><geom name="ball" size=".1" mass="2"/></body>
</worldbody></mujoco>"#;

#[test]
fn contact_forces_carry_the_weight() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(RESTING)?;
    let mut state = State::new(&model)?;
    for _ in 0..2000 {
        state.step()?;
    }
    let (floor, cube, ball) = (
        model.geom("floor")?,
        model.geom("box")?,
        model.geom("ball")?,
    );
    let on_box = state.contact_force_between(&[floor], &[cube]);
    assert_relative_eq!(on_box, Vector3::new(0.0, 0.0, 5.0 * 9.81), epsilon = 0.01);
    assert_relative_eq!(
        state.contact_force_between(&[cube], &[floor]),
        -on_box,
        epsilon = 1e-12
    );
    let on_ball = state.contact_force_on(&[ball]);
    assert_relative_eq!(on_ball, Vector3::new(0.0, 0.0, 2.0 * 9.81), epsilon = 0.01);
    assert_relative_eq!(
        state.contact_force_on(&[cube]),
        Vector3::new(0.0, 0.0, 3.0 * 9.81),
        epsilon = 0.01
    );
    assert!(state.are_touching(&[ball], &[cube]));
    assert!(!state.are_touching(&[ball], &[floor]));
    let contact = state
        .contacts()
        .find(|contact| contact.geom_a == ball || contact.geom_b == ball)
        .expect("ball on box");
    assert_relative_eq!(contact.point, Point3::new(0.0, 0.0, 0.2), epsilon = 1e-3);
    assert_relative_eq!(contact.normal.z.abs(), 1.0, epsilon = 1e-6);
    assert!(state.contact_wrench(99).is_none());

    // Collision detection alone finds the contacts but no forces.
    let n = state.n_contacts();
    state.detect_collisions()?;
    assert_eq!(state.n_contacts(), n);
    assert_eq!(state.contact_force_on(&[ball]), Vector3::zeros());
    Ok(())
}

#[test]
fn geom_distances_are_signed() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(RESTING)?;
    let mut state = State::new(&model)?;
    let (floor, ball) = (model.geom("floor")?, model.geom("ball")?);
    state.forward_kinematics()?;
    assert_relative_eq!(
        state.geom_distance_m(floor, ball, 10.0)?,
        0.2,
        epsilon = 1e-9
    );
    assert_relative_eq!(
        state.geom_distance_m(floor, ball, 0.1)?,
        0.1,
        epsilon = 1e-9
    );
    state.qpos_mut()[9] = 0.07;
    state.forward_kinematics()?;
    assert_relative_eq!(
        state.geom_distance_m(floor, ball, 10.0)?,
        -0.03,
        epsilon = 1e-6
    );
    Ok(())
}

#[test]
fn halves_make_a_step_and_inverse_undoes_forward() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(ARM_AND_BALL)?;
    let (mut whole, mut halves) = (moved(&model, 7)?, moved(&model, 7)?);
    for _ in 0..50 {
        whole.ctrl_mut()[1] = 2.0;
        whole.step()?;
        halves.step1()?;
        halves.ctrl_mut()[1] = 2.0;
        halves.step2()?;
    }
    assert_eq!(whole.qpos(), halves.qpos());
    whole.forward()?;
    let forces: DVector<f64> = DVector::from_column_slice(whole.qfrc_actuator());
    whole.inverse()?;
    let found = DVector::from_column_slice(whole.qfrc_inverse());
    assert_relative_eq!(found, forces, epsilon = 1e-6);
    Ok(())
}

#[test]
fn foreign_snapshots_are_refused() -> Result<(), PhysicsError> {
    let arm = Model::from_mjcf_str(ARM_AND_BALL)?;
    let resting = Model::from_mjcf_str(RESTING)?;
    let snapshot = State::new(&resting)?.snapshot();
    let mut state = State::new(&arm)?;
    let error = state.restore(&snapshot).expect_err("another model");
    assert!(
        matches!(error, PhysicsError::SnapshotModel { .. }),
        "{error:?}"
    );
    // The same name is not the same model; the same text is.
    let longer = ARM_AND_BALL.replace(
        "</worldbody>",
        "<body><freejoint/><geom size='1'/></body></worldbody>",
    );
    let error = state.restore(&State::new(&Model::from_mjcf_str(&longer)?)?.snapshot());
    assert!(
        matches!(error, Err(PhysicsError::SnapshotModel { .. })),
        "{error:?}"
    );
    state.restore(&State::new(&Model::from_mjcf_str(ARM_AND_BALL)?)?.snapshot())?;
    let values = state.snapshot().values().to_vec();
    let again = factotum_physics::Snapshot::from_values(&arm, values.clone())?;
    state.restore(&again)?;
    assert!(factotum_physics::Snapshot::from_values(&arm, values[1..].to_vec()).is_err());
    Ok(())
}

#[test]
fn wrong_sizes_are_refused() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(ARM_AND_BALL)?;
    let state = State::new(&model)?;
    let error = state
        .differentiate_positions(&[0.0; 12], state.qpos(), 1.0)
        .expect_err("nv values for nq")
        .to_string();
    assert_eq!(error, "qpos has 12 values, expected 14");
    assert!(
        state
            .integrate_positions(&mut [0.0; 14], &[0.0; 14], 1.0)
            .is_err()
    );
    Ok(())
}
