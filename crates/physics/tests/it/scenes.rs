//! Composition of parts, ours and other people's.

use std::path::Path;

use approx::assert_relative_eq;
use factotum_physics::{
    AttachOptions, AttachPoint, JointKind, Model, Motion, NewActuator, NewSite, Part, PhysicsError,
    Pose, Primitive, SceneBuilder, Servo, Shape, State,
};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::models::of_wheel;

const TURRET: &str = r#"<mujoco model="turret">
  <compiler angle="degree"/>
  <default><geom rgba="1 0 0 1" mass="2"/></default>
  <worldbody>
    <body name="mast" pos="0 0 1" euler="0 0 90">
      <joint name="pan" axis="0 0 1" range="-90 90"/>
      <geom name="mast" type="capsule" size=".05 .2"/>
      <site name="top" pos="0.1 0 0.3"/>
    </body>
  </worldbody>
  <actuator><motor name="pan" joint="pan" ctrlrange="-5 5"/></actuator>
</mujoco>"#;

const TOOL: &str = r#"<mujoco model="tool">
  <compiler angle="radian"/>
  <option timestep="0.01"/>
  <default><geom rgba="0 1 0 1" mass="0.5"/></default>
  <worldbody>
    <body name="mast"><joint name="pan" axis="1 0 0" range="-1.5 1.5"/>
      <geom name="mast" type="box" size=".1 .1 .1"/><site name="tip" pos="0 0 0.2"/></body>
  </worldbody>
</mujoco>"#;

fn pose(x: f64, y: f64, z: f64, yaw: f64) -> Pose {
    Pose::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw),
    )
}

fn world(x: f64, y: f64, z: f64, yaw: f64) -> AttachPoint {
    AttachPoint::World(pose(x, y, z, yaw))
}

/// The turret `a/` in the world.
fn turret() -> Result<SceneBuilder, PhysicsError> {
    let mut scene = SceneBuilder::new();
    let at = world(1.0, 2.0, 0.0, 0.5);
    scene.attach_text("turret", TURRET, "a/", &at, &AttachOptions::default())?;
    Ok(scene)
}

/// The turret, and the tool `b/` above a site.
fn turret_with_tool(site: &str) -> Result<SceneBuilder, PhysicsError> {
    let mut scene = turret()?;
    let at = AttachPoint::Frame {
        name: site.to_owned(),
        offset: pose(0.0, 0.0, 0.1, 0.0),
    };
    scene.attach_text("tool", TOOL, "b/", &at, &AttachOptions::default())?;
    Ok(scene)
}

/// Two parts with the same inner names, other angle units, other defaults.
#[test]
fn parts_keep_their_own_settings_and_chain_by_sites() -> Result<(), PhysicsError> {
    let scene = turret_with_tool("a/top")?;
    let model = scene.compile()?;

    assert_relative_eq!(model.timestep_secs(), 0.002);
    let pan = model.joint_range(model.joint("a/pan")?).expect("limited");
    assert_relative_eq!(pan[1], 90_f64.to_radians(), epsilon = 1e-9);
    assert_relative_eq!(
        model.joint_range(model.joint("b/pan")?).expect("limited")[1],
        1.5
    );
    assert_relative_eq!(model.body_mass(model.body("a/mast")?), 2.0, epsilon = 1e-9);
    assert_relative_eq!(model.body_mass(model.body("b/mast")?), 0.5, epsilon = 1e-9);
    assert_eq!(model.geom_rgba(model.geom("b/mast")?), [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(
        model.actuator_ctrl_range(model.actuator("a/pan")?),
        Some([-5.0, 5.0])
    );

    let mut state = State::new(&model)?;
    state.forward_kinematics()?;
    let mast = pose(1.0, 2.0, 0.0, 0.5) * pose(0.0, 0.0, 1.0, 90_f64.to_radians());
    let tip = mast * pose(0.1, 0.0, 0.3, 0.0) * pose(0.0, 0.0, 0.1, 0.0) * pose(0.0, 0.0, 0.2, 0.0);
    assert_relative_eq!(
        state.world_from_body(model.body("a/mast")?),
        mast,
        epsilon = 1e-12
    );
    assert_relative_eq!(
        state.world_from_site(model.site("b/tip")?),
        tip,
        epsilon = 1e-12
    );
    Ok(())
}

#[test]
fn clashing_names_are_an_error_that_names_them() -> Result<(), PhysicsError> {
    let mut scene = turret()?;
    let elsewhere = world(3.0, 0.0, 0.0, 0.0);
    scene.attach_text(
        "turret",
        TURRET,
        "a/",
        &elsewhere,
        &AttachOptions::default(),
    )?;
    let error = scene.compile().expect_err("two parts with one prefix");
    assert!(error.to_string().contains("repeated name 'a/"), "{error}");
    Ok(())
}

#[test]
fn an_absent_site_is_an_error_that_lists_the_sites() -> Result<(), PhysicsError> {
    let scene = turret_with_tool("a/flange")?;
    let error = scene.compile().expect_err("no such site").to_string();
    assert!(
        error.contains("`a/flange`") && error.contains("`a/top`"),
        "{error}"
    );
    Ok(())
}

#[test]
fn names_are_escaped() -> Result<(), PhysicsError> {
    let name = r#"Bob's "5 < 6" & co é"#;
    let mut scene = SceneBuilder::new();
    scene.add_box(name, &pose(0.0, 0.0, 1.0, 0.0), [0.1; 3], [1.0; 4], true);
    let model = scene.compile()?;
    assert_eq!(model.geom_name(model.geom(name)?), name);
    assert_eq!(model.body_name(model.body(name)?), name);
    Ok(())
}

#[test]
fn shapes_move_as_they_are_told() -> Result<(), PhysicsError> {
    let shape = |name: &str, motion, z| Shape {
        name: name.to_owned(),
        primitive: Primitive::Sphere { r: 0.1 },
        world_from_shape: pose(0.0, 0.0, z, 0.0),
        rgba: [1.0; 4],
        collides: true,
        motion,
    };
    let mut scene = SceneBuilder::new();
    scene.add_floor("floor", [0.5; 4]);
    scene.add_shape(shape("fixed", Motion::Fixed, 5.0));
    scene.add_shape(shape("free", Motion::Free { mass_kg: 0.3 }, 1.0));
    scene.add_shape(shape("moved", Motion::Mocap, 3.0));
    let model = scene.compile()?;
    let mut state = State::new(&model)?;
    let (fixed, free, moved) = (
        model.body("fixed")?,
        model.body("free")?,
        model.body("moved")?,
    );
    assert_relative_eq!(model.body_mass(free), 0.3, epsilon = 1e-12);
    let target = pose(1.0, 2.0, 3.0, 0.4);
    state.set_mocap(moved, &target)?;
    assert!(state.set_mocap(free, &target).is_err());
    for _ in 0..1000 {
        state.step()?;
    }
    assert_relative_eq!(state.world_from_body(moved), target, epsilon = 1e-12);
    assert_relative_eq!(state.world_from_body(fixed).translation.z, 5.0);
    assert_relative_eq!(
        state.world_from_body(free).translation.z,
        0.1,
        epsilon = 1e-2
    );
    Ok(())
}

#[test]
fn free_parts_fall_and_can_be_placed() -> Result<(), PhysicsError> {
    let mug = r#"<mujoco model="mug"><worldbody><body name="mug">
        <geom name="cup" type="cylinder" size=".04 .05" mass="0.3"/></body></worldbody></mujoco>"#;
    let mut scene = SceneBuilder::new();
    let free = AttachOptions {
        free: true,
        ..AttachOptions::default()
    };
    scene.attach_text("mug", mug, "mug_1/", &world(0.0, 0.0, 2.0, 0.3), &free)?;
    let model = scene.compile()?;
    let joint = model.joint("mug_1/mug_free")?;
    assert_eq!(model.joint_kind(joint), JointKind::Free);
    let body = model.body("mug_1/mug")?;
    let mut state = State::new(&model)?;
    state.forward_kinematics()?;
    assert_relative_eq!(
        state.world_from_body(body),
        pose(0.0, 0.0, 2.0, 0.3),
        epsilon = 1e-12
    );
    let placed = pose(1.0, -1.0, 4.0, -2.0);
    state.set_free_body_pose(body, &placed)?;
    state.forward_kinematics()?;
    assert_relative_eq!(state.world_from_body(body), placed, epsilon = 1e-12);
    state.step()?;
    assert!(state.qvel()[model.dof_adr(joint) + 2] < 0.0);
    Ok(())
}

#[test]
fn actuators_and_sites_are_added_to_parts() -> Result<(), PhysicsError> {
    let actuator = |name: &str, servo| NewActuator {
        name: name.to_owned(),
        joint: "pan".to_owned(),
        servo,
        ctrl_range: Some([-1.0, 1.0]),
        force_range: Some([-20.0, 20.0]),
    };
    let options = AttachOptions {
        actuators: vec![
            actuator("torque", Servo::Motor),
            actuator(
                "position",
                Servo::Position {
                    kp: 100.0,
                    kv: 10.0,
                },
            ),
            actuator("velocity", Servo::Velocity { kv: 5.0 }),
        ],
        sites: vec![NewSite {
            name: "tcp".into(),
            body: "mast".into(),
            body_from_site: pose(0.0, 0.0, 0.5, 0.0),
        }],
        ..AttachOptions::default()
    };
    let mut scene = SceneBuilder::new();
    scene.attach_text("tool", TOOL, "b/", &world(0.0, 0.0, 1.0, 0.0), &options)?;
    let model = scene.compile()?;
    let position = model.actuator("b/position")?;
    assert_eq!(model.actuator_joint(position), Some(model.joint("b/pan")?));
    assert_eq!(model.actuator_ctrl_range(position), Some([-1.0, 1.0]));
    assert_eq!(model.actuator_force_range(position), Some([-20.0, 20.0]));
    let mut state = State::new(&model)?;
    state.set_ctrl(position, 0.4);
    for _ in 0..5000 {
        state.step()?;
    }
    // The velocity servo holds back while it moves only. The gains are stiff for so light a body:
    // an explicit integrator would not settle.
    assert_relative_eq!(
        state.joint_position(model.joint("b/pan")?),
        0.4,
        epsilon = 1e-3
    );
    assert_relative_eq!(
        (state
            .world_from_site(model.site("b/tcp")?)
            .translation
            .vector
            - Vector3::new(0.0, 0.0, 1.0))
        .norm(),
        0.5,
        epsilon = 1e-9
    );

    let absent = AttachOptions {
        actuators: vec![NewActuator {
            joint: "tilt".into(),
            ..actuator("x", Servo::Motor)
        }],
        ..AttachOptions::default()
    };
    let error = scene
        .attach_text("tool", TOOL, "c/", &world(0.0, 0.0, 1.0, 0.0), &absent)
        .expect_err("no joint `tilt`")
        .to_string();
    assert!(
        error.contains("`tilt`") && error.contains("`pan`"),
        "{error}"
    );
    Ok(())
}

#[test]
fn the_composed_text_compiles_to_the_same_model() -> Result<(), PhysicsError> {
    let scene = turret_with_tool("a/top")?;
    let direct = scene.compile()?;
    let text = Model::from_mjcf_str(&scene.xml()?)?;
    assert_eq!(direct.joint_names(), text.joint_names());
    assert_eq!(direct.n_geoms(), text.n_geoms());
    Ok(())
}

#[test]
fn a_part_may_hang_on_a_body() -> Result<(), PhysicsError> {
    let plain = AttachOptions::default();
    let on = |frame: &str| -> Result<SceneBuilder, PhysicsError> {
        let mut scene = SceneBuilder::new();
        scene.attach_text("turret", TURRET, "a/", &world(0.0, 0.0, 0.0, 0.0), &plain)?;
        let at = AttachPoint::Frame {
            name: frame.into(),
            offset: pose(0.1, 0.0, 0.2, 0.0),
        };
        scene.attach_text("tool", TOOL, "b/", &at, &plain)?;
        Ok(scene)
    };
    // The mast stands 1 m high, turned by 90 degrees.
    let model = on("a/mast")?.compile()?;
    let mut state = State::new(&model)?;
    state.forward_kinematics()?;
    let tool = state
        .world_from_body(model.body("b/mast")?)
        .translation
        .vector;
    assert_relative_eq!(tool, Vector3::new(0.0, 0.1, 1.2), epsilon = 1e-9);
    let error = on("a/mist")?.compile().unwrap_err().to_string();
    assert!(error.contains("site or body `a/mist`"), "{error}");
    Ok(())
}

#[test]
fn without_visuals_masses_are_the_same() -> Result<(), PhysicsError> {
    const CLOAKED: &str = r#"<mujoco><worldbody><body name="cloaked"><joint name="hinge"/>
        <geom size=".1" mass="1"/><geom size=".2" mass="2" contype="0" conaffinity="0"/>
        </body></worldbody></mujoco>"#;
    let compiled = |visuals: bool| -> Result<Model, PhysicsError> {
        let mut scene = SceneBuilder::new();
        scene.visuals(visuals);
        let plain = AttachOptions::default();
        scene.attach_text("cloaked", CLOAKED, "", &world(0.0, 0.0, 0.0, 0.0), &plain)?;
        scene.compile()
    };
    let (with, without) = (compiled(true)?, compiled(false)?);
    assert_eq!((with.n_geoms(), without.n_geoms()), (2, 1));
    for model in [with, without] {
        assert_relative_eq!(model.body_mass(model.body("cloaked")?), 3.0);
    }
    Ok(())
}

/// The robosuite wheel's own arms, unchanged, on a base of ours.
#[test]
fn robosuite_arms_attach_unchanged() -> Result<(), PhysicsError> {
    let Some(dir) = of_wheel("FACTOTUM_ROBOSUITE_DIR", "robosuite/robosuite") else {
        return Ok(());
    };
    for (robot, n_joints, n_meshes) in [("panda", 7, 1), ("iiwa", 7, 1), ("jaco", 7, 1)] {
        let file = dir
            .join("models/assets/robots")
            .join(robot)
            .join("robot.xml");
        let mut scene = SceneBuilder::new();
        scene.attach_text(
            "base",
            r#"<mujoco><worldbody><body name="base"><joint name="x" type="slide" axis="1 0 0"/>
               <geom type="box" size=".3 .3 .1" mass="50"/><site name="mount" pos="0 0 .1"/>
               </body></worldbody></mujoco>"#,
            "",
            &world(0.0, 0.0, 0.5, 0.0),
            &AttachOptions::default(),
        )?;
        let part = Part {
            file: file.clone(),
            prefix: "arm/".into(),
        };
        let at = AttachPoint::Frame {
            name: "mount".into(),
            offset: pose(0.0, 0.0, 0.01, 0.7),
        };
        scene.attach(&part, &at, false)?;
        let model = scene.compile()?;
        assert!(scene.xml()?.contains("arm/"));
        let alone = Model::from_mjcf_file(&file)?;
        assert_eq!(model.n_v(), n_joints + 1, "{robot}");
        for body in alone.body_names().iter().skip(1) {
            let attached = model.body(&format!("arm/{body}"))?;
            assert_relative_eq!(
                model.body_mass(attached),
                alone.body_mass(alone.body(body)?),
                epsilon = 1e-12
            );
        }
        let meshes = model
            .geoms()
            .filter(|&geom| {
                matches!(
                    model.geom_shape(geom),
                    factotum_physics::GeomShape::Mesh { .. }
                )
            })
            .count();
        assert!(meshes >= n_meshes, "{robot}: {meshes}");
        let mut state = State::new(&model)?;
        for _ in 0..100 {
            state.step()?;
        }
    }
    Ok(())
}

/// Positions of the door scene 200 steps after its keyframe `home`, by the Python package
/// `mujoco==3.17.0`: `mj_resetDataKeyframe(m, d, 0)`, then `mj_step` 200 times.
const DOOR_AFTER_200_STEPS: [f64; 10] = [
    8.953826997296519e-09,
    0.5511937522743117,
    1.254639906177478e-07,
    -2.70795030638599,
    5.922196564129884e-08,
    3.128108741219877,
    0.7853981673286949,
    0.0012265199257516636,
    -0.0012263438130909123,
    0.0,
];

/// The robosuite door model loads and steps as MuJoCo alone does it, and attached keeps its masses
/// (which hang on `inertiagrouprange`, a compiler setting of the part).
#[test]
fn the_robosuite_door_has_its_masses() -> Result<(), PhysicsError> {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/robosuite_door/door.xml");
    if !file.is_file() {
        println!("skipped: {} is absent", file.display());
        return Ok(());
    }
    let model = Model::from_mjcf_file(&file)?;
    let mut scene = SceneBuilder::new();
    scene.attach(
        &Part {
            file,
            prefix: "rig/".into(),
        },
        &world(0.0, 0.0, 0.0, 0.0),
        false,
    )?;
    let attached = scene.compile()?;
    let mut state = State::new(&model)?;
    state.reset_to_keyframe(model.keyframe("home")?)?;
    for _ in 0..200 {
        state.step()?;
    }
    for (found, expected) in state.qpos().iter().zip(DOOR_AFTER_200_STEPS) {
        // Room for another processor's instructions.
        assert_relative_eq!(*found, expected, epsilon = 1e-6);
    }
    for (name, mass_kg) in [
        ("Door_door", 2.43455),
        ("Door_frame", 7.85398),
        ("robot0_link0", 4.0),
    ] {
        assert_relative_eq!(model.body_mass(model.body(name)?), mass_kg, epsilon = 1e-9);
    }
    for body in model.bodies().skip(1) {
        let name = model.body_name(body);
        assert_relative_eq!(
            attached.body_mass(attached.body(&format!("rig/{name}"))?),
            model.body_mass(body),
            epsilon = 1e-12
        );
    }
    Ok(())
}
