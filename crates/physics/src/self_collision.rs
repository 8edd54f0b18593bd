//! Which pairs of bodies of a robot can touch, found by sampling joint positions.
//!
//! A pair is *adjacent* when one body is the parent of the other across one joint, *always* when it
//! touches in nearly every sample (overlapping shapes: the check says nothing), *never* when it touched
//! in none, and *sometimes* otherwise. Planning checks the last kind and may skip the others; "never"
//! is as good as the number of samples.

use std::collections::BTreeMap;

use rand::{Rng, RngExt as _};

use crate::error::PhysicsError;
use crate::ids::{BodyId, GeomId, JointId};
use crate::joint_kind::JointKind;
use crate::model::Model;
use crate::state::State;

/// Share of samples from which a pair counts as always touching.
const ALWAYS_SHARE: f64 = 0.95;

/// What became of a pair of bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PairKind {
    /// Neighbours across a joint.
    Adjacent,
    /// Touching in nearly every sample.
    Always,
    /// Touching in some samples.
    Sometimes,
    /// Touching in no sample.
    Never,
}

/// A pair of bodies, the lower first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPair {
    /// First body.
    pub a: BodyId,
    /// Second body.
    pub b: BodyId,
    /// What became of it.
    pub kind: PairKind,
    /// Share of the samples in which it touched.
    pub share: f64,
}

/// Sorts all pairs of `bodies` by sampling `n_samples` positions of `joints` (slides and hinges;
/// unlimited hinges over a full turn, unlimited slides over ± 1 m), the rest of the state at its
/// reference. Contacts that the model itself excludes count as never.
///
/// # Errors
/// [`PhysicsError::Argument`] when there are no samples, and as [`State::detect_collisions`].
pub fn self_collision_pairs(
    model: &Model,
    bodies: &[BodyId],
    joints: &[JointId],
    n_samples: usize,
    rng: &mut impl Rng,
) -> Result<Vec<BodyPair>, PhysicsError> {
    if n_samples == 0 {
        return Err(PhysicsError::Argument {
            what: "n_samples",
            found: n_samples.to_string(),
            expected: "at least 1",
        });
    }
    let mut state = State::new(model)?;
    let mut n_touching: BTreeMap<(BodyId, BodyId), usize> = BTreeMap::new();
    for _ in 0..n_samples {
        for &joint in joints {
            let [low, high] = sampled_range(model, joint);
            if low < high {
                state.set_joint_position(joint, rng.random_range(low..high));
            }
        }
        state.detect_collisions()?;
        let mut touching: Vec<(BodyId, BodyId)> = state
            .contacts()
            .filter(|contact| contact.distance_m <= 0.0)
            .map(|contact| ordered(model, contact.geom_a, contact.geom_b))
            .collect();
        touching.sort_unstable();
        touching.dedup();
        for pair in touching {
            *n_touching.entry(pair).or_default() += 1;
        }
    }
    let mut sorted = bodies.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let mut pairs = Vec::new();
    for (i, &a) in sorted.iter().enumerate() {
        for &b in &sorted[i + 1..] {
            let n = n_touching.get(&(a, b)).copied().unwrap_or(0);
            let share = n as f64 / n_samples as f64;
            pairs.push(BodyPair {
                a,
                b,
                kind: kind(model, a, b, share),
                share,
            });
        }
    }
    Ok(pairs)
}

fn kind(model: &Model, a: BodyId, b: BodyId, share: f64) -> PairKind {
    let parent = |body: BodyId| {
        model
            .body_parent(model.body_weld_root(body))
            .map(|parent| model.body_weld_root(parent))
    };
    let (root_a, root_b) = (model.body_weld_root(a), model.body_weld_root(b));
    if root_a == root_b || parent(a) == Some(root_b) || parent(b) == Some(root_a) {
        PairKind::Adjacent
    } else if share >= ALWAYS_SHARE {
        PairKind::Always
    } else if share > 0.0 {
        PairKind::Sometimes
    } else {
        PairKind::Never
    }
}

fn ordered(model: &Model, a: GeomId, b: GeomId) -> (BodyId, BodyId) {
    let (a, b) = (model.geom_body(a), model.geom_body(b));
    (a.min(b), a.max(b))
}

fn sampled_range(model: &Model, joint: JointId) -> [f64; 2] {
    const FULL_TURN: [f64; 2] = [-std::f64::consts::PI, std::f64::consts::PI];
    match model.joint_kind(joint) {
        JointKind::Hinge => model.joint_range(joint).unwrap_or(FULL_TURN),
        JointKind::Slide => model.joint_range(joint).unwrap_or([-1.0, 1.0]),
        JointKind::Free | JointKind::Ball => [0.0, 0.0],
    }
}
