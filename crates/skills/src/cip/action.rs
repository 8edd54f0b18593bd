//! From an action of π_c to a command: thesis Eq. 3.1 with the impedance as part of the action.
//!
//! | components | meaning | range of -1..=1 |
//! |---|---|---|
//! | 0..6 | stiffness, position then rotation | 0 to 300 1/s² |
//! | 6..9 | tool displacement Δp, base frame | ±0.025 m |
//! | 9..12 | tool rotation ΔR as a rotation vector, base frame | ±0.25 rad |
//! | 12 | gripper | -1 open, 1 closed |
//!
//! Displacement and rotation are from where the tool is when the action begins. The ranges are those of the
//! experiments' code: 0.05 m and 0.5 rad, halved.

use factotum_control::Impedance;
use factotum_geometry::Pose;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::rig::RigCommand;

/// Components of an action.
pub const N_ACTION: usize = 13;

/// Which component is the gripper's.
pub const GRIPPER: usize = 12;

/// What the gripper's component means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GripperAction {
    /// It is where the fingers should be: -1 open, 1 closed. The dissertation's text.
    #[default]
    Position,
    /// Its sign is where the fingers should move. The dissertation's code.
    Direction,
}

/// Ranges of an action.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ActionRanges {
    /// Largest stiffness, 1/s².
    pub kp_max: f64,
    /// Largest displacement along an axis, metres.
    pub displacement_max_m: f64,
    /// Largest rotation about an axis, radians.
    pub rotation_max_rad: f64,
    /// What the gripper's component means.
    pub gripper: GripperAction,
}

impl Default for ActionRanges {
    fn default() -> Self {
        Self {
            kp_max: 300.0,
            displacement_max_m: 0.025,
            rotation_max_rad: 0.25,
            gripper: GripperAction::default(),
        }
    }
}

/// An action that does nothing: the tool stays, held with half the stiffness, the fingers close.
pub const HOLD: [f32; N_ACTION] = {
    let mut action = [0.0; N_ACTION];
    action[GRIPPER] = 1.0;
    action
};

/// Control periods in which the fingers close before the policy begins, as in the dissertation's code.
pub(super) const CLOSING_STEPS: u32 = 10;

/// How far the fingers close in a period until they touch, of the whole opening: slow, so that they meet the object gently.
pub(super) const CLOSING_STROKE: f64 = 0.03;

/// The opening around something of a width before the fingers close on it.
pub(super) fn opening_around(width_m: f64, aperture_max_m: f64) -> f64 {
    /// Room on both sides.
    const FINGER_ROOM_M: f64 = 0.008;
    ((width_m + 2.0 * FINGER_ROOM_M) / aperture_max_m).clamp(0.1, 1.0)
}

impl ActionRanges {
    /// The command of an action, from where the tool and the fingers' target are.
    pub fn command(
        &self,
        action: &[f32; N_ACTION],
        base_from_tcp: &Pose,
        opening: f64,
        period_secs: f64,
    ) -> RigCommand {
        let at = |i: usize| f64::from(action[i].clamp(-1.0, 1.0));
        let three = |first: usize| Vector3::new(at(first), at(first + 1), at(first + 2));
        let kp = |first| three(first).map(|share| 0.5 * (share + 1.0) * self.kp_max);
        let displacement = Translation3::from(three(6) * self.displacement_max_m);
        let rotation = UnitQuaternion::from_scaled_axis(three(9) * self.rotation_max_rad);
        RigCommand {
            base_from_tcp: Pose::from_parts(
                displacement * base_from_tcp.translation,
                rotation * base_from_tcp.rotation,
            ),
            impedance: Impedance {
                kp_position: kp(0),
                kp_rotation: kp(3),
                damping_ratio: 1.0,
            },
            opening: match self.gripper {
                GripperAction::Position => 0.5 * (1.0 - at(GRIPPER)),
                GripperAction::Direction => {
                    /// 0.4 s from open to closed: the code moves by 0.01 of -1..1 every 2 ms.
                    const STROKES_PER_SEC: f64 = 2.5;
                    (opening - at(GRIPPER).signum() * STROKES_PER_SEC * period_secs).clamp(0.0, 1.0)
                }
            },
        }
    }

    /// The action that would take the tool from one pose to another at once, cut to the ranges together so that the
    /// direction stays; stiffness `kp` from 0 to 1, fingers closed.
    pub fn towards(&self, from: &Pose, to: &Pose, kp: f64) -> [f32; N_ACTION] {
        let displacement =
            (to.translation.vector - from.translation.vector) / self.displacement_max_m;
        let rotation =
            (to.rotation * from.rotation.inverse()).scaled_axis() / self.rotation_max_rad;
        let largest = displacement.amax().max(rotation.amax()).max(1.0);
        let mut action = HOLD;
        action[..6].fill((2.0 * kp - 1.0) as f32);
        let components = displacement.iter().chain(&rotation);
        for (value, component) in action[6..12].iter_mut().zip(components) {
            *value = (component / largest) as f32;
        }
        action
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_action_means_what_the_table_says() {
        let ranges = ActionRanges::default();
        let at = Pose::from_parts(
            Translation3::new(0.4, 0.1, 0.3),
            UnitQuaternion::from_euler_angles(0.3, -0.2, 1.0),
        );
        let held = ranges.command(&HOLD, &at, 0.3, 0.05);
        assert_eq!(held.base_from_tcp, at);
        assert_eq!(held.opening, 0.0);
        assert_eq!(held.impedance, Impedance::default());
        let mut action = HOLD;
        action[2] = 1.0;
        action[6] = -1.0;
        action[11] = 0.5;
        action[GRIPPER] = -1.0;
        let command = ranges.command(&action, &at, 0.3, 0.05);
        assert_eq!(
            command.impedance.kp_position,
            Vector3::new(150.0, 150.0, 300.0)
        );
        let moved = command.base_from_tcp.translation.vector - at.translation.vector;
        assert!((moved - Vector3::new(-0.025, 0.0, 0.0)).norm() < 1e-12);
        let turned = (command.base_from_tcp.rotation * at.rotation.inverse()).scaled_axis();
        assert!((turned - Vector3::new(0.0, 0.0, 0.125)).norm() < 1e-9);
        assert_eq!(command.opening, 1.0);
        let by_sign = ActionRanges {
            gripper: GripperAction::Direction,
            ..ranges
        };
        assert!((by_sign.command(&HOLD, &at, 0.3, 0.05).opening - 0.175).abs() < 1e-12);
    }

    #[test]
    fn towards_a_pose_within_reach_is_the_way_there_and_beyond_it_the_direction() {
        let ranges = ActionRanges::default();
        let from = Pose::translation(0.4, 0.0, 0.2);
        let near = Pose::from_parts(
            Translation3::new(0.41, -0.02, 0.2),
            UnitQuaternion::from_euler_angles(0.0, 0.0, 0.1),
        );
        let there = ranges.command(&ranges.towards(&from, &near, 0.5), &from, 0.0, 0.05);
        assert!((there.base_from_tcp.translation.vector - near.translation.vector).norm() < 1e-8);
        assert!(there.base_from_tcp.rotation.angle_to(&near.rotation) < 1e-7);
        let far = Pose::translation(0.8, 0.2, 0.2);
        let action = ranges.towards(&from, &far, 0.5);
        assert_eq!((action[6], action[7]), (1.0, 0.5));
    }
}
