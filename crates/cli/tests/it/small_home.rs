//! A user's own home: one room, soon explored.

use std::path::Path;

use tempfile::TempDir;

use crate::{Said, factotum_in, repository};

const STRUCTURE: &str = r#"<mujoco model="den">
  <default><geom type="box"/></default>
  <worldbody>
    <body name="den">
      <geom name="floor" pos="2 1.5 -0.05" size="2.1 1.6 0.05"/>
      <geom name="wall_south" pos="2 -0.05 1.2" size="2.1 0.05 1.2"/>
      <geom name="wall_north" pos="2 3.05 1.2" size="2.1 0.05 1.2"/>
      <geom name="wall_west" pos="-0.05 1.5 1.2" size="0.05 1.5 1.2"/>
      <geom name="wall_east" pos="4.05 1.5 1.2" size="0.05 1.5 1.2"/>
      <geom name="counter" pos="0.5 1.5 0.4" size="0.5 1.5 0.4"/>
      <geom name="table" pos="3.0 2.75 0.375" size="0.5 0.25 0.375"/>
    </body>
  </worldbody>
</mujoco>
"#;

const SCENE: &str = r#"
structure = "structure.xml"
bounds = { min = [-0.1, -0.1, 0.0], max = [4.1, 3.1, 2.4] }
robot_start = { x = [2.2, 2.4], y = [1.2, 1.4], yaw = [0.0, 3.0] }

[[objects]]
name = "bottle_1"
class = "bottle"
on = "table"
places = [{ xyz = [3.0, 2.65, 0.75] }]

[[objects]]
name = "light_switch_1"
class = "light_switch"
on = "wall_west"
places = [{ xyz = [0.0, 1.5, 1.1] }]
joints = { toggle = [0.40, 0.40] }

[[chores]]
name = "throw-away-bottle"
class = "bottle"
action = "throw_away"
[chores.judge]
kind = "inside"
object = "bottle_1"
container = "bin_1"
min = [-0.15, -0.15, 0.0]
max = [0.15, 0.15, 0.33]
speed_max_m_per_s = 0.05

[[chores]]
name = "turn-light-off"
class = "light_switch"
action = "turn_off"
[chores.judge]
kind = "joint"
object = "light_switch_1"
joint = "toggle"
state = "off"
speed_max_rad_per_s = 0.05
"#;

/// A room with a bottle on a table and a light switch behind a deep counter; there is no bin.
pub(crate) struct SmallHome(TempDir);

impl SmallHome {
    pub(crate) fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let objects = repository().join("assets/objects");
        let names = format!("name = \"den\"\nobjects_dir = {objects:?}\n");
        std::fs::write(dir.path().join("scene.toml"), names + SCENE).unwrap();
        std::fs::write(dir.path().join("structure.xml"), STRUCTURE).unwrap();
        Self(dir)
    }

    /// The folder with its scene.
    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// Runs one chore in it, headless.
    pub(crate) fn run(&self, goal: &str) -> Said {
        let scene = self.0.path().to_str().unwrap();
        let arguments = ["run", "--headless", "--no-folder", "--json", "--scene"];
        let arguments = [&arguments[..], &[scene, "--goal", goal]].concat();
        factotum_in(self.0.path(), &arguments)
    }
}
