//! URDF rewriting and self-collision pairs.

use std::fs;
use std::path::Path;

use approx::assert_relative_eq;
use factotum_physics::{
    AttachOptions, AttachPoint, GeomShape, Model, NewActuator, PairKind, Part, PhysicsError, Pose,
    SceneBuilder, Servo, State, UrdfOptions, self_collision_pairs, urdf_to_mjcf,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;

use crate::models::of_wheel;

/// A tetrahedron, as ASCII OBJ.
const TETRAHEDRON: &str =
    "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn urdf(mesh: &str, extra: &str) -> String {
    format!(
        r#"<?xml version="1.0"?>
<robot name="two_link">
  {extra}
  <link name="base"><collision><geometry><box size=".2 .2 .1"/></geometry></collision>
    <inertial><mass value="4"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm">
    <visual><geometry><mesh filename="{mesh}"/></geometry></visual>
    <collision><geometry><cylinder radius=".03" length=".3"/></geometry></collision>
    <inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tool"><inertial><mass value=".2"/>
    <inertia ixx=".001" iyy=".001" izz=".001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="0 0 .3"/><axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="7" velocity="1"/></joint>
  <joint name="flange" type="fixed"><parent link="arm"/><child link="tool"/>
    <origin xyz="0 0 .2"/></joint>
</robot>"#
    )
}

/// A package folder with a mesh, and the URDF two folders down.
fn package(mesh: &str, extra: &str) -> std::io::Result<(tempfile::TempDir, std::path::PathBuf)> {
    let dir = tempfile::tempdir()?;
    let root = dir.path().join("two_link_description");
    fs::create_dir_all(root.join("meshes/visual"))?;
    fs::create_dir_all(root.join("urdf"))?;
    fs::write(root.join("meshes/visual/arm & hand.obj"), TETRAHEDRON)?;
    fs::write(root.join("meshes/arm.dae"), "<COLLADA/>")?;
    let file = root.join("urdf/robot.urdf");
    fs::write(&file, urdf(mesh, extra))?;
    Ok((dir, file))
}

const MESH: &str = "package://two_link_description/meshes/visual/arm &amp; hand.obj";

fn check_whole(model: &Model) -> Result<(), PhysicsError> {
    // Nothing fused, nothing visual dropped.
    assert_eq!(model.n_v(), 1);
    assert_relative_eq!(model.body_mass(model.body("tool")?), 0.2);
    let arm = model.body("arm")?;
    assert_eq!(model.geoms_of_body(arm).len(), 2, "visual and collision");
    let range = model.joint_range(model.joint("shoulder")?);
    assert_eq!(range, Some([-1.0, 2.0]));
    Ok(())
}

#[test]
fn packages_are_found_above_the_file() -> Result<(), Box<dyn std::error::Error>> {
    for extra in [
        "",
        r#"<mujoco><compiler fusestatic="true" strippath="true" discardvisual="true" balanceinertia="true"/></mujoco>"#,
        r#"<mujoco><option timestep="0.001"/></mujoco>"#,
        r#"<mujoco/>"#,
    ] {
        let (_dir, file) = package(MESH, extra)?;
        let xml = urdf_to_mjcf(&file, &UrdfOptions::default())?;
        check_whole(&Model::from_mjcf_str(&xml).map_err(|error| format!("{extra}: {error}"))?)?;
    }
    Ok(())
}

/// `visual/arm.obj` and `collision/arm.obj` are two meshes, and so are two scales of one file.
#[test]
fn meshes_with_the_same_stem_stay_apart() -> Result<(), Box<dyn std::error::Error>> {
    let dir = tempfile::tempdir()?;
    let octahedron = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n\
        f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
    for (folder, mesh) in [("visual", TETRAHEDRON), ("collision", octahedron)] {
        fs::create_dir(dir.path().join(folder))?;
        fs::write(dir.path().join(folder).join("arm.v2.obj"), mesh)?;
    }
    let file = dir.path().join("robot.urdf");
    fs::write(
        &file,
        r#"<robot name="one"><link name="arm">
          <visual><geometry><mesh filename="visual/arm.v2.obj"/></geometry></visual>
          <visual><geometry><mesh filename="visual/arm.v2.obj" scale="2 2 2"/></geometry></visual>
          <collision><geometry><mesh filename="file://collision/arm.v2.obj"/></geometry></collision>
        </link></robot>"#,
    )?;
    let model = Model::from_mjcf_str(&urdf_to_mjcf(&file, &UrdfOptions::default())?)?;
    let sizes: Vec<_> = model
        .geoms()
        .filter_map(|geom| match model.geom_shape(geom) {
            GeomShape::Mesh { vertices, .. } => {
                let radius = model.geom_bounding_radius_m(geom);
                Some((vertices.len(), (radius * 1e3).round()))
            }
            _ => None,
        })
        .collect();
    assert_eq!(sizes.len(), 3);
    assert_eq!((sizes[0].0, sizes[1].0, sizes[2].0), (4, 4, 6));
    assert!((sizes[1].1 - 2.0 * sizes[0].1).abs() <= 1.0, "{sizes:?}");
    Ok(())
}

#[test]
fn packages_are_found_where_told() -> Result<(), Box<dyn std::error::Error>> {
    let (dir, file) = package(MESH, "")?;
    let elsewhere = tempfile::tempdir()?;
    let moved = elsewhere.path().join("robot.urdf");
    fs::copy(&file, &moved)?;
    let error = urdf_to_mjcf(&moved, &UrdfOptions::default()).expect_err("not found");
    let PhysicsError::MeshNotFound {
        reference,
        searched,
        ..
    } = &error
    else {
        panic!("{error:?}");
    };
    assert!(reference.starts_with("package://two_link_description/"));
    assert!(!searched.is_empty());
    for package_dir in [
        dir.path().to_owned(),
        dir.path().join("two_link_description"),
    ] {
        let options = UrdfOptions {
            package_dirs: vec![package_dir],
        };
        check_whole(&Model::from_mjcf_str(&urdf_to_mjcf(&moved, &options)?)?)?;
    }
    Ok(())
}

#[test]
fn collada_is_refused_with_advice() -> Result<(), Box<dyn std::error::Error>> {
    let (_dir, file) = package("package://two_link_description/meshes/arm.dae", "")?;
    let error = urdf_to_mjcf(&file, &UrdfOptions::default()).expect_err("DAE");
    assert!(matches!(&error, PhysicsError::MeshFormat { format, .. } if format == "dae"));
    assert!(error.to_string().contains("convert it"), "{error}");
    Ok(())
}

#[test]
fn broken_urdf_is_an_error_that_says_where() -> Result<(), Box<dyn std::error::Error>> {
    let dir = tempfile::tempdir()?;
    let file = dir.path().join("broken.urdf");
    fs::write(&file, "<robot name='x'><link name='a'></robot>")?;
    let error = urdf_to_mjcf(&file, &UrdfOptions::default())
        .expect_err("broken")
        .to_string();
    assert!(
        error.contains("broken.urdf") && error.contains("1:"),
        "{error}"
    );
    fs::write(&file, "<mujoco/>")?;
    let error = urdf_to_mjcf(&file, &UrdfOptions::default())
        .expect_err("MJCF")
        .to_string();
    assert!(error.contains("expected <robot>"), "{error}");
    assert!(matches!(
        urdf_to_mjcf(Path::new("absent.urdf"), &UrdfOptions::default()),
        Err(PhysicsError::File { .. })
    ));
    Ok(())
}

#[test]
fn a_urdf_part_is_attached_with_actuators() -> Result<(), Box<dyn std::error::Error>> {
    let (_dir, file) = package(MESH, "")?;
    let options = AttachOptions {
        actuators: vec![NewActuator {
            name: "shoulder".into(),
            joint: "shoulder".into(),
            servo: Servo::Motor,
            ctrl_range: Some([-7.0, 7.0]),
            force_range: None,
        }],
        ..AttachOptions::default()
    };
    let mut scene = SceneBuilder::new();
    let at = AttachPoint::World(Pose::translation(1.0, 0.0, 0.5));
    scene.attach_with(
        &Part {
            file,
            prefix: "arm/".into(),
        },
        &at,
        &options,
    )?;
    let model = scene.compile()?;
    assert_relative_eq!(model.body_mass(model.body("arm/tool")?), 0.2);
    let mut state = State::new(&model)?;
    state.set_ctrl(model.actuator("arm/shoulder")?, 5.0);
    for _ in 0..100 {
        state.step()?;
    }
    assert!(state.joint_position(model.joint("arm/shoulder")?) > 0.1);
    assert_relative_eq!(
        state.world_from_body(model.body("arm/base")?).translation.x,
        1.0,
        epsilon = 1e-12
    );
    Ok(())
}

/// The pybullet wheel's own iiwa, unchanged.
#[test]
fn the_pybullet_iiwa_loads_unchanged() -> Result<(), PhysicsError> {
    let Some(dir) = of_wheel("FACTOTUM_PYBULLET_DATA_DIR", "pybullet/pybullet_data") else {
        return Ok(());
    };
    let file = dir.join("kuka_iiwa/model.urdf");
    let model = Model::from_mjcf_str(&urdf_to_mjcf(&file, &UrdfOptions::default())?)?;
    assert_eq!((model.n_q(), model.n_v()), (7, 7));
    // A visual and a collision mesh for each of eight links, from files with the same stem.
    let is_mesh = |geom| matches!(model.geom_shape(geom), GeomShape::Mesh { .. });
    assert_eq!(model.geoms().filter(|&geom| is_mesh(geom)).count(), 16);
    let names: Vec<_> = model.joint_names();
    assert_eq!(names[0], "lbr_iiwa_joint_1");
    assert_relative_eq!(model.body_mass(model.body("lbr_iiwa_link_1")?), 4.0);
    let mut state = State::new(&model)?;
    for _ in 0..200 {
        state.step()?;
    }
    Ok(())
}

/// A three-link planar arm that can fold its last link onto its first, and not onto its base.
const FOLDING: &str = r#"<mujoco><compiler angle="radian"/><worldbody>
  <body name="base"><geom size=".05"/>
    <body name="a" pos="0 0 .1"><joint name="a" axis="0 1 0" range="-.1 .1"/>
      <geom type="capsule" fromto="0 0 .1 0 0 .4" size=".04"/>
      <body name="b" pos="0 0 .5"><joint name="b" axis="0 1 0" range="-3.1 3.1"/>
        <geom type="capsule" fromto="0 0 .1 0 0 .3" size=".04"/>
        <body name="c" pos="0 0 .4"><joint name="c" axis="0 1 0" range="-3.1 3.1"/>
          <geom type="capsule" fromto="0 0 .1 0 0 .2" size=".04"/>
          <body name="stuck"><geom size=".05" pos="0 .03 .2"/></body>
        </body></body></body></body>
</worldbody></mujoco>"#;

#[test]
fn self_collision_pairs_are_told_apart_and_repeatable() -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(FOLDING)?;
    let bodies: Vec<_> = model.bodies().skip(1).collect();
    let joints: Vec<_> = model.joints().collect();
    let pairs = |seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        self_collision_pairs(&model, &bodies, &joints, 400, &mut rng)
    };
    let found = pairs(1)?;
    assert_eq!(found, pairs(1)?);
    assert_eq!(found.len(), 10);
    let kind = |a: &str, b: &str| -> Result<PairKind, PhysicsError> {
        let (a, b) = (model.body(a)?, model.body(b)?);
        Ok(found
            .iter()
            .find(|pair| (pair.a, pair.b) == (a, b))
            .expect("all pairs")
            .kind)
    };
    assert_eq!(kind("a", "b")?, PairKind::Adjacent);
    assert_eq!(
        kind("b", "stuck")?,
        PairKind::Adjacent,
        "fixed to a neighbour"
    );
    assert_eq!(kind("c", "stuck")?, PairKind::Adjacent);
    assert_eq!(kind("a", "c")?, PairKind::Sometimes);
    assert_eq!(kind("base", "b")?, PairKind::Never);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    assert!(self_collision_pairs(&model, &bodies, &joints, 0, &mut rng).is_err());
    Ok(())
}
