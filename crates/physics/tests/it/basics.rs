//! Models, names, errors, and that nothing ends the process.

use std::path::Path;

use factotum_physics::{BodyId, GeomShape, JointKind, Model, PhysicsError, State};

use crate::models::ARM_AND_BALL;

fn send<T: Send>() {}
fn send_and_sync<T: Send + Sync>() {}

#[test]
fn states_move_between_threads_and_models_are_shared() {
    send::<State>();
    send_and_sync::<Model>();
    send_and_sync::<PhysicsError>();
}

#[test]
fn a_model_tells_what_it_has() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(ARM_AND_BALL)?;
    assert_eq!((model.n_q(), model.n_v(), model.n_u()), (14, 12, 2));
    assert_eq!(
        model
            .joints()
            .map(|joint| model.joint_kind(joint))
            .collect::<Vec<_>>(),
        [
            JointKind::Free,
            JointKind::Hinge,
            JointKind::Slide,
            JointKind::Ball,
            JointKind::Hinge
        ]
    );
    let wrist = model.joint("wrist")?;
    assert_eq!((model.qpos_adr(wrist), model.dof_adr(wrist)), (13, 11));
    assert_eq!(model.joint_range(wrist), None);
    assert_eq!(model.joint_range(model.joint("lift")?), Some([-0.5, 0.5]));
    let hand = model.body("hand")?;
    assert_eq!(model.body_name(hand), "hand");
    assert_eq!(model.body_parent(hand), Some(model.body("fore")?));
    assert_eq!(model.body_parent(BodyId::WORLD), None);
    let upper = model.body("upper")?;
    let below: Vec<&str> = model
        .bodies_of_subtree(upper)
        .into_iter()
        .map(|body| model.body_name(body))
        .collect();
    assert_eq!(below, ["upper", "fore", "hand"]);
    assert_eq!(model.geoms_of_subtree(upper).len(), 3);
    assert_eq!(model.geom_body(model.geom("hand")?), hand);
    assert_eq!(
        model.geom_shape(model.geom("hand")?),
        GeomShape::Box {
            half: [0.05, 0.06, 0.07]
        }
    );
    assert_eq!(
        model.geom_shape(model.geom("upper")?),
        GeomShape::Capsule { r: 0.05, half: 0.2 }
    );
    assert_eq!(model.geom_contact_bits(model.geom("ghost")?), (0, 0));
    assert!(!model.geom_collides(model.geom("ghost")?));
    let lift = model.actuator("lift")?;
    assert_eq!(model.actuator_ctrl_range(lift), Some([-100.0, 100.0]));
    assert_eq!(model.actuator_joint(lift), Some(model.joint("lift")?));
    Ok(())
}

#[test]
fn an_unknown_name_lists_the_known_ones() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(ARM_AND_BALL)?;
    let error = model.joint("elbow").expect_err("no such joint").to_string();
    assert_eq!(
        error,
        "joint `elbow` is not in model `arm and ball`; \
         available: `ball`, `shoulder`, `lift`, `swivel`, `wrist`"
    );
    assert!(
        model.site("").is_err(),
        "an unnamed part is not found by the empty name"
    );
    assert!(model.keyframe("home").is_err());
    Ok(())
}

#[test]
fn broken_models_are_errors_that_say_where() {
    for (xml, expected) in [
        (
            "<mujoco><worldbody><geom size='1'></worldbody></mujoco>",
            "line 1 ",
        ),
        (
            "<mujoco><worldbody><gem size='1'/></worldbody></mujoco>",
            "gem",
        ),
        (
            "<mujoco><worldbody><geom type='box' size='1'/></worldbody></mujoco>",
            "size",
        ),
        (
            "<mujoco><worldbody><body name='b'><joint/></body></worldbody></mujoco>",
            "mass and inertia",
        ),
        (
            "<mujoco><asset><mesh name='m' file='absent.stl'/></asset></mujoco>",
            "absent.stl",
        ),
        ("not xml at all", "XML"),
        ("", ""),
        ("<mujoco>\0</mujoco>", "NUL"),
    ] {
        let error = Model::from_mjcf_str(xml).expect_err(xml).to_string();
        assert!(error.contains(expected), "{xml}: {error}");
    }
    let absent = Path::new("absent/model.xml");
    let error = Model::from_mjcf_file(absent)
        .expect_err("absent file")
        .to_string();
    assert!(
        error.contains("absent/model.xml") && error.contains("No such file"),
        "{error}"
    );
}

const STARVED: &str = r#"<mujoco><size memory="3K"/><worldbody>
    <geom type="plane" size="1 1 1"/>
    <body pos="0 0 0.09"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
</worldbody></mujoco>"#;

#[test]
fn a_starved_model_is_an_error_not_an_exit() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(STARVED)?;
    let mut state = State::new(&model)?;
    let error = (0..10).find_map(|_| state.step().err());
    let Some(PhysicsError::Engine { call, message }) = error else {
        panic!("expected an engine error, found {error:?}");
    };
    assert_eq!(call, "mj_step");
    assert!(message.contains("stack overflow"), "{message}");
    // The state is lost and says so; reading it is still safe.
    for result in [
        state.step(),
        state.reset(),
        state.forward(),
        state.forward_kinematics(),
    ] {
        assert!(
            matches!(result, Err(PhysicsError::Discarded { .. })),
            "{result:?}"
        );
    }
    assert_eq!(state.contacts().count(), 0);
    assert_eq!(state.qpos().len(), 7);
    assert!(state.try_clone().is_err());
    // Its model and other states live on.
    let mut other = State::new(&model)?;
    other.forward_kinematics()?;
    Ok(())
}

#[test]
fn starved_states_fail_alone_on_every_thread() -> Result<(), PhysicsError> {
    let starved = Model::from_mjcf_str(STARVED)?;
    let sound = Model::from_mjcf_str(ARM_AND_BALL)?;
    let reference = stepped(&sound, 300)?;
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|i| {
                let (starved, sound) = (&starved, &sound);
                let reference = &reference;
                scope.spawn(move || -> Result<(), PhysicsError> {
                    for _ in 0..10 {
                        if i % 2 == 0 {
                            let mut state = State::new(starved)?;
                            assert!((0..10).any(|_| state.step().is_err()));
                        } else {
                            assert_eq!(&stepped(sound, 300)?, reference);
                            let own = Model::from_mjcf_str(ARM_AND_BALL)?;
                            assert_eq!(&stepped(&own, 300)?, reference);
                        }
                    }
                    Ok(())
                })
            })
            .collect();
        threads
            .into_iter()
            .try_for_each(|thread| thread.join().expect("no panic"))
    })
}

fn stepped(model: &Model, n: usize) -> Result<Vec<f64>, PhysicsError> {
    let mut state = State::new(model)?;
    state.ctrl_mut().copy_from_slice(&[3.0, -2.0]);
    for _ in 0..n {
        state.step()?;
    }
    Ok(state.qpos().to_vec())
}

#[test]
fn bad_numbers_are_errors_that_name_their_joint() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(ARM_AND_BALL)?;
    let mut state = State::new(&model)?;
    let start = state.snapshot();

    state.set_joint_position(model.joint("wrist")?, f64::NAN);
    let error = state.step().expect_err("NaN in qpos").to_string();
    assert_eq!(
        error,
        "bad number in qpos of joint `wrist` at 0 s; reset or restore the state"
    );
    assert!(state.forward_kinematics().is_err());
    assert!(state.detect_collisions().is_err());
    assert!(state.dynamics().is_err());
    assert!(state.qpos()[13].is_nan(), "nothing is silently reset");

    state.restore(&start)?;
    state.qvel_mut()[7] = f64::INFINITY;
    let error = state.step().expect_err("infinite qvel").to_string();
    assert!(error.contains("qvel of joint `lift`"), "{error}");

    state.restore(&start)?;
    state.qfrc_applied_mut()[6] = 1e300;
    let error = (0..3)
        .find_map(|_| state.step().err())
        .expect("huge force")
        .to_string();
    assert!(error.contains("qacc of joint `shoulder`"), "{error}");

    state.restore(&start)?;
    state.ctrl_mut()[1] = f64::NAN;
    let error = state.step().expect_err("NaN in ctrl").to_string();
    assert!(error.contains("ctrl of actuator `lift`"), "{error}");

    state.reset()?;
    state.step()?;
    Ok(())
}

#[test]
fn dropped_contacts_are_an_error() -> Result<(), PhysicsError> {
    // Enough memory for the engine, not for so many contacts.
    let balls: String = (0..40)
        .map(|i| {
            format!(
                "<body pos='{} 0 0.09'><freejoint/><geom size='.1'/></body>",
                f64::from(i) * 0.15
            )
        })
        .collect();
    let xml = format!(
        "<mujoco><size memory='70K'/><worldbody><geom type='plane' size='9 9 1'/>{balls}\
         </worldbody></mujoco>"
    );
    let model = Model::from_mjcf_str(&xml)?;
    let mut state = State::new(&model)?;
    let error = state.step().expect_err("too little memory");
    assert!(
        matches!(
            error,
            PhysicsError::Full { .. } | PhysicsError::Engine { .. }
        ),
        "{error:?}"
    );
    Ok(())
}

#[test]
fn no_log_file_is_left_behind() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(STARVED)?;
    let mut state = State::new(&model)?;
    assert!((0..10).any(|_| state.step().is_err()));
    let mut bad = State::new(&Model::from_mjcf_str(ARM_AND_BALL)?)?;
    bad.qpos_mut()[0] = f64::NAN;
    assert!(bad.step().is_err());
    assert!(!Path::new("MUJOCO_LOG.TXT").exists());
    Ok(())
}

#[test]
fn an_edited_copy_leaves_the_model_alone() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(ARM_AND_BALL)?;
    let ball = model.geom("ball")?;
    let edited = model.edited(|edit| {
        edit.set_timestep_secs(0.001)?;
        edit.set_geom_friction(ball, [0.1, 0.01, 0.001]);
        edit.disable_geom_contacts(ball);
        Ok(())
    })?;
    assert_eq!(edited.timestep_secs(), 0.001);
    assert_eq!(edited.geom_friction(ball), [0.1, 0.01, 0.001]);
    assert!(!edited.geom_collides(ball));
    assert_eq!(model.timestep_secs(), 0.002);
    assert!(model.geom_collides(ball));
    assert!(model.edited(|edit| edit.set_timestep_secs(0.0)).is_err());
    let mut state = State::new(&edited)?;
    for _ in 0..2000 {
        state.step()?;
    }
    assert!(state.qpos()[2] < 0.0, "the ball falls through the floor");
    Ok(())
}
