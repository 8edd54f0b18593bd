//! What π_c sees, φ: the arm, the tool, the fingers and what they feel, and the object.
//!
//! | part | size | unit |
//! |---|---|---|
//! | cosines, sines and velocities of the arm's joints | 3 n | -, -, rad/s |
//! | tool position and orientation (x, y, z, w with w ≥ 0), base frame | 7 | m, - |
//! | positions and velocities of the fingers' joints | 2 n_f | m or rad, per s |
//! | contact force on each pad, tool frame | 3 n_p | [`FORCE_UNIT_N`] |
//! | Λ and middle of the grasp region, base frame; both from the tool | 12 | m |
//! | the object's joint | 1 | rad or m |
//!
//! The Panda with its hand has 51, as in the dissertation's code. Where we differ: forces are in units of the grip
//! force instead of newtons, so that one contact does not drown all else in a network whose inputs are not normalised;
//! and they are contact forces, not those of a force sensor, which also feels the weight of the finger.

use factotum_geometry::Pose;

use super::rig::{Anatomy, Reading};

/// Unit of force in an observation, N.
pub const FORCE_UNIT_N: f64 = 20.0;

/// Where a component of force saturates, in that unit: an impact of a millisecond is a thousand newtons and says no more
/// than a hundred.
const FORCE_MAX: f64 = 5.0;

/// Components of an observation.
pub fn n_observation(anatomy: &Anatomy) -> usize {
    3 * anatomy.arm_limits.len() + 7 + 2 * anatomy.n_finger_joints + 3 * anatomy.n_pads + 13
}

/// Writes what a reading is to the policy; the slice has [`n_observation`] places.
pub fn observe_into(reading: &Reading, observation: &mut [f32]) {
    let tool = reading.base_from_tcp;
    let object = reading.base_from_object.translation.vector;
    let region = reading.region.coords;
    let from_tool = |point: nalgebra::Vector3<f64>| point - tool.translation.vector;
    let values = reading
        .arm_positions
        .iter()
        .map(|q| q.cos())
        .chain(reading.arm_positions.iter().map(|q| q.sin()))
        .chain(reading.arm_velocities.iter().copied())
        .chain(tool.translation.vector.iter().copied())
        .chain(unique_quaternion(&tool))
        .chain(reading.finger_positions.iter().copied())
        .chain(reading.finger_velocities.iter().copied())
        .chain(
            reading
                .pad_forces_in_tcp
                .iter()
                .flat_map(|force| <[f64; 3]>::from((force / FORCE_UNIT_N).map(saturated))),
        )
        .chain(<[f64; 3]>::from(object))
        .chain(<[f64; 3]>::from(region))
        .chain(<[f64; 3]>::from(from_tool(object)))
        .chain(<[f64; 3]>::from(from_tool(region)))
        .chain([reading.object_joint]);
    for (place, value) in observation.iter_mut().zip(values) {
        *place = value as f32;
    }
}

fn saturated(force: f64) -> f64 {
    force.clamp(-FORCE_MAX, FORCE_MAX)
}

/// The one of the two quaternions of an orientation that has w ≥ 0.
fn unique_quaternion(pose: &Pose) -> [f64; 4] {
    let q = pose.rotation.quaternion();
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [q.i, q.j, q.k, q.w].map(|value| sign * value)
}
