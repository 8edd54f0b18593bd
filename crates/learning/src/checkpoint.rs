//! Learners and policies in files, whole or not at all.
//!
//! A file is one of [safetensors](https://github.com/huggingface/safetensors) (any tool that reads those reads the
//! weights), with one entry of metadata, `factotum`: JSON with the version of this format, task, robot, sizes,
//! parameters, counters and a SHA-256 of that header and all tensors. Weight matrices are `(n_inputs, n_outputs)`, row
//! by row; those of a layer with one output are `(1, n_inputs)`. Integers are little-endian.
//!
//! | tensors | of |
//! |---|---|
//! | `policy.*`, `critics.*` | weights by member and layer, as `critics.1.0.weight` |
//! | `*.target.*`, `*.first.*`, `*.second.*` | targets, and Adam's moments |
//! | `replay.*` | transitions as they lie in the ring |
//! | `random.*` | seed, stream and position of each generator |
//!
//! A file is written beside its place, brought to the disk and renamed, so that a crash leaves the old one or the new
//! one. The same learner gives the same bytes.

mod error;
mod file;

pub use error::CheckpointError;

use std::path::Path;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::mlp::{Activation, Mlp};
use crate::panels::Lanes;
use crate::replay::{Ending, Transition};
use crate::td3::{Counters, Policy, Td3, Td3Params};
use file::{Stored, Tensors};

/// Version of the format; a reader refuses any other.
const FORMAT: u32 = 1;

/// For what a learner or policy was trained.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Name of the task.
    pub task: String,
    /// Name of the robot.
    pub robot: String,
    /// Components of an observation.
    pub n_observation: usize,
    /// Components of an action.
    pub n_action: usize,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: u32,
    identity: Identity,
    content: Content,
    /// The caller's own.
    notes: String,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Content {
    Policy {
        hidden: Vec<usize>,
        hidden_activation: Activation,
    },
    Learner {
        params: Td3Params,
        counters: Counters,
        policy_steps: u64,
        critics_steps: u64,
        replay_next: usize,
    },
}

impl Content {
    fn name(&self) -> &'static str {
        match self {
            Self::Policy { .. } => "a policy",
            Self::Learner { .. } => "a learner",
        }
    }
}

/// Stores a learner with all it needs to go on, and `notes`: what the caller needs beside it, such as its bandit.
///
/// # Errors
///
/// When the identity names other sizes than the learner has, or the file cannot be written; an older file stays then.
pub fn save(
    path: &Path,
    learner: &Td3,
    identity: &Identity,
    notes: &str,
) -> Result<(), CheckpointError> {
    check_sizes(path, learner.n_observation, learner.n_action, identity)?;
    let mut tensors = Tensors::new();
    for (name, learned) in [("policy", &learner.policy), ("critics", &learner.critics)] {
        let network = &learned.network;
        put(&mut tensors, name, network, network.parameters());
        put(
            &mut tensors,
            &format!("{name}.target"),
            network,
            learned.target.parameters(),
        );
        put(
            &mut tensors,
            &format!("{name}.first"),
            network,
            &learned.adam.first,
        );
        put(
            &mut tensors,
            &format!("{name}.second"),
            network,
            &learned.adam.second,
        );
    }
    put_replay(&mut tensors, learner);
    for (name, rng) in [
        ("exploring", &learner.exploring),
        ("updating", &learner.updating),
    ] {
        tensors.insert(
            format!("random.{name}"),
            Stored::of_bytes(rng_to_bytes(rng)),
        );
    }
    let header = Header {
        format: FORMAT,
        identity: identity.clone(),
        content: Content::Learner {
            params: learner.params.clone(),
            counters: learner.counters,
            policy_steps: learner.policy.adam.n_steps,
            critics_steps: learner.critics.adam.n_steps,
            replay_next: learner.replay.next(),
        },
        notes: notes.to_owned(),
    };
    file::write(path, &header, &tensors)
}

/// A learner as [`save`] left it, and the notes stored with it.
///
/// # Errors
///
/// When the file cannot be read, is damaged, or holds something else than a learner of this identity.
pub fn load(path: &Path, identity: &Identity) -> Result<(Td3, String), CheckpointError> {
    let (header, mut tensors) = open(path, identity)?;
    let Content::Learner {
        params,
        counters,
        policy_steps,
        critics_steps,
        replay_next,
    } = header.content
    else {
        return Err(other(path, "content", header.content.name(), "a learner"));
    };
    let mut learner = Td3::new(identity.n_observation, identity.n_action, params, 0)?;
    for (name, learned, n_steps) in [
        ("policy", &mut learner.policy, policy_steps),
        ("critics", &mut learner.critics, critics_steps),
    ] {
        let form = learned.network.clone();
        tensors.take_into(path, name, &form, learned.network.parameters_mut())?;
        let target = learned.target.parameters_mut();
        tensors.take_into(path, &format!("{name}.target"), &form, target)?;
        tensors.take_into(
            path,
            &format!("{name}.first"),
            &form,
            &mut learned.adam.first,
        )?;
        tensors.take_into(
            path,
            &format!("{name}.second"),
            &form,
            &mut learned.adam.second,
        )?;
        learned.adam.n_steps = n_steps;
    }
    take_replay(path, &mut tensors, &mut learner, replay_next)?;
    learner.exploring = tensors.take_rng(path, "random.exploring")?;
    learner.updating = tensors.take_rng(path, "random.updating")?;
    learner.counters = counters;
    tensors.check_empty(path)?;
    Ok((learner, header.notes))
}

/// Stores a policy alone: what a skill that is done learning needs.
///
/// # Errors
///
/// As [`save`].
pub fn save_policy(
    path: &Path,
    policy: &Policy,
    identity: &Identity,
    notes: &str,
) -> Result<(), CheckpointError> {
    check_sizes(path, policy.n_observation(), policy.n_action(), identity)?;
    let mut tensors = Tensors::new();
    put(
        &mut tensors,
        "policy",
        &policy.network,
        policy.network.parameters(),
    );
    let form = policy.network.architecture();
    let header = Header {
        format: FORMAT,
        identity: identity.clone(),
        content: Content::Policy {
            hidden: form.hidden.clone(),
            hidden_activation: form.hidden_activation,
        },
        notes: notes.to_owned(),
    };
    file::write(path, &header, &tensors)
}

/// A policy as [`save_policy`] left it, and the notes stored with it.
///
/// # Errors
///
/// As [`load`].
pub fn load_policy(path: &Path, identity: &Identity) -> Result<(Policy, String), CheckpointError> {
    let (header, mut tensors) = open(path, identity)?;
    let Content::Policy {
        hidden,
        hidden_activation,
    } = header.content
    else {
        return Err(other(path, "content", header.content.name(), "a policy"));
    };
    let params = Td3Params {
        hidden,
        hidden_activation,
        ..Td3Params::default()
    };
    params.check().map_err(crate::td3::Td3Error::from)?;
    let form = params.policy_architecture(identity.n_observation, identity.n_action);
    let network = Mlp::new(form, &mut ChaCha8Rng::seed_from_u64(0));
    let mut network = network.map_err(crate::td3::Td3Error::from)?;
    let same = network.clone();
    tensors.take_into(path, "policy", &same, network.parameters_mut())?;
    tensors.check_empty(path)?;
    Ok((Policy::of(network), header.notes))
}

fn open(path: &Path, wanted: &Identity) -> Result<(Header, Tensors), CheckpointError> {
    let (header, tensors) = file::read(path)?;
    let found = &header.identity;
    if header.format != FORMAT {
        return Err(other(
            path,
            "format",
            &header.format.to_string(),
            &FORMAT.to_string(),
        ));
    }
    for (what, found, wanted) in [
        ("task", &found.task, &wanted.task),
        ("robot", &found.robot, &wanted.robot),
    ] {
        if found != wanted {
            return Err(other(
                path,
                what,
                &format!("`{found}`"),
                &format!("`{wanted}`"),
            ));
        }
    }
    check_sizes(path, found.n_observation, found.n_action, wanted)?;
    Ok((header, tensors))
}

fn check_sizes(
    path: &Path,
    n_observation: usize,
    n_action: usize,
    wanted: &Identity,
) -> Result<(), CheckpointError> {
    for (what, found, wanted) in [
        ("observation size", n_observation, wanted.n_observation),
        ("action size", n_action, wanted.n_action),
    ] {
        if found != wanted {
            return Err(other(path, what, &found.to_string(), &wanted.to_string()));
        }
    }
    Ok(())
}

fn other(path: &Path, what: &'static str, found: &str, wanted: &str) -> CheckpointError {
    CheckpointError::Other {
        path: path.to_owned(),
        what,
        found: found.to_owned(),
        wanted: wanted.to_owned(),
    }
}

/// Adds numbers that lie as a network's parameters do.
fn put(tensors: &mut Tensors, prefix: &str, network: &Mlp, lanes: &[Lanes]) {
    for tensor in network.tensors() {
        tensors.insert(
            format!("{prefix}.{}", tensor.name),
            Stored::of_floats(&tensor.block.shape(), tensor.block.elements(lanes)),
        );
    }
}

fn put_replay(tensors: &mut Tensors, learner: &Td3) {
    let replay = &learner.replay;
    let n = replay.len();
    let each = || (0..n).filter_map(|index| replay.get(index));
    let mut add = |name: &str, stored| tensors.insert(format!("replay.{name}"), stored);
    let observation = [n, learner.n_observation];
    let action = [n, learner.n_action];
    add(
        "observations",
        Stored::of_floats(
            &observation,
            each().flat_map(|t| t.observation.iter().copied()),
        ),
    );
    add(
        "actions",
        Stored::of_floats(&action, each().flat_map(|t| t.action.iter().copied())),
    );
    add("rewards", Stored::of_floats(&[n], each().map(|t| t.reward)));
    add(
        "next_observations",
        Stored::of_floats(
            &observation,
            each().flat_map(|t| t.next_observation.iter().copied()),
        ),
    );
    add(
        "endings",
        Stored::of_bytes(each().map(|t| ending_to_byte(t.ending)).collect()),
    );
}

fn take_replay(
    path: &Path,
    tensors: &mut Tensors,
    learner: &mut Td3,
    next: usize,
) -> Result<(), CheckpointError> {
    let endings = tensors.take_bytes(path, "replay.endings")?;
    let n = endings.len();
    let capacity = learner.replay.capacity();
    if n > capacity {
        return Err(other(
            path,
            "transitions",
            &n.to_string(),
            &format!("at most {capacity}"),
        ));
    }
    if next >= capacity || (n < capacity && next != n) {
        return Err(other(
            path,
            "place in the ring",
            &next.to_string(),
            &(n % capacity).to_string(),
        ));
    }
    let (n_observation, n_action) = (learner.n_observation, learner.n_action);
    let mut floats =
        |name: &str, shape: &[usize]| tensors.take_floats(path, &format!("replay.{name}"), shape);
    let observations = floats("observations", &[n, n_observation])?;
    let actions = floats("actions", &[n, n_action])?;
    let rewards = floats("rewards", &[n])?;
    let next_observations = floats("next_observations", &[n, n_observation])?;
    for (i, ending) in endings.into_iter().enumerate() {
        let Some(ending) = ending_of_byte(ending) else {
            return Err(other(
                path,
                "ending of a transition",
                &ending.to_string(),
                "0, 1 or 2",
            ));
        };
        learner.replay.push(&Transition {
            observation: &observations[i * n_observation..][..n_observation],
            action: &actions[i * n_action..][..n_action],
            reward: rewards[i],
            next_observation: &next_observations[i * n_observation..][..n_observation],
            ending,
        });
    }
    learner.replay.go_on_at(next);
    Ok(())
}

fn ending_to_byte(ending: Ending) -> u8 {
    match ending {
        Ending::Goes => 0,
        Ending::Terminal => 1,
        Ending::Cut => 2,
    }
}

fn ending_of_byte(byte: u8) -> Option<Ending> {
    [Ending::Goes, Ending::Terminal, Ending::Cut]
        .into_iter()
        .find(|ending| ending_to_byte(*ending) == byte)
}

/// Seed, stream and position: 32 + 8 + 16 bytes.
const RNG_BYTES: usize = 56;

fn rng_to_bytes(rng: &ChaCha8Rng) -> Vec<u8> {
    let mut bytes = rng.get_seed().to_vec();
    bytes.extend(rng.get_stream().to_le_bytes());
    bytes.extend(rng.get_word_pos().to_le_bytes());
    bytes
}

fn rng_of_bytes(bytes: &[u8; RNG_BYTES]) -> Option<ChaCha8Rng> {
    let (seed, rest) = bytes.split_first_chunk::<32>()?;
    let (stream, position) = rest.split_first_chunk::<8>()?;
    let mut rng = ChaCha8Rng::from_seed(*seed);
    rng.set_stream(u64::from_le_bytes(*stream));
    rng.set_word_pos(u128::from_le_bytes(position.try_into().ok()?));
    Some(rng)
}

#[cfg(test)]
mod tests;
