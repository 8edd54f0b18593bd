//! What was really achieved, read from physics alone.
//!
//! The judge knows neither plans nor beliefs; whoever tried has no say.

use factotum_physics::{BodyId, State};
use nalgebra::{Point3, Vector3};

use crate::WorldError;
use crate::assembly::{Assembly, ObjectIds};
use crate::scene::{Criterion, HomeScene};

/// The judge's word on a chore.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// Whether it is achieved now.
    pub achieved: bool,
    /// What was measured, in one sentence.
    pub measured: String,
}

/// Reads the physics of a world.
#[derive(Debug, Clone, Copy)]
pub struct Judge<'a> {
    pub(crate) scene: &'a HomeScene,
    pub(crate) assembly: &'a Assembly,
    pub(crate) state: &'a State,
}

impl Judge<'_> {
    /// Whether a chore of the scene is achieved now.
    ///
    /// An object that the chore needs and the home does not have is a reason for "no", not an error.
    ///
    /// # Errors
    /// [`WorldError::UnknownName`] for a chore that the scene does not have.
    pub fn achieved(&self, chore: &str) -> Result<Verdict, WorldError> {
        Ok(match &self.scene.chore(chore)?.judge {
            Criterion::Inside {
                object,
                container,
                min,
                max,
                speed_max_m_per_s,
            } => match (
                self.assembly.object(object),
                self.assembly.object(container),
            ) {
                (Some(object), Some(container)) => {
                    self.inside(object, container, [*min, *max], *speed_max_m_per_s)
                }
                (None, _) => absent(object),
                (_, None) => absent(container),
            },
            Criterion::Joint {
                object,
                joint,
                state,
                speed_max_rad_per_s,
            } => match self.assembly.object(object) {
                Some(found) => self.joint(found, joint, state, *speed_max_rad_per_s),
                None => absent(object),
            },
        })
    }

    fn inside(
        &self,
        object: &ObjectIds,
        container: &ObjectIds,
        [min, max]: [[f64; 3]; 2],
        speed_max: f64,
    ) -> Verdict {
        let world_from_container = self.state.world_from_body(container.root);
        let centre =
            world_from_container.inverse_transform_point(&self.centre_of_mass(object.root));
        let speed = self.state.body_velocity(object.root).0.norm();
        let held = self
            .state
            .are_touching(&self.assembly.robot.geoms, &object.geoms);
        let within = (0..3).all(|i| (min[i]..=max[i]).contains(&centre[i]));
        Verdict {
            achieved: within && speed <= speed_max && !held,
            measured: format!(
                "centre of {} at ({:.3}, {:.3}, {:.3}) m in {}, speed {speed:.3} m/s, {}",
                object.name,
                centre.x,
                centre.y,
                centre.z,
                container.name,
                if held {
                    "touched by the robot"
                } else {
                    "not touched"
                },
            ),
        }
    }

    fn joint(&self, object: &ObjectIds, joint: &str, state: &str, speed_max: f64) -> Verdict {
        let class = &self.scene.classes()[&object.class];
        let (Some(id), Some(interval)) = (object.joints.get(joint), class.state(state)) else {
            return absent(&format!("{}/{joint}", object.name));
        };
        let position = self.state.joint_position(*id);
        let speed = self.state.joint_velocity(*id).abs();
        let [low, high] = interval.range;
        Verdict {
            achieved: (low..=high).contains(&position) && speed <= speed_max,
            measured: format!(
                "joint {joint} of {} at {position:.3} rad, speed {speed:.3} rad/s; `{state}` is [{low}, {high}]",
                object.name
            ),
        }
    }

    fn centre_of_mass(&self, root: BodyId) -> Point3<f64> {
        let model = &self.assembly.model;
        let mut mass = 0.0;
        let mut moment = Vector3::zeros();
        for body in model.bodies_of_subtree(root) {
            let body_mass = model.body_mass(body);
            mass += body_mass;
            moment += self.state.body_com_in_world(body).coords * body_mass;
        }
        if mass > 0.0 {
            Point3::from(moment / mass)
        } else {
            Point3::from(self.state.world_from_body(root).translation.vector)
        }
    }
}

fn absent(name: &str) -> Verdict {
    Verdict {
        achieved: false,
        measured: format!("this home has no `{name}`"),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use factotum_control::Robot as _;
    use factotum_descriptions::RobotDescription;
    use factotum_geometry::Pose;

    use crate::{HomeScene, Noise, SimRobot, WorldConfig};

    fn household() -> SimRobot {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        let config = WorldConfig {
            robot: RobotDescription::load(&assets.join("robots/movo")).unwrap(),
            scene: HomeScene::load(&assets.join("scenes/household")).unwrap(),
            seed: 4,
            noise: Noise::none(),
            fault: None,
        };
        SimRobot::new(config).unwrap()
    }

    #[test]
    fn a_bottle_at_rest_in_the_bin_counts_and_a_flying_one_does_not() {
        let mut robot = household();
        let (assembly, state) = robot.physics_mut();
        let bin = state.world_from_body(assembly.object("bin_1").unwrap().root);
        let bottle = assembly.object("bottle_1").unwrap().root;
        let above = bin * Pose::translation(0.02, 0.0, 0.1);
        state.set_free_body_pose(bottle, &above).unwrap();
        robot.wait(0.1).unwrap();
        let falling = robot.judge().achieved("throw-away-bottle").unwrap();
        assert!(!falling.achieved, "{}", falling.measured);
        robot.wait(3.0).unwrap();
        let resting = robot.judge().achieved("throw-away-bottle").unwrap();
        assert!(resting.achieved, "{}", resting.measured);
    }

    #[test]
    fn a_switch_that_is_down_and_a_lever_that_is_shut_count() {
        let mut robot = household();
        let (assembly, state) = robot.physics_mut();
        let toggle = assembly.object("light_switch_1").unwrap().joints["toggle"];
        let handle = assembly.object("faucet_1").unwrap().joints["handle"];
        state.set_joint_position(toggle, -0.4);
        state.set_joint_position(handle, 0.02);
        robot.wait(0.5).unwrap();
        for chore in ["turn-light-off", "close-faucet"] {
            let verdict = robot.judge().achieved(chore).unwrap();
            assert!(verdict.achieved, "{chore}: {}", verdict.measured);
        }
    }
}
