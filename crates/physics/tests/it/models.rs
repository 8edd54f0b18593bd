//! Models that several tests use.

use std::path::{Path, PathBuf};

/// A free ball, and an arm with a hinge, a slide, a ball joint and a hinge: nq = 14, nv = 12.
pub(crate) const ARM_AND_BALL: &str = r#"<mujoco model="arm and ball">
  <compiler angle="radian"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 1"/>
    <body name="ball" pos="1 0 0.5">
      <joint name="ball" type="free"/>
      <geom name="ball" type="ellipsoid" size=".1 .15 .2" mass="1.5"/>
      <site name="ball_mark" pos=".1 .02 .03" euler="0.1 0.2 0.3"/>
    </body>
    <body name="upper" pos="0 0 1" euler="0.2 0 0">
      <joint name="shoulder" axis="0 1 0.2" range="-2 2" damping="1"/>
      <geom name="upper" type="capsule" size=".05 .2" mass="2"/>
      <body name="fore" pos="0 0.1 0.3" euler="0 0.3 0">
        <joint name="lift" type="slide" axis="0 0 1" range="-.5 .5" damping="20"/>
        <joint name="swivel" type="ball" damping="0.5"/>
        <geom name="fore" type="cylinder" size=".04 .1" mass="1"/>
        <body name="hand" pos="0 0 0.3">
          <joint name="wrist" axis="1 0 0" damping="0.3"/>
          <geom name="hand" type="box" size=".05 .06 .07" mass="0.5"/>
          <site name="tcp" pos="0 0.02 0.1" euler="0 1 0"/>
          <camera name="eye" pos="0 0 0.1" fovy="60"/>
        </body>
      </body>
    </body>
    <body name="ghost" pos="0 0 3"><geom name="ghost" size=".1" contype="0" conaffinity="0"/></body>
  </worldbody>
  <actuator>
    <motor name="shoulder" joint="shoulder" ctrlrange="-50 50"/>
    <motor name="lift" joint="lift" ctrlrange="-100 100"/>
  </actuator>
</mujoco>"#;

/// A folder of a Python wheel with other makers' models: where the variable says, else where `cargo x models` puts it.
pub(crate) fn of_wheel(variable: &str, in_deps: &str) -> Option<PathBuf> {
    let deps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.deps");
    let folder = std::env::var_os(variable).map_or_else(|| deps.join(in_deps), PathBuf::from);
    let found = folder.is_dir().then_some(folder);
    if found.is_none() {
        println!("skipped: `.deps/{in_deps}` is absent (cargo x models) and {variable} is not set");
    }
    found
}
