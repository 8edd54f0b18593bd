//! Drawing a home, putting the robot in it and letting it come to rest.

use factotum_physics::State;

use super::{SimRobot, WorldConfig};
use crate::WorldError;
use crate::assembly::Assembly;
use crate::odometry::Odometry;
use crate::random::{Purpose, stream};
use crate::scene::Placed;

/// Time in which objects come to rest and the robot takes its posture before the world begins, seconds.
const SETTLE_SECS: f64 = 0.5;

/// Draws of a home before it is given up.
const N_DRAWS: usize = 50;

/// Overlap of two bodies at the start that is more than resting on each other, metres.
const START_OVERLAP_M: f64 = 0.003;

impl SimRobot {
    /// Draws homes of the seed until one is free of overlaps.
    pub(super) fn draw(config: &WorldConfig) -> Result<(Placed, Assembly, State), WorldError> {
        let mut rng = stream(config.seed, Purpose::Placement);
        let mut problem = None;
        for _ in 0..N_DRAWS {
            let placed = config.scene.draw(&mut rng);
            let assembly = Assembly::new(&config.robot, &config.scene, &placed)?;
            let mut state = assembly.initial_state(&config.robot, &placed)?;
            state
                .detect_collisions()
                .map_err(WorldError::physics("placing the robot and the objects"))?;
            match start_overlap(config, &placed, &assembly, &state) {
                None => return Ok((placed, assembly, state)),
                Some(overlap) => problem = Some(overlap),
            }
        }
        Err(problem.unwrap_or_else(|| WorldError::NoPlace {
            object: config.robot.name.clone(),
            scene: config.scene.name().to_owned(),
            attempts: N_DRAWS,
        }))
    }

    /// Lets everything come to rest, and begins time and odometry there.
    pub(super) fn settle(&mut self) -> Result<(), WorldError> {
        let what = "letting the world come to rest";
        while self.state.time_secs() < SETTLE_SECS {
            self.step()?;
        }
        self.state.set_time_secs(0.0);
        self.state
            .forward_kinematics()
            .map_err(WorldError::physics(what))?;
        let world_from_base = self.assembly.world_from_base(&self.state);
        self.live.odometry = Odometry::new(self.config.seed, &self.config.noise, world_from_base);
        Ok(())
    }
}

/// The first overlap that is more than resting on each other, of the robot with the home or of a movable object.
fn start_overlap(
    config: &WorldConfig,
    placed: &Placed,
    assembly: &Assembly,
    state: &State,
) -> Option<WorldError> {
    let robot = &assembly.robot.geoms;
    for contact in state
        .contacts()
        .filter(|contact| contact.distance_m < -START_OVERLAP_M)
    {
        let [a, b] = [contact.geom_a, contact.geom_b];
        let (a_mine, b_mine) = (robot.contains(&a), robot.contains(&b));
        if a_mine != b_mine {
            let other = if a_mine { b } else { a };
            return Some(WorldError::StartOccupied {
                robot: config.robot.name.clone(),
                scene: config.scene.name().to_owned(),
                x_m: placed.world_from_base.translation.x,
                y_m: placed.world_from_base.translation.y,
                geom: assembly.model.geom_name(other).to_owned(),
            });
        }
        let object = assembly.objects.iter().find(|object| {
            object.movable && (object.geoms.contains(&a) != object.geoms.contains(&b))
        });
        if let Some(object) = object {
            return Some(WorldError::NoPlace {
                object: object.name.clone(),
                scene: config.scene.name().to_owned(),
                attempts: N_DRAWS,
            });
        }
    }
    None
}
