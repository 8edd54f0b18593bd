//! Generated kitchens: walls, counters, appliances and objects on them, drawn from a seed.
//!
//! Where a skill can run is decided in physics and by no rule: a stand-in for a mobile manipulator is put on every cell of
//! a grid, and [`feasibility`] looks at what it touches, what its camera sees, and what is in the way of its arm. The
//! result is an [`ActionMap`] like those that are read from files.
//!
//! The sizes of furniture are those of fitted kitchens (counters 0.6 m deep and 0.9 m high, cabinets 0.5 m above them).
//!
//! Frames: the world has its origin in a corner of the room, x and y along the walls. An object faces along its x.

mod feasibility;
mod layout;
#[cfg(test)]
mod tests;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::WorldError;
use crate::action_map::ActionMap;
use layout::Layout;

/// Rooms that are drawn until coffee can be made in one.
const N_ROOMS_MAX: usize = 100;

/// The kitchen of a seed, as `kitchen-SEED`; mug and coffee machine can be reached in it.
///
/// # Errors
/// [`WorldError::NoPlace`] if none could be drawn in which they can, [`WorldError::Physics`] if the engine refuses.
pub fn kitchen(seed: u64) -> Result<ActionMap, WorldError> {
    let scene = format!("kitchen-{seed}");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..N_ROOMS_MAX {
        let Some(layout) = Layout::draw(&mut rng) else {
            continue;
        };
        let map = feasibility::action_map(&scene, &layout)?;
        let is_usable = |object: &layout::Target| {
            let mut actions = object.actions.iter();
            actions.all(|action| map.object_for(action, object.class).is_some())
        };
        if layout.targets.iter().all(is_usable) {
            return Ok(map);
        }
    }
    Err(WorldError::NoPlace {
        object: "Mug and CoffeeMachine within reach".to_owned(),
        scene,
        attempts: N_ROOMS_MAX,
    })
}
