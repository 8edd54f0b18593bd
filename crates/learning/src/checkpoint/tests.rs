//! Going on as if never stopped, and files that cannot be gone on from.

use std::fs;
use std::path::Path;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::{CheckpointError, Identity, load, load_policy, save, save_policy};
use crate::replay::{Ending, Transition};
use crate::td3::{Td3, Td3Params};

fn identity() -> Identity {
    Identity {
        task: "door".to_owned(),
        robot: "panda".to_owned(),
        n_observation: 5,
        n_action: 2,
    }
}

fn learner() -> Td3 {
    let params = Td3Params {
        hidden: vec![24, 16],
        batch_size: 32,
        // Full after 60 steps, so that the ring has turned.
        replay_capacity: 60,
        warmup_steps: 10,
        critic_layer_norm: true,
        // Not a number of few digits.
        updates_per_step: 1.0 / 3.0,
        learning_rate: 1e-3 / 3.0,
        ..Td3Params::default()
    };
    Td3::new(5, 2, params, 8).unwrap()
}

/// Lives and learns for `n` updates. What happens depends on the count of steps alone.
fn go_on(learner: &mut Td3, n: u64) {
    for _ in 0..n {
        let step = learner.counters().n_env_steps;
        let mut rng = ChaCha8Rng::seed_from_u64(step);
        let mut observation =
            || -> [f32; 5] { std::array::from_fn(|_| rng.random_range(-1.0..1.0)) };
        let (before, after) = (observation(), observation());
        let mut action = [0.0; 2];
        learner.explore_into(&before, &mut action).unwrap();
        let transition = Transition {
            observation: &before,
            action: &action,
            reward: before[0] * action[1],
            next_observation: &after,
            ending: [Ending::Goes, Ending::Terminal, Ending::Cut][step as usize % 3],
        };
        learner.record(&transition).unwrap();
        learner.update_owed().unwrap();
        learner.update().unwrap();
    }
}

fn bytes_of(learner: &Td3, folder: &Path) -> Vec<u8> {
    let path = folder.join("bytes.safetensors");
    save(&path, learner, &identity(), "").unwrap();
    fs::read(path).unwrap()
}

#[test]
fn a_stored_learner_goes_on_as_if_it_had_never_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let mut never_stopped = learner();
    go_on(&mut never_stopped, 200);

    let mut stopped = learner();
    go_on(&mut stopped, 100);
    let path = folder.path().join("half.safetensors");
    save(&path, &stopped, &identity(), "{\"episode\": 7}").unwrap();
    let (mut resumed, notes) = load(&path, &identity()).unwrap();
    assert!(resumed.params() == stopped.params());
    assert_eq!(notes, "{\"episode\": 7}");
    go_on(&mut resumed, 100);

    assert!(resumed.counters().n_updates > 200);
    let (resumed, wanted) = (
        bytes_of(&resumed, folder.path()),
        bytes_of(&never_stopped, folder.path()),
    );
    assert!(resumed == wanted);
    go_on(&mut never_stopped, 1);
    assert!(
        bytes_of(&never_stopped, folder.path()) != wanted,
        "the bytes tell learners apart"
    );
    let names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(names.len(), 2, "nothing unfinished is left: {names:?}");
}

#[test]
fn a_policy_comes_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.safetensors");
    let mut learner = learner();
    go_on(&mut learner, 20);
    save_policy(&path, &learner.policy(), &identity(), "made by hand").unwrap();
    let (policy, notes) = load_policy(&path, &identity()).unwrap();
    assert!(policy == learner.policy());
    assert_eq!(notes, "made by hand");
    let refused = load(&path, &identity()).unwrap_err().to_string();
    assert!(
        refused.ends_with("has content a policy, expected a learner"),
        "{refused}"
    );
    save(&path, &learner, &identity(), "").unwrap();
    let refused = load_policy(&path, &identity()).unwrap_err().to_string();
    assert!(
        refused.ends_with("has content a learner, expected a policy"),
        "{refused}"
    );
}

#[test]
fn a_checkpoint_of_something_else_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("door.safetensors");
    save(&path, &learner(), &identity(), "").unwrap();
    let cases = [
        (
            Identity {
                task: "lever".to_owned(),
                ..identity()
            },
            "task `door`, expected `lever`",
        ),
        (
            Identity {
                robot: "movo".to_owned(),
                ..identity()
            },
            "robot `panda`, expected `movo`",
        ),
        (
            Identity {
                n_observation: 51,
                ..identity()
            },
            "observation size 5, expected 51",
        ),
        (
            Identity {
                n_action: 13,
                ..identity()
            },
            "action size 2, expected 13",
        ),
    ];
    for (wanted, message) in cases {
        let refused = load(&path, &wanted).unwrap_err().to_string();
        assert!(refused.ends_with(message), "{refused}");
        assert!(refused.contains("door.safetensors"), "{refused}");
    }
    let other = Identity {
        n_action: 13,
        ..identity()
    };
    let refused = save(&path, &learner(), &other, "").unwrap_err().to_string();
    assert!(refused.ends_with("action size 2, expected 13"), "{refused}");
    assert!(load(&path, &identity()).is_ok(), "the older file stays");
}

#[test]
fn a_damaged_file_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.safetensors");
    let mut learner = learner();
    go_on(&mut learner, 3);
    save(&path, &learner, &identity(), "").unwrap();
    let whole = fs::read(&path).unwrap();
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        load(&path, &identity()).err()
    };
    for length in (0..whole.len()).step_by(whole.len() / 60) {
        let error = refused(&whole[..length]);
        assert!(
            matches!(error, Some(CheckpointError::Damaged { .. })),
            "{length}: {error:?}"
        );
    }
    for at in (0..whole.len()).step_by(whole.len() / 120) {
        let mut changed = whole.clone();
        changed[at] ^= 0x10;
        assert!(refused(&changed).is_some(), "byte {at} was changed");
    }
    assert!(refused(&whole).is_none());
}

#[test]
fn a_file_that_is_not_there_or_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no/such.safetensors");
    let error = load(&path, &identity()).unwrap_err().to_string();
    assert!(
        error.starts_with("cannot read checkpoint `") && error.contains("such.safetensors"),
        "{error}"
    );
    let error = save(&path, &learner(), &identity(), "")
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("cannot write checkpoint `"), "{error}");
}
